//! Check of a radar's configured position against the transponders of its tracks.
//!
//! A radar that stands d = (east, north) from its configured position sees its targets shifted by -d. Over several directions
//! this differs from what a turned bearing or a range offset does. The latest segments of tracks are solved for bearing, range,
//! time, east and north together by iteratively reweighted least squares (Huber); windows of different length find a radar that
//! was moved a short time ago.

use std::collections::VecDeque;

use nalgebra::{Matrix2, Matrix5, Vector2, Vector5};
use serde::{Deserialize, Serialize};

use super::along::{Information, Sample};
use super::displaced::{AXES_OVER_GROUND, PlaceInformation};
use super::estimate::BiasValue;
use super::parameters::{BEARING, PRIOR, RANGE, TIME};
use crate::report::Identity;

/// The parameters that are solved together with the displacement; first those that shift the two axes directly.
const TOGETHER: [usize; 3] = [BEARING, RANGE, TIME];
const EAST: usize = TOGETHER.len();
/// Maximum number of segments.
const SEGMENTS: usize = 96;
/// Minimum number of segments.
const FEW: usize = 12;
/// Prior standard deviation of each component, metres: none.
const ANYWHERE_M: f64 = 1e5;
/// Distance from the configured position, in deviations, from which the data contradict it.
const CONTRADICTED: f64 = 5.0;
/// The same without any one transponder: a transponder with a constant error of position looks like a displaced radar.
const CONFIRMED: f64 = 3.0;
/// Share of these limits from which a contradiction lasts, so that an alert does not flicker.
const LASTING: f64 = 0.7;
/// Distance from the configured position from which it is worth an alert, metres. Errors of GNSS receivers and of maps that all
/// transponders share are smaller.
const WORTH_M: f64 = 15.0;
/// Deviations beyond which a segment counts less.
const FAR: f64 = 3.0;
/// Minimum factor of a variance.
const LEAST_FACTOR: f64 = 0.25;
/// Number of solutions, each with the weights that follow from the one before.
const ROUNDS: usize = 3;
/// Segments with the expected scatter that are assumed in advance.
const ASSUMED: f64 = 10.0;

/// Where a radar stands, according to its tracks, relative to its configured position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Displacement {
    /// East of the configured position, metres.
    pub east_m: f64,
    /// North of the configured position, metres.
    pub north_m: f64,
    /// Covariance of both, m².
    pub covariance_m2: Matrix2<f64>,
    /// Bias of the azimuth at that position, measured minus true, radians clockwise.
    pub bearing: BiasValue,
    /// Time that the tracks last on which it rests, in minutes of one drone.
    pub drone_minutes: f64,
    /// Whether the tracks contradict the configured position.
    pub contradicts: bool,
}

impl Displacement {
    /// Distance from the configured position, metres.
    pub fn distance_m(&self) -> f64 {
        self.east_m.hypot(self.north_m)
    }

    /// Standard deviation along the direction of the displacement, metres.
    pub fn sigma_m(&self) -> f64 {
        let along = Vector2::new(self.east_m, self.north_m) / self.distance_m().max(f64::MIN_POSITIVE);
        along.dot(&(self.covariance_m2 * along)).sqrt()
    }

    /// Distance from the configured position in deviations.
    fn deviations(&self) -> f64 {
        let place = Vector2::new(self.east_m, self.north_m);
        self.covariance_m2.cholesky().map_or(0.0, |root| place.dot(&root.solve(&place)).sqrt())
    }
}

/// Information of one axis about bearing, range, time, east and north.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Row {
    matrix: Matrix5<f64>,
    vector: Vector5<f64>,
}

impl Row {
    fn of(about: &Information, place: &PlaceInformation) -> Self {
        let own = |index: usize| TOGETHER.get(index).copied();
        let matrix = Matrix5::from_fn(|row, column| match (own(row), own(column)) {
            (Some(row), Some(column)) => about.matrix[(row, column)],
            (Some(row), None) => place.cross[(row, column - EAST)],
            (None, Some(column)) => place.cross[(column, row - EAST)],
            (None, None) => place.matrix[(row - EAST, column - EAST)],
        });
        let vector = Vector5::from_fn(|row, _| match own(row) {
            Some(row) => about.vector[row],
            None => place.vector[row - EAST],
        });
        Self { matrix, vector }
    }

    /// Squared distance of the mean offset on this axis from what the solution explains, in variances; `None` without one.
    fn distance2(&self, own: usize, solution: &Vector5<f64>) -> Option<f64> {
        let information = self.matrix[(own, own)];
        (information > 0.0).then(|| {
            let unexplained = self.vector[own] - self.matrix.row(own).transpose().dot(solution);
            unexplained * unexplained / information
        })
    }
}

/// A segment of a track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Segment {
    identity: Identity,
    lasted_s: f64,
    rows: [Row; AXES_OVER_GROUND],
}

