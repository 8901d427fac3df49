//! A region of some nodes and a log, as a state from which every possible next step is taken.
//!
//! A node that takes no step is suspended: there is no fault of its own for it. Nodes make slots whenever the model chooses, which is
//! what wrong clocks and late data can cause at most.

use std::hash::{DefaultHasher, Hash, Hasher};

use fusion::slots::Slot;
use jiff::SignedDuration;

use super::log::{Agreed, Answer, LogMutant, ModelLog, Operation, Run, holder};
use super::recorder::{Recorder, grid, input};
use crate::cell::{AppendResult, Cell, CellLoss, LogRequest, Tail};
use crate::lease_rules::{
    EntryAnswer, EntryRequest, Lease, LeaseEnd, LeaseEvent, LeaseProcedure, PeerReports, RoleMemory,
    RoleStep, RoleView,
};
use crate::log::{Holder, Renewal};
use crate::reference_clock::ClockReading;

/// Present time. Times that are noted are moved into the past instead.
const NOW: SignedDuration = SignedDuration::from_secs(1_000);
const TICK: SignedDuration = SignedDuration::from_secs(1);
const LEASE: SignedDuration = SignedDuration::from_secs(super::log::LEASE_TICKS as i64);
/// Age above which a noted time does not change any more: no rule but one compares with more. A false name is remembered for ever.
const MAX_AGE: SignedDuration = SignedDuration::from_secs(2 * super::log::LEASE_TICKS as i64);
const WAIT: SignedDuration = SignedDuration::from_millis(500);
/// Time after a slot's due time at which an owner waits for nothing any more.
const WAITS_OVER: SignedDuration = SignedDuration::from_secs(10);
/// Maximum number of requests that a node has given up and the log may still execute.
const MAX_LATE: usize = 2;
/// Maximum number of slots that an owner has made and not published.
const MAX_MADE: u64 = 2;

/// A rule of the nodes that a model leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodeMutant {
    /// The lease is ignored: an owner takes another's outputs for foreign ones.
    AnyLeaseIsMine,
    /// No node takes a lease.
    EveryLeaseIsTaken,
}

/// Bounds and rules of a model.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub(super) nodes: usize,
    pub(super) slots: i64,
    pub(super) inputs: u64,
    /// Number of lost answers, crashes, orderly ends and reports not received.
    pub(super) faults: u8,
    /// Number of answers that arrive after other steps than the log's. Every other answer arrives at once.
    pub(super) delays: u8,
    /// Number of leases that are given to a node.
    pub(super) leases: u64,
    /// Whether servers agree on requests after the leader has checked them.
    pub(super) is_replicated: bool,
    /// Whether clocks of nodes may be late by a tick.
    pub(super) has_late_clocks: bool,
    /// Whether a node that starts has no checkpoint.
    pub(super) is_stateless: bool,
    pub(super) log: Option<LogMutant>,
    pub(super) node: Option<NodeMutant>,
}

/// A request of a node.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Call {
    /// Sent, and not executed.
    Asked(Operation),
    /// The servers agree on it.
    Agreed(Operation),
    Answered(Answer),
}

/// The tasks of a node that send requests: one for the lease, one for the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Port {
    Lease,
    Cell,
}

const PORTS: [Port; 2] = [Port::Lease, Port::Cell];

/// A node's last report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Report {
    run: u8,
    is_standby: bool,
}

