//! Decides which aircraft of its engine's picture a cell publishes, and which messages it sends to adjacent cells about them.

mod handover;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use serde::{Deserialize, Serialize};

use super::Region;
use super::cell_message::{CellMessage, CellMessageContent, Sighting};
use super::matching::EngineTrackId;
use super::numbers::{CellNumbers, number_table};
use super::public_name::{PublicName, publish};
use fusion::frames::TangentPlane;
use fusion::integrity::Assessment;
use fusion::operational::{TrackHandover, TrackRef};
use fusion::slots::Slot;
use fusion::{Engine, Identity};
use picture::{Picture, PictureTrack};
use site::territory::{CellName, Outline};

/// Interval at which an unanswered offer is repeated, in slots.
const REPEAT_SLOTS: i64 = 4;
/// Time after which an unanswered offer may go to another cell, in slots.
const OFFER_TIMEOUT_SLOTS: i64 = 16;
/// Time after which the owner of an aircraft without an offer is asked for, in slots. The question is repeated after [`REPEAT_SLOTS`].
const QUESTION_DELAY_SLOTS: i64 = 4;
/// Time after which an aircraft that may have been offered before it was seen here is started, in slots, unless the offer is
/// repeated.
const UNSEEN_OFFER_SLOTS: i64 = 2 * REPEAT_SLOTS;
/// Time after which an aircraft has no owner if the question is unanswered, in slots (4 s). Messages take less time there and
/// back.
const QUESTION_TIMEOUT_SLOTS: i64 = 16;
/// Interval at which the owner of an aircraft near a border confirms to the cell beyond that it keeps the aircraft, in slots
/// (5 s).
const CONFIRMATION_INTERVAL_SLOTS: i64 = 20;
/// Validity of that confirmation, in slots (10 s).
const CONFIRMATION_VALID_SLOTS: i64 = 40;
/// Time for which an aircraft started after an unanswered question gives way to an owner that keeps it, in slots (20 s).
const YIELD_SLOTS: i64 = 80;
/// Time without a sighting after which an aircraft has ended, in slots (10 min).
const ENDED_SLOTS: i64 = 2400;
/// Period of sent messages that a new owner sends again, in slots (20 s). It is longer than the suspension of an owner plus its
/// lease.
const RESEND_SLOTS: i64 = 80;
/// Time for which a number stays reserved after its aircraft was last published, in slots (24 h).
const NUMBER_RESERVED_SLOTS: i64 = 345_600;
/// Absence after which the state of an aircraft is sent again when it comes back, in slots (10 s).
const HANDOVER_AGAIN_SLOTS: i64 = 40;
/// Age above which messages are treated as already handled, in slots (2 min).
const REMEMBERED_SLOTS: i64 = 480;
/// Factor of the transponder number T in the track number T · 10,000 + R.
const TRACK_NUMBER_FACTOR: u32 = 10_000;
/// Increase of the minimum id count per slot, so that a restarted cell repeats no id. Fewer ids are assigned in a slot.
const IDS_PER_SLOT: u64 = 16;

/// An engine, and the frame of its positions.
#[derive(Clone, Copy, Debug)]
pub struct EngineView<'a> {
    /// The engine.
    pub engine: &'a Engine,
    /// Its frame.
    pub frame: &'a TangentPlane,
}

/// Ownership of aircraft in a cell, and messages of adjacent cells.
#[derive(Debug)]
pub struct Border {
    region: Region,
    state: BorderState,
    /// Counters since this process started.
    pub counts: BorderCounts,
}

/// Counters of a border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BorderCounts {
    /// Aircraft that were started here.
    pub births: u64,
    /// Offers sent.
    pub offers: u64,
    /// Aircraft taken over from another cell.
    pub taken: u64,
    /// Aircraft taken over by another cell.
    pub given: u64,
    /// Offers of aircraft that are not seen here.
    pub unknown: u64,
    /// Aircraft without an offer whose owner was asked for.
    pub asked: u64,
    /// Aircraft that already had an id here when they were offered under another one.
    pub renamed: u64,
    /// Aircraft left out of a picture because no number was free.
    pub unnumbered: u64,
    /// Messages that had been handled before.
    pub repeated: u64,
}

