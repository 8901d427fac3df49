//! Which heights are wrong by a constant: a radar's, those of all transponders, or those of a few.
//!
//! Plots less reports show h - c - oᵢ, with h the radar's error at a place (height bias and tilts), c an offset that all
//! transponders share, and oᵢ one of a single transponder. Three explanations are weighed by how likely each makes the sums
//! of all radar tracks: a radar that is levelled, a radar that is badly levelled, and transponders whose heights have another
//! reference. A transponder's own offset is nothing or large (a spike and a slab). All of it is Gaussian, given the
//! explanation and which offsets are large, so likelihoods and posteriors are exact; which are large is decided by turns.

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use serde::{Deserialize, Serialize};

use super::along::Sample;
use super::parameters::{HEIGHT, TILT_EAST, TILT_NORTH};

/// Parameters of a radar that move heights.
pub(super) const MOVING: [usize; 3] = [TILT_EAST, TILT_NORTH, HEIGHT];
/// The axis of heights in a sample.
const HEIGHTS: usize = 2;
/// Share of the earlier information that each piece of a track discards.
const FORGOTTEN: f64 = 1.0 / 200.0;
/// Each explanation: prior probability; sigma of the radar's tilts, radians, and of its height bias, metres; and of the offset
/// that all transponders share, metres. A spirit level is good to 0.2°; the other numbers are by judgement.
const EXPLANATIONS: [Explanation; 3] = [
    Explanation { prior: 0.88, tilt: 0.2_f64.to_radians(), height_m: 5.0, common_m: 0.01 },
    Explanation { prior: 0.02, tilt: 1.0_f64.to_radians(), height_m: 15.0, common_m: 0.01 },
    Explanation { prior: 0.10, tilt: 0.2_f64.to_radians(), height_m: 5.0, common_m: 40.0 },
];
/// The explanation by another reference.
const REFERENCE: usize = 2;
/// Probability that the heights of a transponder have an offset of their own. And its sigma, metres.
const OWN_PRIOR: f64 = 0.1;
const OWN_M: f64 = 40.0;
/// Rounds in which it is decided which offsets are large.
const ROUNDS: usize = 4;

#[derive(Clone, Copy, Debug)]
struct Explanation {
    prior: f64,
    tilt: f64,
    height_m: f64,
    common_m: f64,
}

/// Evidence of one radar's tracks about the heights of one transponder: information about tilts and height bias.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HeightSums {
    matrix: Matrix3<f64>,
    vector: Vector3<f64>,
}

/// A Gaussian over tilts, height bias, and the offset of all transponders.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct HeightState {
    mean: Vector4<f64>,
    covariance: Matrix4<f64>,
}

/// The offset of one transponder's heights, reported less true, as one radar shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct HeightOffset {
    /// Probability that there is a large one.
    pub(crate) probability: f64,
    /// The offset if there is: mean, metres, and variance, m².
    pub(crate) mean_m: f64,
    pub(crate) variance_m2: f64,
    /// Information of the radar's tracks, 1/m².
    pub(crate) information: f64,
}

/// The verdict on one radar's tracks.
#[derive(Clone, Debug)]
pub(crate) struct HeightVerdict {
    /// Tilts and height bias by all explanations: mean and covariance.
    pub(crate) alignment: HeightAlignment,
    /// Each transponder, in the order in which they were given.
    pub(crate) offsets: Vec<HeightOffset>,
}

/// A radar's tilts (radians) and height bias (metres) where transponders' heights have offsets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HeightAlignment {
    pub(super) mean: Vector3<f64>,
    pub(super) covariance: Matrix3<f64>,
}

impl HeightSums {
    pub(crate) const NONE: Self = Self {
        matrix: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        vector: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Adds a piece of a radar track.
    pub(crate) fn add(&mut self, sample: &Sample) {
        let heights = &sample.axes[HEIGHTS];
        let of = |row: usize, column: usize| heights.matrix[(MOVING[row], MOVING[column])];
        self.matrix = self.matrix * (1.0 - FORGOTTEN) + Matrix3::from_fn(of);
        self.vector =
            self.vector * (1.0 - FORGOTTEN) + Vector3::from_fn(|row, _| heights.vector[MOVING[row]]);
    }

    /// Whether heights were measured.
    pub(crate) fn is_some(&self) -> bool {
        self.information() > 0.0
    }

    /// Information about a height, 1/m².
    fn information(&self) -> f64 {
        self.matrix[(2, 2)]
    }

    /// This evidence as information about the state. An offset is a height bias with the other sign.
    fn about_state(&self) -> (Matrix4<f64>, Vector4<f64>) {
        let across = -self.matrix.column(2);
        let mut matrix = Matrix4::zeros();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.matrix);
        matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&across);
        matrix.fixed_view_mut::<1, 3>(3, 0).copy_from(&across.transpose());
        matrix[(3, 3)] = self.information();
        (matrix, self.vector.push(-self.vector[2]))
    }
}

