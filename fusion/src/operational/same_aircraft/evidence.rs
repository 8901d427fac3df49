//! Evidence that two transponder identities belong to one aircraft.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::operational::tuning::{
    SAME_APART_LOOKS, SAME_APART_SIGMAS, SAME_CROWD_M, SAME_FLOWN_M, SAME_HEIGHT_SIGMAS, SAME_LEAVE_LLR,
    SAME_LINK_LLR, SAME_LOOK_SIGMA_MAX_M, SAME_LOOKS, SAME_MEMORY_S, SAME_MOUNT_M, SAME_NEIGHBOURS_PER_M2,
    SAME_SLOW_S, SAME_SPACING_M, SAME_SPAN_S, SAME_TWO_TRACKS_S,
};
use crate::time::Time;

/// One comparison of two transponders at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct TransponderComparison {
    pub(super) time: Time,
    /// Position of one minus that of the other, over ground, metres.
    pub(super) apart: Vector2<f64>,
    /// Covariance of the persistent errors of both, with a correlation time of about a minute, m².
    pub(super) slow: Matrix2<f64>,
    /// Variance on each axis of the errors that are independent between reports, including interpolation, m².
    pub(super) white_m2: f64,
    /// Difference of the heights and its variance, metres and m²; `None` if one of them reports no height, or a coarse
    /// one.
    pub(super) height: Option<(f64, f64)>,
    /// Distance flown since the previous look, metres.
    pub(super) flown_m: f64,
    /// Number of other aircraft within [`SAME_CROWD_M`].
    pub(super) crowd: f64,
    /// Whether a radar has two tracks of them.
    pub(super) is_seen_twice: bool,
}

/// Evidence on a pair of identities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SameAircraftEvidence {
    /// Time of the first look since the two last separated.
    since: Time,
    /// Time of the newest look.
    last: Time,
    looks: u32,
    /// Means over the looks, weighted towards the newer ones: position difference, its persistent covariance, number of
    /// aircraft nearby.
    apart: Vector2<f64>,
    slow: Matrix2<f64>,
    crowd: f64,
    /// Means of the height difference and its variance, and the number of looks with one.
    height: (f64, f64, u32),
    flown_m: f64,
    /// Number of consecutive looks at which the errors do not explain the distance.
    apart_looks: u32,
    /// Number of consecutive looks with two radar tracks.
    two_tracks: u32,
    is_linked: bool,
}

impl SameAircraftEvidence {
    pub(super) fn new(time: Time) -> Self {
        Self {
            since: time,
            last: time,
            looks: 0,
            apart: Vector2::zeros(),
            slow: Matrix2::zeros(),
            crowd: 0.0,
            height: (0.0, 0.0, 0),
            flown_m: 0.0,
            apart_looks: 0,
            two_tracks: 0,
            is_linked: false,
        }
    }

    /// Whether the two are linked as one aircraft.
    pub(super) fn is_linked(&self) -> bool {
        self.is_linked
    }

    /// Time of the newest look.
    pub(super) fn last(&self) -> Time {
        self.last
    }

    /// Adds a look; links the two, or revokes the link.
    pub(super) fn observe(&mut self, look: &TransponderComparison) {
        self.last = look.time;
        self.two_tracks = if look.is_seen_twice { self.two_tracks + 1 } else { 0 };
        self.apart_looks = if is_apart(look) { self.apart_looks + 1 } else { 0 };
        if self.apart_looks >= SAME_APART_LOOKS || self.two_tracks >= SAME_TWO_TRACKS_S {
            // Earlier evidence is void: they are two aircraft now.
            *self = Self::new(look.time);
            return;
        }
        self.flown_m += look.flown_m;
        if look.white_m2 <= SAME_LOOK_SIGMA_MAX_M * SAME_LOOK_SIGMA_MAX_M {
            self.average(look);
        }
        let llr = self.llr();
        let is_long = self.last.seconds_since(self.since) >= SAME_SPAN_S && self.looks >= SAME_LOOKS;
        if llr >= SAME_LINK_LLR && is_long && self.flown_m >= SAME_FLOWN_M && self.two_tracks == 0 {
            self.is_linked = true;
        } else if llr < SAME_LEAVE_LLR {
            self.is_linked = false;
        }
    }

    fn average(&mut self, look: &TransponderComparison) {
        self.looks += 1;
        let share = (1.0 / f64::from(self.looks)).max(1.0 / SAME_MEMORY_S);
        self.apart += (look.apart - self.apart) * share;
        self.slow += (look.slow - self.slow) * share;
        self.crowd += (look.crowd - self.crowd) * share;
        if let Some((apart_m, variance_m2)) = look.height {
            let (mean, variance, looks) = &mut self.height;
            *looks += 1;
            let share = (1.0 / f64::from(*looks)).max(1.0 / SAME_MEMORY_S);
            *mean += (apart_m - *mean) * share;
            *variance += (variance_m2 - *variance) * share;
        }
    }

    /// Natural logarithm of the likelihood ratio of "one aircraft" to "two that fly beside each other".
    ///
    /// It compares the mean position difference under both hypotheses. One aircraft: persistent errors of both, and the
    /// distance between the antennas. Two aircraft: all distances are equally likely, at the density of aircraft
    /// nearby, except those shorter than the spacing that aircraft keep.
    pub(super) fn llr(&self) -> f64 {
        if self.looks == 0 {
            return f64::NEG_INFINITY;
        }
        let (height_m, variance_m2, looks) = self.height;
        if looks > 0 && height_m * height_m > SAME_HEIGHT_SIGMAS * SAME_HEIGHT_SIGMAS * variance_m2 {
            return f64::NEG_INFINITY;
        }
        // Errors with a correlation time of about a minute become smaller in a mean over minutes.
        let averaged_s = self.last.seconds_since(self.since).min(SAME_MEMORY_S);
        let slow = self.slow / (1.0 + averaged_s / (2.0 * SAME_SLOW_S));
        let one = slow + Matrix2::identity() * (SAME_MOUNT_M * SAME_MOUNT_M);
        let Some(inverse) = one.try_inverse() else { return f64::NEG_INFINITY };
        let of_one = -(TAU * one.determinant().sqrt()).ln() - 0.5 * self.apart.dot(&(inverse * self.apart));
        let around_m2 = std::f64::consts::PI * SAME_CROWD_M * SAME_CROWD_M;
        let density = SAME_NEIGHBOURS_PER_M2 + self.crowd / around_m2;
        let spacing_m2 = SAME_SPACING_M * SAME_SPACING_M;
        let spread_m2 = spacing_m2 + slow.trace() / 2.0;
        let avoided = spacing_m2 / spread_m2 * (-self.apart.norm_squared() / (2.0 * spread_m2)).exp();
        of_one - (density * (1.0 - avoided)).ln()
    }
}

/// Whether the errors of both do not explain their distance.
fn is_apart(look: &TransponderComparison) -> bool {
    let all = look.slow + Matrix2::identity() * (look.white_m2 + SAME_MOUNT_M * SAME_MOUNT_M);
    let limit = SAME_APART_SIGMAS * SAME_APART_SIGMAS;
    let is_beside = all.try_inverse().is_none_or(|inverse| look.apart.dot(&(inverse * look.apart)) > limit);
    let is_above = look.height.is_some_and(|(apart_m, variance_m2)| apart_m * apart_m > limit * variance_m2);
    is_beside || is_above
}

#[cfg(test)]
mod tests;
