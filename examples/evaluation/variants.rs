//! Shipped scenarios with one thing changed: in the flight, or in the service's configuration.

use std::ops::RangeInclusive;

use utm_fusion::config::{Config, Motion, SensorKind};
use utm_fusion::simulate::{Scenario, Span, VelocityModel};

use crate::flights::{self, Failure, Flight, Row};

/// A scenario and what is changed in it.
pub struct Variant {
    pub name: &'static str,
    base: &'static str,
    flown: Flown,
    change: fn(&mut Scenario),
    configure: fn(&mut Config),
}

/// Which chance a variant is flown by.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Flown {
    /// Its base's: flight by flight the same but for the change.
    AsBase,
    /// Its own.
    Otherwise,
}

/// Birds that look like drones.
pub const BIRDS: [&str; 2] = ["crossing-birds-half", "dense-birds-half"];
/// A turned radar, and nobody without a transponder.
pub const BIAS_EQUIPPED: &str = "bias-equipped";
/// Sparse reports.
pub const SPARSE: &str = "transponder-period-5s";
/// The paper's Table 1.
pub const PAPER: &str = "paper";
/// How late transponders stamp is configured.
pub const DELAY_KNOWN: &str = "delay-known";
/// Velocities of the radar that are worth nothing, each with the scenario that has none of them.
pub const BOGUS: [(&str, &str); 4] = [
    ("velocities-frozen", "crossing"),
    ("velocities-scaled", "crossing"),
    ("velocities-frozen-gaps", "gaps"),
    ("velocities-scaled-gaps", "gaps"),
];
/// Several radars.
pub const TWO_RADARS: &str = "two-radars";
pub const TWO_RADARS_PATCHY: &str = "two-radars-patchy";
pub const THREE_RADARS: &str = "three-radars";
/// Several radars, each with the same flight of which the service knows only the first radar.
pub const RADARS: [(&str, &str); 3] = [
    (TWO_RADARS, "two-radars-first-only"),
    (TWO_RADARS_PATCHY, "two-radars-patchy-first-only"),
    (THREE_RADARS, "three-radars-first-only"),
];

/// In the order of the table.
pub const VARIANTS: [Variant; 26] = [
    changed(BIAS_EQUIPPED, "bias", Flown::AsBase, |scenario| {
        scenario.drones.equipped = scenario.drone_count();
    }),
    changed("track-azimuth-0.8", "crossing", Flown::Otherwise, |scenario| {
        scenario.radars[0].track_azimuth_deg = 0.8;
    }),
    changed("track-azimuth-1.8", "crossing", Flown::Otherwise, |scenario| {
        scenario.radars[0].track_azimuth_deg = 1.8;
    }),
    changed("radar-period-1s", "crossing", Flown::Otherwise, |scenario| {
        scenario.radars[0].period_s = 1.0;
        scenario.radars[0].drop_after_s = 4.0;
    }),
    changed("transponder-period-1s", "crossing", Flown::Otherwise, |scenario| {
        scenario.transponder.period_s = Span::new(1.0, 1.0);
    }),
    changed(SPARSE, "crossing", Flown::Otherwise, |scenario| {
        scenario.transponder.period_s = Span::new(5.0, 5.0);
    }),
    changed("velocities", "crossing", Flown::Otherwise, |scenario| {
        scenario.radars[0].velocities = true;
        scenario.transponder.velocities = true;
    }),
    changed(BOGUS[0].0, BOGUS[0].1, Flown::AsBase, |scenario| velocities(scenario, VelocityModel::Frozen)),
    changed(BOGUS[1].0, BOGUS[1].1, Flown::AsBase, |scenario| velocities(scenario, VelocityModel::Scaled)),
    changed(BOGUS[2].0, BOGUS[2].1, Flown::AsBase, |scenario| velocities(scenario, VelocityModel::Frozen)),
    changed(BOGUS[3].0, BOGUS[3].1, Flown::AsBase, |scenario| velocities(scenario, VelocityModel::Scaled)),
    changed("stamped-at-once", "crossing", Flown::Otherwise, |scenario| {
        scenario.transponder.stamped_late_s = Span::new(0.0, 0.0);
    }),
    // The mean of what is flown.
    configured(DELAY_KNOWN, "crossing", Flown::AsBase, |config| known_delay(config, 0.125)),
    changed(BIRDS[0], "crossing", Flown::Otherwise, birds_half),
    changed(BIRDS[1], "dense", Flown::Otherwise, birds_half),
    changed("azimuth-bias-minus-3", "bias", Flown::Otherwise, |scenario| {
        scenario.radars[0].bias_azimuth_deg = -3.0;
    }),
    changed("range-bias-15m", "crossing", Flown::Otherwise, |scenario| {
        scenario.radars[0].bias_range_m = 15.0;
    }),
    configured("singer", "crossing", Flown::Otherwise, |config| config.fusion.motion = Motion::Singer),
    configured("singer-gaps", "gaps", Flown::Otherwise, |config| config.fusion.motion = Motion::Singer),
    changed(TWO_RADARS, "two-radars", Flown::AsBase, |_| {}),
    configured(RADARS[0].1, "two-radars", Flown::AsBase, first_radar_only),
    changed(TWO_RADARS_PATCHY, "two-radars", Flown::AsBase, patchy),
    Variant { change: patchy, ..configured(RADARS[1].1, "two-radars", Flown::AsBase, first_radar_only) },
    changed(THREE_RADARS, "three-radars", Flown::AsBase, |_| {}),
    configured(RADARS[2].1, "three-radars", Flown::AsBase, first_radar_only),
    // The threshold of the paper's Figure 6 cannot be read; a wide one.
    configured(PAPER, "paper", Flown::AsBase, |config| config.fusion.threshold_m = vec![(0.0, 300.0)]),
];