#[derive(Clone, Debug)]
struct Node {
    run: u8,
    cell: Option<Cell<Recorder>>,
    lease: Option<Lease>,
    procedure: Option<LeaseProcedure>,
    /// First and last sequence of outputs that were read, while the lease is looked up.
    tail: Option<(u64, u64)>,
    calls: [Option<Call>; 2],
    memory: RoleMemory,
    read_inputs: u64,
    read_outputs: u64,
    /// Whether the lease was renewed in this tick, and need not be checked again.
    is_renewed: bool,
    /// Whether its clock is a tick late.
    is_late: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Region {
    pub(super) log: ModelLog,
    nodes: Vec<Node>,
    reports: Vec<Option<Report>>,
    /// Requests given up by their senders that may still be executed.
    late: Vec<Agreed>,
    faults: u8,
    delays: u8,
    /// Why a node has lost the cell, except that another owns it.
    pub(super) loss: Option<CellLoss>,
    /// Whether a node has lost the cell because another owns it.
    pub(super) is_fenced: bool,
}

/// A step of the region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Action {
    /// A second passes; on the clock of the node with this index, if any, later.
    Tick(Option<usize>),
    /// The late clock of a node is right again.
    CatchUp(usize),
    /// An input is written.
    Write,
    ReadInput(usize),
    ReadOutput(usize),
    /// A node without a lease reads that it is free.
    Check(usize),
    Renew(usize),
    /// An owner makes the next slot.
    Make(usize),
    /// The log executes a request, and the node receives the answer.
    Answer(usize, Port),
    /// The log executes a request, and the answer arrives later.
    Execute(usize, Port),
    /// The node receives the answer.
    Receive(usize, Port),
    /// The node gives the request up, or its answer is lost.
    Lose(usize, Port),
    /// The servers store the first request that they have agreed on.
    Store,
    /// The log executes a request that was given up.
    ExecuteLate(usize),
    Report(usize),
    /// A node's reports do not arrive.
    Silence(usize),
    Crash(usize),
    /// A node ends in order, and gives its lease up.
    Stop(usize),
    Start(usize),
}

struct Peers<'a>(&'a [Option<Report>]);

impl Peers<'_> {
    fn report(&self, by: &Holder) -> Option<Report> {
        let (node, report) = self.0.iter().enumerate().find(|(node, _)| by.node == format!("n{node}"))?;
        report.filter(|report| holder((node, report.run)) == *by)
    }
}

impl PeerReports for Peers<'_> {
    fn is_reporting(&self, by: &Holder) -> bool {
        self.report(by).is_some()
    }

    fn is_standby(&self, by: &Holder) -> bool {
        self.report(by).is_some_and(|report| report.is_standby)
    }
}

fn later(at: &mut SignedDuration) {
    *at = (*at - TICK).max(NOW - MAX_AGE);
}

impl Node {
    fn new() -> Self {
        Self {
            run: 0,
            cell: None,
            lease: None,
            procedure: None,
            tail: None,
            calls: [None, None],
            memory: RoleMemory::default(),
            read_inputs: 0,
            read_outputs: 0,
            is_renewed: false,
            is_late: false,
        }
    }

    fn tick(&mut self) {
        self.is_renewed = false;
        later(&mut self.memory.last_output_read);
        self.memory.false_name.iter_mut().for_each(later);
        if let Some(lease) = &mut self.lease {
            later(&mut lease.renewed);
            lease.challenged.iter_mut().for_each(later);
        }
        if let Some(procedure) = &mut self.procedure {
            procedure.for_each_time(later);
        }
    }

    /// Whether the lease is locked by a task.
    fn is_locked(&self) -> bool {
        self.procedure.is_some() || self.tail.is_some()
    }

    fn owns(&self) -> bool {
        self.cell.as_ref().is_some_and(Cell::owns)
    }
}

impl Hash for Node {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        let Self {
            run,
            cell,
            lease,
            procedure,
            tail,
            calls,
            memory,
            read_inputs,
            read_outputs,
            is_renewed,
            is_late,
        } = self;
        (run, lease, procedure, tail, calls, memory).hash(hasher);
        (read_inputs, read_outputs, is_renewed, is_late, cell.is_some()).hash(hasher);
        cell.iter().for_each(|cell| cell.write_state(hasher));
    }
}

impl Hash for Region {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        let Self { log, nodes, reports, late, faults, delays, loss, is_fenced: _ } = self;
        (log, nodes, reports, late.len(), faults, delays, loss.map(|loss| loss.to_string())).hash(hasher);
        late.iter().for_each(|Agreed { by, operation }| (by, operation).hash(hasher));
    }
}

impl PartialEq for Region {
    fn eq(&self, other: &Self) -> bool {
        self.digest() == other.digest()
    }
}