/// The state that a checkpoint contains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct BorderState {
    /// The last slot that was made.
    last: Option<Slot>,
    /// The next id count.
    next_id: u64,
    numbers: CellNumbers,
    /// The engine's aircraft that this cell owns.
    owned: BTreeMap<EngineTrackId, OwnedAircraft>,
    /// All aircraft of the engine: the last sighting, and the time since when they are inside without an owner.
    known: BTreeMap<EngineTrackId, KnownAircraft>,
    /// Aircraft of the last picture.
    seen: BTreeMap<EngineTrackId, Sighting>,
    /// Slot in which an aircraft or radar track was last visible to an adjacent cell to which its state was sent.
    written: BTreeMap<(TrackRef, CellName), Slot>,
    /// Offers of aircraft that were not seen here, with their slots, by id.
    unseen: BTreeMap<String, (Slot, Sighting)>,
    /// The cells to which this cell's aircraft were handed over.
    given: BTreeMap<String, (CellName, Slot)>,
    /// Messages to be sent with the next slot.
    answers: Vec<(CellName, CellMessageContent)>,
    /// Handled messages.
    handled: BTreeMap<CellName, BTreeSet<(Slot, u16)>>,
    /// Recently sent messages.
    sent: VecDeque<CellMessage>,
    /// Slot of the last request for numbers.
    wanted: Option<Slot>,
}

/// Name and outline of a cell, its halo and its hysteresis in metres.
type CellGeometry = (CellName, Outline, [f64; 2]);

/// An aircraft that this cell owns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct OwnedAircraft {
    public: PublicName,
    /// Numbers released when the aircraft ends: its own, and its transponder's.
    numbers: [Option<u32>; 2],
    /// First slot in which this cell publishes the aircraft.
    from: Slot,
    /// First slot in which this cell no longer publishes it.
    until: Option<Slot>,
    offered: Option<PendingOffer>,
    /// Slot of the last confirmation that the aircraft is kept near a border.
    kept: Option<Slot>,
}

impl OwnedAircraft {
    fn is_published(&self, slot: Slot) -> bool {
        self.from <= slot && self.until.is_none_or(|until| slot < until)
    }
}

/// An unanswered offer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct PendingOffer {
    to: CellName,
    first: Slot,
    last: Slot,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct KnownAircraft {
    seen: Slot,
    unowned_since: Option<Slot>,
    asked: Option<OwnerQuestion>,
    /// Slot of the last confirmation by an owner that keeps the aircraft near the border.
    kept: Option<Slot>,
    /// Slot since when the aircraft may be one that was offered before it was seen here.
    held: Option<Slot>,
}

/// Slots of the first and last question for an aircraft's owner. An owned aircraft was started because no cell answered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct OwnerQuestion {
    first: Slot,
    last: Slot,
}

impl Border {
    /// Creates the border of a cell, without any state.
    pub fn new(region: Region) -> Self {
        Self { region, state: BorderState::default(), counts: BorderCounts::default() }
    }

    /// The cell's geometry.
    pub const fn region(&self) -> &Region {
        &self.region
    }

    /// Serialises the state.
    pub fn checkpoint(&self) -> Vec<u8> {
        postcard::to_stdvec(&(self.geometry(), &self.state)).expect("every state can be written down")
    }

    /// Restores the state from a checkpoint. Returns whether the checkpoint belongs to this cell.
    pub fn restore(&mut self, octets: &[u8]) -> bool {
        let read: Option<(CellGeometry, BorderState)> = postcard::from_bytes(octets).ok();
        let state = read.filter(|(geometry, _)| *geometry == self.geometry()).map(|(_, state)| state);
        state.map(|state| self.state = state).is_some()
    }

    /// Takes the numbers from a state that is too old to continue.
    pub fn restore_numbers(&mut self, octets: &[u8]) {
        let read: Option<(CellGeometry, BorderState)> = postcard::from_bytes(octets).ok();
        if let Some((_, state)) = read.filter(|((cell, ..), _)| *cell == self.region.cell) {
            self.state.numbers = state.numbers;
        }
    }

    /// This cell's share of the region's numbers: the first numbers of its blocks, and the numbers of identities.
    pub fn claims(&self) -> (Vec<u32>, Vec<(Identity, u32)>) {
        self.state.numbers.claims()
    }

