//! Handover of aircraft between cells: offers, and their answers.

use super::super::AHEAD;
use super::super::cell_message::{AircraftOffer, CellMessageContent, Sighting};
use super::super::matching::{self, EngineTrackId};
use super::super::public_name::PublicName;
use super::{
    Border, BorderState, CONFIRMATION_INTERVAL_SLOTS, OFFER_TIMEOUT_SLOTS, OwnedAircraft, PendingOffer,
    REPEAT_SLOTS, TRACK_NUMBER_FACTOR, YIELD_SLOTS,
};
use fusion::slots::Slot;
use picture::Picture;
use site::territory::CellName;

impl Border {
    /// Handles an offer by an adjacent cell.
    pub(super) fn handle_offer(&mut self, offer: AircraftOffer, by: &CellName) {
        let (next, ahead) = (self.next(), offer.seen.slot.plus(AHEAD));
        let from = ahead.max(next);
        if let Some(owned) = self.owned(&offer.id).filter(|owned| owned.until.is_none()) {
            // The answer to an earlier offer is still on its way.
            let content = CellMessageContent::Accept { id: offer.id, from: owned.from };
            return self.state.answers.push((by.clone(), content));
        }
        let Some(track_id) = self.find(&offer.seen) else {
            self.counts.unknown += 1;
            self.state.unseen.insert(offer.id.clone(), (next, offer.seen));
            return self.state.answers.push((by.clone(), CellMessageContent::Reject { id: offer.id }));
        };
        let identity = offer.seen.identity;
        let own_number = offer.number / TRACK_NUMBER_FACTOR;
        let numbers = &mut self.state.numbers;
        // A transponder's number belongs to its identity. The aircraft may have another number from before the identity was
        // known.
        let is_same = offer.transponder_number == Some(own_number);
        numbers.assign(own_number, identity.filter(|_| is_same), next);
        if let Some((number, identity)) = offer.transponder_number.zip(identity) {
            numbers.assign(number, Some(identity), next);
        }
        let before = self.state.owned.get(&track_id).filter(|owned| owned.until.is_none());
        self.counts.renamed += u64::from(before.is_some());
        let owned = OwnedAircraft {
            public: PublicName { id: offer.id.clone(), number: offer.number, first_seen: offer.first_seen },
            numbers: [Some(own_number), offer.transponder_number],
            // An aircraft that is already published stays published.
            from: before.map_or(from, |before| before.from),
            until: None,
            offered: None,
            kept: None,
        };
        self.state.owned.insert(track_id, owned);
        self.state.known.get_mut(&track_id).into_iter().for_each(|known| known.asked = None);
        self.state.given.remove(&offer.id);
        self.counts.taken += 1;
        self.state.answers.push((by.clone(), CellMessageContent::Accept { id: offer.id, from }));
    }

    /// Finds an offered aircraft in the last picture: one without an owner here or, if both cells have published it, one with the
    /// same transponder or radar track.
    fn find(&self, wanted: &Sighting) -> Option<EngineTrackId> {
        let BorderState { seen, owned, .. } = &self.state;
        let is_own =
            |track_id: &EngineTrackId| owned.get(track_id).is_some_and(|owned| owned.until.is_none());
        let of = |own: bool| {
            let seen = seen.iter().filter(move |(track_id, _)| is_own(track_id) == own);
            seen.map(|(track_id, seen)| (*track_id, seen))
        };
        let certain =
            of(true).filter(|(_, seen)| seen.identity == wanted.identity && wanted.is_certainly(seen));
        matching::find(wanted, &of(false)).or_else(|| certain.map(|(track_id, _)| track_id).next())
    }

    /// Handles the takeover of an aircraft by an adjacent cell.
    pub(super) fn handle_acceptance(&mut self, id: &str, from: Slot, by: &CellName) {
        let until = from.max(self.next());
        let others = self.state.given.get(id).is_some_and(|(to, _)| to != by);
        match self.owned(id) {
            Some(owned) if owned.until.is_none() => {
                owned.until = Some(until);
                let numbers = owned.numbers;
                numbers.into_iter().flatten().for_each(|number| self.state.numbers.hand_over(number));
                self.state.given.insert(id.to_owned(), (by.clone(), until));
                self.counts.given += 1;
            }
            _ if others => self
                .state
                .answers
                .push((by.clone(), CellMessageContent::TakenElsewhere { id: id.to_owned() })),
            _ => {}
        }
    }

