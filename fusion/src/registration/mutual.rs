//! Alignment of radars by aircraft that two of them see.
//!
//! The offset between the plots of two radars of one aircraft is J₁p₁ − J₂p₂ plus the lasting and white errors of both, where p are
//! bearing, range and time of a radar. A Kalman filter follows the lasting errors along a pair of tracks, and how its mean changes
//! with p₁ and p₂, as in the comparison with a transponder: its innovations are white, and each adds what is new. Aircraft in
//! several directions distinguish p₁ from p₂, because the positions of the radars are known.
//!
//! All pairs of radars are solved together, with the values of each radar's own tracks of transponders. The errors of the solutions
//! are correlated: a radar takes the information of its marginal less its own, so that its own counts once.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{
    DMatrix, DVector, Matrix2, Matrix2x4, Matrix3, Matrix4, SMatrix, SVector, Vector2, Vector3, Vector4,
};
use serde::{Deserialize, Serialize};

use super::estimate::OVER_GROUND;
use super::parameters::PRIOR;
use crate::filter::{LineOfSight, RadarErrors};
use crate::frames::Enu;
use crate::report::SensorIndex;
use crate::time::Time;

/// Parameters of one radar: bearing (radians), range (metres), time (seconds). Their priors are those of [`super::parameters`].
pub(super) const OF_RADAR: usize = 3;
/// Parameters of two radars.
const OF_PAIR: usize = 2 * OF_RADAR;
/// The parameters of two radars, and a constant offset east and north, by which a segment is compared with the solution.
const WITH_OFFSET: usize = OF_PAIR + 2;
/// Prior standard deviation of the range of a radar whose own tracks do not determine it, metres. In a small area, a common
/// displacement of all aircraft resembles offsets in range, and radars measure ranges well.
const RANGE_M: f64 = 5.0;
/// Maximum number of segments of one pair of radars.
const SEGMENTS: usize = 360;
/// Time in which a segment's weight decays to 1/e, seconds.
const MEMORY_S: f64 = 7200.0;
/// Number of solutions, each with the weights that follow from the one before.
const ROUNDS: usize = 4;
/// Deviations beyond which a segment counts less, and beyond which it does not count: it may show two aircraft.
const FAR: f64 = 2.0;
const REJECTED: f64 = 4.0;
/// Segments with the expected scatter that are assumed in advance.
const ASSUMED: f64 = 10.0;
/// Bounds of the factor of all variances that follows from the scatter.
const FACTORS: [f64; 2] = [0.25, 9.0];
/// Numbers of latest segments that are compared with the solution, and the distance, in deviations, above which they show that a
/// radar was turned or moved: the alignment then restarts with them.
const LATEST: [usize; 3] = [16, 32, 64];
const STEP: f64 = 5.0;

/// Two radars, in order.
type RadarPair = (SensorIndex, SensorIndex);

/// Plots of two radars of one aircraft, at the time of the first one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SharedLook {
    /// Time of the first radar's plot.
    pub(crate) time: Time,
    /// Position of each radar.
    pub(crate) radars: [Enu; 2],
    /// Plot of each radar.
    pub(crate) plots: [Enu; 2],
    /// Bearing and range that were taken off the plot of each radar before: radians, metres.
    pub(crate) corrected: [Vector2<f64>; 2],
    /// Smoothed position of the aircraft. With that of the plots, the rows would depend on the plots' noise.
    pub(crate) place: Enu,
    /// Velocity of the aircraft over ground, m/s.
    pub(crate) velocity: Vector2<f64>,
    /// Standard deviation of the interpolation between the second radar's plots, each axis, metres.
    pub(crate) between_m: f64,
}

/// Information of a segment about both radars and a constant offset.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct SharedInformation {
    matrix: SMatrix<f64, WITH_OFFSET, WITH_OFFSET>,
    vector: SVector<f64, WITH_OFFSET>,
}