    /// Replaces the numbers in a transponder's assessment by the region's. Returns whether this cell reports the transponder:
    /// another cell does while it owns the aircraft.
    pub fn to_public(&self, assessment: &mut Assessment) -> bool {
        let BorderState { seen, owned, numbers, .. } = &self.state;
        let mut aircraft =
            seen.iter().filter(|(_, seen)| seen.identity == Some(assessment.identity)).peekable();
        if aircraft.peek().is_some() && !aircraft.any(|(track_id, _)| owned.contains_key(track_id)) {
            return false;
        }
        assessment.number = numbers.known(assessment.identity);
        assessment.twin = assessment.twin.and_then(|twin| {
            let mut of = owned.iter().filter(|(track_id, _)| track_id.number == twin);
            of.next().map(|(_, owned)| owned.public.number)
        });
        true
    }

    /// Identifies the cell that a state belongs to.
    fn geometry(&self) -> CellGeometry {
        let Region { cell, halo_m, hysteresis_m, .. } = &self.region;
        (cell.clone(), self.region.outline().clone(), [*halo_m, *hysteresis_m])
    }

    /// Handles a message to this cell. Repeated messages are ignored. Returns the content if the engine has to handle it.
    pub fn handle_message(&mut self, message: &CellMessage) -> Option<CellMessageContent> {
        let handled = self.state.handled.entry(message.from.clone()).or_default();
        let newest = handled.last().map_or(message.slot, |newest| newest.0);
        if message.to != self.region.cell || message.slot < newest.plus(-REMEMBERED_SLOTS) {
            self.counts.repeated += 1;
            return None;
        }
        if !handled.insert((message.slot, message.index)) {
            self.counts.repeated += 1;
            return None;
        }
        while handled.first().is_some_and(|first| first.0 < message.slot.plus(-REMEMBERED_SLOTS)) {
            handled.pop_first();
        }
        match message.content.clone() {
            CellMessageContent::Offer(offer) => self.handle_offer(offer, &message.from),
            CellMessageContent::Accept { id, from } => self.handle_acceptance(&id, from, &message.from),
            CellMessageContent::Reject { id } => {
                if let Some(owned) = self.owned(&id) {
                    owned.offered = owned.offered.take().filter(|offered| offered.to != message.from);
                }
            }
            CellMessageContent::TakenElsewhere { id } => {
                self.state.owned.retain(|_, owned| owned.public.id != id);
            }
            CellMessageContent::AskOwner(sighting) => self.handle_question(&sighting, &message.from),
            CellMessageContent::KeepsOwnership(sighting) => self.handle_keeping(&sighting),
            CellMessageContent::Block { first } => {
                self.state.numbers.add_block(first);
                self.state.wanted = None;
            }
            CellMessageContent::Number { identity, number } => {
                self.state.numbers.set_number(identity, number);
            }
            CellMessageContent::RequestBlock => {}
            content @ (CellMessageContent::Values { .. }
            | CellMessageContent::Labelled(_)
            | CellMessageContent::Handover(_)
            | CellMessageContent::Correlate { .. }
            | CellMessageContent::SetTrust { .. }) => {
                return Some(content);
            }
        }
        None
    }

    fn owned(&mut self, id: &str) -> Option<&mut OwnedAircraft> {
        self.state.owned.values_mut().find(|owned| owned.public.id == id)
    }

    /// The next slot to be made.
    fn next(&self) -> Slot {
        self.state.last.map_or(Slot(i64::MIN), |last| last.plus(1))
    }

