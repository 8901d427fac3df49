//! One encounter over time: the closest point of approach as predicted by the output, and as it follows from the true
//! states.

use std::collections::BTreeMap;

use super::paths::{TruePaths, time_steps};
use super::{ConflictPrediction, HORIZON_S, JUDGED_S, TrackOwners, equipped};
use crate::evaluate::labels::Labels;
use crate::evaluate::truth::Truth;
use crate::evaluate::types::{OutputPoint, Scoring};
use fusion::time::{SECOND, Time};

/// Time shown before the closest point, seconds. It is the earliest time at which closest points are scored, and both
/// drones must have flown for at least this time.
const BEFORE_S: f64 = *JUDGED_S.end();
/// Time shown after the closest point, nanoseconds.
const AFTER_NS: i64 = 5 * SECOND;

/// Closest point of approach over ground, for two drones that fly straight on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestApproach {
    /// Time at which the prediction is made.
    pub time: Time,
    /// Time to the closest point, seconds, between 0 and the horizon.
    pub t_cpa_s: f64,
    /// Distance over ground at the closest point, metres.
    pub d_cpa_m: f64,
}

/// A closest point of approach that the output predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedApproach {
    /// The prediction.
    pub approach: ClosestApproach,
    /// Predicted standard deviation of the distance, metres.
    pub sigma_m: f64,
}

/// The closest encounter of two drones with transponders during a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Encounter {
    /// Ids of the drones.
    pub ids: [String; 2],
    /// Time at which the drones were closest.
    pub time: Time,
    /// Distance at that time, metres: 3-D, or over ground if a height is unknown.
    pub distance_m: f64,
    /// Distance over ground at that time, metres.
    pub ground_m: f64,
    /// Predictions from the true positions and velocities, in order of time.
    pub truth: Vec<ClosestApproach>,
    /// Predictions in the output, in order of time; empty if there are none.
    pub foreseen: Vec<PredictedApproach>,
}

/// Finds the closest encounter of a flight; `None` if no two equipped drones flew at the same time.
///
/// `foreseen` may hold several volumes: their predictions of the closest point are the same.
pub fn encounter<'a>(
    truth: &Truth,
    labels: &Labels,
    output: &[OutputPoint],
    foreseen: impl Iterator<Item = &'a ConflictPrediction>,
    settings: &Scoring,
) -> Option<Encounter> {
    let paths = TruePaths::of(truth);
    let nearest = paths.nearest(&equipped(labels, truth), BEFORE_S)?;
    let (pair, time) = (nearest.pair, nearest.time);
    let from = Time::from_nanos(time.nanos() - (BEFORE_S * SECOND as f64) as i64);
    let until = Time::from_nanos(time.nanos() + AFTER_NS);
    let true_approach = |time: Time| {
        let (t_cpa_s, d_cpa_m) = paths.relative(pair, time)?.closest(HORIZON_S);
        Some(ClosestApproach { time, t_cpa_s, d_cpa_m })
    };
    let owners = TrackOwners::of(truth, labels, output, settings.grid);
    let of_pair = |one: &&'a ConflictPrediction| {
        one.is_seen && (from..=until).contains(&one.time) && owners.pair(one.numbers, one.time) == Some(pair)
    };
    let by_time: BTreeMap<Time, PredictedApproach> =
        foreseen.filter(of_pair).map(|one| (one.time, PredictedApproach::from(one))).collect();
    Some(Encounter {
        ids: pair.map(|drone| truth.tracks()[drone].id().to_owned()),
        time,
        distance_m: nearest.distance_m,
        ground_m: nearest.ground_m,
        truth: time_steps(from, until).filter_map(true_approach).collect(),
        foreseen: by_time.into_values().collect(),
    })
}

impl From<&ConflictPrediction> for PredictedApproach {
    fn from(one: &ConflictPrediction) -> Self {
        // `across` is in the direction of the miss, so its value is the distance.
        let (d_cpa_m, variance_m2) = one.across;
        let approach = ClosestApproach { time: one.time, t_cpa_s: one.t_cpa_s, d_cpa_m };
        Self { approach, sigma_m: variance_m2.sqrt() }
    }
}
