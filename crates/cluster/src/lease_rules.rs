//! Rules by which a node takes, keeps and recovers the lease and the standby role of a cell. Sans-IO.
//!
//! Each is an entry of the log that expires unless it is renewed. A procedure states its next request for the entry, and handles the
//! answer. Other processes may write there, too: octets that no node can have written are overwritten, and the node continues.
//!
//! The rules decide which node publishes soon. The log prevents that two nodes publish the same slot: it refuses an output behind
//! one that its sender has not read.

use jiff::SignedDuration;

use super::log::{EntryState, HeldEntry, Holder, Renewal};

/// Time within which a node named in the lease has to publish. After it the name counts as false.
const CHALLENGE_TIMEOUT: SignedDuration = SignedDuration::from_millis(750);
/// Time after a false name for which further ones are overwritten at once.
const FALSE_NAME_MEMORY: SignedDuration = SignedDuration::from_secs(60);

/// A request for the entry of a role.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum EntryRequest {
    /// Create the entry with this node's name if no entry exists.
    Create,
    /// Read the entry.
    Read,
    /// Write this node's name over the entry with this number.
    Replace(u64),
}

/// The log's answer to an [`EntryRequest`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum EntryAnswer {
    /// Number of the created entry. `None` if an entry exists or the log did not answer.
    Created(Option<u64>),
    /// State of the entry. `None` if the log did not answer.
    State(Option<EntryState>),
    /// Result of a replacement.
    Replaced(Renewal),
}

/// A lease held by this node. Times are those of a clock that is never set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Lease {
    /// Lease number under which the node publishes.
    pub(crate) epoch: u64,
    /// Number of the last entry that it wrote.
    pub(crate) revision: u64,
    /// Time at which the last renewal was requested. Until a lease time after it, no other node can have found the lease free.
    pub(crate) renewed: SignedDuration,
    /// Time since when the lease names another node.
    pub(crate) challenged: Option<SignedDuration>,
}

/// Times that a node has noted about a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct RoleMemory {
    /// Time at which an output of the cell was last read.
    pub(crate) last_output_read: SignedDuration,
    /// Time at which the lease last had a false name.
    pub(crate) false_name: Option<SignedDuration>,
}

/// The other nodes, by their reports.
pub(crate) trait PeerReports {
    /// Whether that run of a node has reported recently.
    fn is_reporting(&self, by: &Holder) -> bool;

    /// Whether it reports to be the standby of the cell.
    fn is_standby(&self, by: &Holder) -> bool;
}

/// Knowledge of a node when it decides.
#[derive(Debug)]
pub(crate) struct RoleView<'a, P> {
    /// This run of the node.
    pub(crate) me: &'a Holder,
    /// Time after which an entry expires that is not renewed.
    pub(crate) lease: SignedDuration,
    /// Present time, by the clock that is never set.
    pub(crate) now: SignedDuration,
    pub(crate) memory: RoleMemory,
    pub(crate) peers: &'a P,
}

impl<P: PeerReports> RoleView<'_, P> {
    fn is_silent_for(&self, time: SignedDuration) -> bool {
        self.now - self.memory.last_output_read >= time
    }

    /// Whether another node has the cell, by its lease.
    pub(crate) fn is_taken(&self, lease: &EntryState) -> bool {
        match lease {
            EntryState::Free => false,
            // A cell without outputs has no owner, whatever the lease states.
            EntryState::Foreign(_) => !self.is_silent_for(self.lease),
            EntryState::Held(held) if held.by == *self.me || !self.peers.is_reporting(&held.by) => {
                !self.is_silent_for(self.lease)
            }
            EntryState::Held(held) => {
                !self.peers.is_standby(&held.by) || !self.is_silent_for(self.lease + self.lease)
            }
        }
    }

    /// Whether this node certainly has the lease, so that no other node can have one with a greater number. `held` is the lease
    /// as known to the node, `entry` as just read.
    pub(crate) fn is_mine(&self, held: &Lease, entry: &EntryState) -> bool {
        match entry {
            EntryState::Held(entry) if entry.by == *self.me => true,
            EntryState::Held(entry) if self.peers.is_reporting(&entry.by) => false,
            EntryState::Held(_) | EntryState::Foreign(_) => self.now - held.renewed < self.lease,
            EntryState::Free => false,
        }
    }
}

