//! Which aircraft of its engine's picture a cell publishes, and what it writes to its neighbours about that.

mod handover;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use serde::{Deserialize, Serialize};

use super::Region;
use super::letter::{Letter, Sighting, Word};
use super::matching::Inner;
use super::numbers::{Numbers, numbers_office};
use super::public::{Public, publish};
use crate::picture::{Picture, PictureTrack};
use crate::territory::{CellName, Outline};
use fusion::frames::TangentPlane;
use fusion::integrity::Assessment;
use fusion::operational::{Acquaintance, Name};
use fusion::slots::Slot;
use fusion::{Engine, Identity};

/// An offer that is not answered is made again after so many slots,
const AGAIN: i64 = 4;
/// and to another cell after so many.
const PATIENCE: i64 = 16;
/// An aircraft in a cell that nobody has offered is asked after when it has been there for so many slots, and again after
/// [`AGAIN`].
const STRANGE: i64 = 4;
/// What may have been offered before it was seen here begins after so many slots, if it is not offered again.
const HELD: i64 = 2 * AGAIN;
/// It is nobody's where that is not answered for so many: 4 s, longer than letters take there and back.
const ANSWERED: i64 = 16;
/// Who has one near a border says so to the cell beyond, and again after so many: 5 s;
const KEEPS: i64 = 20;
/// that holds for so many: 10 s.
const KEPT: i64 = 40;
/// What was begun because nobody answered gives way to who keeps it after all, for so many slots: 20 s.
const BEGUN: i64 = 80;
/// What was not seen for so many slots has ended: 10 min.
const ENDED: i64 = 2400;
/// Letters of so many slots are written again by who takes over: 20 s, longer than an owner stands still and its lease lasts.
const SENT: i64 = 80;
/// A number is its aircraft's for so many slots more: 24 h.
const RESTS: i64 = 345_600;
/// What is known of an aircraft is written again when it comes back after so many slots: 10 s.
const KNOWN_AGAIN: i64 = 40;
/// Letters older than so many slots are not told apart from those handled before: 2 min.
const REMEMBERED: i64 = 480;
/// The track number is T · this + R.
const PER_TRANSPONDER: u32 = 10_000;
/// Ids count on from here with a new cell: more than are given in a slot.
const IDS_PER_SLOT: u64 = 16;

/// An engine, and the frame of its positions.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The engine.
    pub engine: &'a Engine,
    /// Its frame.
    pub frame: &'a TangentPlane,
}

/// Aircraft of a cell, and its neighbours' letters.
#[derive(Debug)]
pub struct Border {
    region: Region,
    state: State,
    /// What has happened since this process began.
    pub counts: Counts,
}

/// How often what has happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Aircraft that began here.
    pub births: u64,
    /// Letters with an offer.
    pub offers: u64,
    /// Aircraft that came from another cell.
    pub taken: u64,
    /// Aircraft that another cell has taken.
    pub given: u64,
    /// Offers of what is not seen here.
    pub unknown: u64,
    /// Aircraft that nobody had offered.
    pub asked: u64,
    /// Aircraft that had an id here already when they were offered under another one.
    pub renamed: u64,
    /// Aircraft left out of a picture because there is no number.
    pub unnumbered: u64,
    /// Letters that had been handled before.
    pub repeated: u64,
}

/// All that a checkpoint has to hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    /// The slot that was made last.
    last: Option<Slot>,
    /// The next id.
    next_id: u64,
    numbers: Numbers,
    /// Of the engine's aircraft those that are this cell's.
    owned: BTreeMap<Inner, Owned>,
    /// All aircraft of the engine: when each was seen last, and since when it is inside and nobody's.
    known: BTreeMap<Inner, Known>,
    /// Those of the last picture.
    seen: BTreeMap<Inner, Sighting>,
    /// When an aircraft or a radar track was last where a neighbour sees it, who was written what is known of it.
    written: BTreeMap<(Name, CellName), Slot>,
    /// Offers of what was not seen here: when, by id.
    unseen: BTreeMap<String, (Slot, Sighting)>,
    /// Where those went that were this cell's.
    given: BTreeMap<String, (CellName, Slot)>,
    /// What is to be written with the next slot.
    answers: Vec<(CellName, Word)>,
    /// Letters that were handled.
    handled: BTreeMap<CellName, BTreeSet<(Slot, u16)>>,
    /// What was written lately.
    sent: VecDeque<Letter>,
    /// When numbers were wanted last.
    wanted: Option<Slot>,
}

/// A cell, where that is, its halo and its hysteresis, metres.
type Whose = (CellName, Outline, [f64; 2]);

/// An aircraft of this cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Owned {
    public: Public,
    /// The numbers that end with it: its own, and that of its transponder.
    numbers: [Option<u32>; 2],
    /// The first slot in which this cell publishes it,
    from: Slot,
    /// and the first in which it no longer does.
    until: Option<Slot>,
    offered: Option<Offered>,
    /// When it was said last that it is kept near a border.
    kept: Option<Slot>,
}

