//! Evidence from the offset between the tracks of two radars that they are one aircraft.
//!
//! Two radars have no precise axis in common: the range of one may lie along the azimuth of the other. So changes from
//! plot to plot give little evidence, and the size of the offset gives most. It persists as long as the biases do. So
//! plots are weighted by the time between them, and old ones count less.

use nalgebra::Matrix2;
use serde::{Deserialize, Serialize};

use crate::filter::{LineOfSight, RadarErrors};
use crate::frames::Enu;
use crate::operational::settings::RadarSettings;
use crate::operational::tuning::{
    MUTUAL_LIKELY_LLR, MUTUAL_LOOK_MIN_LLR, MUTUAL_LOOK_S, MUTUAL_MEMORY_S, MUTUAL_WIDE,
    SEPARATION_IN_HEIGHT, SEPARATION_OVER_GROUND,
};
use crate::report::Plot;
use crate::time::Time;

/// Position of another radar's track at the time of a plot.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReferencePosition {
    pub(super) position: Enu,
    pub(super) height_measured: bool,
    /// Standard deviation of the interpolation between its plots, metres.
    pub(super) between_m: f64,
    /// Position and errors of the other radar.
    pub(super) radar: Enu,
    pub(super) errors: RadarErrors,
}

/// Likelihood ratio of two tracks: one aircraft against two.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(in crate::operational) struct RadarPairEvidence {
    /// Natural logarithm of the likelihood ratio.
    pub(in crate::operational) llr: f64,
    /// Time of the last plot after which the pair was likely.
    pub(in crate::operational) last_likely: Option<Time>,
    /// Time of the last plot.
    last: Option<Time>,
}

impl RadarPairEvidence {
    /// Whether nothing was compared.
    pub(super) fn is_empty(&self) -> bool {
        self.last.is_none()
    }

    /// Adds a plot and the position of the other radar's track; forward or backward in time.
    pub(super) fn add(&mut self, plot: &Plot, reference: &ReferencePosition, radar: &RadarSettings) {
        let look = plot_llr(plot, reference, radar).max(MUTUAL_LOOK_MIN_LLR);
        self.llr = match self.last {
            None => look,
            Some(last) => {
                let dt = plot.time.seconds_since(last).abs();
                self.llr * (-dt / MUTUAL_MEMORY_S).exp() + look * (dt / MUTUAL_LOOK_S).min(1.0)
            }
        };
        self.last = Some(plot.time);
        if self.llr >= MUTUAL_LIKELY_LLR {
            self.last_likely = Some(plot.time);
        }
    }
}

/// LLR of one plot alone: an offset due to the errors of both radars, against the distance between two aircraft.
fn plot_llr(plot: &Plot, reference: &ReferencePosition, radar: &RadarSettings) -> f64 {
    let spread = |radar: Enu, errors: &RadarErrors, place: Enu| {
        LineOfSight::from(radar, place).spread(
            errors.bias_range_m.hypot(errors.noise_range_m),
            errors.bias_azimuth.hypot(errors.noise_azimuth),
        )
    };
    let ReferencePosition { position, between_m, errors, .. } = reference;
    let covariance = spread(radar.position, &radar.errors, plot.position)
        + spread(reference.radar, errors, *position)
        + Matrix2::identity() * (between_m * between_m);
    let determinant = covariance.determinant();
    let apart = plot.position.0 - position.0;
    let (east, north) = (apart.x, apart.y);
    let distance = (east * east * covariance[(1, 1)] - 2.0 * east * north * covariance[(0, 1)]
        + north * north * covariance[(0, 0)])
        / determinant;
    let apart_m = SEPARATION_OVER_GROUND.distance_m;
    let other = (east * east + north * north) / (apart_m * apart_m);
    let density = |scale: f64| (-0.5 * distance / (scale * scale)).exp() / (scale * scale);
    let (share, scale) = MUTUAL_WIDE;
    let one = (1.0 - share) * density(1.0) + share * density(scale);
    let mut llr = (apart_m * apart_m / determinant.sqrt()).ln() + one.ln() + 0.5 * other;
    if plot.height_measured && reference.height_measured {
        let sigma = |errors: &RadarErrors| errors.bias_height_m.hypot(errors.noise_height_m);
        let sigma_m = sigma(&radar.errors).hypot(sigma(errors));
        let apart_m = SEPARATION_IN_HEIGHT.distance_m;
        let distance = (apart.z / sigma_m).powi(2) - (apart.z / apart_m).powi(2);
        llr += (apart_m / sigma_m).ln() - 0.5 * distance;
    }
    llr
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{RadarTrackKey, SensorIndex};
    use crate::settings;
    use crate::time::SECOND;

    /// Plots every quarter of a second, 1500 m from either radar, with this offset; the lines of sight cross at a right
    /// angle.
    fn evidence(seconds: f64, apart: impl Fn(f64) -> [f64; 3]) -> RadarPairEvidence {
        let radar = RadarSettings::from(&settings::Radar::default());
        let mut evidence = RadarPairEvidence::default();
        for quarter in 0..(4.0 * seconds) as i64 {
            let place = Enu::new(0.0, 1500.0, 100.0);
            let second = quarter as f64 / 4.0;
            let reference = ReferencePosition {
                position: Enu::from(place.0 + nalgebra::Vector3::from(apart(second))),
                height_measured: true,
                between_m: 0.0,
                radar: Enu::new(-1500.0, 1500.0, 0.0),
                errors: radar.errors,
            };
            let track = RadarTrackKey { sensor: SensorIndex(0), number: 1 };
            let time = Time::from_nanos(quarter * SECOND / 4);
            evidence.add(&Plot::new(track, time, place, 1500.0), &reference, &radar);
        }
        evidence
    }

    #[test]
    fn a_small_offset_that_stays_is_one_aircraft() {
        let near = |_| [20.0, -15.0, 5.0];
        assert!(evidence(0.25, near).llr < 6.0, "one plot is not enough");
        assert!(evidence(8.0, near).llr > 6.0, "{:?}", evidence(8.0, near));
    }

    #[test]
    fn an_offset_of_a_turn_decides_nothing() {
        // Over ground the standard deviation is 38 m on each axis, including the misalignment of a new radar.
        let llr = |sigmas: f64| evidence(8.0, |_| [80.0 * sigmas / 3.0, 80.0 * sigmas / 3.0, 0.0]).llr;
        assert!((-4.0..6.0).contains(&llr(3.0)), "{}", llr(3.0));
        assert!(llr(5.0) < -4.0, "{}", llr(5.0));
    }

    #[test]
    fn an_offset_that_no_errors_explain_is_two() {
        for apart in [[150.0, 0.0, 0.0], [0.0, -150.0, 0.0], [0.0, 0.0, 50.0]] {
            assert!(evidence(3.0, |_| apart).llr < 0.0, "{apart:?}");
        }
    }

    #[test]
    fn linked_tracks_split_when_they_move_apart() {
        let together = evidence(30.0, |_| [10.0, 10.0, 0.0]).llr;
        let parted = evidence(53.0, |second| [10.0 + 15.0 * (second - 30.0).max(0.0), 10.0, 0.0]);
        assert!(together > 6.0 && parted.llr < -4.0, "{together} {parted:?}");
        assert!(parted.last_likely.is_some_and(|time| time < Time::from_nanos(49 * SECOND)));
    }
}