/// A message of a lease procedure to the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LeaseEvent {
    /// Answer to the cell's request of the lease: its number, if it was granted.
    Answer(Option<u64>),
    /// The lease had expired and was written again, under this number.
    Recreated(u64),
    /// Publication is suspended, or resumed.
    Suspend(bool),
}

/// Result of a lease procedure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LeaseEnd {
    /// The lease from now on.
    pub(crate) lease: Option<Lease>,
    /// Messages to the cell, in this order.
    pub(crate) events: Vec<LeaseEvent>,
    /// Whether the lease has to be checked again soon.
    pub(crate) is_soon: bool,
    /// Whether the name of a node that does not publish was overwritten.
    pub(crate) has_false_name: bool,
}

/// Next step of a procedure: a request, or its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum RoleStep<T> {
    /// The procedure waits for the answer to this request.
    Request(EntryRequest),
    /// The procedure has ended.
    End(T),
}

/// Request whose answer a lease procedure waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum LeaseStage {
    /// Creation of a lease, its state, and replacement of an entry that no owner keeps.
    Create,
    Look,
    Claim,
    /// Replacement of the node's own entry in a renewal, and the entry's state if that failed.
    Renew,
    Check,
    /// Creation of the lease after it has expired.
    Recreate,
    /// Replacement of an entry that no node can have written.
    Restore,
    /// Replacement of the name of a node that does not publish.
    Reclaim,
}

/// A procedure that takes or renews a lease.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LeaseProcedure {
    lease: Option<Lease>,
    asked: SignedDuration,
    stage: LeaseStage,
}

impl LeaseProcedure {
    /// Takes the lease if it is free.
    pub(crate) fn take(now: SignedDuration) -> (Self, EntryRequest) {
        (Self { lease: None, asked: now, stage: LeaseStage::Create }, EntryRequest::Create)
    }

    /// Renews a lease.
    pub(crate) fn renew(lease: Lease, now: SignedDuration) -> (Self, EntryRequest) {
        let procedure = Self { lease: Some(lease), asked: now, stage: LeaseStage::Renew };
        (procedure, EntryRequest::Replace(lease.revision))
    }

    /// Changes each time noted, for a model in which the present time is always the same.
    #[cfg(test)]
    pub(crate) fn for_each_time(&mut self, change: impl Fn(&mut SignedDuration)) {
        change(&mut self.asked);
        if let Some(lease) = &mut self.lease {
            change(&mut lease.renewed);
            lease.challenged.iter_mut().for_each(&change);
        }
    }

    /// Handles the answer to the last request.
    pub(crate) fn handle(
        &mut self,
        answer: EntryAnswer,
        view: &RoleView<'_, impl PeerReports>,
    ) -> RoleStep<LeaseEnd> {
        match (self.lease, answer) {
            (None, answer) => self.handle_take(answer, view),
            (Some(lease), answer) => self.handle_renewal(lease, answer, view),
        }
    }

    fn handle_take(
        &mut self,
        answer: EntryAnswer,
        view: &RoleView<'_, impl PeerReports>,
    ) -> RoleStep<LeaseEnd> {
        match answer {
            EntryAnswer::Created(None) => self.request(LeaseStage::Look, EntryRequest::Read),
            EntryAnswer::State(Some(entry)) if !view.is_taken(&entry) => match entry {
                EntryState::Foreign(revision) | EntryState::Held(HeldEntry { revision, .. }) => {
                    self.request(LeaseStage::Claim, EntryRequest::Replace(revision))
                }
                EntryState::Free => self.taken(None),
            },
            EntryAnswer::Created(taken) => self.taken(taken),
            EntryAnswer::Replaced(Renewal::Until(revision)) => self.taken(Some(revision)),
            EntryAnswer::State(_) | EntryAnswer::Replaced(_) => self.taken(None),
        }
    }

    fn taken(&self, taken: Option<u64>) -> RoleStep<LeaseEnd> {
        let renewed = self.asked;
        let lease = taken.map(|epoch| Lease { epoch, revision: epoch, renewed, challenged: None });
        let events = vec![LeaseEvent::Answer(taken)];
        RoleStep::End(LeaseEnd { lease, events, is_soon: false, has_false_name: false })
    }

