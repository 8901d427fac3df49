//! Shipped scenarios with one change, in the flight or in the service's configuration.

use std::ops::RangeInclusive;

use utm_fusion::config::{Config, Motion, SensorKind};
use utm_fusion::simulate::{Scenario, Span, VelocityModel};

use crate::flights::{self, EvaluationFailure, EvaluationFlight, FlightRow};

/// A scenario with a change.
pub struct Variant {
    pub name: &'static str,
    base: &'static str,
    flown: VariantSeed,
    change: fn(&mut Scenario),
    configure: fn(&mut Config),
}

/// Random seed of a variant.
#[derive(Clone, Copy, PartialEq, Eq)]
enum VariantSeed {
    /// Same as the base scenario: each flight differs only by the change.
    AsBase,
    /// Its own: the flights differ.
    Otherwise,
}

/// Birds that look like drones.
pub const BIRDS: [&str; 2] = ["crossing-birds-half", "dense-birds-half"];
/// A misaligned radar, and a transponder on every drone.
pub const BIAS_EQUIPPED: &str = "bias-equipped";
/// Sparse reports.
pub const SPARSE: &str = "transponder-period-5s";
/// The paper's Table 1.
pub const PAPER: &str = "paper";
/// The time-stamp delay of transponders is configured.
pub const DELAY_KNOWN: &str = "delay-known";
/// Misleading velocities of the radar, each with the scenario that has no velocities.
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
/// Several radars, each with the variant in which the service knows only the first radar.
pub const RADARS: [(&str, &str); 3] = [
    (TWO_RADARS, "two-radars-first-only"),
    (TWO_RADARS_PATCHY, "two-radars-patchy-first-only"),
    (THREE_RADARS, "three-radars-first-only"),
];

/// Variants, in the order of the table.
pub const VARIANTS: [Variant; 26] = [
    changed(BIAS_EQUIPPED, "bias", VariantSeed::AsBase, |scenario| {
        scenario.drones.equipped = scenario.drone_count();
    }),
    changed("track-azimuth-0.8", "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.radars[0].track_azimuth_deg = 0.8;
    }),
    changed("track-azimuth-1.8", "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.radars[0].track_azimuth_deg = 1.8;
    }),
    changed("radar-period-1s", "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.radars[0].period_s = 1.0;
        scenario.radars[0].drop_after_s = 4.0;
    }),
    changed("transponder-period-1s", "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.transponder.period_s = Span::new(1.0, 1.0);
    }),
    changed(SPARSE, "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.transponder.period_s = Span::new(5.0, 5.0);
    }),
    changed("velocities", "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.radars[0].velocities = true;
        scenario.transponder.velocities = true;
    }),
    changed(BOGUS[0].0, BOGUS[0].1, VariantSeed::AsBase, |scenario| {
        velocities(scenario, VelocityModel::Frozen);
    }),
    changed(BOGUS[1].0, BOGUS[1].1, VariantSeed::AsBase, |scenario| {
        velocities(scenario, VelocityModel::Scaled);
    }),
    changed(BOGUS[2].0, BOGUS[2].1, VariantSeed::AsBase, |scenario| {
        velocities(scenario, VelocityModel::Frozen);
    }),
    changed(BOGUS[3].0, BOGUS[3].1, VariantSeed::AsBase, |scenario| {
        velocities(scenario, VelocityModel::Scaled);
    }),
    changed("stamped-at-once", "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.transponder.stamped_late_s = Span::new(0.0, 0.0);
    }),
    // Mean delay in the simulation.
    configured(DELAY_KNOWN, "crossing", VariantSeed::AsBase, |config| known_delay(config, 0.125)),
    changed(BIRDS[0], "crossing", VariantSeed::Otherwise, birds_half),
    changed(BIRDS[1], "dense", VariantSeed::Otherwise, birds_half),
    changed("azimuth-bias-minus-3", "bias", VariantSeed::Otherwise, |scenario| {
        scenario.radars[0].bias_azimuth_deg = -3.0;
    }),
    changed("range-bias-15m", "crossing", VariantSeed::Otherwise, |scenario| {
        scenario.radars[0].bias_range_m = 15.0;
    }),
    configured("singer", "crossing", VariantSeed::Otherwise, |config| config.fusion.motion = Motion::Singer),
    configured("singer-gaps", "gaps", VariantSeed::Otherwise, |config| config.fusion.motion = Motion::Singer),
    changed(TWO_RADARS, "two-radars", VariantSeed::AsBase, |_| {}),
    configured(RADARS[0].1, "two-radars", VariantSeed::AsBase, first_radar_only),
    changed(TWO_RADARS_PATCHY, "two-radars", VariantSeed::AsBase, patchy),
    Variant {
        change: patchy,
        ..configured(RADARS[1].1, "two-radars", VariantSeed::AsBase, first_radar_only)
    },
    changed(THREE_RADARS, "three-radars", VariantSeed::AsBase, |_| {}),
    configured(RADARS[2].1, "three-radars", VariantSeed::AsBase, first_radar_only),
    // The threshold in the paper's Figure 6 is not readable; a wide one is used.
    configured(PAPER, "paper", VariantSeed::AsBase, |config| config.fusion.threshold_m = vec![(0.0, 300.0)]),
];

const fn changed(
    name: &'static str,
    base: &'static str,
    flown: VariantSeed,
    change: fn(&mut Scenario),
) -> Variant {
    Variant { name, base, flown, change, configure: |_| {} }
}

const fn configured(
    name: &'static str,
    base: &'static str,
    flown: VariantSeed,
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

/// Each radar sees a drone as often as the paper's radar did.
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

/// Reports of the other radars then come from unknown sources.
fn first_radar_only(config: &mut Config) {
    let mut radars = 0;
    config.sensors.retain(|sensor| {
        radars += u32::from(matches!(sensor.kind, SensorKind::Radar(_)));
        radars <= 1 || matches!(sensor.kind, SensorKind::Transponder(_))
    });
}

impl Variant {
    /// Flights of the variant with these seeds.
    pub fn flights(&self, seeds: RangeInclusive<u64>) -> Result<Vec<EvaluationFlight>, EvaluationFailure> {
        let mut scenario = flights::scenario(self.base)?;
        if self.flown == VariantSeed::Otherwise {
            self.name.clone_into(&mut scenario.name);
        }
        (self.change)(&mut scenario);
        let flights = flights::of_scenario(&FlightRow::Variant(self.name), &scenario, seeds, 0.0);
        Ok(flights
            .into_iter()
            .map(|flight| EvaluationFlight { configure: self.configure, ..flight })
            .collect())
    }
}
