//! From one cell to the next: offers, and their answers.

use super::super::AHEAD;
use super::super::letter::{Offer, Sighting, Word};
use super::super::matching::{self, Inner};
use super::super::public::Public;
use super::{AGAIN, BEGUN, Border, KEEPS, Offered, Owned, PATIENCE, PER_TRANSPONDER, State};
use crate::picture::Picture;
use crate::territory::CellName;
use fusion::slots::Slot;

impl Border {
    /// A neighbour offers an aircraft.
    pub(super) fn offered(&mut self, offer: Offer, by: &CellName) {
        let (next, ahead) = (self.next(), offer.seen.slot.plus(AHEAD));
        let from = ahead.max(next);
        if let Some(owned) = self.owned(&offer.id).filter(|owned| owned.until.is_none()) {
            // The answer is still on its way.
            let word = Word::Take { id: offer.id, from: owned.from };
            return self.state.answers.push((by.clone(), word));
        }
        let Some(inner) = self.find(&offer.seen) else {
            self.counts.unknown += 1;
            self.state.unseen.insert(offer.id.clone(), (next, offer.seen));
            return self.state.answers.push((by.clone(), Word::Unknown { id: offer.id }));
        };
        let identity = offer.seen.identity;
        let own_number = offer.number / PER_TRANSPONDER;
        let numbers = &mut self.state.numbers;
        // The number of a transponder is its identity's; that of the aircraft may be another one, of before it was known.
        let is_same = offer.transponder_number == Some(own_number);
        numbers.take(own_number, identity.filter(|_| is_same), next);
        if let Some((number, identity)) = offer.transponder_number.zip(identity) {
            numbers.take(number, Some(identity), next);
        }
        let before = self.state.owned.get(&inner).filter(|owned| owned.until.is_none());
        self.counts.renamed += u64::from(before.is_some());
        let owned = Owned {
            public: Public { id: offer.id.clone(), number: offer.number, first_seen: offer.first_seen },
            numbers: [Some(own_number), offer.transponder_number],
            // What is shown already stays.
            from: before.map_or(from, |before| before.from),
            until: None,
            offered: None,
            kept: None,
        };
        self.state.owned.insert(inner, owned);
        self.state.known.get_mut(&inner).into_iter().for_each(|known| known.asked = None);
        self.state.given.remove(&offer.id);
        self.counts.taken += 1;
        self.state.answers.push((by.clone(), Word::Take { id: offer.id, from }));
    }

    /// Which aircraft of the last picture an offered one is: one that nobody owns here or, where both have published it, the one
    /// that is certainly the same.
    fn find(&self, wanted: &Sighting) -> Option<Inner> {
        let State { seen, owned, .. } = &self.state;
        let is_own = |inner: &Inner| owned.get(inner).is_some_and(|owned| owned.until.is_none());
        let of = |own: bool| {
            let seen = seen.iter().filter(move |(inner, _)| is_own(inner) == own);
            seen.map(|(inner, seen)| (*inner, seen))
        };
        let certain =
            of(true).filter(|(_, seen)| seen.identity == wanted.identity && wanted.is_certainly(seen));
        matching::find(wanted, &of(false)).or_else(|| certain.map(|(inner, _)| inner).next())
    }

    /// A neighbour takes an aircraft.
    pub(super) fn taken(&mut self, id: &str, from: Slot, by: &CellName) {
        let until = from.max(self.next());
        let others = self.state.given.get(id).is_some_and(|(to, _)| to != by);
        match self.owned(id) {
            Some(owned) if owned.until.is_none() => {
                owned.until = Some(until);
                let numbers = owned.numbers;
                numbers.into_iter().flatten().for_each(|number| self.state.numbers.give(number));
                self.state.given.insert(id.to_owned(), (by.clone(), until));
                self.counts.given += 1;
            }
            _ if others => self.state.answers.push((by.clone(), Word::Gone { id: id.to_owned() })),
            _ => {}
        }
    }