/// The latest segments of one radar's tracks, and where it stands according to them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PlaceCheck {
    segments: VecDeque<Segment>,
    found: Option<Displacement>,
}

impl PlaceCheck {
    /// Where the radar stands; `None` before the first tracks.
    pub fn found(&self) -> Option<&Displacement> {
        self.found.as_ref()
    }

    /// Adds a segment of a track of this transponder.
    pub(crate) fn add(&mut self, identity: Identity, sample: &Sample) {
        let rows = std::array::from_fn(|axis| Row::of(&sample.axes[axis], &sample.places[axis]));
        self.segments.push_back(Segment { identity, lasted_s: sample.lasted_s, rows });
        if self.segments.len() > SEGMENTS {
            self.segments.pop_front();
        }
        self.found = self.solve();
    }

    /// All segments if they contradict the configured position; otherwise the shortest window that does, or else all segments.
    fn solve(&self) -> Option<Displacement> {
        let lengths = std::iter::successors(Some(FEW), |length| Some(length * 2));
        let shorter = lengths.take_while(|&length| length < self.segments.len());
        let latest = |length: usize| -> Vec<&Segment> { self.segments.iter().rev().take(length).collect() };
        let share = if self.found.is_some_and(|before| before.contradicts) { LASTING } else { 1.0 };
        let judged = |length: usize| {
            let window = latest(length);
            let mut found = displacement(&window)?;
            found.contradicts = contradicts(&window, &found, share);
            Some(found)
        };
        let all = judged(self.segments.len())?;
        let contradicting = |found: &Displacement| found.contradicts;
        Some(if all.contradicts {
            all
        } else {
            shorter.filter_map(judged).find(contradicting).unwrap_or(all)
        })
    }
}

/// Whether these segments contradict the configured position, also without any one of the transponders, beyond this share of the
/// limits.
fn contradicts(segments: &[&Segment], found: &Displacement, share: f64) -> bool {
    let is_near = found.distance_m() < share * WORTH_M || found.deviations() < share * CONTRADICTED;
    if segments.len() < FEW || is_near {
        return false;
    }
    let mut identities: Vec<Identity> = segments.iter().map(|segment| segment.identity).collect();
    identities.sort_unstable();
    identities.dedup();
    identities.len() > 1
        && identities.iter().all(|left_out| {
            let others: Vec<&Segment> =
                segments.iter().copied().filter(|segment| segment.identity != *left_out).collect();
            displacement(&others).is_some_and(|others| {
                let same_side = others.east_m * found.east_m + others.north_m * found.north_m > 0.0;
                same_side && others.deviations() >= share * CONFIRMED
            })
        })
}

/// Solution of these segments.
fn displacement(segments: &[&Segment]) -> Option<Displacement> {
    let mut weights = vec![[1.0; AXES_OVER_GROUND]; segments.len()];
    let mut factors = [1.0; AXES_OVER_GROUND];
    let mut solved = None;
    for _ in 0..ROUNDS {
        let mut matrix = Matrix5::from_diagonal(&Vector5::from_fn(|row, _| {
            TOGETHER.get(row).map_or(ANYWHERE_M, |&own| PRIOR[own]).powi(-2)
        }));
        let mut vector = Vector5::zeros();
        for (segment, weights) in segments.iter().zip(&weights) {
            for axis in 0..AXES_OVER_GROUND {
                let weight = weights[axis] / factors[axis];
                matrix += segment.rows[axis].matrix * weight;
                vector += segment.rows[axis].vector * weight;
            }
        }
        let covariance = matrix.cholesky()?.inverse();
        let solution = covariance * vector;
        solved = Some((solution, covariance));
        for axis in 0..AXES_OVER_GROUND {
            let (mut squares, mut count) = (0.0, 0.0);
            for (segment, weights) in segments.iter().zip(&mut weights) {
                let Some(distance2) = segment.rows[axis].distance2(axis, &solution) else { continue };
                weights[axis] = (FAR / (distance2 / factors[axis]).sqrt()).min(1.0);
                squares += distance2.min(FAR * FAR * factors[axis]);
                count += 1.0;
            }
            // Birge's ratio. It may be below 1: what is learnt of a displaced radar's errors contains its displacement.
            factors[axis] = ((ASSUMED + squares) / (ASSUMED + count)).max(LEAST_FACTOR);
        }
    }
    let (solution, covariance) = solved?;
    Some(Displacement {
        east_m: solution[EAST],
        north_m: solution[EAST + 1],
        covariance_m2: covariance.fixed_view::<2, 2>(EAST, EAST).into_owned(),
        bearing: BiasValue {
            value: solution[0],
            deviation: covariance[(0, 0)].sqrt(),
            observable: covariance[(0, 0)].sqrt() < super::parameters::USEFUL[BEARING],
        },
        drone_minutes: segments.iter().map(|segment| segment.lasted_s).sum::<f64>() / 60.0,
        contradicts: false,
    })
}