impl Region {
    /// A region whose first node owns the cell and has published a slot, and whose other nodes have reproduced it.
    pub(super) fn running(bounds: &Bounds) -> Self {
        let nodes = (0..bounds.nodes).map(|_| Node::new()).collect();
        let log = ModelLog { inputs: 1, ..ModelLog::default() };
        let mut region = Self {
            log,
            nodes,
            reports: vec![None; bounds.nodes],
            late: Vec::new(),
            faults: 0,
            delays: 0,
            loss: None,
            is_fenced: false,
        };
        let first = Bounds { slots: 1, node: None, log: None, ..bounds.clone() };
        for _ in 0..3 {
            region.round(&first);
        }
        assert_eq!(region.log.outputs.len(), 1, "{region:?}");
        assert!(
            region.nodes[0].owns() && region.nodes.iter().all(|node| node.read_outputs == 1),
            "{region:?}"
        );
        (region.faults, region.delays) = (bounds.faults, bounds.delays);
        region
    }

    /// The phases of a take-over at whose beginnings the exploration starts: the first node publishes; it is suspended with a slot
    /// to publish until its lease has expired; the second node has taken the lease.
    pub(super) fn phases(bounds: &Bounds) -> Vec<Self> {
        let mut region = Self::running(bounds);
        let mut phases = vec![region.clone()];
        region.take(Action::Make(0), bounds);
        while region.log.lease.is_some() {
            region.take(Action::Tick(None), bounds);
        }
        phases.push(region.clone());
        if !region.is_taken(1, bounds) {
            region.take(Action::Check(1), bounds);
            region.finish_calls(1, bounds);
            assert!(region.nodes[1].owns(), "{region:?}");
            phases.push(region);
        }
        phases
    }

    /// Hash of the state.
    pub(super) fn digest(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.hash(&mut hasher);
        hasher.finish()
    }

    /// Number of nodes that publish.
    pub(super) fn owners(&self) -> usize {
        self.nodes.iter().filter(|node| node.owns()).count()
    }

    /// Whether a node waits for the answer that its output was refused.
    pub(super) fn is_refused(&self) -> bool {
        let refused = Some(Call::Answered(Answer::Appended(AppendResult::Refused)));
        self.nodes.iter().any(|node| node.calls.contains(&refused))
    }

    pub(super) fn actions(&self, bounds: &Bounds, actions: &mut Vec<Action>) {
        actions.push(Action::Tick(None));
        if self.log.inputs < bounds.inputs {
            actions.push(Action::Write);
        }
        if !self.log.agreed.is_empty() {
            actions.push(Action::Store);
        }
        for (index, Agreed { by, operation }) in self.late.iter().enumerate() {
            if self.may_execute(*by, operation, bounds) {
                actions.push(Action::ExecuteLate(index));
            }
        }
        for (index, node) in self.nodes.iter().enumerate() {
            if node.is_late {
                actions.push(Action::CatchUp(index));
            } else if bounds.has_late_clocks {
                actions.push(Action::Tick(Some(index)));
            }
            self.node_actions(index, node, bounds, actions);
        }
    }

    fn node_actions(&self, index: usize, node: &Node, bounds: &Bounds, actions: &mut Vec<Action>) {
        let is_fault = self.faults > 0;
        let report = self.reports[index];
        let Some(cell) = &node.cell else {
            // Without a checkpoint a node waits until no other has the cell.
            if !bounds.is_stateless || self.log.lease.is_none() {
                actions.push(Action::Start(index));
            }
            // A node without a process reports nothing.
            if report.is_some() {
                actions.push(Action::Silence(index));
            }
            return;
        };
        if node.read_inputs < self.log.inputs {
            actions.push(Action::ReadInput(index));
        }
        if node.read_outputs < self.log.outputs.len() as u64 {
            actions.push(Action::ReadOutput(index));
        }
        if !node.is_locked() {
            match node.lease {
                Some(_) if !node.is_renewed => actions.push(Action::Renew(index)),
                None if !self.is_taken(index, bounds) => {
                    actions.push(Action::Check(index));
                }
                _ => {}
            }
        }
        if cell.owns() && cell.engine().slots() < bounds.slots && cell.unpublished() < MAX_MADE {
            actions.push(Action::Make(index));
        }
        for port in PORTS {
            match &node.calls[port as usize] {
                None => {}
                Some(Call::Asked(operation)) => {
                    let is_locked = node.tail.is_some() && node.procedure.is_some();
                    if !is_locked && self.may_execute((index, node.run), operation, bounds) {
                        let is_agreed = bounds.is_replicated && operation.is_write();
                        if !is_agreed {
                            actions.push(Action::Answer(index, port));
                        }
                        if self.delays > 0 || is_agreed {
                            actions.push(Action::Execute(index, port));
                        }
                    }
                    if is_fault {
                        actions.push(Action::Lose(index, port));
                    }
                }
                Some(Call::Agreed(_)) if is_fault => actions.push(Action::Lose(index, port)),
                Some(Call::Agreed(_)) => {}
                Some(Call::Answered(_)) => {
                    actions.push(Action::Receive(index, port));
                    if is_fault {
                        actions.push(Action::Lose(index, port));
                    }
                }
            }
        }
        if report != Some(self.own_report(index)) {
            actions.push(Action::Report(index));
        }
        if is_fault {
            actions.extend([Action::Crash(index), Action::Stop(index)]);
            if report.is_some() {
                actions.push(Action::Silence(index));
            }
        }
    }

