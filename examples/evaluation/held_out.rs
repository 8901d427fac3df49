//! Scenarios that nothing was tuned on: shipped ones with other parameters, and other flights (another name is another
//! stream of chance). Of two the profile's model of motion is what is changed.

use utm_fusion::config::Motion;
use utm_fusion::simulate::{Scenario, Span};

use crate::flights::{self, Failure, Flight, Row};

/// Seeds of each.
const SEEDS: u64 = 6;

/// A scenario and what is changed in it.
pub struct Variant {
    pub name: &'static str,
    base: &'static str,
    change: fn(&mut Scenario),
}

/// The names of those that are flown by the Singer model.
const SINGER: [&str; 2] = ["singer", "singer-gaps"];

/// Birds that look like drones; their names are asked for, too.
pub const BIRDS: [&str; 2] = ["crossing-birds-half", "dense-birds-half"];

/// In the order of the table.
pub const VARIANTS: [Variant; 13] = [
    Variant {
        name: "track-azimuth-0.8",
        base: "crossing",
        change: |scenario| scenario.radars[0].track_azimuth_deg = 0.8,
    },
    Variant {
        name: "track-azimuth-1.8",
        base: "crossing",
        change: |scenario| scenario.radars[0].track_azimuth_deg = 1.8,
    },
    Variant {
        name: "radar-period-1s",
        base: "crossing",
        change: |scenario| {
            scenario.radars[0].period_s = 1.0;
            scenario.radars[0].drop_after_s = 4.0;
        },
    },
    Variant {
        name: "transponder-period-1s",
        base: "crossing",
        change: |scenario| scenario.transponder.period_s = Span::new(1.0, 1.0),
    },
    Variant {
        name: "transponder-period-5s",
        base: "crossing",
        change: |scenario| scenario.transponder.period_s = Span::new(5.0, 5.0),
    },
    Variant {
        name: "velocities",
        base: "crossing",
        change: |scenario| {
            scenario.radars[0].velocities = true;
            scenario.transponder.velocities = true;
        },
    },
    Variant {
        name: "stamped-at-once",
        base: "crossing",
        change: |scenario| scenario.transponder.stamped_late_s = Span::new(0.0, 0.0),
    },
    Variant { name: BIRDS[0], base: "crossing", change: birds_half },
    Variant { name: BIRDS[1], base: "dense", change: birds_half },
    Variant {
        name: "azimuth-bias-minus-3",
        base: "bias",
        change: |scenario| scenario.radars[0].bias_azimuth_deg = -3.0,
    },
    Variant {
        name: "range-bias-15m",
        base: "crossing",
        change: |scenario| scenario.radars[0].bias_range_m = 15.0,
    },
    Variant { name: SINGER[0], base: "crossing", change: |_| {} },
    Variant { name: SINGER[1], base: "gaps", change: |_| {} },
];

fn birds_half(scenario: &mut Scenario) {
    scenario.birds.zero_share = 0.0;
    scenario.birds.high_share = 1.0;
    scenario.birds.high_probability = Span::new(0.5, 0.5);
}

/// All of them.
pub fn flights() -> Result<Vec<Flight>, Failure> {
    let mut all = Vec::new();
    for Variant { name, base, change } in VARIANTS {
        let mut scenario = flights::scenario(base)?;
        name.clone_into(&mut scenario.name);
        change(&mut scenario);
        let mut flights = flights::of_scenario(&Row::HeldOut(name), &scenario, 1..=SEEDS, 0.0);
        let motion = if SINGER.contains(&name) { Motion::Singer } else { Motion::Imm };
        flights.iter_mut().for_each(|flight| flight.motion = motion);
        all.extend(flights);
    }
    Ok(all)
}
