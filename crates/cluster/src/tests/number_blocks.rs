//! Every order of events when cells take blocks of numbers: each request is handled by two nodes, as after a take-over, and answers
//! are lost.

use std::collections::BTreeMap;

use stateright::{Checker, HasDiscoveries, Model, Property};

use crate::block_procedure::{BlockAnswer, BlockProcedure, BlockRequest, BlockStep};

const ONE_CELL: &str = "a block is given to one request";
const ONE_BLOCK: &str = "a repeated request is given the same block";
const ANSWERED: &str = "every request is answered";

/// Requests of two cells. The first is handled by two nodes; the second also, in the longer test.
const REQUESTS: [&str; 3] = ["a.1", "a.1", "b.1"];
const ALL_REQUESTS: [&str; 4] = ["a.1", "a.1", "b.1", "b.1"];

#[derive(Clone, Debug)]
struct Table {
    requests: &'static [&'static str],
    blocks: u32,
    /// Number of answers that may be lost.
    losses: u8,
    /// Whether a name is written although another is there.
    is_overwritten: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Call {
    Asked(BlockRequest),
    Answered(BlockAnswer),
}

/// A node that handles a request.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Handler {
    name: &'static str,
    procedure: BlockProcedure,
    call: Option<Call>,
    given: Option<u32>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    table: BTreeMap<u32, String>,
    handlers: Vec<Handler>,
    losses: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Action {
    Execute(usize),
    Receive(usize),
    /// The node receives no answer, and begins again.
    Lose(usize),
}

impl State {
    fn all_pairs(&self, rule: impl Fn(&Handler, &Handler) -> bool) -> bool {
        self.handlers.iter().all(|one| self.handlers.iter().all(|other| rule(one, other)))
    }
}

impl Table {
    fn begin(&self, name: &'static str) -> Handler {
        let (procedure, request) = BlockProcedure::take(name.to_owned(), self.blocks);
        Handler { name, procedure, call: Some(Call::Asked(request)), given: None }
    }

    fn answer(&self, table: &mut BTreeMap<u32, String>, name: &str, request: BlockRequest) -> BlockAnswer {
        match request {
            BlockRequest::List => BlockAnswer::Taken(table.keys().copied().collect()),
            BlockRequest::Read(block) => BlockAnswer::Name(table.get(&block).cloned()),
            BlockRequest::Create(block) if self.is_overwritten || !table.contains_key(&block) => {
                table.insert(block, name.to_owned());
                BlockAnswer::Created
            }
            BlockRequest::Create(_) => BlockAnswer::Exists,
        }
    }
}

impl Model for Table {
    type State = State;
    type Action = Action;

    fn init_states(&self) -> Vec<State> {
        let handlers = self.requests.iter().map(|name| self.begin(name)).collect();
        vec![State { table: BTreeMap::new(), handlers, losses: self.losses }]
    }

    fn actions(&self, state: &State, actions: &mut Vec<Action>) {
        for (index, handler) in state.handlers.iter().enumerate() {
            match handler.call {
                None => continue,
                Some(Call::Asked(_)) => actions.push(Action::Execute(index)),
                Some(Call::Answered(_)) => actions.push(Action::Receive(index)),
            }
            if state.losses > 0 {
                actions.push(Action::Lose(index));
            }
        }
    }

    fn next_state(&self, state: &State, action: Action) -> Option<State> {
        let mut next = state.clone();
        match action {
            Action::Execute(index) => {
                let handler = &mut next.handlers[index];
                let Some(Call::Asked(request)) = handler.call else { return None };
                handler.call = Some(Call::Answered(self.answer(&mut next.table, handler.name, request)));
            }
            Action::Receive(index) => {
                let handler = &mut next.handlers[index];
                let Some(Call::Answered(answer)) = handler.call.take() else { return None };
                match handler.procedure.handle(answer) {
                    BlockStep::Request(request) => handler.call = Some(Call::Asked(request)),
                    BlockStep::End(given) => handler.given = given,
                }
            }
            Action::Lose(index) => {
                next.losses -= 1;
                next.handlers[index] = self.begin(next.handlers[index].name);
            }
        }
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(ONE_CELL, |_, state: &State| {
                state.all_pairs(|one, other| {
                    one.name == other.name || one.given.is_none() || one.given != other.given
                })
            }),
            Property::always(ONE_BLOCK, |_, state: &State| {
                state.all_pairs(|one, other| {
                    one.name != other.name
                        || one.given.is_none()
                        || other.given.is_none()
                        || one.given == other.given
                })
            }),
            Property::always(ANSWERED, |_, state: &State| {
                state.handlers.iter().all(|handler| handler.call.is_some() || handler.given.is_some())
            }),
        ]
    }
}

/// The rules that are broken within the bounds, and the number of states.
fn broken(table: &Table) -> (Vec<&'static str>, usize) {
    let checker = table.clone().checker().finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
    let broken = checker.discoveries().into_iter().map(|(name, path)| {
        println!("{name}: {:?}", path.into_actions());
        name
    });
    let (broken, states) = (broken.collect(), checker.unique_state_count());
    println!("{table:?}: {states} states, {} steps at most", checker.max_depth());
    (broken, states)
}

#[test]
fn block_is_given_once_whatever_the_order() {
    let (broken, states) =
        broken(&Table { requests: &REQUESTS, blocks: 3, losses: 1, is_overwritten: false });
    assert!(broken.is_empty() && states > 1_000, "{broken:?} {states}");
}

#[test]
#[ignore = "a minute of a processor"]
fn block_is_given_once_to_two_repeated_requests() {
    let (broken, states) =
        broken(&Table { requests: &ALL_REQUESTS, blocks: 3, losses: 1, is_overwritten: false });
    assert!(broken.is_empty() && states > 100_000, "{broken:?} {states}");
}

#[test]
fn block_checker_finds_a_table_that_overwrites() {
    let (broken, _) = broken(&Table { requests: &REQUESTS, blocks: 3, losses: 0, is_overwritten: true });
    assert!(broken.contains(&ONE_CELL), "{broken:?}");
}