    fn handle_renewal(
        &mut self,
        lease: Lease,
        answer: EntryAnswer,
        view: &RoleView<'_, impl PeerReports>,
    ) -> RoleStep<LeaseEnd> {
        match (self.stage, answer) {
            // The lease of a node whose entry is unchanged: only the time of the renewal is new.
            (LeaseStage::Renew, EntryAnswer::Replaced(Renewal::Until(revision))) => {
                let lease = Lease { revision, renewed: self.asked, ..lease };
                let events = Vec::new();
                RoleStep::End(LeaseEnd { lease: Some(lease), events, is_soon: false, has_false_name: false })
            }
            (LeaseStage::Renew, EntryAnswer::Replaced(Renewal::Lost)) => {
                self.request(LeaseStage::Check, EntryRequest::Read)
            }
            (LeaseStage::Renew, _) => ended(lease, Vec::new(), false),
            (LeaseStage::Check, EntryAnswer::State(Some(entry))) => self.recover(lease, entry, view),
            (LeaseStage::Restore, EntryAnswer::Replaced(Renewal::Until(revision))) => {
                self.resumed(lease, revision)
            }
            (LeaseStage::Recreate, EntryAnswer::Created(Some(number))) => self.written(lease, number, false),
            (LeaseStage::Reclaim, EntryAnswer::Replaced(Renewal::Until(number))) => {
                self.written(lease, number, true)
            }
            _ => ended(lease, Vec::new(), true),
        }
    }

    /// Handles a lease whose octets are not the last that this node wrote.
    fn recover(
        &mut self,
        mut lease: Lease,
        entry: EntryState,
        view: &RoleView<'_, impl PeerReports>,
    ) -> RoleStep<LeaseEnd> {
        let has_expired = view.now - lease.renewed >= view.lease;
        let revision = match entry {
            // This node's own entry, whose acknowledgement was lost.
            EntryState::Held(HeldEntry { by, revision }) if by == *view.me => {
                return self.resumed(lease, revision);
            }
            // Without a leader of the log no node could renew. The first one continues.
            EntryState::Free => return self.request(LeaseStage::Recreate, EntryRequest::Create),
            EntryState::Held(HeldEntry { by, revision }) if has_expired || view.peers.is_reporting(&by) => {
                revision
            }
            EntryState::Foreign(revision) if has_expired => revision,
            // No node can have written this: this node still owns the cell.
            EntryState::Foreign(revision) | EntryState::Held(HeldEntry { revision, .. }) => {
                return self.request(LeaseStage::Restore, EntryRequest::Replace(revision));
            }
        };
        // If the named node publishes soon, this node has lost the cell.
        let is_false = view.memory.false_name.is_some_and(|at| view.now - at < FALSE_NAME_MEMORY);
        let since = *lease.challenged.get_or_insert(self.asked);
        if view.now - since < CHALLENGE_TIMEOUT && (has_expired || !is_false) {
            return ended(lease, vec![LeaseEvent::Suspend(true)], true);
        }
        self.lease = Some(lease);
        self.request(LeaseStage::Reclaim, EntryRequest::Replace(revision))
    }

    /// The node still has its lease, under the same number.
    fn resumed(&self, lease: Lease, revision: u64) -> RoleStep<LeaseEnd> {
        let events = resumption(&lease);
        ended(Lease { revision, renewed: self.asked, challenged: None, ..lease }, events, false)
    }

    /// The node has written its lease again, under another number.
    fn written(&self, lease: Lease, number: u64, has_false_name: bool) -> RoleStep<LeaseEnd> {
        let mut events = vec![LeaseEvent::Recreated(number)];
        events.extend(resumption(&lease));
        let lease = Some(Lease { epoch: number, revision: number, renewed: self.asked, challenged: None });
        RoleStep::End(LeaseEnd { lease, events, is_soon: false, has_false_name })
    }

    fn request(&mut self, stage: LeaseStage, request: EntryRequest) -> RoleStep<LeaseEnd> {
        self.stage = stage;
        RoleStep::Request(request)
    }
}

fn resumption(lease: &Lease) -> Vec<LeaseEvent> {
    lease.challenged.map(|_| LeaseEvent::Suspend(false)).into_iter().collect()
}

fn ended(lease: Lease, events: Vec<LeaseEvent>, is_soon: bool) -> RoleStep<LeaseEnd> {
    RoleStep::End(LeaseEnd { lease: Some(lease), events, is_soon, has_false_name: false })
}

/// Aim of a standby procedure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum StandbyStage {
    /// Taking the role. `is_long` states that other octets have been there for longer than a lease lasts.
    Take { is_long: bool },
    /// Renewing the role, whose entry has this number.
    Renew(u64),
}

/// A procedure that takes or renews the standby role. Its result is the number of the entry, or `None` if another node has the
/// role; also if the log did not answer when the role was to be taken.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct StandbyProcedure {
    stage: StandbyStage,
    /// Whether the entry has been read.
    has_read: bool,
}