/// Comparison of the tracks of two radars of one aircraft.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SharedComparison {
    errors: [RadarErrors; 2],
    /// Lasting errors: azimuth and range of the first radar, then of the second.
    mean: Vector4<f64>,
    sensitivity: SMatrix<f64, 4, WITH_OFFSET>,
    covariance: Matrix4<f64>,
    information: SharedInformation,
    newest: Option<Time>,
    since: Option<Time>,
}

/// A segment of such a comparison.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct SharedSample {
    /// End of the segment.
    time: Time,
    lasted_s: f64,
    information: SharedInformation,
}

/// Bearing, range and time of a radar with their covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OverGround {
    pub(crate) mean: Vector3<f64>,
    pub(crate) covariance: Matrix3<f64>,
}

/// Information about bearing, range and time of a radar from the aircraft that other radars see as well.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntFromRadars {
    matrix: Matrix3<f64>,
    vector: Vector3<f64>,
    /// Time for which other radars saw aircraft together with it, in minutes of one aircraft.
    pub minutes: f64,
}

/// The segments of all pairs of radars.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct MutualAlignment {
    segments: BTreeMap<RadarPair, VecDeque<SharedSample>>,
    /// Whether segments came or went since the last solution.
    is_changed: bool,
}

/// Variances of the lasting errors.
fn stationary(errors: &[RadarErrors; 2]) -> Vector4<f64> {
    let [first, second] = errors;
    Vector4::new(first.bias_azimuth, first.bias_range_m, second.bias_azimuth, second.bias_range_m)
        .map(|sigma| sigma * sigma)
}

impl SharedInformation {
    fn none() -> Self {
        Self { matrix: SMatrix::zeros(), vector: SVector::zeros() }
    }

    /// Information about a constant offset, together with the parameters of both radars (columns), and what this solution leaves.
    fn offset(
        &self,
        solution: &SVector<f64, OF_PAIR>,
    ) -> (Matrix2<f64>, SMatrix<f64, 2, OF_PAIR>, Vector2<f64>) {
        let matrix = self.matrix.fixed_view::<2, 2>(OF_PAIR, OF_PAIR).into();
        let cross: SMatrix<f64, 2, OF_PAIR> = self.matrix.fixed_view::<2, OF_PAIR>(OF_PAIR, 0).into();
        let left = self.vector.fixed_rows::<2>(OF_PAIR) - cross * solution;
        (matrix, cross, left)
    }
}

impl SharedComparison {
    /// An empty comparison. `errors`: errors of each radar when aligned.
    pub(crate) fn new(errors: [RadarErrors; 2]) -> Self {
        Self {
            errors,
            mean: Vector4::zeros(),
            sensitivity: SMatrix::zeros(),
            covariance: Matrix4::from_diagonal(&stationary(&errors)),
            information: SharedInformation::none(),
            newest: None,
            since: None,
        }
    }