/// A transponder's part in the information about the state, its own offset integrated out.
#[derive(Clone, Copy)]
struct OffsetPart {
    matrix: Matrix4<f64>,
    vector: Vector4<f64>,
    /// Logarithm of its factor in the likelihood.
    log: f64,
}

/// A transponder while it is decided whether its offset is large.
struct UndecidedOffset {
    information: (Matrix4<f64>, Vector4<f64>),
    /// With a small offset, and with a large one.
    parts: [OffsetPart; 2],
    sigmas_m: [f64; 2],
    large: usize,
}

impl OffsetPart {
    fn of(matrix: &Matrix4<f64>, vector: &Vector4<f64>, sigma_m: f64) -> Self {
        let across = matrix.column(3);
        let known = matrix[(3, 3)] + sigma_m.powi(-2);
        let of_offset = vector[3];
        Self {
            matrix: matrix - across * across.transpose() / known,
            vector: vector - across * (of_offset / known),
            log: 0.5 * of_offset * of_offset / known - 0.5 * (known * sigma_m * sigma_m).ln(),
        }
    }
}

impl UndecidedOffset {
    fn new(sums: &HeightSums, sigma_m: f64) -> Self {
        let (matrix, vector) = sums.about_state();
        let sigmas_m = [sigma_m, OWN_M.hypot(sigma_m)];
        let parts =
            [OffsetPart::of(&matrix, &vector, sigmas_m[0]), OffsetPart::of(&matrix, &vector, sigmas_m[1])];
        Self { information: (matrix, vector), parts, sigmas_m, large: 0 }
    }

    fn part(&self) -> &OffsetPart {
        &self.parts[self.large]
    }

    /// Logarithm of its factor in the probability of the explanation.
    fn log(&self) -> f64 {
        let prior = if self.large == 1 { OWN_PRIOR } else { 1.0 - OWN_PRIOR };
        self.part().log + prior.ln()
    }

    /// Its offset beside that of all, given the state: mean and variance as the tracks have it.
    fn offset(&self, state: &HeightState) -> (f64, f64) {
        let (matrix, vector) = &self.information;
        let across = matrix.column(3);
        let known = matrix[(3, 3)];
        let variance = 1.0 / known + across.dot(&(state.covariance * across)) / (known * known);
        ((vector[3] - across.dot(&state.mean)) / known, variance)
    }

    /// Probability that its offset is large, given what all others show.
    fn probability(&self, others: &HeightState) -> f64 {
        let (mean, variance) = self.offset(others);
        let log = |sigma_m: f64, prior: f64| {
            let all = variance + sigma_m * sigma_m;
            prior.ln() - 0.5 * (mean * mean / all + all.ln())
        };
        let odds = log(self.sigmas_m[1], OWN_PRIOR) - log(self.sigmas_m[0], 1.0 - OWN_PRIOR);
        1.0 / (1.0 + (-odds).exp())
    }
}

/// The state of this information; `None`: rounding has made it none.
fn solved(matrix: &Matrix4<f64>, vector: &Vector4<f64>) -> Option<(HeightState, f64)> {
    let root = matrix.cholesky()?;
    let covariance = root.inverse();
    let mean = covariance * vector;
    let log = 0.5 * vector.dot(&mean) - root.l().diagonal().iter().map(|root| root.ln()).sum::<f64>();
    log.is_finite().then_some((HeightState { mean, covariance }, log))
}

/// One explanation: logarithm of its probability, the state, and of each transponder the probability that its offset is
/// large, and that offset if it is: mean and variance.
struct WeighedExplanation {
    log: f64,
    state: HeightState,
    offsets: Vec<(f64, f64, f64)>,
}

