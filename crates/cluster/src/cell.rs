//! A node's copy of a cell: it follows the owner's outputs, or owns the cell.

mod inputs;
#[cfg(test)]
mod model_state;
mod outputs;

use std::collections::VecDeque;

use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use super::message::{CellOutput, LoggedMessage, ReceivedDatagram};
use super::overload::{OverloadControl, SheddingLevel};
use super::reference_clock::{ClockReading, EARLY, NodeTime};
use super::region::CellMessage;
use super::watermarks::Watermarks;
pub use inputs::{InputRecord, InputRefusals};
use outputs::{OwnSlot, UnmatchedSlot};

/// Margin between assigned reception times and due times of slots. Data handled between two slots is received at least this long
/// after the first was due, and before the second is due.
const RECEPTION_MARGIN: SignedDuration = SignedDuration::from_micros(1);
/// Maximum number of inputs refused within a slot, so that the slot's output fits into a message. Further inputs are handled with
/// the next slot.
const MAX_REFUSED: usize = 10_000;
/// Maximum number of slots that an owner makes in one call of [`Cell::pump`].
const MAX_SLOTS_PER_CALL: usize = 4;
/// Time after an outage of the log, in addition to the wait for sensors, within which gateways repeat their requests.
const RETURN_WAIT: SignedDuration = SignedDuration::from_secs(1);

/// A cell's engine. The same inputs at the same times produce the same outputs, byte for byte.
pub trait CellEngine {
    /// Handles a datagram as received at `at`, which is before the next slot is due.
    fn receive(&mut self, datagram: &ReceivedDatagram, at: Time);

    /// Makes the slots due by `now`.
    fn tick(&mut self, now: Time);

    /// Time at which the next slot is due; `None` before the first datagram.
    fn next_due(&self) -> Option<Time>;

    /// Takes the next slot that was made, with its picture.
    fn poll(&mut self) -> Option<(Slot, Vec<u8>)>;

    /// Sets the level of load shedding from now on, because the machine cannot keep up.
    fn set_level(&mut self, _level: SheddingLevel) {}

    /// Handles a message addressed to this cell.
    fn handle_message(&mut self, _message: &CellMessage) {}

    /// Takes the messages to other cells written by the slot that was polled last.
    fn take_messages(&mut self) -> Vec<CellMessage> {
        Vec::new()
    }

    /// Messages to other cells written by the slots of the last 20 s. A new owner sends them again.
    fn recent_messages(&self) -> Vec<CellMessage> {
        Vec::new()
    }
}

/// Reason why a node has to restart a cell from a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CellLoss {
    /// The owner's picture differs from this node's.
    #[error("the state differs from the owner's")]
    Diverged,
    /// Another node owns the cell.
    #[error("another node owns the cell")]
    Fenced,
    /// This node's state is too old to reproduce the owner's outputs.
    #[error("the state is too old to follow the owner")]
    Behind,
}

/// A request to the log. Each is answered once before the cell makes the next request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LogRequest {
    /// Create the lease, which no node holds. Answered by [`Cell::handle_lease`].
    Lease,
    /// Read the cell's outputs after this sequence. Answered by [`Cell::handle_tail`].
    Tail(u64),
    /// Append an output if the last message among the cell's outputs has the expected sequence. Answered by [`Cell::handle_append`].
    Append {
        /// Sequence of the last message; 0 if there is none.
        expected: u64,
        /// Output to publish.
        output: CellOutput,
    },
}

/// Result of an append.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AppendResult {
    /// The output is stored, with this sequence.
    Stored(u64),
    /// The last output is not the expected one.
    Refused,
    /// The log did not answer in time.
    Unknown,
}

impl AppendResult {
    /// Result of an append whose message name was taken by the message with the sequence `there`. `is_output` states whether that
    /// message is among the cell's outputs, and `is_same` whether its content is the same. `None`: the output is sent again under
    /// another name.
    pub(crate) const fn of_taken_name(
        there: u64,
        expected: u64,
        is_output: bool,
        is_same: bool,
    ) -> Option<Self> {
        match (is_output, is_same) {
            (true, true) => Some(Self::Stored(there)),
            // Whether that message is valid is found by reading it.
            (true, false) if there > expected => Some(Self::Refused),
            _ => None,
        }
    }
}