impl StandbyProcedure {
    /// Takes the standby role, also from octets that no node can have written.
    pub(crate) fn take(is_long: bool) -> (Self, EntryRequest) {
        (Self { stage: StandbyStage::Take { is_long }, has_read: false }, EntryRequest::Create)
    }

    /// Renews the standby role.
    pub(crate) fn renew(revision: u64) -> (Self, EntryRequest) {
        (Self { stage: StandbyStage::Renew(revision), has_read: false }, EntryRequest::Replace(revision))
    }

    /// Handles the answer to the last request.
    pub(crate) fn handle(
        &mut self,
        answer: EntryAnswer,
        view: &RoleView<'_, impl PeerReports>,
    ) -> RoleStep<Option<u64>> {
        let unanswered = match self.stage {
            StandbyStage::Take { .. } => None,
            StandbyStage::Renew(revision) => Some(revision),
        };
        match (self.stage, answer) {
            (_, EntryAnswer::Created(Some(revision)) | EntryAnswer::Replaced(Renewal::Until(revision))) => {
                RoleStep::End(Some(revision))
            }
            (StandbyStage::Take { .. }, EntryAnswer::Created(None)) if !self.has_read => self.read(),
            (StandbyStage::Renew(_), EntryAnswer::Replaced(Renewal::Lost)) if !self.has_read => self.read(),
            (_, EntryAnswer::State(Some(entry))) => self.found(&entry, view),
            (_, EntryAnswer::State(None) | EntryAnswer::Replaced(Renewal::Unknown)) => {
                RoleStep::End(unanswered)
            }
            (_, EntryAnswer::Created(None) | EntryAnswer::Replaced(Renewal::Lost)) => RoleStep::End(None),
        }
    }

    fn read(&mut self) -> RoleStep<Option<u64>> {
        self.has_read = true;
        RoleStep::Request(EntryRequest::Read)
    }