    fn may_execute(&self, by: Run, operation: &Operation, bounds: &Bounds) -> bool {
        self.log.leases < bounds.leases || !self.log.gives_lease(by, operation)
    }

    /// Whether the cell is another node's, as this one knows.
    fn is_taken(&self, index: usize, bounds: &Bounds) -> bool {
        bounds.node == Some(NodeMutant::EveryLeaseIsTaken)
            || self.view(index).decide(|view| view.is_taken(&self.log.entry_state()))
    }

    fn own_report(&self, index: usize) -> Report {
        let node = &self.nodes[index];
        Report { run: node.run, is_standby: !node.owns() }
    }

    fn view(&self, index: usize) -> NodeView<'_> {
        let node = &self.nodes[index];
        NodeView { me: holder((index, node.run)), memory: node.memory, peers: Peers(&self.reports) }
    }

    /// Takes a step.
    pub(super) fn take(&mut self, action: Action, bounds: &Bounds) {
        match action {
            Action::Tick(late) => {
                self.log.tick();
                for (index, node) in self.nodes.iter_mut().enumerate() {
                    // A clock is late by one tick at most.
                    if late == Some(index) {
                        node.is_late = true;
                        node.is_renewed = false;
                    } else {
                        node.tick();
                    }
                }
            }
            Action::CatchUp(index) => {
                let node = &mut self.nodes[index];
                node.is_late = false;
                node.tick();
            }
            Action::Write => self.log.inputs += 1,
            Action::ReadInput(index) => {
                let written = self.log.inputs;
                let node = &mut self.nodes[index];
                node.read_inputs += 1;
                let sequence = node.read_inputs;
                if let Some(cell) = &mut node.cell {
                    cell.add_input(sequence, input(sequence));
                    cell.set_has_more(sequence < written);
                }
                self.settle(index, Ok(()));
            }
            Action::ReadOutput(index) => {
                let node = &mut self.nodes[index];
                let output = self.log.outputs[node.read_outputs as usize].clone();
                node.read_outputs += 1;
                node.memory.last_output_read = NOW;
                let sequence = node.read_outputs;
                let handled = node.cell.as_mut().map(|cell| cell.handle_output(sequence, output));
                self.settle(index, handled.unwrap_or(Ok(())));
            }
            Action::Check(index) => {
                self.nodes[index].cell.iter_mut().for_each(|cell| cell.set_lease_held(false));
                self.settle(index, Ok(()));
            }
            Action::Renew(index) => {
                let node = &mut self.nodes[index];
                node.is_renewed = true;
                if let Some(lease) = node.lease {
                    let (procedure, request) = LeaseProcedure::renew(lease, NOW);
                    node.procedure = Some(procedure);
                    node.calls[Port::Lease as usize] = Some(Call::Asked(Operation::Entry(request)));
                }
            }
            Action::Make(index) => {
                let Some(cell) = &mut self.nodes[index].cell else { return };
                let wall = grid().open(Slot(cell.engine().slots() + 1)) + WAITS_OVER;
                let made = cell.pump(ClockReading { wall, ..ClockReading::default() });
                self.settle(index, made);
            }
            Action::Answer(index, port) => {
                self.execute(index, port, bounds);
                self.receive(index, port, bounds);
            }
            Action::Execute(index, port) => {
                self.execute(index, port, bounds);
                if !matches!(self.nodes[index].calls[port as usize], Some(Call::Agreed(_))) {
                    self.delays = self.delays.saturating_sub(1);
                }
            }
            Action::Receive(index, port) => self.receive(index, port, bounds),
            Action::Lose(index, port) => {
                self.faults -= 1;
                self.give_up(index, port);
                self.receive(index, port, bounds);
            }
            Action::Store => self.store(bounds),
            Action::ExecuteLate(index) => {
                let Agreed { by, operation } = self.late.remove(index);
                self.log.execute(by, &operation, bounds.is_replicated, bounds.log);
            }
            Action::Report(index) => self.reports[index] = Some(self.own_report(index)),
            Action::Silence(index) => {
                self.faults -= u8::from(self.nodes[index].cell.is_some());
                self.reports[index] = None;
            }
            Action::Crash(index) => {
                self.faults -= 1;
                self.end(index);
                self.nodes[index].run += 1;
            }
            Action::Stop(index) => {
                self.faults -= 1;
                let (node, run) = (&self.nodes[index], self.nodes[index].run);
                let lease = node.lease;
                self.end(index);
                self.nodes[index].run += 1;
                if let Some(lease) = lease {
                    self.add_late(Agreed { by: (index, run), operation: Operation::Delete(lease.revision) });
                }
            }
            Action::Start(index) => self.start(index, bounds),
        }
    }

    fn start(&mut self, index: usize, bounds: &Bounds) {
        let cell = Cell::new(Recorder::default(), grid(), WAIT, 0, 0);
        let node = &mut self.nodes[index];
        node.cell = Some(match self.log.outputs.last() {
            Some(last) if bounds.is_stateless => {
                let published = self.log.outputs.len() as u64;
                node.read_outputs = published;
                Cell::new(Recorder::default(), grid(), WAIT, 0, published).silent_until(last.slot)
            }
            _ => cell,
        });
        node.memory = RoleMemory { last_output_read: NOW, false_name: None };
        self.settle(index, Ok(()));
    }

    /// Ends the node's part in the cell. Its requests may still be executed.
    fn end(&mut self, index: usize) {
        PORTS.into_iter().for_each(|port| self.give_up(index, port));
        let node = &mut self.nodes[index];
        *node = Node { run: node.run, is_late: node.is_late, ..Node::new() };
    }

    /// Gives a request up. The task receives no answer.
    fn give_up(&mut self, index: usize, port: Port) {
        let node = &mut self.nodes[index];
        let by = (index, node.run);
        let Some(call) = node.calls[port as usize].take() else { return };
        node.calls[port as usize] = Some(Call::Answered(unanswered(&call)));
        if let Call::Asked(operation) = call
            && operation.is_write()
        {
            self.add_late(Agreed { by, operation });
        }
    }

    fn add_late(&mut self, request: Agreed) {
        if self.late.len() == MAX_LATE {
            self.late.remove(0);
        }
        self.late.push(request);
    }

    fn execute(&mut self, index: usize, port: Port, bounds: &Bounds) {
        let node = &mut self.nodes[index];
        let Some(Call::Asked(operation)) = node.calls[port as usize].take() else { return };
        let done = self.log.execute((index, node.run), &operation, bounds.is_replicated, bounds.log);
        node.calls[port as usize] = Some(done.map_or(Call::Agreed(operation), Call::Answered));
    }

    fn store(&mut self, bounds: &Bounds) {
        let Agreed { by, operation } = self.log.agreed.remove(0);
        let answer = self.log.store(by, &operation, bounds.log);
        let node = &mut self.nodes[by.0];
        let is_waiting = |call: &&mut Option<Call>| **call == Some(Call::Agreed(operation.clone()));
        if node.run == by.1
            && let Some(call) = node.calls.iter_mut().find(is_waiting)
        {
            *call = Some(Call::Answered(answer));
        }
    }

    /// Passes an answer to the task that waits for it.
    fn receive(&mut self, index: usize, port: Port, bounds: &Bounds) {
        let Some(Call::Answered(answer)) = self.nodes[index].calls[port as usize].take() else { return };
        match port {
            Port::Lease => self.continue_procedure(index, answer),
            Port::Cell => {
                let result = self.answer_cell(index, answer, bounds);
                self.settle(index, result);
            }
        }
    }

    fn continue_procedure(&mut self, index: usize, answer: Answer) {
        let Some(mut procedure) = self.nodes[index].procedure.take() else { return };
        let Answer::Entry(answer) = answer else { return };
        let step = self.view(index).decide(|view| procedure.handle(answer, view));
        let node = &mut self.nodes[index];
        match step {
            RoleStep::Request(request) => {
                node.procedure = Some(procedure);
                let operation = match (request, node.lease) {
                    (EntryRequest::Replace(number), None) => Operation::Claim(number),
                    _ => Operation::Entry(request),
                };
                node.calls[Port::Lease as usize] = Some(Call::Asked(operation));
            }
            RoleStep::End(LeaseEnd { lease, events, is_soon, has_false_name }) => {
                node.lease = lease;
                node.is_renewed &= !is_soon;
                if has_false_name {
                    node.memory.false_name = Some(NOW);
                }
                if let Some(cell) = &mut node.cell {
                    for event in events {
                        match event {
                            LeaseEvent::Answer(taken) => cell.handle_lease(taken),
                            LeaseEvent::Recreated(number) => cell.handle_recreated_lease(number),
                            LeaseEvent::Suspend(is_suspended) => cell.set_suspended(is_suspended),
                        }
                    }
                }
                self.settle(index, Ok(()));
            }
        }
    }

    fn answer_cell(&mut self, index: usize, answer: Answer, bounds: &Bounds) -> Result<(), CellLoss> {
        let lease = self.nodes[index].lease;
        let tail = self.nodes[index].tail.take();
        let mine = match (&answer, lease) {
            (Answer::Entry(EntryAnswer::State(Some(entry))), Some(lease)) => {
                bounds.node == Some(NodeMutant::AnyLeaseIsMine)
                    || self.view(index).decide(|view| view.is_mine(&lease, entry))
            }
            _ => false,
        };
        let node = &mut self.nodes[index];
        let Some(cell) = &mut node.cell else { return Ok(()) };
        match (answer, tail) {
            (Answer::Appended(appended), _) => {
                cell.handle_append(appended);
                Ok(())
            }
            (Answer::Tail(after, last), _) => {
                node.tail = Some((after, last));
                node.calls[Port::Cell as usize] = Some(Call::Asked(Operation::Entry(EntryRequest::Read)));
                Ok(())
            }
            (Answer::Entry(EntryAnswer::State(Some(_))), Some((after, last))) => {
                let output = |sequence: u64| (sequence, self.log.outputs[sequence as usize - 1].clone());
                let outputs = (after + 1..=last).map(output).collect();
                cell.handle_tail(Ok(Tail { outputs, last, is_complete: true, is_mine: mine }))
            }
            _ => cell.handle_tail(Err(())),
        }
    }

    /// Runs the cell's thread and sends its request, or ends the node's part if the cell is lost.
    fn settle(&mut self, index: usize, result: Result<(), CellLoss>) {
        let node = &mut self.nodes[index];
        let Some(cell) = &mut node.cell else { return };
        if let Err(loss) = result.and_then(|()| cell.pump(ClockReading::default())) {
            match loss {
                CellLoss::Fenced => self.is_fenced = true,
                CellLoss::Diverged | CellLoss::Behind => self.loss = Some(loss),
            }
            return self.end(index);
        }
        let (port, operation) = match cell.next_request() {
            None => return,
            Some(LogRequest::Lease) => {
                let (procedure, request) = LeaseProcedure::take(NOW);
                node.procedure = Some(procedure);
                (Port::Lease, Operation::Entry(request))
            }
            Some(LogRequest::Tail(after)) => (Port::Cell, Operation::Tail(after)),
            Some(LogRequest::Append { expected, output }) => {
                (Port::Cell, Operation::Append { expected, output })
            }
        };
        node.calls[port as usize] = Some(Call::Asked(operation));
    }

    /// Whether the rest is published once no more faults occur and every node takes its steps.
    pub(super) fn recovers(&self, bounds: &Bounds) -> bool {
        let mut region = self.clone();
        region.late.clear();
        (0..24).any(|_| {
            region.round(bounds);
            region.log.outputs.last().is_some_and(|last| last.slot.0 == bounds.slots - 1)
        })
    }

    /// A second in which every node takes all its steps.
    fn round(&mut self, bounds: &Bounds) {
        for index in 0..self.nodes.len() {
            if self.nodes[index].is_late {
                self.take(Action::CatchUp(index), bounds);
            }
            if self.nodes[index].cell.is_none() {
                self.take(Action::Start(index), bounds);
            }
            self.take(Action::Report(index), bounds);
            self.finish_calls(index, bounds);
            while self.nodes[index].cell.is_some() && self.nodes[index].read_inputs < self.log.inputs {
                self.take(Action::ReadInput(index), bounds);
            }
            self.read_outputs(index, bounds);
            match self.nodes[index].lease {
                Some(_) if !self.nodes[index].is_locked() => self.take(Action::Renew(index), bounds),
                None if self.nodes[index].cell.is_some() && !self.is_taken(index, bounds) => {
                    self.take(Action::Check(index), bounds);
                }
                _ => {}
            }
            self.finish_calls(index, bounds);
            let is_owner = self.nodes[index].owns();
            if is_owner
                && self.nodes[index].cell.as_ref().is_some_and(|cell| cell.engine().slots() < bounds.slots)
            {
                self.take(Action::Make(index), bounds);
                self.finish_calls(index, bounds);
            }
        }
        (0..self.nodes.len()).for_each(|index| self.read_outputs(index, bounds));
        self.take(Action::Tick(None), bounds);
    }

    fn read_outputs(&mut self, index: usize, bounds: &Bounds) {
        while self.nodes[index].cell.is_some()
            && self.nodes[index].read_outputs < self.log.outputs.len() as u64
        {
            self.take(Action::ReadOutput(index), bounds);
            self.finish_calls(index, bounds);
        }
    }

    fn finish_calls(&mut self, index: usize, bounds: &Bounds) {
        for _ in 0..24 {
            if !self.log.agreed.is_empty() {
                self.take(Action::Store, bounds);
            }
            for port in PORTS {
                match &self.nodes[index].calls[port as usize] {
                    Some(Call::Asked(_)) => self.take(Action::Execute(index, port), bounds),
                    Some(Call::Answered(_)) => self.take(Action::Receive(index, port), bounds),
                    Some(Call::Agreed(_)) | None => {}
                }
            }
        }
    }
}