/// A cell's outputs after a sequence, as read from the stream's leader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tail {
    /// Outputs with their sequences, in order, without messages that are not outputs.
    pub outputs: Vec<(u64, CellOutput)>,
    /// Sequence of the last message read, valid output or not; 0 if there is none.
    pub last: u64,
    /// Whether no message follows `last`.
    pub is_complete: bool,
    /// Whether this node certainly holds the lease, so that no other node can have a lease with a greater number.
    pub is_mine: bool,
}

/// Whether the log answers an owner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum LogState {
    /// It answers. Slots made before this time wait for data that gateways have kept.
    Available(Option<Time>),
    /// It has answered again since the last call of [`Cell::pump`].
    Returned,
    /// The last request was not answered.
    Away,
}

/// A node's role in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CellRole {
    /// The node reproduces the owner's outputs.
    Standby,
    /// The node holds the lease with number `epoch`. `until` is the sequence of the last output at that time, once known.
    Candidate { epoch: u64, until: Option<u64> },
    /// The node publishes.
    Owner { epoch: u64 },
}

/// A node's copy of a cell.
#[derive(Debug)]
#[cfg_attr(test, derive(Clone))]
pub struct Cell<E> {
    engine: E,
    grid: SlotGrid,
    /// Time to wait for sensors after a slot is due.
    wait: SignedDuration,
    role: CellRole,
    /// Inputs read and not yet handled: sequence, message, and whether this node would refuse it as the owner.
    inputs: VecDeque<(u64, LoggedMessage, bool)>,
    /// Hash of the shared configuration; 0 accepts inputs with any configuration.
    config: u64,
    /// Reference time, derived from the inputs read.
    time: NodeTime,
    /// Sequences of inputs that this owner has refused since the last slot, and counts for the log.
    refused: Vec<u64>,
    refusals: InputRefusals,
    /// Sequences of the last input read and of the last input handled.
    read: u64,
    handled: u64,
    /// Whether the log holds input that has not been read.
    has_more: bool,
    watermarks: Watermarks,
    /// Outputs published by other nodes and not yet reproduced by this node.
    outputs: VecDeque<(u64, CellOutput)>,
    /// Sequence of the last output that this node has reproduced or published.
    published: u64,
    /// Sequence of the last known message among the outputs, valid or not.
    last_known_output: u64,
    /// A slot made for comparison, while all outputs read so far have another picture or an earlier slot.
    unmatched: Option<UnmatchedSlot>,
    /// Last published slot.
    slot: Option<Slot>,
    /// Whether an output was skipped because it was made after an earlier input than the last one handled here.
    has_skipped_past: bool,
    /// Number of outputs skipped because no owner can have written them.
    foreign: u64,
    /// Lease number of the last output that an owner has stored.
    stored_epoch: Option<u64>,
    /// A greater lease number under which another node publishes. Whether that node holds the lease is not known yet.
    greater_epoch: Option<u64>,
    /// Whether `greater_epoch` was read before the last request to the log.
    is_tail_requested: bool,
    /// Greatest lease number in the outputs read.
    greatest_epoch: u64,
    /// Whether publication is suspended because the lease names another node, until it is known which node owns the cell.
    is_suspended: bool,
    /// Own slots that are not in the log yet.
    made: VecDeque<OwnSlot>,
    /// Messages to be sent to other cells.
    outbox: VecDeque<CellMessage>,
    /// This node does not publish slots up to this one.
    silent_until: Option<Slot>,
    /// Overload control, and the level in force.
    overload: OverloadControl,
    level: SheddingLevel,
    is_lease_free: bool,
    /// Whether a state is wanted that has no slots or refused inputs waiting for the log.
    is_rest_requested: bool,
    /// Whether a request is unanswered.
    is_request_pending: bool,
    /// Whether more slots could be made at once.
    has_due_slots: bool,
    is_tail_unknown: bool,
    log_state: LogState,
}

