//! Radars whose true errors are other than their data sheet says: the site's `accuracy` stays what it is, and the random
//! errors of the radar, slow and white, are a multiple of what the scenario has.

use std::ops::RangeInclusive;

use utm_fusion::simulate::Scenario;

use crate::flights::{self, Failure, Flight, Row};

/// The true errors over those that the data sheet stands for, in percent.
pub const PERCENT: [u32; 7] = [10, 30, 50, 70, 100, 150, 200];
/// What is flown: three equipped drones by themselves, and shipped scenarios.
pub const BASES: [&str; 2] = [THREE, "crossing"];

const THREE: &str = "three";

/// The flights of a base with these seeds, by each multiple: the same but for the size of the errors.
pub fn flights(base: &'static str, seeds: RangeInclusive<u64>) -> Result<Vec<Flight>, Failure> {
    let mut all = Vec::new();
    for percent in PERCENT {
        let mut scenario = scenario(base)?;
        scale(&mut scenario, f64::from(percent) / 100.0);
        all.extend(flights::of_scenario(&Row::Sheet(base, percent), &scenario, seeds.clone(), 0.0));
    }
    Ok(all)
}

/// The rows of a base, by name.
pub fn rows(base: &'static str) -> impl Iterator<Item = (String, Row)> {
    PERCENT
        .into_iter()
        .map(move |percent| (format!("{base} × {}", f64::from(percent) / 100.0), Row::Sheet(base, percent)))
}

/// Without any registration bias: what is asked is how well random errors are borne.
fn scenario(base: &str) -> Result<Scenario, Failure> {
    let mut scenario = flights::scenario(if base == THREE { "single" } else { base })?;
    if base == THREE {
        THREE.clone_into(&mut scenario.name);
        (scenario.drones.multirotors, scenario.drones.fixed_wings, scenario.drones.equipped) = (2, 1, 3);
        scenario.birds.count = 0;
    }
    for radar in &mut scenario.radars {
        (radar.bias_azimuth_deg, radar.bias_range_m, radar.bias_height_m) = (0.0, 0.0, 0.0);
    }
    Ok(scenario)
}

fn scale(scenario: &mut Scenario, by: f64) {
    for radar in &mut scenario.radars {
        let slow = [&mut radar.track_azimuth_deg, &mut radar.track_range_m, &mut radar.track_height_m];
        let white = [&mut radar.plot_azimuth_deg, &mut radar.plot_range_m, &mut radar.plot_height_m];
        slow.into_iter().chain(white).for_each(|error| *error *= by);
    }
}