    /// Reduces the pictures of a slot to the aircraft that this cell publishes, under their ids and numbers. Returns the messages
    /// to send with the slot, including `outgoing`.
    pub fn publish(
        &mut self,
        picture: &mut Picture,
        now: Option<&mut Picture>,
        view: &EngineView<'_>,
        mut outgoing: Vec<(CellName, CellMessageContent)>,
    ) -> Vec<CellMessage> {
        let slot = picture.slot;
        self.state.next_id = self.state.next_id.max(slot.0.unsigned_abs() * IDS_PER_SLOT);
        self.state.last = Some(slot);
        let sighting = |track: &PictureTrack| (EngineTrackId::of(track), Sighting::of(track, slot));
        self.state.seen = picture.tracks.iter().map(sighting).collect();
        for track in &picture.tracks {
            self.assign_owner(track, slot);
        }
        self.remove_ended(slot);
        outgoing.append(&mut self.state.answers);
        self.offer_all(picture, slot, &mut outgoing);
        self.send_handovers(picture, slot, view, &mut outgoing);
        if self.state.numbers.needs_block() && self.state.wanted.is_none_or(|last| slot >= last.plus(40)) {
            self.state.wanted = Some(slot);
            outgoing.push((number_table(), CellMessageContent::RequestBlock));
        }
        let BorderState { owned, numbers, .. } = &mut self.state;
        let published = |track_id: EngineTrackId| {
            owned.get(&track_id).filter(|owned| owned.is_published(slot)).map(|owned| owned.public.clone())
        };
        let known = |identity| numbers.known(identity);
        publish(picture, published, known);
        now.into_iter().for_each(|now| publish(now, published, known));
        let from = &self.region.cell;
        let message = |(index, (to, content)): (usize, (CellName, CellMessageContent))| {
            let index = u16::try_from(index).ok()?;
            Some(CellMessage { from: from.clone(), to, slot, index, content })
        };
        let messages: Vec<CellMessage> = outgoing.into_iter().enumerate().filter_map(message).collect();
        let sent = &mut self.state.sent;
        sent.extend(messages.iter().cloned());
        while sent.front().is_some_and(|message| message.slot < slot.plus(-RESEND_SLOTS)) {
            sent.pop_front();
        }
        messages
    }

    /// Messages sent in the last 20 s.
    pub fn recent_messages(&self) -> Vec<CellMessage> {
        self.state.sent.iter().cloned().collect()
    }

    /// Decides which cell owns a track of the engine's picture.
    fn assign_owner(&mut self, track: &PictureTrack, slot: Slot) {
        let track_id = EngineTrackId::of(track);
        let is_new = !self.state.known.contains_key(&track_id);
        let known = self.state.known.entry(track_id).or_insert(KnownAircraft {
            seen: slot,
            unowned_since: None,
            asked: None,
            kept: None,
            held: None,
        });
        known.seen = slot;
        let identity = track.point.source.transponder().map(|part| part.identity);
        if let Some(owned) = self.state.owned.get_mut(&track_id) {
            // A transponder may have been associated since.
            if owned.numbers[1].is_none()
                && let Some(identity) = identity
                && let Some((number, is_given)) = self.state.numbers.number_for(Some(identity), slot)
            {
                owned.numbers[1] = Some(number);
                self.report_number(is_given.then_some(identity), number);
            }
            let Some(owned) = self.state.owned.get(&track_id) else { return };
            owned.numbers.into_iter().flatten().for_each(|number| self.state.numbers.note(number, slot));
            return;
        }
        if !self.region.contains(track.position) {
            // An aircraft just beyond the border may be back in the next slot.
            if self.region.is_beyond(track.position) {
                (known.unowned_since, known.asked, known.kept) = (None, None, None);
            }
            return;
        }
        let sighting = Sighting::of(track, slot);
        if is_new && self.state.unseen.values().any(|(_, offered)| offered.may_have_been(&sighting)) {
            // Its owner also sees it again, and will repeat the offer.
            known.held = Some(slot);
        }
        let is_held = known.held.take_if(|since| slot >= since.plus(UNSEEN_OFFER_SLOTS)).is_some();
        if is_held || (is_new && known.held.is_none()) {
            return self.start_aircraft(track, slot);
        }
        let is_deep_inside = self.region.is_deep_inside(track.position);
        if known.kept.is_some_and(|kept| !is_deep_inside && slot < kept.plus(CONFIRMATION_VALID_SLOTS)) {
            return;
        }
        // A question from before a longer absence is discarded.
        known.asked = known.asked.filter(|asked| slot <= asked.last.plus(QUESTION_TIMEOUT_SLOTS));
        if known.asked.is_some_and(|asked| slot >= asked.first.plus(QUESTION_TIMEOUT_SLOTS)) {
            return self.start_aircraft(track, slot);
        }
        let is_unowned = slot >= known.unowned_since.get_or_insert(slot).plus(QUESTION_DELAY_SLOTS);
        if is_unowned && known.asked.is_none_or(|asked| slot >= asked.last.plus(REPEAT_SLOTS)) {
            self.counts.asked += u64::from(known.asked.is_none());
            let first = known.asked.map_or(slot, |asked| asked.first);
            known.asked = Some(OwnerQuestion { first, last: slot });
            let asks = self
                .region
                .neighbours()
                .map(|to| (to.clone(), CellMessageContent::AskOwner(sighting.clone())));
            self.state.answers.extend(asks);
        }
    }