    /// Adds the plots of a time. They are ignored if they are not newer than the last ones, or not numbers.
    pub(crate) fn add(&mut self, look: &SharedLook) {
        let SharedLook { time, radars, plots, corrected, place, velocity, between_m } = *look;
        let mut offset = (plots[0].0 - plots[1].0).xy();
        if !(offset.sum() + place.0.sum() + velocity.sum() + between_m).is_finite()
            || self.newest.is_some_and(|newest| time <= newest)
        {
            return;
        }
        if let Some(newest) = self.newest {
            let dt = time.seconds_since(newest);
            let [first, second] = self.errors.map(|errors| (-dt / errors.correlation_s).exp());
            let kept = Matrix4::from_diagonal(&Vector4::new(first, first, second, second));
            self.mean = kept * self.mean;
            self.sensitivity = kept * self.sensitivity;
            self.covariance = kept * self.covariance * kept
                + Matrix4::from_diagonal(&stationary(&self.errors)) * (Matrix4::identity() - kept * kept);
        }
        (self.newest, self.since) = (Some(time), self.since.or(Some(time)));
        let mut seen = Matrix2x4::zeros();
        let mut rows = SMatrix::<f64, 2, WITH_OFFSET>::zeros();
        let mut noise = Matrix2::identity() * (between_m * between_m);
        for (radar, sign) in [(0, 1.0), (1, -1.0)] {
            let line = LineOfSight::from(radars[radar], place);
            let LineOfSight { range_m, outward, clockwise } = line;
            let errors = &self.errors[radar];
            let turned = clockwise * (sign * range_m);
            let further = outward * (sign * (place.0 - radars[radar].0).norm() / range_m);
            seen.set_column(2 * radar, &turned);
            seen.set_column(2 * radar + 1, &further);
            rows.set_column(OF_RADAR * radar, &turned);
            rows.set_column(OF_RADAR * radar + 1, &further);
            rows.set_column(OF_RADAR * radar + 2, &(velocity * sign));
            offset += turned * corrected[radar].x + further * corrected[radar].y;
            // Errors in azimuth move a plot along an arc, on average nearer to the radar than the tangent.
            let azimuth2 = errors.bias_azimuth.powi(2) + errors.noise_azimuth.powi(2);
            offset += outward * (sign * range_m * azimuth2 / 2.0);
            noise += line.spread(errors.noise_range_m, errors.noise_azimuth);
        }
        rows[(0, OF_PAIR)] = 1.0;
        rows[(1, OF_PAIR + 1)] = 1.0;

        let innovation = offset - seen * self.mean;
        let rows = rows - seen * self.sensitivity;
        let across = self.covariance * seen.transpose();
        let Some(inverse) = (seen * across + noise).try_inverse() else { return };
        self.information.matrix += rows.transpose() * inverse * rows;
        self.information.vector += rows.transpose() * (inverse * innovation);
        let gain = across * inverse;
        self.mean += gain * innovation;
        self.sensitivity += gain * rows;
        self.covariance -= gain * across.transpose();
    }

    /// Time of the newest plots.
    pub(crate) fn newest(&self) -> Option<Time> {
        self.newest
    }

    /// Time from the first to the newest plots since the last [`Self::take_sample`], seconds.
    pub(crate) fn gathered_s(&self) -> f64 {
        self.since.zip(self.newest).map_or(0.0, |(since, newest)| newest.seconds_since(since))
    }

    /// Information since the last call; `None` without plots.
    pub(crate) fn take_sample(&mut self) -> Option<SharedSample> {
        let (since, time) = self.since.take().zip(self.newest)?;
        let information = std::mem::replace(&mut self.information, SharedInformation::none());
        Some(SharedSample { time, lasted_s: time.seconds_since(since), information })
    }
}

impl OverGround {
    /// Without any evidence.
    pub(super) fn unknown() -> Self {
        let prior = Vector3::from(OVER_GROUND.map(|parameter| PRIOR[parameter]));
        Self { mean: Vector3::zeros(), covariance: Matrix3::from_diagonal(&prior.map(|sigma| sigma * sigma)) }
    }

    /// With the prior of the range where that is not known better.
    fn with_range(mut self) -> Self {
        if self.covariance[(1, 1)] <= RANGE_M * RANGE_M {
            return self;
        }
        let column = self.covariance.column(1).into_owned();
        let variance = self.covariance[(1, 1)] + RANGE_M * RANGE_M;
        self.mean -= column * (self.mean.y / variance);
        self.covariance -= column * column.transpose() / variance;
        self
    }

    fn information(&self) -> Matrix3<f64> {
        self.covariance.cholesky().map_or_else(Matrix3::zeros, |root| root.inverse())
    }
}

impl LearntFromRadars {
    /// The values that follow from a radar's own and these.
    pub(super) fn with(&self, own: &OverGround) -> OverGround {
        let information = own.information();
        match (information + self.matrix).cholesky() {
            Some(root) => {
                let mean = root.solve(&(information * own.mean + self.vector));
                OverGround { mean, covariance: root.inverse() }
            }
            None => *own,
        }
    }
}

