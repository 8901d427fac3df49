//! The misalignment that follows from the sums, with its deviations.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::heights::{HeightAlignment, MOVING};
use super::mutual::{LearntFromRadars, OF_RADAR, OverGround};
use super::parameters::{AZIMUTH, BEARING, HEIGHT, PRIOR, RANGE, TILT_EAST, TILT_NORTH, TIME, USEFUL};
use super::qmethod;
use super::sums::{MisalignmentSums, SolvedSums};

/// A bias: measured minus true.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasValue {
    /// The value.
    pub value: f64,
    /// Its standard deviation, in the same unit.
    pub deviation: f64,
    /// Whether the radar's tracks determine it well enough. Plots are corrected by such values only.
    pub observable: bool,
}

/// A radar's misalignment, as estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Misalignment {
    /// Bias of the azimuth, measured minus true, radians clockwise. `bearing_correction_deg` has to be smaller by this.
    pub bearing: BiasValue,
    /// Tilt about the east axis, radians, right-handed: what lies north is seen too high. Zero where it is not observable.
    pub tilt_east: BiasValue,
    /// Tilt about the north axis, radians, right-handed: what lies east is seen too low. Zero where it is not observable.
    pub tilt_north: BiasValue,
    /// Bias of the slant range, metres.
    pub range_m: BiasValue,
    /// Bias of the height, metres.
    pub height_m: BiasValue,
    /// Time bias, seconds: plots lie ahead of their targets by velocity times this. Transponder reports are stamped late by
    /// it, or the radar's plots early.
    pub time_s: BiasValue,
    /// Number of radar tracks it rests on, the older ones in part.
    pub samples: f64,
    /// Scatter of the tracks' azimuth offsets about the estimate, as a ratio of variances (twice Wahba's loss per track): 1 if it
    /// agrees with the radar's stated errors. `None` below eight tracks.
    pub residual: Option<f64>,
    /// Second moments of what is left once plots are corrected by what is observable.
    pub(super) left: Matrix6<f64>,
}

/// Information about the time bias.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeInformation {
    /// 1/s².
    pub(crate) inverse_variance: f64,
    /// The mean times the inverse variance, 1/s.
    pub(crate) weighted_mean: f64,
}

impl TimeInformation {
    /// Returns the information with the deviation multiplied by this factor.
    pub(crate) fn weakened(self, times: f64) -> Self {
        let share = times.powi(-2);
        Self { inverse_variance: self.inverse_variance * share, weighted_mean: self.weighted_mean * share }
    }
}

/// The parameters that two radars of one aircraft show.
pub(super) const OVER_GROUND: [usize; OF_RADAR] = [BEARING, RANGE, TIME];
/// Minimum number of tracks for a residual.
const TRACKS: f64 = 8.0;
/// Above this, tracks lie twice as far apart as promised.
const DOUBTFUL: f64 = 4.0;

impl Misalignment {
    /// Whether the tracks lie further apart than the configured errors of the radar allow: there is more than a misalignment,
    /// or the errors are larger.
    pub fn doubtful(&self) -> bool {
        self.residual.is_some_and(|residual| residual > DOUBTFUL)
    }

    /// Information of the tracks about the time bias, without the prior.
    pub(crate) fn time_information(&self) -> TimeInformation {
        let BiasValue { value, deviation, .. } = self.time_s;
        TimeInformation {
            inverse_variance: (deviation.powi(-2) - PRIOR[TIME].powi(-2)).max(0.0),
            weighted_mean: value * deviation.powi(-2),
        }
    }

    /// Replaces this share of tilts and height bias by those of `alignment`, where heights of transponders have offsets.
    pub(crate) fn with_heights(mut self, alignment: &HeightAlignment, share: f64) -> Self {
        let HeightAlignment { mean, covariance } = alignment;
        let values = [&mut self.tilt_east, &mut self.tilt_north, &mut self.height_m];
        for (index, value) in values.into_iter().enumerate() {
            let own = if value.observable { value.value } else { 0.0 };
            let variance = covariance[(index, index)];
            *value = BiasValue {
                value: own + share * (mean[index] - own),
                deviation: value.deviation + share * (variance.sqrt() - value.deviation),
                observable: true,
            };
        }
        for (row, &first) in MOVING.iter().enumerate() {
            for (column, &second) in MOVING.iter().enumerate() {
                let left = &mut self.left[(first, second)];
                *left += share * (covariance[(row, column)] - *left);
            }
            for other in [BEARING, RANGE, TIME] {
                self.left[(first, other)] *= 1.0 - share;
                self.left[(other, first)] *= 1.0 - share;
            }
        }
        self
    }

