//! One encounter over time: the closest point of approach as it was foreseen, and as the true states lead to it.

use std::collections::BTreeMap;

use super::paths::{Paths, looks};
use super::{Foreseen, HORIZON_S, JUDGED_S, Owners, equipped};
use crate::evaluate::labels::Labels;
use crate::evaluate::truth::Truth;
use crate::evaluate::types::{OutputPoint, Scoring};
use fusion::time::{SECOND, Time};

/// How long is shown before they are closest, seconds: as early as a closest point is judged. Both have flown for so long.
const BEFORE_S: f64 = *JUDGED_S.end();
/// How long is shown after they were closest, nanoseconds.
const AFTER_NS: i64 = 5 * SECOND;

/// The closest point of approach over ground of two that fly straight on from a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlook {
    /// From when on.
    pub time: Time,
    /// Time until then, seconds, between 0 and the horizon.
    pub t_cpa_s: f64,
    /// Distance over ground then, metres.
    pub d_cpa_m: f64,
}

/// An outlook that was stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// What was stated.
    pub outlook: Outlook,
    /// Stated standard deviation of the distance, metres.
    pub sigma_m: f64,
}

/// The two equipped drones of a flight that came closest to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Encounter {
    /// Their ids.
    pub ids: [String; 2],
    /// When they were closest.
    pub time: Time,
    /// Their distance then, metres: in space, or over ground where a height is not known.
    pub distance_m: f64,
    /// Their distance over ground then, metres.
    pub ground_m: f64,
    /// By their true positions and velocities, in order of time.
    pub truth: Vec<Outlook>,
    /// As it was foreseen, in order of time; empty where nothing was.
    pub foreseen: Vec<Stated>,
}

/// The closest encounter of a flight; `None` where no two equipped drones flew together.
///
/// `foreseen` may be of several volumes: they say the same about where a pair is closest.
pub fn encounter<'a>(
    truth: &Truth,
    labels: &Labels,
    output: &[OutputPoint],
    foreseen: impl Iterator<Item = &'a Foreseen>,
    settings: &Scoring,
) -> Option<Encounter> {
    let paths = Paths::of(truth);
    let nearest = paths.nearest(&equipped(labels, truth), BEFORE_S)?;
    let (pair, time) = (nearest.pair, nearest.time);
    let from = Time::from_nanos(time.nanos() - (BEFORE_S * SECOND as f64) as i64);
    let until = Time::from_nanos(time.nanos() + AFTER_NS);
    let true_outlook = |time: Time| {
        let (t_cpa_s, d_cpa_m) = paths.relative(pair, time)?.closest(HORIZON_S);
        Some(Outlook { time, t_cpa_s, d_cpa_m })
    };
    let owners = Owners::of(truth, labels, output, settings.grid);
    let of_pair = |one: &&'a Foreseen| {
        one.is_seen && (from..=until).contains(&one.time) && owners.pair(one.numbers, one.time) == Some(pair)
    };
    let by_time: BTreeMap<Time, Stated> =
        foreseen.filter(of_pair).map(|one| (one.time, Stated::from(one))).collect();
    Some(Encounter {
        ids: pair.map(|drone| truth.tracks()[drone].id().to_owned()),
        time,
        distance_m: nearest.distance_m,
        ground_m: nearest.ground_m,
        truth: looks(from, until).filter_map(true_outlook).collect(),
        foreseen: by_time.into_values().collect(),
    })
}

impl From<&Foreseen> for Stated {
    fn from(one: &Foreseen) -> Self {
        // Across is the direction of the miss, so that the miss across is the distance.
        let (d_cpa_m, variance_m2) = one.across;
        let outlook = Outlook { time: one.time, t_cpa_s: one.t_cpa_s, d_cpa_m };
        Self { outlook, sigma_m: variance_m2.sqrt() }
    }
}
