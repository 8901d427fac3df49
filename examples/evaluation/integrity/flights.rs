//! What is flown: shipped scenarios without attacks, and `spoof` with each attack.

use std::ops::RangeInclusive;

use utm_fusion::evaluate::AttackKind;
use utm_fusion::simulate::{Attack, Scenario, Span};

use crate::flights::{Failure, scenario};

/// Scenarios without an attack, the largest first; the receivers of `gaps` do not jump here.
const CLEAN: [&str; 5] = ["dense", "crossing", "gaps", "bias", "single"];
/// The attacks that are flown, and on how many seeds for each of a scenario without one.
const ATTACKS: [(Attack, u64); 7] = [
    (Attack::Drift, DRIFTS),
    (Attack::Jump, 2),
    (Attack::Frozen, 2),
    (Attack::Replay, 2),
    (Attack::Duplicate, 2),
    (Attack::Swapped, 2),
    (Attack::Time, 2),
];
/// The same of drifts.
const DRIFTS: u64 = 3;
/// Of eight transponders in `crossing` three are jammed at once, seconds after take-off.
const JAMMED: u32 = 3;
const JAMMED_AFTER_S: f64 = 90.0;

/// Flights that are flown with and without integrity, and with and without an attack.
pub const COMPARED: &str = "compared";
/// Real flights.
pub const REAL: &str = "real";
/// Names of all that is flown.
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

/// A flight, and why it is flown.
pub struct Flight {
    pub what: What,
    pub scenario: Scenario,
    pub seed: u64,
}

/// Why a flight is flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Nobody lies.
    Clean(&'static str),
    /// Somebody does, or several are jammed.
    Attack(AttackKind),
    /// Nobody lies in a real flight.
    RealClean(&'static str),
    /// Somebody is made to in a real flight.
    RealAttack(&'static str),
}

impl What {
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean(name) | Self::RealClean(name) | Self::RealAttack(name) => name,
            Self::Attack(kind) => kind.name(),
        }
    }
}

/// All simulated flights, the largest first.
pub fn all(seeds: &RangeInclusive<u64>) -> Result<Vec<Flight>, Failure> {
    let mut flights = Vec::new();
    for name in CLEAN {
        let mut scenario = scenario(name)?;
        scenario.transponder.jump_every_s = 0.0;
        flights.extend(of(What::Clean(name), &scenario, seeds.clone()));
    }
    let mut jammed = scenario("crossing")?;
    jammed.drones.jammed = JAMMED;
    jammed.transponder.jam_after_s = Span::new(JAMMED_AFTER_S, JAMMED_AFTER_S);
    flights.extend(of(What::Attack(AttackKind::Jammed), &jammed, seeds.clone()));
    for (attack, times) in ATTACKS {
        let kind = AttackKind::of_name(attack.name()).ok_or("an attack without a name")?;
        flights.extend(of(What::Attack(kind), &attacked(attack)?, times_as_many(seeds, times)));
    }
    Ok(flights)
}

/// The flights with a drift.
pub fn drifts(seeds: &RangeInclusive<u64>) -> Result<Vec<Flight>, Failure> {
    let drift = attacked(Attack::Drift)?;
    Ok(of(What::Attack(AttackKind::Drift), &drift, times_as_many(seeds, DRIFTS)).collect())
}

fn of(what: What, scenario: &Scenario, seeds: RangeInclusive<u64>) -> impl Iterator<Item = Flight> {
    let scenario = scenario.clone();
    seeds.map(move |seed| Flight { what, scenario: scenario.clone(), seed })
}

fn times_as_many(seeds: &RangeInclusive<u64>, times: u64) -> RangeInclusive<u64> {
    let count = seeds.end() + 1 - seeds.start();
    *seeds.start()..=seeds.start() + times * count - 1
}

/// `spoof` with another attack: the same flights.
fn attacked(attack: Attack) -> Result<Scenario, Failure> {
    let mut scenario = scenario("spoof")?;
    scenario.transponder.attack = attack;
    if attack == Attack::Swapped {
        scenario.drones.spoofed = 2;
    }
    Ok(scenario)
}