    /// Handles the question of an adjacent cell which cell owns an aircraft inside that cell.
    pub(super) fn handle_question(&mut self, sighting: &Sighting, by: &CellName) {
        let Some(slot) = self.state.last else { return };
        let mine = self.state.owned.iter().filter(|(_, owned)| owned.until.is_none() && owned.from <= slot);
        let seen = mine.filter_map(|(track_id, _)| Some((*track_id, self.state.seen.get(track_id)?)));
        let Some(track_id) = matching::find(sighting, &seen) else {
            return self.handle_mutual_question(sighting, by);
        };
        let Some(offer) = self.offer(track_id) else { return };
        if !self.region.is_beyond(sighting.position) {
            return self.state.answers.push((by.clone(), CellMessageContent::KeepsOwnership(offer.seen)));
        }
        if let Some(owned) = self.state.owned.get_mut(&track_id) {
            owned.offered = Some(PendingOffer { to: by.clone(), first: slot, last: slot });
        }
        self.counts.offers += 1;
        self.state.answers.push((by.clone(), CellMessageContent::Offer(offer)));
    }

    /// Handles a question about an aircraft that has no owner here either. If both cells ask, on the border, the cell with the
    /// lower name starts it.
    fn handle_mutual_question(&mut self, sighting: &Sighting, by: &CellName) {
        let BorderState { seen, owned, known, .. } = &mut self.state;
        let is_asked =
            |track_id: &EngineTrackId| known.get(track_id).is_some_and(|known| known.asked.is_some());
        let unowned = seen.iter().filter(|(track_id, _)| !owned.contains_key(track_id) && is_asked(track_id));
        let found = matching::find(sighting, &unowned.map(|(track_id, seen)| (*track_id, seen)));
        if let Some(known) =
            found.filter(|_| *by < self.region.cell).and_then(|track_id| known.get_mut(&track_id))
        {
            (known.unowned_since, known.asked) = (None, None);
        }
    }

    /// Handles the message that the owner of an aircraft in this cell keeps it, even if it arrives late and the aircraft has been
    /// started here.
    pub(super) fn handle_keeping(&mut self, sighting: &Sighting) {
        let next = self.next();
        let BorderState { seen, owned, known, .. } = &mut self.state;
        let Some(track_id) =
            seen.iter().find(|(_, seen)| sighting.is_certainly(seen)).map(|(track_id, _)| *track_id)
        else {
            return;
        };
        let Some(known) = known.get_mut(&track_id) else { return };
        let is_begun = known.asked.is_some_and(|asked| next < asked.last.plus(YIELD_SLOTS));
        if is_begun || !owned.contains_key(&track_id) {
            (known.unowned_since, known.asked, known.kept) = (None, None, Some(next));
            owned.remove(&track_id);
        }
    }

    fn offer(&self, track_id: EngineTrackId) -> Option<AircraftOffer> {
        let OwnedAircraft { public, .. } = self.state.owned.get(&track_id)?;
        let seen = self.state.seen.get(&track_id)?.clone();
        let transponder_number = seen.identity.and_then(|identity| self.state.numbers.known(identity));
        Some(AircraftOffer {
            id: public.id.clone(),
            number: public.number,
            first_seen: public.first_seen,
            transponder_number,
            seen,
        })
    }

    /// Offers aircraft that have left the cell to the cells that contain them.
    pub(super) fn offer_all(
        &mut self,
        picture: &Picture,
        slot: Slot,
        outgoing: &mut Vec<(CellName, CellMessageContent)>,
    ) {
        for track in &picture.tracks {
            let track_id = EngineTrackId::of(track);
            let Some(owned) = self.state.owned.get_mut(&track_id) else { continue };
            if !owned.is_published(slot) || owned.until.is_some() {
                continue;
            }
            if !self.region.is_beyond(track.position) {
                // The aircraft has come back, unless it was offered in answer to a question.
                owned.offered = owned.offered.take().filter(|offered| slot < offered.last.plus(REPEAT_SLOTS));
                let is_confirmed =
                    owned.kept.is_some_and(|last| slot < last.plus(CONFIRMATION_INTERVAL_SLOTS));
                if !is_confirmed {
                    let kept = CellMessageContent::KeepsOwnership(Sighting::of(track, slot));
                    for to in self.region.cells_that_keep(track.position) {
                        outgoing.push((to.clone(), kept.clone()));
                        owned.kept = Some(slot);
                    }
                }
                continue;
            }
            let here = self.region.territory.cell_of(track.position);
            let Some(here) = here.filter(|here| *here != self.region.cell) else { continue };
            let offered = owned.offered.take();
            let offered =
                offered.filter(|known| known.to == here || slot < known.first.plus(OFFER_TIMEOUT_SLOTS));
            let is_time = offered.as_ref().is_none_or(|offered| slot >= offered.last.plus(REPEAT_SLOTS));
            let (to, first) = offered.as_ref().map_or((here, slot), |known| (known.to.clone(), known.first));
            let last = if is_time { slot } else { offered.map_or(slot, |offered| offered.last) };
            owned.offered = Some(PendingOffer { to: to.clone(), first, last });
            if is_time && let Some(offer) = self.offer(track_id) {
                self.counts.offers += 1;
                outgoing.push((to, CellMessageContent::Offer(offer)));
            }
        }
    }
}