impl Owned {
    fn is_published(&self, slot: Slot) -> bool {
        self.from <= slot && self.until.is_none_or(|until| slot < until)
    }
}

/// An offer without an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Offered {
    to: CellName,
    first: Slot,
    last: Slot,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Known {
    seen: Slot,
    strange_since: Option<Slot>,
    asked: Option<Asked>,
    /// When somebody who keeps it near the border has last said so.
    kept: Option<Slot>,
    /// Since when it may be one that was offered before it was seen here.
    held: Option<Slot>,
}

/// When it was asked whose an aircraft is; of one of this cell: it was begun because nobody answered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Asked {
    first: Slot,
    last: Slot,
}

impl Border {
    /// Of a cell that knows nothing yet.
    pub fn new(region: Region) -> Self {
        Self { region, state: State::default(), counts: Counts::default() }
    }

    /// Its cell.
    pub const fn region(&self) -> &Region {
        &self.region
    }

    /// The state as octets.
    pub fn checkpoint(&self) -> Vec<u8> {
        postcard::to_stdvec(&(self.whose(), &self.state)).expect("every state can be written down")
    }

    /// Goes on with a checkpoint; whether it is one of this cell.
    pub fn go_on(&mut self, octets: &[u8]) -> bool {
        let read: Option<(Whose, State)> = postcard::from_bytes(octets).ok();
        let state = read.filter(|(whose, _)| *whose == self.whose()).map(|(_, state)| state);
        state.map(|state| self.state = state).is_some()
    }

    /// Takes what outlives a gap from a state that is too old to go on with: numbers.
    pub fn remember(&mut self, octets: &[u8]) {
        let read: Option<(Whose, State)> = postcard::from_bytes(octets).ok();
        if let Some((_, state)) = read.filter(|((cell, ..), _)| *cell == self.region.cell) {
            self.state.numbers = state.numbers;
        }
    }

    /// What of the region's numbers is this cell's: blocks, by their first numbers, and those of identities.
    pub fn claims(&self) -> (Vec<u32>, Vec<(Identity, u32)>) {
        self.state.numbers.claims()
    }

    /// Gives what is known of a transponder the region's numbers; whether this cell speaks of it: another one does while the
    /// aircraft is that one's.
    pub fn publicise(&self, assessment: &mut Assessment) -> bool {
        let State { seen, owned, numbers, .. } = &self.state;
        let mut aircraft =
            seen.iter().filter(|(_, seen)| seen.identity == Some(assessment.identity)).peekable();
        if aircraft.peek().is_some() && !aircraft.any(|(inner, _)| owned.contains_key(inner)) {
            return false;
        }
        assessment.number = numbers.known(assessment.identity);
        assessment.twin = assessment.twin.and_then(|twin| {
            let mut of = owned.iter().filter(|(inner, _)| inner.number == twin);
            of.next().map(|(_, owned)| owned.public.number)
        });
        true
    }

    /// What a state is of.
    fn whose(&self) -> Whose {
        let Region { cell, halo_m, hysteresis_m, .. } = &self.region;
        (cell.clone(), self.region.outline().clone(), [*halo_m, *hysteresis_m])
    }

    /// Handles a letter to this cell; again is as good as once. What is an engine's to handle is given back.
    pub fn letter(&mut self, letter: &Letter) -> Option<Word> {
        let handled = self.state.handled.entry(letter.from.clone()).or_default();
        let newest = handled.last().map_or(letter.slot, |newest| newest.0);
        if letter.to != self.region.cell || letter.slot < newest.plus(-REMEMBERED) {
            self.counts.repeated += 1;
            return None;
        }
        if !handled.insert((letter.slot, letter.index)) {
            self.counts.repeated += 1;
            return None;
        }
        while handled.first().is_some_and(|first| first.0 < letter.slot.plus(-REMEMBERED)) {
            handled.pop_first();
        }
        match letter.word.clone() {
            Word::Offer(offer) => self.offered(offer, &letter.from),
            Word::Take { id, from } => self.taken(&id, from, &letter.from),
            Word::Unknown { id } => {
                if let Some(owned) = self.owned(&id) {
                    owned.offered = owned.offered.take().filter(|offered| offered.to != letter.from);
                }
            }
            Word::Gone { id } => self.state.owned.retain(|_, owned| owned.public.id != id),
            Word::Ask(sighting) => self.asked(&sighting, &letter.from),
            Word::Kept(sighting) => self.kept(&sighting),
            Word::Block { first } => {
                self.state.numbers.add_block(first);
                self.state.wanted = None;
            }
            Word::Number { identity, number } => self.state.numbers.learn(identity, number),
            Word::Wanted => {}
            word @ (Word::Values { .. }
            | Word::Labelled(_)
            | Word::Known(_)
            | Word::Correlate { .. }
            | Word::Say { .. }) => {
                return Some(word);
            }
        }
        None
    }