impl MutualAlignment {
    /// Adds a segment.
    pub(crate) fn add(&mut self, pair: RadarPair, sample: SharedSample) {
        let segments = self.segments.entry(pair).or_default();
        segments.push_back(sample);
        if segments.len() > SEGMENTS {
            segments.pop_front();
        }
        self.is_changed = true;
    }

    /// Whether segments came or went since the last solution.
    pub(crate) fn is_changed(&self) -> bool {
        self.is_changed
    }

    /// Forgets what a radar has shared, because it was moved or turned.
    pub(crate) fn forget(&mut self, sensor: SensorIndex) {
        self.segments.retain(|&(one, other), _| one != sensor && other != sensor);
        self.is_changed = true;
    }

    /// Information of each radar from the others. `own`: the values of its own tracks of transponders.
    pub(crate) fn solve(
        &mut self,
        own: impl Fn(SensorIndex) -> Option<OverGround>,
    ) -> BTreeMap<SensorIndex, LearntFromRadars> {
        self.is_changed = false;
        let mut radars: Vec<SensorIndex> =
            self.segments.keys().flat_map(|&(one, other)| [one, other]).collect();
        radars.sort_unstable();
        radars.dedup();
        let alone: Vec<OverGround> =
            radars.iter().map(|&radar| own(radar).unwrap_or_else(OverGround::unknown)).collect();
        let own: Vec<OverGround> = alone.iter().map(|own| own.with_range()).collect();
        let place = |radar: SensorIndex| radars.binary_search(&radar).map_or(0, |index| OF_RADAR * index);
        let Some(solution) = self.solution(&own, place) else { return BTreeMap::new() };
        let restarted = self.restart(&solution, place);
        let solution = if restarted { self.solution(&own, place) } else { Some(solution) };
        let Some(solution) = solution else { return BTreeMap::new() };
        let learnt = |(index, &radar): (usize, &SensorIndex)| {
            let at = OF_RADAR * index;
            let marginal = OverGround {
                mean: Vector3::from_fn(|row, _| solution.mean[at + row]),
                covariance: Matrix3::from_fn(|row, column| solution.covariance[(at + row, at + column)]),
            };
            let (information, before) = (marginal.information(), alone[index].information());
            let of_radar = self.segments.iter().filter(|((one, other), _)| *one == radar || *other == radar);
            let lasted_s: f64 =
                of_radar.flat_map(|(_, segments)| segments).map(|sample| sample.lasted_s).sum();
            let learnt = LearntFromRadars {
                matrix: information - before,
                vector: information * marginal.mean - before * alone[index].mean,
                minutes: lasted_s / 60.0,
            };
            (radar, learnt)
        };
        radars.iter().enumerate().map(learnt).collect()
    }

    /// Values of all radars by iteratively reweighted least squares.
    fn solution(&self, own: &[OverGround], place: impl Fn(SensorIndex) -> usize) -> Option<Solution> {
        let size = OF_RADAR * own.len();
        let (mut matrix, mut vector) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for (index, own) in own.iter().enumerate() {
            let at = OF_RADAR * index;
            let information = own.information();
            matrix.fixed_view_mut::<OF_RADAR, OF_RADAR>(at, at).copy_from(&information);
            vector.fixed_rows_mut::<OF_RADAR>(at).copy_from(&(information * own.mean));
        }
        let now = self.segments.values().flatten().map(|sample| sample.time).max()?;
        let mut solved: Option<Solution> = None;
        for round in 0..ROUNDS {
            let (mut matrix, mut vector) = (matrix.clone(), vector.clone());
            for (&(one, other), segments) in &self.segments {
                let places = [place(one), place(other)];
                let factor = solved.as_ref().map_or(1.0, |solved| solved.factor(segments.iter(), places));
                for sample in segments {
                    let age = (-now.seconds_since(sample.time) / MEMORY_S).exp();
                    let weight = age / factor
                        * solved.as_ref().map_or(1.0, |solved| solved.weight(sample, places, factor, round));
                    let at = |index: usize| places[index / OF_RADAR] + index % OF_RADAR;
                    for row in 0..OF_PAIR {
                        vector[at(row)] += sample.information.vector[row] * weight;
                        for column in 0..OF_PAIR {
                            matrix[(at(row), at(column))] +=
                                sample.information.matrix[(row, column)] * weight;
                        }
                    }
                }
            }
            let root = matrix.cholesky()?;
            solved = Some(Solution { mean: root.solve(&vector), covariance: root.inverse() });
        }
        solved
    }

