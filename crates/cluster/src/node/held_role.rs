//! A node's lease or standby role of a cell: executes the requests of the rules for it.

use std::sync::Mutex;
use std::sync::mpsc::Sender;

use jiff::SignedDuration;

use super::cell_member::CellMember;
use super::locked;
use super::node_reports::NodeReports;
use crate::cell_thread::{CellInput, send, steady};
use crate::lease_rules::{
    EntryAnswer, EntryRequest, Lease, LeaseEnd, LeaseEvent, LeaseProcedure, PeerReports, RoleMemory,
    RoleStep, RoleView, StandbyProcedure,
};
use crate::log::{EntryState, Holder, LogError};
use crate::node_report::NodeRole;

/// The lease or standby role of a cell that this node holds.
#[derive(Debug)]
pub(super) struct HeldRole {
    pub(super) lease: tokio::sync::Mutex<Option<Lease>>,
    memory: Mutex<RoleMemory>,
}

impl Default for HeldRole {
    fn default() -> Self {
        let memory = RoleMemory { last_output_read: steady(), false_name: None };
        Self { lease: tokio::sync::Mutex::default(), memory: Mutex::new(memory) }
    }
}

impl HeldRole {
    /// Notes that an output of the cell was read.
    pub(super) fn note_output(&self) {
        locked(&self.memory).last_output_read = steady();
    }
}

/// The reports of nodes about a cell.
struct CellReports<'a> {
    nodes: &'a NodeReports,
    cell: &'a str,
}

impl PeerReports for CellReports<'_> {
    fn is_reporting(&self, by: &Holder) -> bool {
        self.nodes.is_reporting(by)
    }

    fn is_standby(&self, by: &Holder) -> bool {
        self.nodes.role(by, self.cell) == Some(NodeRole::Standby)
    }
}

impl CellMember {
    fn view<T>(&self, decide: impl FnOnce(&RoleView<'_, CellReports<'_>>) -> T) -> T {
        let nodes = locked(&self.shared.nodes);
        let peers = CellReports { nodes: &nodes, cell: self.cell.as_str() };
        let lease = SignedDuration::try_from(self.lease()).unwrap_or(SignedDuration::MAX);
        let memory = *locked(&self.hold.memory);
        decide(&RoleView { me: &self.me, lease, now: steady(), memory, peers: &peers })
    }

    /// Executes a request for an entry.
    async fn ask(&self, key: &str, request: EntryRequest) -> EntryAnswer {
        match request {
            EntryRequest::Create => EntryAnswer::Created(self.log.create_entry(key, &self.me).await),
            EntryRequest::Read => EntryAnswer::State(self.log.entry_state(key).await.ok()),
            EntryRequest::Replace(revision) => {
                EntryAnswer::Replaced(self.log.renew_entry(key, &self.me, revision).await)
            }
        }
    }

    /// Whether another node has the cell, by its lease.
    pub(super) fn is_taken(&self, place: &EntryState) -> bool {
        self.view(|view| view.is_taken(place))
    }

    /// Whether another node has the cell.
    pub(super) async fn is_owned(&self) -> Result<bool, LogError> {
        Ok(self.is_taken(&self.log.entry_state(&self.owner()).await?))
    }

    /// Takes the lease if it is free.
    pub(super) async fn take_lease(&self, to_cell: &Sender<CellInput>) {
        let mut lease = self.hold.lease.lock().await;
        self.run_lease(&mut lease, LeaseProcedure::take(steady()), to_cell).await;
    }

    /// Whether this node certainly has the lease, so that no other node can have one with a greater number. The lease has to be
    /// locked.
    pub(super) async fn is_mine(&self, lease: Option<Lease>) -> Result<bool, LogError> {
        let Some(lease) = lease else { return Ok(false) };
        let entry = self.log.entry_state(&self.owner()).await?;
        Ok(self.view(|view| view.is_mine(&lease, &entry)))
    }

    /// Renews the lease. Returns whether it has to be checked again soon.
    pub(super) async fn renew_lease(&self, to_cell: &Sender<CellInput>) -> bool {
        let mut lease = self.hold.lease.lock().await;
        let Some(held) = *lease else { return false };
        self.run_lease(&mut lease, LeaseProcedure::renew(held, steady()), to_cell).await
    }

    async fn run_lease(
        &self,
        lease: &mut Option<Lease>,
        (mut procedure, mut request): (LeaseProcedure, EntryRequest),
        to_cell: &Sender<CellInput>,
    ) -> bool {
        let key = self.owner();
        let end = loop {
            let answer = self.ask(&key, request).await;
            match self.view(|view| procedure.handle(answer, view)) {
                RoleStep::Request(next) => request = next,
                RoleStep::End(end) => break end,
            }
        };
        let LeaseEnd { lease: held, events, is_soon, has_false_name } = end;
        *lease = held;
        if has_false_name {
            locked(&self.hold.memory).false_name = Some(steady());
            self.log.skips.note(&key, "the name of a node that does not publish");
        }
        for event in events {
            let input = match event {
                LeaseEvent::Answer(taken) => CellInput::LeaseAnswer(taken),
                LeaseEvent::Recreated(number) => CellInput::LeaseRecreated(number),
                LeaseEvent::Suspend(is_suspended) => CellInput::Suspend(is_suspended),
            };
            send(to_cell, input);
        }
        is_soon
    }

    /// Takes the standby role, also from octets that no node can have written. `is_long` states that these have been there for
    /// longer than a lease lasts. `None` if another node has the role or the log did not answer.
    pub(super) async fn take_standby(&self, is_long: bool) -> Option<u64> {
        self.run_standby(StandbyProcedure::take(is_long)).await
    }

    /// Renews the standby role. `None` if another node has it.
    pub(super) async fn renew_standby(&self, standby_revision: u64) -> Option<u64> {
        self.run_standby(StandbyProcedure::renew(standby_revision)).await
    }

    async fn run_standby(
        &self,
        (mut procedure, mut request): (StandbyProcedure, EntryRequest),
    ) -> Option<u64> {
        let key = self.standby();
        loop {
            let answer = self.ask(&key, request).await;
            match self.view(|view| procedure.handle(answer, view)) {
                RoleStep::Request(next) => request = next,
                RoleStep::End(revision) => return revision,
            }
        }
    }
}