impl Explanation {
    fn weigh(&self, evidence: &[(HeightSums, f64)]) -> Option<WeighedExplanation> {
        let sigmas = Vector4::new(self.tilt, self.tilt, self.height_m, self.common_m);
        let prior = Matrix4::from_diagonal(&sigmas.map(|sigma| sigma.powi(-2)));
        let mut all: Vec<UndecidedOffset> =
            evidence.iter().map(|(sums, sigma_m)| UndecidedOffset::new(sums, *sigma_m)).collect();
        let (mut matrix, mut vector) = (prior, Vector4::zeros());
        for judged in &all {
            matrix += judged.part().matrix;
            vector += judged.part().vector;
        }
        let mut probabilities = vec![0.0; all.len()];
        for _ in 0..ROUNDS {
            let mut is_settled = true;
            for (judged, probability) in all.iter_mut().zip(&mut probabilities) {
                let part = *judged.part();
                let (others, _) = solved(&(matrix - part.matrix), &(vector - part.vector))?;
                *probability = judged.probability(&others);
                let now = usize::from(*probability > 0.5);
                if now != judged.large {
                    judged.large = now;
                    matrix += judged.part().matrix - part.matrix;
                    vector += judged.part().vector - part.vector;
                    is_settled = false;
                }
            }
            if is_settled {
                break;
            }
        }
        let (state, log) = solved(&matrix, &vector)?;
        let log = self.prior.ln() + log - sigmas.iter().map(|sigma| sigma.ln()).sum::<f64>()
            + all.iter().map(UndecidedOffset::log).sum::<f64>();
        let offset = |(judged, probability): (&UndecidedOffset, f64)| {
            let (mean, variance) = judged.offset(&state);
            let share = OWN_M * OWN_M / (OWN_M * OWN_M + variance);
            (probability, mean * share, variance * share)
        };
        let offsets = all.iter().zip(probabilities).map(offset).collect();
        Some(WeighedExplanation { log, state, offsets })
    }
}

/// Judges these transponders by one radar, each by its sums and the sigma of its heights. `None` where there are none.
pub(crate) fn height_verdict(evidence: &[(HeightSums, f64)]) -> Option<HeightVerdict> {
    if evidence.is_empty() {
        return None;
    }
    let weighed: Vec<WeighedExplanation> =
        EXPLANATIONS.iter().map(|explanation| explanation.weigh(evidence)).collect::<Option<_>>()?;
    let most = weighed.iter().map(|weighed| weighed.log).fold(f64::NEG_INFINITY, f64::max);
    let shares: Vec<f64> = weighed.iter().map(|weighed| (weighed.log - most).exp()).collect();
    let sum: f64 = shares.iter().sum();
    let shares: Vec<f64> = shares.iter().map(|share| share / sum).collect();
    let each = || weighed.iter().zip(&shares).enumerate();
    let mean: Vector3<f64> = each().map(|(_, (one, &share))| one.state.mean.fixed_rows::<3>(0) * share).sum();
    let covariance = each().map(|(_, (one, &share))| {
        let off = one.state.mean.fixed_rows::<3>(0) - mean;
        (one.state.covariance.fixed_view::<3, 3>(0, 0) + off * off.transpose()) * share
    });
    let alignment = HeightAlignment { mean, covariance: covariance.sum() };
    let offset = |index: usize| {
        // With the offset of all: that of its own may be small then.
        let of_all = |which: usize, state: &HeightState| match which {
            REFERENCE => (state.mean[3], state.covariance[(3, 3)]),
            _ => (0.0, 0.0),
        };
        let mut offset = HeightOffset { information: evidence[index].0.information(), ..Default::default() };
        let (mut first, mut second) = (0.0, 0.0);
        for (which, (one, &share)) in each() {
            let (probability, own_m, own_m2) = one.offsets[index];
            let (all_m, all_m2) = of_all(which, &one.state);
            let mut add = |share: f64, mean: f64, variance: f64| {
                first += share * mean;
                second += share * (mean * mean + variance);
            };
            let is_large = if which == REFERENCE { 1.0 } else { probability };
            offset.probability += share * is_large;
            add(share * probability, all_m + own_m, all_m2 + own_m2);
            if which == REFERENCE {
                add(share * (1.0 - probability), all_m, all_m2);
            }
        }
        if offset.probability > 0.0 {
            offset.mean_m = first / offset.probability;
            offset.variance_m2 = (second / offset.probability - offset.mean_m * offset.mean_m).max(0.0);
        }
        offset
    };
    let offsets = (0..evidence.len()).map(offset).collect();
    Some(HeightVerdict { alignment, offsets })
}