impl<E: CellEngine> Cell<E> {
    /// A cell whose engine has handled the inputs up to the sequence `handled` and reproduced the outputs up to `published`; 0
    /// for none.
    pub fn new(engine: E, grid: SlotGrid, wait: SignedDuration, handled: u64, published: u64) -> Self {
        Self {
            engine,
            grid,
            wait,
            role: CellRole::Standby,
            inputs: VecDeque::new(),
            config: 0,
            time: NodeTime::default(),
            refused: Vec::new(),
            refusals: InputRefusals::default(),
            read: handled,
            handled,
            has_more: false,
            watermarks: Watermarks::default(),
            outputs: VecDeque::new(),
            published,
            last_known_output: published,
            unmatched: None,
            slot: None,
            has_skipped_past: false,
            foreign: 0,
            stored_epoch: None,
            greater_epoch: None,
            is_tail_requested: false,
            greatest_epoch: 0,
            is_suspended: false,
            made: VecDeque::new(),
            outbox: VecDeque::new(),
            silent_until: None,
            overload: OverloadControl::default(),
            level: SheddingLevel::default(),
            is_lease_free: false,
            is_rest_requested: false,
            is_request_pending: false,
            has_due_slots: false,
            is_tail_unknown: false,
            log_state: LogState::Available(None),
        }
    }

    /// Suppresses the publication of slots up to `slot`: the nodes that knew their content are gone.
    pub fn silent_until(self, slot: Slot) -> Self {
        Self { silent_until: Some(slot), ..self }
    }

    /// Sets the hash of the shared configuration: an owner refuses inputs of members with another one.
    pub fn configured(self, config: u64) -> Self {
        Self { config, ..self }
    }

    /// Whether this node publishes the cell.
    pub const fn owns(&self) -> bool {
        matches!(self.role, CellRole::Owner { .. })
    }

    /// Lease number under which this node publishes.
    pub const fn epoch(&self) -> Option<u64> {
        match self.role {
            CellRole::Owner { epoch } => Some(epoch),
            CellRole::Standby | CellRole::Candidate { .. } => None,
        }
    }

    /// Sequence of the last output that this node has reproduced or published.
    pub const fn published(&self) -> u64 {
        self.published
    }

    /// Number of slots that the owner has published and this node has not reproduced yet.
    pub fn outstanding(&self) -> u64 {
        self.outputs.len() as u64
    }

    /// Sequences of the last input handled and of the last output made, if the engine's state corresponds to exactly these.
    pub fn rest_sequences(&self) -> Option<(u64, u64)> {
        (self.made.is_empty() && self.unmatched.is_none() && self.refused.is_empty())
            .then_some((self.handled, self.published))
    }

    /// Requests such a state: an owner then handles no input between a slot and the next call.
    pub const fn request_rest(&mut self, is_wanted: bool) {
        self.is_rest_requested = is_wanted;
    }

    /// Whether the picture of the last slot made here differs from all pictures published for it so far.
    pub fn differs(&self) -> bool {
        self.unmatched.as_ref().is_some_and(|unmatched| unmatched.has_other)
    }

    /// Number of outputs skipped because no owner can have written them.
    pub const fn foreign(&self) -> u64 {
        self.foreign
    }

    /// Level of load shedding.
    pub const fn level(&self) -> SheddingLevel {
        self.level
    }

    /// Updates the level of load shedding, after [`Cell::pump`]: checks whether an owner has made all slots due at `now`.
    pub fn update_level(&mut self, now: ClockReading) {
        if !self.owns() || !self.time.is_settled() {
            return;
        }
        let now = self.now(now);
        let waits = self.engine.next_due().filter(|due| self.is_time_for(*due, now));
        let after_input = waits.map_or(SignedDuration::ZERO, |due| now - due - self.wait);
        self.level = self.overload.update(after_input, now);
    }

    /// Sets a level of load shedding, as if the node could not keep up.
    #[cfg(test)]
    pub(super) fn set_level(&mut self, level: SheddingLevel) {
        self.level = level;
        self.overload.adopt(level);
    }