/// Result of a request without an answer.
fn unanswered(call: &Call) -> Answer {
    match call {
        Call::Asked(Operation::Entry(EntryRequest::Create))
        | Call::Agreed(Operation::Entry(EntryRequest::Create))
        | Call::Answered(Answer::Entry(EntryAnswer::Created(_))) => Answer::Entry(EntryAnswer::Created(None)),
        Call::Asked(Operation::Entry(EntryRequest::Replace(_)) | Operation::Claim(_))
        | Call::Agreed(Operation::Entry(EntryRequest::Replace(_)) | Operation::Claim(_))
        | Call::Answered(Answer::Entry(EntryAnswer::Replaced(_))) => {
            Answer::Entry(EntryAnswer::Replaced(Renewal::Unknown))
        }
        Call::Asked(Operation::Entry(EntryRequest::Read))
        | Call::Agreed(Operation::Entry(EntryRequest::Read))
        | Call::Answered(Answer::Entry(EntryAnswer::State(_))) => Answer::Entry(EntryAnswer::State(None)),
        Call::Asked(Operation::Append { .. })
        | Call::Agreed(Operation::Append { .. })
        | Call::Answered(Answer::Appended(_)) => Answer::Appended(AppendResult::Unknown),
        Call::Asked(_) | Call::Agreed(_) | Call::Answered(_) => Answer::Nothing,
    }
}

struct NodeView<'a> {
    me: Holder,
    memory: RoleMemory,
    peers: Peers<'a>,
}

impl<'a> NodeView<'a> {
    fn decide<T>(&self, decide: impl FnOnce(&RoleView<'_, Peers<'a>>) -> T) -> T {
        let Self { me, memory, peers } = self;
        decide(&RoleView { me, lease: LEASE, now: NOW, memory: *memory, peers })
    }
}
