//! Doubt about a reacquired target: the radar track assigned to it may be another aircraft.
//!
//! If no sensor has detected a target for a while, a track that begins at its expected position is assigned to it
//! ([`reacquisition`]). Some of these tracks are other aircraft, as often as the likelihood ratio implies. Until the
//! target's transponder reports again, its position is therefore a mixture: that of the track, or somewhere near the
//! expected position, from where it flies independently. The likelier position is published, with the second moment of
//! the mixture about it.
//!
//! [`reacquisition`]: super::reacquisition

use serde::{Deserialize, Serialize};

use super::tuning::{DOUBT_SIGMA_MAX_M, SEPARATION_OVER_GROUND};
use crate::time::Time;

/// Probability that the track is another aircraft, and the resulting uncertainty of the target's position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Doubt {
    probability: f64,
    /// Variance of the expected position, on each axis over ground, m².
    variance_m2: f64,
    since: Time,
}

impl Doubt {
    /// Doubt about a track that begins at `since` and is the target by this LLR. The alternatives are a new aircraft,
    /// or any target of `all` LLRs, which include this one.
    pub(super) fn new(llr: f64, all: &[f64], variance_m2: f64, since: Time) -> Self {
        let others: f64 = all.iter().map(|other| (other - llr).exp()).sum::<f64>() + (-llr).exp();
        Self { probability: 1.0 - 1.0 / others, variance_m2, since }
    }

    /// Combines this doubt with one from before.
    pub(super) fn after(self, before: Option<Self>) -> Self {
        let sure = before.map_or(1.0, |before| 1.0 - before.probability);
        Self { probability: 1.0 - (1.0 - self.probability) * sure, ..self }
    }

    pub(super) fn since(&self) -> Time {
        self.since
    }

    /// Variance added to the position on each axis over ground, m².
    pub(super) fn variance_m2(&self, time: Time) -> f64 {
        let parted_m = SEPARATION_OVER_GROUND.rate_m_s * time.seconds_since(self.since).max(0.0);
        let apart_m2 = (self.variance_m2 + parted_m * parted_m).min(DOUBT_SIGMA_MAX_M * DOUBT_SIGMA_MAX_M);
        self.probability * apart_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * 1_000_000_000)
    }

    #[test]
    fn a_find_is_as_doubtful_as_its_likelihood_ratio_says() {
        let of = |llr: f64, all: &[f64]| Doubt::new(llr, all, 100.0, at(0)).variance_m2(at(0)) / 100.0;
        assert!((of(0.0, &[0.0]) - 0.5).abs() < 1e-12, "as likely a new one");
        assert!((of(4.0, &[4.0]) - 1.0 / (1.0 + 4_f64.exp())).abs() < 1e-12);
        assert!((of(9.0, &[9.0, 9.0]) - 0.5).abs() < 1e-3, "two that it could be alike");
        let both = Doubt::new(0.0, &[0.0], 100.0, at(9)).after(Some(Doubt::new(0.0, &[0.0], 1.0, at(0))));
        assert!((both.variance_m2(at(9)) - 75.0).abs() < 1e-9, "right twice, or not at all");
    }

    #[test]
    fn a_target_that_is_not_the_track_goes_its_own_way() {
        let doubt = Doubt::new(3.0, &[3.0], 50.0 * 50.0, at(10));
        let sigmas_m: Vec<f64> = [0, 10, 12, 14, 1000].map(|time| doubt.variance_m2(at(time)).sqrt()).into();
        assert_eq!(sigmas_m[0], sigmas_m[1], "before it begins it is where it is expected");
        assert!(sigmas_m.windows(2).skip(1).all(|pair| pair[0] < pair[1]));
        let probability = 1.0 / (1.0 + 3_f64.exp());
        assert!((sigmas_m[4] - DOUBT_SIGMA_MAX_M * probability.sqrt()).abs() < 1e-9);
    }
}