    /// The engine, for checkpoints.
    pub const fn engine(&self) -> &E {
        &self.engine
    }

    /// The engine, for reports.
    pub const fn engine_mut(&mut self) -> &mut E {
        &mut self.engine
    }

    /// Sets whether the log holds input that has not been read. While it does, slots wait for all sensors: their data may be
    /// there.
    pub const fn set_has_more(&mut self, has_more: bool) {
        self.has_more = has_more;
    }

    /// Takes the next message to another cell. Messages are written into the log in this order, each at least once.
    pub fn next_message(&mut self) -> Option<CellMessage> {
        self.outbox.pop_front()
    }

    /// Sets whether a node holds the lease.
    pub const fn set_lease_held(&mut self, is_held: bool) {
        self.is_lease_free = !is_held;
    }

    /// Handles inputs and makes the slots due at `now`. An owner makes only a few slots per call, so that they are published and
    /// the level of load shedding is updated in between.
    ///
    /// # Errors
    /// This node has to restart the cell.
    pub fn pump(&mut self, now: ClockReading) -> Result<(), CellLoss> {
        self.has_due_slots = false;
        if !self.owns() {
            self.run_standby()?;
        }
        if let CellRole::Candidate { epoch, until: Some(until) } = self.role
            && self.outputs.is_empty()
            && self.last_known_output >= until
        {
            self.role = CellRole::Owner { epoch };
            // The log may have been away for the previous owner.
            self.log_state = LogState::Returned;
            self.is_tail_unknown = self.greater_epoch.is_some();
            self.start_publishing(epoch);
            // The previous owner may have been lost before it sent its messages.
            self.outbox.extend(self.engine.recent_messages());
        }
        if let CellRole::Owner { epoch } = self.role {
            let now = self.now(now);
            if self.log_state == LogState::Returned {
                self.log_state = LogState::Available(Some(now + self.wait + RETURN_WAIT));
            }
            self.run_owner(epoch, now);
        }
        Ok(())
    }

    /// Whether more slots can be made at once.
    pub const fn has_due_slots(&self) -> bool {
        self.has_due_slots
    }

    /// Returns the next request to the log, if any.
    pub fn next_request(&mut self) -> Option<LogRequest> {
        if self.is_request_pending {
            return None;
        }
        let request = match self.role {
            CellRole::Standby => self.is_lease_free.then_some(LogRequest::Lease),
            CellRole::Candidate { until: None, .. } => Some(self.request_tail()),
            CellRole::Candidate { .. } => None,
            CellRole::Owner { .. } if self.is_tail_unknown => Some(self.request_tail()),
            CellRole::Owner { .. } if self.is_suspended => None,
            CellRole::Owner { .. } => {
                let output = self.made.front().map(|made| made.output.clone());
                output.map(|output| LogRequest::Append { expected: self.last_known_output, output })
            }
        };
        self.is_request_pending = request.is_some();
        request
    }

    const fn request_tail(&mut self) -> LogRequest {
        self.is_tail_requested = true;
        LogRequest::Tail(self.last_known_output)
    }

    /// Handles the answer to [`LogRequest::Lease`]: the lease number. `None` if another node was first, or the log did not answer.
    pub fn handle_lease(&mut self, epoch: Option<u64>) {
        self.is_request_pending = false;
        self.is_lease_free = false;
        if let Some(epoch) = epoch {
            self.role = CellRole::Candidate { epoch, until: None };
            self.greater_epoch = Some(self.greatest_epoch).filter(|greatest| *greatest > epoch);
        }
    }

    /// Handles a lease that expired unclaimed and was created again under this number: the owner continues.
    pub const fn handle_recreated_lease(&mut self, number: u64) {
        if let CellRole::Owner { epoch } | CellRole::Candidate { epoch, .. } = &mut self.role {
            *epoch = number;
        }
    }