    fn owned(&mut self, id: &str) -> Option<&mut Owned> {
        self.state.owned.values_mut().find(|owned| owned.public.id == id)
    }

    /// The slot that is made next.
    fn next(&self) -> Slot {
        self.state.last.map_or(Slot(i64::MIN), |last| last.plus(1))
    }

    /// Leaves in the pictures of a slot what this cell publishes, under its ids and numbers; what it has to write with it,
    /// `words` among it.
    pub fn turn(
        &mut self,
        picture: &mut Picture,
        now: Option<&mut Picture>,
        view: &View<'_>,
        mut words: Vec<(CellName, Word)>,
    ) -> Vec<Letter> {
        let slot = picture.slot;
        self.state.next_id = self.state.next_id.max(slot.0.unsigned_abs() * IDS_PER_SLOT);
        self.state.last = Some(slot);
        let sighting = |track: &PictureTrack| (Inner::of(track), Sighting::of(track, slot));
        self.state.seen = picture.tracks.iter().map(sighting).collect();
        for track in &picture.tracks {
            self.meet(track, slot);
        }
        self.end(slot);
        words.append(&mut self.state.answers);
        self.offer_all(picture, slot, &mut words);
        self.write_known(picture, slot, view, &mut words);
        if self.state.numbers.are_few() && self.state.wanted.is_none_or(|last| slot >= last.plus(40)) {
            self.state.wanted = Some(slot);
            words.push((numbers_office(), Word::Wanted));
        }
        let State { owned, numbers, .. } = &mut self.state;
        let published = |inner: Inner| {
            owned.get(&inner).filter(|owned| owned.is_published(slot)).map(|owned| owned.public.clone())
        };
        let known = |identity| numbers.known(identity);
        publish(picture, published, known);
        now.into_iter().for_each(|now| publish(now, published, known));
        let from = &self.region.cell;
        let letter = |(index, (to, word)): (usize, (CellName, Word))| {
            let index = u16::try_from(index).ok()?;
            Some(Letter { from: from.clone(), to, slot, index, word })
        };
        let letters: Vec<Letter> = words.into_iter().enumerate().filter_map(letter).collect();
        let sent = &mut self.state.sent;
        sent.extend(letters.iter().cloned());
        while sent.front().is_some_and(|letter| letter.slot < slot.plus(-SENT)) {
            sent.pop_front();
        }
        letters
    }

    /// What was written in the last 20 s.
    pub fn recent_letters(&self) -> Vec<Letter> {
        self.state.sent.iter().cloned().collect()
    }

    /// Whose a track of the engine's picture is.
    fn meet(&mut self, track: &PictureTrack, slot: Slot) {
        let inner = Inner::of(track);
        let is_new = !self.state.known.contains_key(&inner);
        let known = self.state.known.entry(inner).or_insert(Known {
            seen: slot,
            strange_since: None,
            asked: None,
            kept: None,
            held: None,
        });
        known.seen = slot;
        let identity = track.point.source.transponder().map(|part| part.identity);
        if let Some(owned) = self.state.owned.get_mut(&inner) {
            // A transponder may have joined it since.
            if owned.numbers[1].is_none()
                && let Some(identity) = identity
                && let Some((number, is_given)) = self.state.numbers.of(Some(identity), slot)
            {
                owned.numbers[1] = Some(number);
                self.tell_number(is_given.then_some(identity), number);
            }
            let Some(owned) = self.state.owned.get(&inner) else { return };
            owned.numbers.into_iter().flatten().for_each(|number| self.state.numbers.note(number, slot));
            return;
        }
        if !self.region.contains(track.position) {
            // Just over the border it may be back in the next slot.
            if self.region.is_left(track.position) {
                (known.strange_since, known.asked, known.kept) = (None, None, None);
            }
            return;
        }
        let sighting = Sighting::of(track, slot);
        if is_new && self.state.unseen.values().any(|(_, offered)| offered.may_have_been(&sighting)) {
            // Its owner sees it again, too, and will offer it again.
            known.held = Some(slot);
        }
        let is_held = known.held.take_if(|since| slot >= since.plus(HELD)).is_some();
        if is_held || (is_new && known.held.is_none()) {
            return self.give_birth(track, slot);
        }
        let is_deep = self.region.is_deep(track.position);
        if known.kept.is_some_and(|kept| !is_deep && slot < kept.plus(KEPT)) {
            return;
        }
        // What was asked before it was away for a while is forgotten.
        known.asked = known.asked.filter(|asked| slot <= asked.last.plus(ANSWERED));
        if known.asked.is_some_and(|asked| slot >= asked.first.plus(ANSWERED)) {
            return self.give_birth(track, slot);
        }
        let is_strange = slot >= known.strange_since.get_or_insert(slot).plus(STRANGE);
        if is_strange && known.asked.is_none_or(|asked| slot >= asked.last.plus(AGAIN)) {
            self.counts.asked += u64::from(known.asked.is_none());
            let first = known.asked.map_or(slot, |asked| asked.first);
            known.asked = Some(Asked { first, last: slot });
            let asks = self.region.neighbours().map(|to| (to.clone(), Word::Ask(sighting.clone())));
            self.state.answers.extend(asks);
        }
    }