    /// Forgets the earlier segments of each pair whose latest ones contradict the solution. Returns whether there are any.
    fn restart(&mut self, solution: &Solution, place: impl Fn(SensorIndex) -> usize) -> bool {
        let mut restarted = false;
        for (&(one, other), segments) in &mut self.segments {
            let places = [place(one), place(other)];
            let mut firsts = LATEST.iter().filter_map(|&latest| segments.len().checked_sub(latest));
            let contradicts =
                |&first: &usize| first >= LATEST[0] && solution.contradicts(segments, first, places);
            if let Some(first) = firsts.find(contradicts) {
                segments.drain(..first);
                restarted = true;
            }
        }
        restarted
    }
}

/// Values of all radars.
struct Solution {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Solution {
    /// Values of two radars.
    fn of_pair(&self, places: [usize; 2]) -> SVector<f64, OF_PAIR> {
        SVector::from_fn(|index, _| self.mean[places[index / OF_RADAR] + index % OF_RADAR])
    }

    /// Distance of a segment from the solution, in deviations of one axis.
    fn distance(&self, sample: &SharedSample, places: [usize; 2]) -> Option<f64> {
        let (matrix, _, left) = sample.information.offset(&self.of_pair(places));
        Some((left.dot(&(matrix.try_inverse()? * left)) / 2.0).sqrt())
    }

    /// Whether the segments from `first` on together contradict the solution. No single one counts much.
    fn contradicts(&self, segments: &VecDeque<SharedSample>, first: usize, places: [usize; 2]) -> bool {
        // The scatter of the earlier segments: a step must not hide behind its own.
        let factor = self.factor(segments.range(..first), places);
        let (mut matrix, mut cross, mut left) =
            (Matrix2::zeros(), SMatrix::<f64, 2, OF_PAIR>::zeros(), Vector2::zeros());
        for sample in segments.range(first..) {
            let Some(distance) = self.distance(sample, places) else { continue };
            let own = sample.information.offset(&self.of_pair(places));
            matrix += own.0;
            cross += own.1;
            left += own.2 * (FAR * factor.sqrt() / distance).min(1.0);
        }
        let at = |index: usize| places[index / OF_RADAR] + index % OF_RADAR;
        let covariance =
            SMatrix::<f64, OF_PAIR, OF_PAIR>::from_fn(|row, column| self.covariance[(at(row), at(column))]);
        let variance = matrix * factor + cross * covariance * cross.transpose();
        variance.try_inverse().is_some_and(|inverse| left.dot(&(inverse * left)) > STEP * STEP)
    }

    /// Weight of a segment: the later rounds leave out those that are far.
    fn weight(&self, sample: &SharedSample, places: [usize; 2], factor: f64, round: usize) -> f64 {
        let Some(distance) = self.distance(sample, places) else { return 0.0 };
        let distance = distance / factor.sqrt();
        if round + 1 == ROUNDS && distance > REJECTED { 0.0 } else { (FAR / distance).min(1.0) }
    }

    /// Birge's ratio of the segments of a pair of radars.
    fn factor<'a>(&self, segments: impl Iterator<Item = &'a SharedSample>, places: [usize; 2]) -> f64 {
        let (mut squares, mut count) = (0.0, 0.0);
        for distance in segments.filter_map(|sample| self.distance(sample, places)) {
            squares += distance.powi(2).min(FAR * FAR);
            count += 1.0;
        }
        ((ASSUMED + squares) / (ASSUMED + count)).clamp(FACTORS[0], FACTORS[1])
    }
}