const fn changed(name: &'static str, base: &'static str, flown: Flown, change: fn(&mut Scenario)) -> Variant {
    Variant { name, base, flown, change, configure: |_| {} }
}

const fn configured(
    name: &'static str,
    base: &'static str,
    flown: Flown,
    configure: fn(&mut Config),
) -> Variant {
    Variant { name, base, flown, change: |_| {}, configure }
}

fn birds_half(scenario: &mut Scenario) {
    scenario.birds.zero_share = 0.0;
    scenario.birds.high_share = 1.0;
    scenario.birds.high_probability = Span::new(0.5, 0.5);
}

fn velocities(scenario: &mut Scenario, model: VelocityModel) {
    for radar in &mut scenario.radars {
        (radar.velocities, radar.velocity_model) = (true, model);
    }
}

/// Each radar sees a drone as often as the paper's did.
fn patchy(scenario: &mut Scenario) {
    scenario.radars.iter_mut().for_each(|radar| radar.unseen_s = 20.0);
}

fn known_delay(config: &mut Config, delay_s: f64) {
    for sensor in &mut config.sensors {
        if let SensorKind::Transponder(transponder) = &mut sensor.kind {
            transponder.delay_s = Some(delay_s);
        }
    }
}

/// What the others send is then of sources that no sensor has.
fn first_radar_only(config: &mut Config) {
    let mut radars = 0;
    config.sensors.retain(|sensor| {
        radars += u32::from(matches!(sensor.kind, SensorKind::Radar(_)));
        radars <= 1 || matches!(sensor.kind, SensorKind::Transponder(_))
    });
}

impl Variant {
    /// Its flights with these seeds.
    pub fn flights(&self, seeds: RangeInclusive<u64>) -> Result<Vec<Flight>, Failure> {
        let mut scenario = flights::scenario(self.base)?;
        if self.flown == Flown::Otherwise {
            self.name.clone_into(&mut scenario.name);
        }
        (self.change)(&mut scenario);
        let flights = flights::of_scenario(&Row::Variant(self.name), &scenario, seeds, 0.0);
        Ok(flights.into_iter().map(|flight| Flight { configure: self.configure, ..flight }).collect())
    }
}
