//! Compares flights of `spoof` with and without integrity, and with and without the attack.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use utm_fusion::areas::Areas;
use utm_fusion::config::{Action, Config, Integrity};
use utm_fusion::evaluate::{OutputPoint, PointFlags, Scoring, evaluate};
use utm_fusion::simulate::{Simulation, simulate};

use super::flights::{AttackFlight, drifts};
use super::flown::{Replayed, attacks, configured, labels};
use super::rows::row;
use super::shares::{ratio, share};
use crate::flights::EvaluationFailure;
use crate::parallel;
use crate::results::ResultRow;

/// Comparison of one flight.
pub struct ComparedFlight {
    /// Whether `flag` without its three options publishes the same as `off`, except for flags.
    is_equal: bool,
    /// Sum and number of the errors of equipped drones that are not attacked: with `flag`, with `off`.
    others: [(f64, f64); 2],
    /// Azimuth registration errors of the first radar at the end, degrees: with an attack and jamming, with jamming
    /// only, without either.
    bearing_deg: Option<[f64; 3]>,
}

/// Flies each drift.
pub fn all(seeds: &RangeInclusive<u64>, threads: usize) -> Result<Vec<ComparedFlight>, EvaluationFailure> {
    parallel::each(&drifts(seeds)?, threads, |_, flight| of(flight)).into_iter().collect()
}

fn of(flight: &AttackFlight) -> Result<ComparedFlight, EvaluationFailure> {
    let simulation = simulate(&flight.scenario, flight.seed, None)?;
    let flag = Integrity::default();
    let off = Integrity { action: Action::Off, ..flag };
    let bare = Integrity { accuracy: false, show_twin: false, protect: false, ..flag };
    let [flag, off, bare] = [flag, off, bare].map(|integrity| replayed(&simulation, integrity));
    let honest = |jammed: u32| -> Result<Replayed, EvaluationFailure> {
        let mut scenario = flight.scenario.clone();
        (scenario.drones.spoofed, scenario.drones.jammed) = (0, jammed);
        Ok(replayed(&simulate(&scenario, flight.seed, None)?, Integrity::default()))
    };
    let (jammed, honest) = (honest(flight.scenario.drones.jammed)?, honest(0)?);
    let truth_deg = flight.scenario.radars.first().map_or(0.0, |radar| radar.bias_azimuth_deg);
    let error_deg = |replayed: &Replayed| Some((replayed.bearing_deg? - truth_deg).abs());
    let bearing_deg = || Some([error_deg(&flag)?, error_deg(&jammed)?, error_deg(&honest)?]);
    Ok(ComparedFlight {
        is_equal: unflagged(&bare.points) == unflagged(&off.points),
        others: [others(&simulation, &flag.points), others(&simulation, &off.points)],
        bearing_deg: bearing_deg(),
    })
}

fn replayed(simulation: &Simulation, integrity: Integrity) -> Replayed {
    let config = Config { integrity, ..configured(&simulation.config) };
    Replayed::of(simulation.receptions(), &config, &Areas::default())
}

fn unflagged(points: &[OutputPoint]) -> Vec<OutputPoint> {
    points.iter().map(|point| OutputPoint { flags: PointFlags::default(), ..point.clone() }).collect()
}

/// Sum and number of the errors of equipped drones that are not attacked.
fn others(simulation: &Simulation, points: &[OutputPoint]) -> (f64, f64) {
    let attacks = attacks(simulation);
    let attacked: BTreeSet<&str> = attacks.iter().map(|attack| attack.id.as_str()).collect();
    let settings = Scoring::of(&simulation.config);
    let scored = evaluate(&simulation.truth(), Some(&labels(simulation)), points, None, &settings);
    let drones = scored.drones.iter().zip(&scored.fused.drones);
    let others = drones
        .filter(|(drone, _)| drone.equipped == Some(true) && !attacked.contains(drone.id.as_str()))
        .filter_map(|(_, score)| score.epos);
    others.fold((0.0, 0.0), |sum, error| {
        let count = error.count as f64;
        (sum.0 + error.mean_m * count, sum.1 + count)
    })
}

/// Rows of the table.
pub fn rows(compared: &[ComparedFlight]) -> Vec<ResultRow> {
    let errors: Vec<(f64, f64)> = compared
        .iter()
        .map(|flight| flight.others.map(|(sum, count)| sum / count))
        .map(|[flag, off]| (flag, off))
        .collect();
    let bearings = |over: fn([f64; 3]) -> f64| {
        let errors_deg = compared.iter().filter_map(|flight| flight.bearing_deg);
        ratio(&errors_deg.map(|errors_deg| (errors_deg[0], over(errors_deg))).collect::<Vec<_>>())
    };
    vec![
        row(
            "`flag` without its three helpers: flights whose points are those of `off`, percent",
            share(compared.iter().map(|flight| flight.is_equal)),
        ),
        row("`flag` / `off`: error of equipped drones that are not attacked", ratio(&errors)).decimals(4),
        row("azimuth registration error: `spoof` / nothing attacked", bearings(|[_, _, honest]| honest))
            .decimals(2),
        row(
            "azimuth registration error: `spoof` / its other drone jammed alone",
            bearings(|[_, jammed, _]| jammed),
        )
        .decimals(2),
    ]
}