    /// Handles the answer to [`LogRequest::Append`].
    pub fn handle_append(&mut self, appended: AppendResult) {
        self.is_request_pending = false;
        self.note_answer(appended != AppendResult::Unknown);
        match appended {
            // The output may be read before it is acknowledged.
            AppendResult::Stored(sequence) if sequence <= self.published => {}
            AppendResult::Stored(sequence) => self.confirm_stored(sequence),
            AppendResult::Refused | AppendResult::Unknown => self.is_tail_unknown = true,
        }
    }

    /// Notes whether the log has answered a request.
    const fn note_answer(&mut self, is_answered: bool) {
        self.log_state = match (is_answered, self.log_state) {
            (false, _) => LogState::Away,
            (true, LogState::Away) => LogState::Returned,
            (true, state) => state,
        };
    }

    /// Handles inputs, and makes each slot once every sensor has reported up to its due time, or the wait is over.
    fn run_owner(&mut self, epoch: u64, now: Time) {
        if !self.time.is_settled() {
            return;
        }
        let mut remaining = MAX_SLOTS_PER_CALL;
        loop {
            if let Some(due) = self.engine.next_due()
                && self.is_time_for(due, now)
            {
                if remaining == 0 {
                    self.has_due_slots = true;
                    return;
                }
                remaining -= 1;
                while let Some((slot, picture)) = self.make(due) {
                    let messages = self.engine.take_messages();
                    self.engine.set_level(self.level);
                    if self.silent_until.is_some_and(|until| slot <= until) {
                        continue;
                    }
                    let (after_input, level) = (self.handled, self.level);
                    let refused = std::mem::take(&mut self.refused);
                    let output = CellOutput { slot, epoch, after_input, refused, level, picture };
                    self.made.push_back(OwnSlot { output, messages });
                }
            } else if self.refused.len() >= MAX_REFUSED
                || self.is_rest_requested && self.published > 0 && self.refused.is_empty()
            {
                return;
            } else {
                let Some((sequence, logged, is_refused)) = self.inputs.pop_front() else { return };
                self.handled = sequence;
                match is_refused {
                    true => self.refused.push(sequence),
                    false => self.handle(logged),
                }
            }
        }
    }

    /// Whether the slot that is due at `due` is made now. `now` is reference time.
    fn is_time_for(&self, due: Time, now: Time) -> bool {
        if due - now > EARLY {
            return false;
        }
        let latest = due + self.wait;
        let is_complete =
            self.watermarks.complete_slot().is_some_and(|slot| self.grid.open(slot.plus(1)) >= due);
        // A gateway writes slots in order, so an input this recent means that older inputs are in the log.
        let is_passed = match self.inputs.front() {
            Some((_, LoggedMessage::Input(input), false)) => self.grid.open(input.slot) >= latest,
            Some(_) | None => false,
        };
        // Unread input is not silence of a sensor, and neither is an outage of the log, during which gateways keep their data.
        let is_all_read = self.inputs.is_empty() && !self.has_more || self.refused.len() >= MAX_REFUSED;
        let is_silent = match self.log_state {
            // Reference time may have been set back.
            LogState::Available(until) => {
                let is_over = |until: Time| now >= until || until - now > self.wait + RETURN_WAIT;
                now >= latest && until.is_none_or(is_over)
            }
            LogState::Returned | LogState::Away => false,
        };
        is_complete || is_passed || is_all_read && is_silent
    }

    fn handle(&mut self, logged: LoggedMessage) {
        let input = match logged {
            LoggedMessage::Input(input) => input,
            LoggedMessage::Message(message) => return self.engine.handle_message(&message),
        };
        let slot = self.grid.slot();
        for datagram in &input.datagrams {
            // Clamp the reception time between the last slot and the next by the engine's own due time, which is the same on
            // every node.
            let at = self.engine.next_due().map_or(datagram.received, |due| {
                datagram.received.clamp(due + -slot + RECEPTION_MARGIN, due + -RECEPTION_MARGIN)
            });
            self.engine.receive(datagram, at);
        }
        if input.is_last {
            self.watermarks.note(input.sensor, input.slot);
        }
    }

    fn make(&mut self, due: Time) -> Option<(Slot, Vec<u8>)> {
        self.engine.tick(due);
        self.engine.poll()
    }
}