    /// Starts an aircraft in this cell.
    fn start_aircraft(&mut self, track: &PictureTrack, slot: Slot) {
        let track_id = EngineTrackId::of(track);
        let identity = track.point.source.transponder().map(|part| part.identity);
        let Some((number, is_given)) = self.state.numbers.number_for(identity, slot) else {
            self.counts.unnumbered += 1;
            // Try again with the next slot.
            self.state.known.remove(&track_id);
            return;
        };
        self.report_number(identity.filter(|_| is_given), number);
        let radar = track.point.source.radar().map_or(0, |part| u32::from(part.track.number));
        let public = PublicName {
            id: format!("U-{}-{}", self.region.cell, base_32(self.state.next_id)),
            number: number * TRACK_NUMBER_FACTOR + radar,
            first_seen: track.time,
        };
        self.state.next_id += 1;
        self.counts.births += 1;
        let numbers = [Some(number), identity.map(|_| number)];
        let owned = OwnedAircraft { public, numbers, from: slot, until: None, offered: None, kept: None };
        self.state.owned.insert(track_id, owned);
    }

    /// Reports a new number to the table of numbers.
    fn report_number(&mut self, identity: Option<Identity>, number: u32) {
        let content = identity.map(|identity| CellMessageContent::Number { identity, number: Some(number) });
        self.state.answers.extend(content.map(|content| (number_table(), content)));
    }

    /// Removes aircraft that have ended or that another cell owns.
    fn remove_ended(&mut self, slot: Slot) {
        let BorderState { owned, known, unseen, given, written, numbers, answers, .. } = &mut self.state;
        owned.retain(|_, owned| owned.until.is_none_or(|until| slot < until));
        if slot.0.rem_euclid(REPEAT_SLOTS) != 0 {
            return;
        }
        let before = slot.plus(-ENDED_SLOTS);
        unseen.retain(|_, (since, _)| *since >= slot.plus(-OFFER_TIMEOUT_SLOTS));
        known.retain(|_, known| known.seen >= before);
        owned.retain(|track_id, owned| known.contains_key(track_id) || owned.from > slot);
        given.retain(|_, (_, since)| *since >= before);
        written.retain(|_, last| slot < last.plus(HANDOVER_AGAIN_SLOTS));
        let forgotten = numbers.release_expired(slot.plus(-NUMBER_RESERVED_SLOTS));
        answers.extend(
            forgotten
                .into_iter()
                .map(|identity| (number_table(), CellMessageContent::Number { identity, number: None })),
        );
    }

    /// Sends the engine's state of aircraft in the cell to adjacent cells that begin to see them, and of offered aircraft with
    /// the offer.
    fn send_handovers(
        &mut self,
        picture: &Picture,
        slot: Slot,
        EngineView { engine, frame }: &EngineView<'_>,
        outgoing: &mut Vec<(CellName, CellMessageContent)>,
    ) {
        let Self { region, state, .. } = self;
        let is_own = |place| region.contains(frame.to_geodetic(place));
        let mut write = |known: Option<TrackHandover>, to: &CellName| {
            outgoing.extend(known.map(|known| (to.clone(), CellMessageContent::Handover(Box::new(known)))));
        };
        for track in &picture.tracks {
            let offered = state.owned.get(&EngineTrackId::of(track)).and_then(|owned| owned.offered.as_ref());
            if let Some(offered) = offered.filter(|offered| offered.last == slot)
                && let Some(name) = engine.numbered(track.point.number)
            {
                // The other cell knows the surroundings there best.
                write(engine.handover(name, |_| false), &offered.to);
            }
        }
        if slot.0.rem_euclid(REPEAT_SLOTS) != 0 {
            return;
        }
        for (name, place) in engine.names().into_iter().filter(|(_, place)| is_own(*place)) {
            for to in region.cells_that_see(frame.to_geodetic(place)) {
                if state.written.insert((name, to.clone()), slot).is_none() {
                    write(engine.handover(name, is_own), to);
                }
            }
        }
    }

    /// Number of aircraft that this cell owns.
    pub fn owns(&self) -> usize {
        self.state.owned.len()
    }
}

/// Formats a count with the digits 0 to 9 and a to v.
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