    fn value(&self, parameter: usize) -> &BiasValue {
        let values =
            [&self.bearing, &self.tilt_east, &self.tilt_north, &self.range_m, &self.height_m, &self.time_s];
        values[parameter]
    }

    /// Second moment of two values that are not corrected.
    fn kept(&self, row: usize, column: usize) -> f64 {
        let [one, other] = [row, column].map(|parameter| self.value(parameter));
        if one.observable || other.observable { 0.0 } else { one.value * other.value }
    }

    /// Bearing, range and time.
    pub(crate) fn over_ground(&self) -> OverGround {
        let parameters = OVER_GROUND;
        OverGround {
            mean: Vector3::from(parameters.map(|parameter| self.value(parameter).value)),
            covariance: Matrix3::from_fn(|row, column| {
                let (row, column) = (parameters[row], parameters[column]);
                self.left[(row, column)] - self.kept(row, column)
            }),
        }
    }

    /// Adds what other radars show of bearing and range.
    pub(crate) fn with_radars(mut self, learnt: &LearntFromRadars) -> Self {
        let OverGround { mean, covariance } = learnt.with(&self.over_ground());
        let taken = [BEARING, RANGE];
        for (index, &parameter) in taken.iter().enumerate() {
            let deviation = covariance[(index, index)].sqrt();
            let value =
                BiasValue { value: mean[index], deviation, observable: deviation < USEFUL[parameter] };
            match parameter {
                BEARING => self.bearing = value,
                _ => self.range_m = value,
            }
            self.left.row_mut(parameter).fill(0.0);
            self.left.column_mut(parameter).fill(0.0);
        }
        for (row, &first) in taken.iter().enumerate() {
            for (column, &second) in taken.iter().enumerate() {
                self.left[(first, second)] = covariance[(row, column)] + self.kept(first, second);
            }
        }
        self
    }

    pub(super) fn of(sums: &MisalignmentSums) -> Self {
        let factors = sums.spread.factors();
        let SolvedSums { mean, covariance } = SolvedSums::from(&sums.axes, &factors);
        let known = |parameter: usize| covariance[(parameter, parameter)].sqrt() < USEFUL[parameter];

        let [bearing, tilt_east, tilt_north] =
            [BEARING, TILT_EAST, TILT_NORTH].map(|which| PRIOR[which].powi(-2));
        let mut profile =
            qmethod::bare(&Matrix3::from_diagonal(&Vector3::new(tilt_east, tilt_north, bearing)));
        let (height_m, time_s) = (mean[HEIGHT], mean[TIME]);
        let [azimuths, heights] = &sums.profiles;
        profile += azimuths.without(height_m, time_s) / factors[0];
        profile += heights.without(height_m, time_s) / factors[2];
        let mut best = mean;
        if known(TILT_EAST) || known(TILT_NORTH) {
            let turn = qmethod::rotation(&profile).0.scaled_axis();
            (best[TILT_EAST], best[TILT_NORTH], best[BEARING]) = (turn.x, turn.y, -turn.z);
        } else {
            best[BEARING] = qmethod::turn(&profile).0;
        }

        // A bias that is not corrected remains in full.
        let kept = Vector6::from_fn(|parameter, _| if known(parameter) { 0.0 } else { best[parameter] });
        let left = covariance + kept * kept.transpose();
        let value = |parameter: usize| BiasValue {
            value: best[parameter],
            deviation: covariance[(parameter, parameter)].sqrt(),
            observable: known(parameter),
        };
        let tilt = |parameter: usize| match value(parameter) {
            tilt if tilt.observable => tilt,
            _ => BiasValue { value: 0.0, deviation: left[(parameter, parameter)].sqrt(), observable: false },
        };
        Self {
            bearing: value(BEARING),
            tilt_east: tilt(TILT_EAST),
            tilt_north: tilt(TILT_NORTH),
            range_m: value(RANGE),
            height_m: value(HEIGHT),
            time_s: value(TIME),
            samples: sums.tracks,
            residual: residual(sums, height_m, time_s),
            left,
        }
    }
}

/// The q-method's loss in the plane: the sum of weights less the largest trace.
fn residual(sums: &MisalignmentSums, height_m: f64, time_s: f64) -> Option<f64> {
    if sums.tracks < TRACKS {
        return None;
    }
    let weights = sums.axes[AZIMUTH].matrix[(BEARING, BEARING)];
    let (_, trace) = qmethod::turn(&sums.profiles[0].without(height_m, time_s));
    Some(2.0 * (weights - trace) / (sums.tracks - 1.0))
}
