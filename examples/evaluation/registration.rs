//! Accuracy of a radar's azimuth registration over time.

use std::ops::RangeInclusive;

use fusion::operational::Registered;
use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Scenario, simulate};

use crate::flights::EvaluationFailure;
use crate::results::{ResultRow, measured};
use crate::summary::MeanValue;

/// Minutes of flight of drones with a transponder after which the registration is scored.
const DRONE_MINUTES: [f64; 2] = [15.0, 200.0];

/// Results, one per flight: azimuth error in degrees, and its normalised square.
#[derive(Default)]
pub struct RegistrationResults {
    errors_deg: [Vec<f64>; 2],
    squares: Vec<f64>,
}

/// Flies the scenario for the required time.
pub fn found(
    scenario: &Scenario,
    seeds: RangeInclusive<u64>,
    threads: usize,
) -> Result<RegistrationResults, EvaluationFailure> {
    let equipped = f64::from(scenario.drones.equipped);
    let marks_s = DRONE_MINUTES.map(|minutes| 60.0 * minutes / equipped);
    let mut scenario = Scenario { duration_s: marks_s[1] + 10.0, ..scenario.clone() };
    // In such long flights the separation cannot be kept.
    scenario.drones.separation_m = 0.0;
    let mut found = RegistrationResults::default();
    let seeds: Vec<u64> = seeds.collect();
    for some in seeds.chunks(threads.max(1)) {
        let errors: Vec<_> = std::thread::scope(|scope| {
            let scenario = &scenario;
            let fly = |&seed: &u64| scope.spawn(move || of_flight(scenario, seed, marks_s));
            let flights: Vec<_> = some.iter().map(fly).collect();
            flights
                .into_iter()
                .map(|flight| flight.join().expect("a flight that panics is a fault"))
                .collect()
        });
        for of_flight in errors {
            for (errors_deg, (error_deg, deviation_deg)) in found.errors_deg.iter_mut().zip(of_flight?) {
                errors_deg.push(error_deg.abs());
                found.squares.push((error_deg / deviation_deg).powi(2));
            }
        }
    }
    Ok(found)
}

/// Azimuth error and its standard deviation, degrees, at these times after take-off.
fn of_flight(
    scenario: &Scenario,
    seed: u64,
    marks_s: [f64; 2],
) -> Result<[(f64, f64); 2], Box<dyn std::error::Error + Send + Sync>> {
    let simulation = simulate(scenario, seed, None)?;
    let mut config = simulation.config.clone();
    config.fusion.profile = Profile::Operational;
    let mut pipeline = Pipeline::new(&config, Masks::default());
    let truth_deg = scenario.radars.first().map_or(0.0, |radar| radar.bias_azimuth_deg);
    let mut errors = marks_s.map(|_| None);
    for reception in simulation.receptions() {
        let Some(received) = reception.received else { continue };
        pipeline.receive(&reception);
        for (error, mark_s) in errors.iter_mut().zip(marks_s) {
            if error.is_none() && received.seconds_since(scenario.start_time()) >= mark_s {
                let of = |(_, registered): (_, &Registered)| {
                    let bearing = registered.estimate.bearing;
                    (bearing.value.to_degrees() - truth_deg, bearing.deviation.to_degrees())
                };
                *error = pipeline.engine().registered().next().map(of);
            }
        }
    }
    let [Some(first), Some(second)] = errors else { return Err("a radar was not registered".into()) };
    Ok([first, second])
}

/// Rows of the table.
pub fn rows(found: &RegistrationResults) -> Vec<ResultRow> {
    let row = |figure, values: &[f64]| ResultRow::new(figure, measured(MeanValue::of(values), None));
    let [early, late] = &found.errors_deg;
    vec![
        row("azimuth registration after 15 drone-minutes of `crossing`: mean error, degrees", early),
        row("azimuth registration after 200 drone-minutes of `crossing`: mean error, degrees", late),
        row("NEES of the azimuth registration", &found.squares).farthest_from_one(),
    ]
}
