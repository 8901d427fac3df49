//! Radars whose true errors differ from their data sheet: the site's `accuracy` stays the same, and the radar's random
//! errors, slow and white, are multiplied.

use std::ops::RangeInclusive;

use utm_fusion::simulate::Scenario;

use crate::flights::{self, EvaluationFailure, EvaluationFlight, FlightRow};

/// True errors as a percentage of those in the data sheet.
pub const PERCENT: [u32; 7] = [10, 30, 50, 70, 100, 150, 200];
/// Base flights: three equipped drones only, and a shipped scenario.
pub const BASES: [&str; 2] = [THREE, "crossing"];

const THREE: &str = "three";

/// Flights of a base with these seeds, for each percentage. They differ only in the size of the errors.
pub fn flights(
    base: &'static str,
    seeds: RangeInclusive<u64>,
) -> Result<Vec<EvaluationFlight>, EvaluationFailure> {
    let mut all = Vec::new();
    for percent in PERCENT {
        let mut scenario = scenario(base)?;
        scale(&mut scenario, f64::from(percent) / 100.0);
        all.extend(flights::of_scenario(&FlightRow::Sheet(base, percent), &scenario, seeds.clone(), 0.0));
    }
    Ok(all)
}

/// Rows of a base, by name.
pub fn rows(base: &'static str) -> impl Iterator<Item = (String, FlightRow)> {
    PERCENT.into_iter().map(move |percent| {
        (format!("{base} × {}", f64::from(percent) / 100.0), FlightRow::Sheet(base, percent))
    })
}

/// Scenario without registration bias, because only random errors are of interest.
fn scenario(base: &str) -> Result<Scenario, EvaluationFailure> {
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