    /// A neighbour asks whose an aircraft is that is inside its cell.
    pub(super) fn asked(&mut self, sighting: &Sighting, by: &CellName) {
        let Some(slot) = self.state.last else { return };
        let mine = self.state.owned.iter().filter(|(_, owned)| owned.until.is_none() && owned.from <= slot);
        let seen = mine.filter_map(|(inner, _)| Some((*inner, self.state.seen.get(inner)?)));
        let Some(inner) = matching::find(sighting, &seen) else { return self.asked_both(sighting, by) };
        let Some(offer) = self.offer(inner) else { return };
        if !self.region.is_left(sighting.position) {
            return self.state.answers.push((by.clone(), Word::Kept(offer.seen)));
        }
        if let Some(owned) = self.state.owned.get_mut(&inner) {
            owned.offered = Some(Offered { to: by.clone(), first: slot, last: slot });
        }
        self.counts.offers += 1;
        self.state.answers.push((by.clone(), Word::Offer(offer)));
    }

    /// It is nobody's here either. Where both ask, on the border, the cell that comes first by its name begins it.
    fn asked_both(&mut self, sighting: &Sighting, by: &CellName) {
        let State { seen, owned, known, .. } = &mut self.state;
        let is_asked = |inner: &Inner| known.get(inner).is_some_and(|known| known.asked.is_some());
        let nobodys = seen.iter().filter(|(inner, _)| !owned.contains_key(inner) && is_asked(inner));
        let found = matching::find(sighting, &nobodys.map(|(inner, seen)| (*inner, seen)));
        if let Some(known) = found.filter(|_| *by < self.region.cell).and_then(|inner| known.get_mut(&inner))
        {
            (known.strange_since, known.asked) = (None, None);
        }
    }

    /// An aircraft in this cell is a neighbour's, who keeps it; also where that is said too late, and it has been begun here.
    pub(super) fn kept(&mut self, sighting: &Sighting) {
        let next = self.next();
        let State { seen, owned, known, .. } = &mut self.state;
        let Some(inner) = seen.iter().find(|(_, seen)| sighting.is_certainly(seen)).map(|(inner, _)| *inner)
        else {
            return;
        };
        let Some(known) = known.get_mut(&inner) else { return };
        let is_begun = known.asked.is_some_and(|asked| next < asked.last.plus(BEGUN));
        if is_begun || !owned.contains_key(&inner) {
            (known.strange_since, known.asked, known.kept) = (None, None, Some(next));
            owned.remove(&inner);
        }
    }

    fn offer(&self, inner: Inner) -> Option<Offer> {
        let Owned { public, .. } = self.state.owned.get(&inner)?;
        let seen = self.state.seen.get(&inner)?.clone();
        let transponder_number = seen.identity.and_then(|identity| self.state.numbers.known(identity));
        Some(Offer {
            id: public.id.clone(),
            number: public.number,
            first_seen: public.first_seen,
            transponder_number,
            seen,
        })
    }

    /// Offers what has left the cell to who has it now.
    pub(super) fn offer_all(&mut self, picture: &Picture, slot: Slot, words: &mut Vec<(CellName, Word)>) {
        for track in &picture.tracks {
            let inner = Inner::of(track);
            let Some(owned) = self.state.owned.get_mut(&inner) else { continue };
            if !owned.is_published(slot) || owned.until.is_some() {
                continue;
            }
            if !self.region.is_left(track.position) {
                // It has come back, unless it was offered because somebody asked.
                owned.offered = owned.offered.take().filter(|offered| slot < offered.last.plus(AGAIN));
                let is_told = owned.kept.is_some_and(|last| slot < last.plus(KEEPS));
                if !is_told {
                    let kept = Word::Kept(Sighting::of(track, slot));
                    for to in self.region.who_is_near(track.position) {
                        words.push((to.clone(), kept.clone()));
                        owned.kept = Some(slot);
                    }
                }
                continue;
            }
            let here = self.region.territory.cell_of(track.position);
            let Some(here) = here.filter(|here| *here != self.region.cell) else { continue };
            let offered = owned.offered.take();
            let offered = offered.filter(|known| known.to == here || slot < known.first.plus(PATIENCE));
            let is_time = offered.as_ref().is_none_or(|offered| slot >= offered.last.plus(AGAIN));
            let (to, first) = offered.as_ref().map_or((here, slot), |known| (known.to.clone(), known.first));
            let last = if is_time { slot } else { offered.map_or(slot, |offered| offered.last) };
            owned.offered = Some(Offered { to: to.clone(), first, last });
            if is_time && let Some(offer) = self.offer(inner) {
                self.counts.offers += 1;
                words.push((to, Word::Offer(offer)));
            }
        }
    }
}