    fn found(&self, entry: &EntryState, view: &RoleView<'_, impl PeerReports>) -> RoleStep<Option<u64>> {
        let is_reporting = |held: &HeldEntry| view.peers.is_reporting(&held.by);
        match (self.stage, entry) {
            (StandbyStage::Renew(_), EntryState::Held(held)) if held.by == *view.me => {
                RoleStep::End(Some(held.revision))
            }
            (StandbyStage::Renew(_), EntryState::Free) => RoleStep::Request(EntryRequest::Create),
            (_, EntryState::Foreign(revision)) => RoleStep::Request(EntryRequest::Replace(*revision)),
            (StandbyStage::Renew(_) | StandbyStage::Take { is_long: true }, EntryState::Held(held))
                if !is_reporting(held) =>
            {
                RoleStep::Request(EntryRequest::Replace(held.revision))
            }
            (_, EntryState::Held(_) | EntryState::Free) => RoleStep::End(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct NobodyReports;

    impl PeerReports for NobodyReports {
        fn is_reporting(&self, _: &Holder) -> bool {
            false
        }

        fn is_standby(&self, _: &Holder) -> bool {
            false
        }
    }

    fn after(milliseconds: i64) -> SignedDuration {
        SignedDuration::from_millis(milliseconds)
    }

    fn holder(node: &str) -> Holder {
        Holder { node: node.to_owned(), ..Holder::default() }
    }

    fn step(
        procedure: &mut LeaseProcedure,
        answer: EntryAnswer,
        milliseconds: i64,
        memory: RoleMemory,
    ) -> RoleStep<LeaseEnd> {
        let me = holder("me");
        let (lease, now, peers) = (after(2_000), after(milliseconds), &NobodyReports);
        procedure.handle(answer, &RoleView { me: &me, lease, now, memory, peers })
    }

    fn state(entry: EntryState) -> EntryAnswer {
        EntryAnswer::State(Some(entry))
    }

    fn until(number: u64) -> EntryAnswer {
        EntryAnswer::Replaced(Renewal::Until(number))
    }

    /// A lease renewed at 0 s, and a renewal at this time that finds another entry.
    fn changed(lease: Option<Lease>, milliseconds: i64) -> (Lease, LeaseProcedure) {
        let lease =
            lease.unwrap_or(Lease { epoch: 5, revision: 7, renewed: SignedDuration::ZERO, challenged: None });
        let (mut procedure, request) = LeaseProcedure::renew(lease, after(milliseconds));
        assert_eq!(request, EntryRequest::Replace(lease.revision));
        let lost = EntryAnswer::Replaced(Renewal::Lost);
        let read = step(&mut procedure, lost, milliseconds, RoleMemory::default());
        assert_eq!(read, RoleStep::Request(EntryRequest::Read));
        (lease, procedure)
    }

    #[test]
    fn foreign_entry_of_a_valid_lease_is_overwritten() {
        let named = EntryState::Held(HeldEntry { by: holder("other"), revision: 9 });
        for entry in [EntryState::Foreign(9), named] {
            let (lease, mut procedure) = changed(None, 1_000);
            let replaced = step(&mut procedure, state(entry), 1_010, RoleMemory::default());
            assert_eq!(replaced, RoleStep::Request(EntryRequest::Replace(9)));
            let kept = Lease { revision: 10, renewed: after(1_000), ..lease };
            let end = step(&mut procedure, until(10), 1_020, RoleMemory::default());
            assert_eq!(end, ended(kept, Vec::new(), false));
        }
    }

    #[test]
    fn named_node_that_does_not_publish_loses_the_lease() {
        let named = || state(EntryState::Held(HeldEntry { by: holder("other"), revision: 9 }));
        let (_, mut procedure) = changed(None, 2_500);
        let end = step(&mut procedure, named(), 2_510, RoleMemory::default());
        let RoleStep::End(LeaseEnd { lease: Some(lease), events, is_soon: true, has_false_name: false }) =
            end
        else {
            panic!("{end:?}")
        };
        assert_eq!(
            (lease.challenged, &*events),
            (Some(after(2_500)), [LeaseEvent::Suspend(true)].as_slice())
        );
        let (_, mut procedure) = changed(Some(lease), 3_300);
        let replaced = step(&mut procedure, named(), 3_310, RoleMemory::default());
        assert_eq!(replaced, RoleStep::Request(EntryRequest::Replace(9)));
        let end = step(&mut procedure, until(10), 3_320, RoleMemory::default());
        let RoleStep::End(LeaseEnd { lease: Some(lease), events, is_soon: false, has_false_name: true }) =
            end
        else {
            panic!("{end:?}")
        };
        assert_eq!((lease.epoch, lease.challenged), (10, None));
        assert_eq!(events, [LeaseEvent::Recreated(10), LeaseEvent::Suspend(false)]);
    }

    #[test]
    fn silent_cells_lease_is_taken_from_a_foreign_entry() {
        for (read, taken) in [(0, Some(8)), (1_500, None)] {
            let memory = RoleMemory { last_output_read: after(read), false_name: None };
            let (mut procedure, request) = LeaseProcedure::take(after(2_000));
            assert_eq!(request, EntryRequest::Create);
            let looked = step(&mut procedure, EntryAnswer::Created(None), 2_000, memory);
            assert_eq!(looked, RoleStep::Request(EntryRequest::Read));
            let mut next = step(&mut procedure, state(EntryState::Foreign(7)), 2_000, memory);
            if next == RoleStep::Request(EntryRequest::Replace(7)) {
                next = step(&mut procedure, until(8), 2_000, memory);
            }
            let RoleStep::End(end) = next else { panic!("{next:?}") };
            assert_eq!(
                (end.lease.map(|lease| lease.epoch), end.events),
                (taken, vec![LeaseEvent::Answer(taken)])
            );
        }
    }

    #[test]
    fn standby_role_is_kept_if_the_log_does_not_answer() {
        let me = holder("me");
        let view = RoleView {
            me: &me,
            lease: after(2_000),
            now: after(5_000),
            memory: RoleMemory::default(),
            peers: &NobodyReports,
        };
        let (mut renewal, _) = StandbyProcedure::renew(3);
        assert_eq!(renewal.handle(EntryAnswer::Replaced(Renewal::Unknown), &view), RoleStep::End(Some(3)));
        let (mut renewal, _) = StandbyProcedure::renew(3);
        renewal.handle(EntryAnswer::Replaced(Renewal::Lost), &view);
        assert_eq!(renewal.handle(EntryAnswer::State(None), &view), RoleStep::End(Some(3)));
        let (mut taking, _) = StandbyProcedure::take(false);
        taking.handle(EntryAnswer::Created(None), &view);
        let other = HeldEntry { by: holder("other"), revision: 9 };
        assert_eq!(taking.handle(state(EntryState::Held(other)), &view), RoleStep::End(None));
    }
}