    /// An aircraft begins in this cell.
    fn give_birth(&mut self, track: &PictureTrack, slot: Slot) {
        let inner = Inner::of(track);
        let identity = track.point.source.transponder().map(|part| part.identity);
        let Some((number, is_given)) = self.state.numbers.of(identity, slot) else {
            self.counts.unnumbered += 1;
            // Asked for again with the next slot.
            self.state.known.remove(&inner);
            return;
        };
        self.tell_number(identity.filter(|_| is_given), number);
        let radar = track.point.source.radar().map_or(0, |part| u32::from(part.track.number));
        let public = Public {
            id: format!("U-{}-{}", self.region.cell, base_32(self.state.next_id)),
            number: number * PER_TRANSPONDER + radar,
            first_seen: track.time,
        };
        self.state.next_id += 1;
        self.counts.births += 1;
        let numbers = [Some(number), identity.map(|_| number)];
        let owned = Owned { public, numbers, from: slot, until: None, offered: None, kept: None };
        self.state.owned.insert(inner, owned);
    }

    /// Who keeps the numbers learns of a new one.
    fn tell_number(&mut self, identity: Option<Identity>, number: u32) {
        let word = identity.map(|identity| Word::Number { identity, number: Some(number) });
        self.state.answers.extend(word.map(|word| (numbers_office(), word)));
    }

    /// Forgets what has ended, or is another cell's.
    fn end(&mut self, slot: Slot) {
        let State { owned, known, unseen, given, written, numbers, answers, .. } = &mut self.state;
        owned.retain(|_, owned| owned.until.is_none_or(|until| slot < until));
        if slot.0.rem_euclid(AGAIN) != 0 {
            return;
        }
        let before = slot.plus(-ENDED);
        unseen.retain(|_, (since, _)| *since >= slot.plus(-PATIENCE));
        known.retain(|_, known| known.seen >= before);
        owned.retain(|inner, owned| known.contains_key(inner) || owned.from > slot);
        given.retain(|_, (_, since)| *since >= before);
        written.retain(|_, last| slot < last.plus(KNOWN_AGAIN));
        let forgotten = numbers.turn(slot.plus(-RESTS));
        answers.extend(
            forgotten.into_iter().map(|identity| (numbers_office(), Word::Number { identity, number: None })),
        );
    }

    /// Writes what the engine knows of who is in the cell to those who begin to see them, and of whom it offers with the offer.
    fn write_known(
        &mut self,
        picture: &Picture,
        slot: Slot,
        View { engine, frame }: &View<'_>,
        words: &mut Vec<(CellName, Word)>,
    ) {
        let Self { region, state, .. } = self;
        let is_own = |place| region.contains(frame.to_geodetic(place));
        let mut write = |known: Option<Acquaintance>, to: &CellName| {
            words.extend(known.map(|known| (to.clone(), Word::Known(Box::new(known)))));
        };
        for track in &picture.tracks {
            let offered = state.owned.get(&Inner::of(track)).and_then(|owned| owned.offered.as_ref());
            if let Some(offered) = offered.filter(|offered| offered.last == slot)
                && let Some(name) = engine.numbered(track.point.number)
            {
                // What is around it there its own cell knows best.
                write(engine.acquaintance(name, |_| false), &offered.to);
            }
        }
        if slot.0.rem_euclid(AGAIN) != 0 {
            return;
        }
        for (name, place) in engine.names().into_iter().filter(|(_, place)| is_own(*place)) {
            for to in region.who_see(frame.to_geodetic(place)) {
                if state.written.insert((name, to.clone()), slot).is_none() {
                    write(engine.acquaintance(name, is_own), to);
                }
            }
        }
    }

    /// How many aircraft are this cell's.
    pub fn owns(&self) -> usize {
        self.state.owned.len()
    }
}

/// A count in digits 0 to 9, a to v.
fn base_32(mut count: u64) -> String {
    let mut digits = Vec::new();
    loop {
        digits.push(b"0123456789abcdefghijklmnopqrstuv"[(count % 32) as usize]);
        count /= 32;
        if count == 0 {
            break;
        }
    }
    digits.iter().rev().copied().map(char::from).collect()
}
