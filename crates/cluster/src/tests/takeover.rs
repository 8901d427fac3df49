//! Every order of events of a take-over within bounds: the rules of cells and leases, as the service runs them, over a model of the
//! log. `UTM_FUSION_MODEL_STEPS` is the number of steps for each of the bounds of the ignored test.

mod log;
mod recorder;
mod region;

use stateright::{Checker, Expectation, HasDiscoveries, Model, Path, Property};

use log::LogMutant;
use region::{Action, Bounds, NodeMutant, Region};

const ONCE: &str = "no slot is published twice, and none after a later one";
const NONE_LOST: &str = "no slot is missing";
const REPLACED: &str = "a replaced owner publishes nothing";
const SAME: &str = "pictures are those of an uninterrupted engine";
const FOLLOWED: &str = "no node's state differs from the owner's";
const RECOVERS: &str = "a node publishes the rest once faults end";

const TAKEN_OVER: &str = "another node publishes";
const FENCED: &str = "a node learns that it was replaced";
const TWO: &str = "two nodes take themselves for the owner";
const REFUSED: &str = "an output is refused";

/// One of this number of states is tried for recovery, which takes as long as many steps.
const RECOVERY_SHARE: u64 = 32;

/// Two nodes, one fault.
const PAIR: Bounds = Bounds {
    nodes: 2,
    slots: 3,
    inputs: 2,
    faults: 1,
    delays: 1,
    leases: 3,
    is_replicated: false,
    has_late_clocks: false,
    is_stateless: false,
    log: None,
    node: None,
};

/// Rules with the steps that break them.
type BrokenRules = Vec<(&'static str, Vec<Action>)>;

impl Model for Bounds {
    type State = Region;
    type Action = Action;

    fn init_states(&self) -> Vec<Region> {
        Region::phases(self)
    }

    fn actions(&self, region: &Region, actions: &mut Vec<Action>) {
        region.actions(self, actions);
    }

    fn next_state(&self, region: &Region, action: Action) -> Option<Region> {
        let mut next = region.clone();
        next.take(action, self);
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        let mut properties = vec![
            Property::always(ONCE, |_, region: &Region| {
                region.log.all_pairs(|one, next| one.slot < next.slot)
            }),
            Property::always(REPLACED, |_, region: &Region| {
                region.log.all_pairs(|one, next| one.epoch <= next.epoch)
            }),
            Property::sometimes(TAKEN_OVER, |_, region: &Region| {
                !region.log.all_pairs(|one, next| one.epoch == next.epoch)
            }),
        ];
        // A node without a checkpoint makes other pictures: those that knew the content of the slots are gone.
        if !self.is_stateless {
            properties.extend([
                Property::always(NONE_LOST, |_, region: &Region| {
                    region.log.all_pairs(|one, next| next.slot == one.slot.plus(1))
                }),
                Property::always(SAME, |_, region: &Region| region.log.is_reproducible()),
                Property::always(FOLLOWED, |_, region: &Region| region.loss.is_none()),
                Property::always(RECOVERS, |bounds: &Self, region: &Region| {
                    !region.digest().is_multiple_of(RECOVERY_SHARE) || region.recovers(bounds)
                }),
                Property::sometimes(FENCED, |_, region: &Region| region.is_fenced),
                Property::sometimes(TWO, |_, region: &Region| region.owners() > 1),
                Property::sometimes(REFUSED, |_, region: &Region| region.is_refused()),
            ]);
        }
        properties
    }
}

/// Explores the states in the order of their number of steps, until there are no more, or this number of steps was taken, or a rule
/// is broken. Returns the broken rules with the steps that break them, and the situations that did not occur.
fn explore(bounds: &Bounds, steps: usize) -> (BrokenRules, Vec<&'static str>) {
    let checker = bounds
        .clone()
        .checker()
        .threads(2)
        .target_state_count(steps)
        .finish_when(HasDiscoveries::AnyFailures)
        .spawn_bfs()
        .join();
    let (count, unique, depth) = (checker.state_count(), checker.unique_state_count(), checker.max_depth());
    println!("{bounds:?}: {count} steps, {unique} states, depth {depth}");
    let (mut broken, mut missed) = (Vec::new(), Vec::new());
    for Property { name, expectation, .. } in bounds.properties() {
        let found = checker.discovery(name).map(Path::into_actions);
        match expectation {
            Expectation::Always => broken.extend(found.map(|actions| (name, actions))),
            Expectation::Sometimes | Expectation::Eventually => {
                missed.extend(found.is_none().then_some(name));
            }
        }
    }
    (broken, missed)
}

/// Bounds of the exhaustive exploration. The first ones are explored in part by every run of the tests.
fn explored() -> Vec<Bounds> {
    vec![
        PAIR,
        Bounds { is_replicated: true, ..PAIR },
        Bounds { has_late_clocks: true, ..PAIR },
        Bounds { is_stateless: true, ..PAIR },
        Bounds { faults: 2, delays: 2, ..PAIR },
        Bounds { nodes: 3, ..PAIR },
    ]
}

#[test]
fn pair_of_nodes_satisfies_every_rule_within_bounds() {
    let [single, replicated] = &explored()[..2] else { panic!("two bounds") };
    assert_eq!(explore(single, 60_000), (Vec::new(), vec![REFUSED]));
    assert_eq!(explore(replicated, 60_000), (Vec::new(), Vec::new()));
}

#[test]
#[ignore = "minutes of two processors"]
fn nodes_satisfy_every_rule_in_all_bounds() {
    let steps = std::env::var("UTM_FUSION_MODEL_STEPS").map_or(600_000, |text| text.parse().unwrap());
    for bounds in explored() {
        assert_eq!(explore(&bounds, steps).0, []);
    }
}

/// The rules broken by a model without faults, in which nodes are only suspended.
fn broken_without_faults(bounds: &Bounds) -> Vec<&'static str> {
    let (broken, _) = explore(&Bounds { faults: 0, delays: 0, inputs: 1, ..bounds.clone() }, 400_000);
    broken.iter().for_each(|(rule, steps)| println!("{rule}: {steps:?}"));
    broken.into_iter().map(|(rule, _)| rule).collect()
}

#[test]
fn checker_finds_appends_without_expected_sequence() {
    let broken = broken_without_faults(&Bounds { log: Some(LogMutant::Unconditional), ..PAIR });
    assert!(broken.contains(&ONCE), "{broken:?}");
}

#[test]
fn checker_finds_replicated_outputs_without_names() {
    let nameless = Bounds { log: Some(LogMutant::Nameless), is_replicated: true, ..PAIR };
    assert!(broken_without_faults(&nameless).contains(&ONCE));
}

#[test]
fn checker_finds_an_owner_that_ignores_the_lease() {
    let broken = broken_without_faults(&Bounds { node: Some(NodeMutant::AnyLeaseIsMine), ..PAIR });
    assert!(broken.contains(&ONCE) && broken.contains(&REPLACED), "{broken:?}");
}

#[test]
fn checker_finds_a_cell_that_no_node_takes() {
    let (broken, _) = explore(&Bounds { node: Some(NodeMutant::EveryLeaseIsTaken), ..PAIR }, 60_000);
    let rules: Vec<&str> = broken.iter().map(|(rule, _)| *rule).collect();
    assert_eq!(rules, [RECOVERS]);
}
