//! What is flown: shipped scenarios without attacks, and `spoof` with each attack.

use std::ops::RangeInclusive;

use utm_fusion::evaluate::AttackKind;
use utm_fusion::simulate::{Attack, Scenario};

use crate::flights::{Failure, scenario};

/// Scenarios without an attack; the receivers of `gaps` do not jump here.
const CLEAN: [&str; 5] = ["single", "crossing", "dense", "bias", "gaps"];
/// The attacks that are flown, and on how many seeds for each of a scenario without one.
const ATTACKS: [(Attack, u64); 7] = [
    (Attack::Drift, 3),
    (Attack::Jump, 2),
    (Attack::Frozen, 2),
    (Attack::Replay, 2),
    (Attack::Duplicate, 2),
    (Attack::Swapped, 2),
    (Attack::Time, 2),
];
/// Names of all of them.
pub const NAMES: [&str; 12] = [
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
    /// Somebody does.
    Attack(AttackKind),
}

impl What {
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean(name) => name,
            Self::Attack(kind) => kind.name(),
        }
    }
}

/// All flights, the largest first.
pub fn all(seeds: &RangeInclusive<u64>) -> Result<Vec<Flight>, Failure> {
    let mut flights = Vec::new();
    let mut names = CLEAN;
    names.sort_by_key(|name| *name != "dense");
    for name in names {
        let mut scenario = scenario(name)?;
        scenario.transponder.jump_every_s = 0.0;
        flights.extend(seeds.clone().map(|seed| Flight {
            what: What::Clean(name),
            scenario: scenario.clone(),
            seed,
        }));
    }
    let count = seeds.end() - seeds.start() + 1;
    for (attack, times) in ATTACKS {
        let scenario = attacked(attack)?;
        let kind = AttackKind::of_name(attack.name()).ok_or("an attack without a name")?;
        let seeds = *seeds.start()..seeds.start() + times * count;
        flights.extend(seeds.map(|seed| Flight {
            what: What::Attack(kind),
            scenario: scenario.clone(),
            seed,
        }));
    }
    Ok(flights)
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
