//! Flights for integrity: shipped scenarios without attacks, and `spoof` with each attack.

use std::ops::RangeInclusive;

use utm_fusion::evaluate::AttackKind;
use utm_fusion::simulate::{Attack, Scenario, Span};

use crate::flights::{EvaluationFailure, scenario};

/// Scenarios without an attack, the largest first; the GNSS receivers of `gaps` do not jump here.
const CLEAN: [&str; 5] = ["dense", "crossing", "gaps", "bias", "single"];
/// Attacks, each with the number of seeds per seed of a scenario without an attack.
const ATTACKS: [(Attack, u64); 7] = [
    (Attack::Drift, DRIFTS),
    (Attack::Jump, 2),
    (Attack::Frozen, 2),
    (Attack::Replay, 2),
    (Attack::Duplicate, 2),
    (Attack::Swapped, 2),
    (Attack::Time, 2),
];
/// Number of seeds of the drift per seed of a scenario without an attack.
const DRIFTS: u64 = 3;
/// Number of the eight transponders in `crossing` that are jammed at the same time. `JAMMED_AFTER_S` is seconds after
/// take-off.
const JAMMED: u32 = 3;
const JAMMED_AFTER_S: f64 = 90.0;

/// Flights with and without integrity, and with and without an attack.
pub const COMPARED: &str = "compared";
/// Real flights.
pub const REAL: &str = "real";
/// Names of all flights.
pub const NAMES: [&str; 15] = [
    "single",
    "crossing",
    "dense",
    "bias",
    "gaps",
    "drift",
    "jump",
    "frozen",
    "replay",
    "duplicate",
    "swapped",
    "time",
    "jammed",
    COMPARED,
    REAL,
];

/// A flight, and its purpose.
pub struct AttackFlight {
    pub what: FlightKind,
    pub scenario: Scenario,
    pub seed: u64,
}

/// Purpose of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlightKind {
    /// Scenario without an attack.
    Clean(&'static str),
    /// An attack, or jamming of several transponders.
    Attack(AttackKind),
    /// A real flight without an attack.
    RealClean(&'static str),
    /// A real flight with an attack added.
    RealAttack(&'static str),
}

impl FlightKind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean(name) | Self::RealClean(name) | Self::RealAttack(name) => name,
            Self::Attack(kind) => kind.name(),
        }
    }
}

/// All simulated flights, the largest first.
pub fn all(seeds: &RangeInclusive<u64>) -> Result<Vec<AttackFlight>, EvaluationFailure> {
    let mut flights = Vec::new();
    for name in CLEAN {
        let mut scenario = scenario(name)?;
        scenario.transponder.jump_every_s = 0.0;
        flights.extend(of(FlightKind::Clean(name), &scenario, seeds.clone()));
    }
    let mut jammed = scenario("crossing")?;
    jammed.drones.jammed = JAMMED;
    jammed.transponder.jam_after_s = Span::new(JAMMED_AFTER_S, JAMMED_AFTER_S);
    flights.extend(of(FlightKind::Attack(AttackKind::Jammed), &jammed, seeds.clone()));
    for (attack, times) in ATTACKS {
        let kind = AttackKind::of_name(attack.name()).ok_or("an attack without a name")?;
        flights.extend(of(FlightKind::Attack(kind), &attacked(attack)?, times_as_many(seeds, times)));
    }
    Ok(flights)
}

/// Flights with a drift.
pub fn drifts(seeds: &RangeInclusive<u64>) -> Result<Vec<AttackFlight>, EvaluationFailure> {
    let drift = attacked(Attack::Drift)?;
    Ok(of(FlightKind::Attack(AttackKind::Drift), &drift, times_as_many(seeds, DRIFTS)).collect())
}

fn of(
    what: FlightKind,
    scenario: &Scenario,
    seeds: RangeInclusive<u64>,
) -> impl Iterator<Item = AttackFlight> {
    let scenario = scenario.clone();
    seeds.map(move |seed| AttackFlight { what, scenario: scenario.clone(), seed })
}

fn times_as_many(seeds: &RangeInclusive<u64>, times: u64) -> RangeInclusive<u64> {
    let count = seeds.end() + 1 - seeds.start();
    *seeds.start()..=seeds.start() + times * count - 1
}

/// Scenario `spoof` with another attack; the flights are the same.
fn attacked(attack: Attack) -> Result<Scenario, EvaluationFailure> {
    let mut scenario = scenario("spoof")?;
    scenario.transponder.attack = attack;
    if attack == Attack::Swapped {
        scenario.drones.spoofed = 2;
    }
    Ok(scenario)
}
