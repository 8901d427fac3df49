//! One hypothesis of the bank: the expected offsets if the transponder is honest, or if its reports are false since a
//! certain time.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::{ELSEWHERE_M, PersistentErrors, StampDelay, TrackObservation};
use crate::time::Time;

/// The state: offset and drift of the reported positions, east and north; delay of the time stamps; the radar's
/// misalignment and the persistent error of its track, each in range and azimuth.
const STATES: usize = 9;
const OFFSET: usize = 0;
const DRIFT: usize = 2;
const LATE: usize = 4;
const MISALIGNED: usize = 5;
const SLOW: usize = 7;

/// Standard deviation of the offset of an honest receiver, each axis, metres, and its correlation time, seconds.
const HONEST_M: f64 = 2.2;
const HONEST_LASTS_S: f64 = 60.0;
/// White acceleration of a false position, m²/s³.
const LIE_ACCELERATION_M2_S3: f64 = 0.02;
/// Number of standard deviations beyond which a residual counts only linearly (Huber).
const HUBER: f64 = 3.5;
/// Mean time after which a radar track leaves its aircraft, seconds: it drifts away, or exchanges its number with
/// another track.
const LEAVES_AFTER_S: f64 = 70.0;
/// Least and most that one observation adds to the log-likelihood that the track is of this aircraft.
const LOOK_ADDS: [f64; 2] = [-6.0, 4.0];
/// Log-likelihood ratio above which the track is assigned to this aircraft with certainty.
const SURELY_OWN: f64 = 3.0;

/// Kind of a hypothesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum HypothesisKind {
    Honest,
    /// The transponder is honest; the radar track begins to drift away.
    Walk,
    /// The reported positions begin to drift away.
    Drift,
    /// The reported positions jump.
    Jump,
    /// The time stamps jump.
    Late,
}

impl HypothesisKind {
    /// Standard deviations added to those of honesty at the start: offset and drift, each axis, metres and metres a
    /// second; delay, seconds.
    fn begins_with(self) -> [f64; 3] {
        match self {
            Self::Honest => [0.0; 3],
            Self::Walk => [3.0, 10.0, 0.0],
            Self::Drift => [8.0, 2.0, 0.0],
            Self::Jump => [70.0, 0.5, 0.0],
            Self::Late => [0.0, 0.0, 1.5],
        }
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Hypothesis {
    pub(super) kind: HypothesisKind,
    pub(super) since: Time,
    /// Number of times that hypotheses were started before.
    pub(super) number: u32,
    /// Natural logarithm of the likelihood, without the observed radar track.
    log: f64,
    /// Time of the state.
    pub(super) at: Time,
    mean: SVector<f64, STATES>,
    covariance: SMatrix<f64, STATES, STATES>,
    track: Option<ObservedTrack>,
}

/// The observed radar track: log-likelihoods that it is of this aircraft, and that it is of another aircraft or has
/// changed to one. Both are relative to the likelihood of another aircraft.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ObservedTrack {
    own: f64,
    other: f64,
    /// Logarithm of the sum of both likelihoods.
    either: f64,
    /// Mean and covariance when the track was last certainly of this aircraft, or before it was observed.
    saved: (SVector<f64, STATES>, SMatrix<f64, STATES, STATES>),
}

/// Elapsed time, which is the same for all hypotheses.
pub(super) struct ElapsedTime {
    until: Time,
    /// Duration, seconds.
    dt: f64,
    /// Persistent errors of the observed radar track and the share of them that remains; the share of an honest offset
    /// that remains.
    slow: PersistentErrors,
    slow_kept: f64,
    honest_kept: f64,
}

impl ElapsedTime {
    /// The passage between two times; `None` if it is not positive.
    pub(super) fn between(from: Time, until: Time, slow: PersistentErrors) -> Option<Self> {
        let dt = until.seconds_since(from);
        let kept = |lasts_s: f64| (-dt / lasts_s).exp();
        let (slow_kept, honest_kept) = (kept(slow.lasts_s), kept(HONEST_LASTS_S));
        (dt > 0.0).then_some(Self { until, dt, slow, slow_kept, honest_kept })
    }
}

/// Natural logarithms of the probabilities that a radar track leaves its aircraft between two observations, and that it
/// stays.
pub(super) struct DriftLogProbabilities {
    leaves: f64,
    stays: f64,
}

impl DriftLogProbabilities {
    /// Probabilities for an interval of `dt` seconds.
    pub(super) fn within(dt: f64) -> Self {
        let leaves = (dt / LEAVES_AFTER_S).min(0.5);
        Self { leaves: leaves.ln(), stays: (1.0 - leaves).ln() }
    }
}

impl Hypothesis {
    pub(super) fn honest(time: Time, delay: StampDelay) -> Self {
        let mut row = Self {
            kind: HypothesisKind::Honest,
            since: time,
            number: 0,
            log: 0.0,
            at: time,
            mean: SVector::zeros(),
            covariance: SMatrix::zeros(),
            track: None,
        };
        row.forget_offset();
        row.mean[LATE] = delay.mean_s;
        row.covariance[(LATE, LATE)] = delay.sigma_s * delay.sigma_s;
        row
    }

    /// A copy that is of another kind since `since`.
    pub(super) fn branch(&self, kind: HypothesisKind, since: Time) -> Self {
        let mut row = Self { kind, since, ..self.clone() };
        let [offset_m, drift_m_s, late_s] = kind.begins_with();
        for axis in 0..2 {
            row.covariance[(OFFSET + axis, OFFSET + axis)] += offset_m * offset_m;
            row.covariance[(DRIFT + axis, DRIFT + axis)] += drift_m_s * drift_m_s;
        }
        row.covariance[(LATE, LATE)] += late_s * late_s;
        row
    }

    /// Subtracts `to` from the log-likelihood.
    pub(super) fn subtract_log(&mut self, to: f64) {
        self.log -= to;
    }

    /// Resets the offset to the prior of an honest receiver.
    pub(super) fn forget_offset(&mut self) {
        for state in OFFSET..LATE {
            self.reset(state, if state < DRIFT { HONEST_M } else { 0.0 });
        }
    }

    /// Predicts the state over that interval.
    pub(super) fn predict(&mut self, passage: &ElapsedTime) {
        let ElapsedTime { until, dt, slow, slow_kept, honest_kept } = *passage;
        self.at = until;
        self.decay(SLOW, slow_kept, slow.range_m);
        self.decay(SLOW + 1, slow_kept, slow.azimuth);
        match self.kind {
            HypothesisKind::Honest | HypothesisKind::Late => {
                for axis in 0..2 {
                    self.decay(OFFSET + axis, honest_kept, HONEST_M);
                }
            }
            HypothesisKind::Walk | HypothesisKind::Drift | HypothesisKind::Jump => self.drift(dt),
        }
    }

    /// Predicts the offset by its drift.
    fn drift(&mut self, dt: f64) {
        let white = if self.kind == HypothesisKind::Walk { 0.0 } else { LIE_ACCELERATION_M2_S3 };
        for axis in 0..2 {
            let (offset, drift) = (OFFSET + axis, DRIFT + axis);
            self.mean[offset] += dt * self.mean[drift];
            for other in 0..STATES {
                let added = dt * self.covariance[(drift, other)];
                self.covariance[(offset, other)] += added;
            }
            for other in 0..STATES {
                let added = dt * self.covariance[(other, drift)];
                self.covariance[(other, offset)] += added;
            }
            self.covariance[(offset, offset)] += white * dt * dt * dt / 3.0;
            self.covariance[(offset, drift)] += white * dt * dt / 2.0;
            self.covariance[(drift, offset)] += white * dt * dt / 2.0;
            self.covariance[(drift, drift)] += white * dt;
        }
    }

    /// Predicts an exponentially correlated variable: x' = kept · x + w.
    fn decay(&mut self, state: usize, kept: f64, sigma: f64) {
        self.mean[state] *= kept;
        for other in 0..STATES {
            self.covariance[(state, other)] *= kept;
            self.covariance[(other, state)] *= kept;
        }
        self.covariance[(state, state)] += sigma * sigma * (1.0 - kept * kept);
    }

    /// Resets a variable to zero with this standard deviation.
    fn reset(&mut self, state: usize, sigma: f64) {
        self.mean[state] = 0.0;
        for other in 0..STATES {
            self.covariance[(state, other)] = 0.0;
            self.covariance[(other, state)] = 0.0;
        }
        self.covariance[(state, state)] = sigma * sigma;
    }

    /// Sets the prior of another radar's misalignment.
    pub(super) fn reset_radar(&mut self, look: &TrackObservation) {
        self.reset(MISALIGNED, look.alignment[0]);
        self.reset(MISALIGNED + 1, look.alignment[1]);
    }

    /// Sets the prior of another radar track's persistent errors.
    pub(super) fn reset_track(&mut self, look: &TrackObservation) {
        self.reset(SLOW, look.slow.range_m);
        self.reset(SLOW + 1, look.slow.azimuth);
    }

    /// Begins to observe another radar track, which is of this aircraft with prior probability `own`.
    pub(super) fn begin_track(&mut self, look: &TrackObservation, sights: &[AxisRow; 2], own: f64) {
        let place = self.place(look, sights);
        let saved = (self.mean, self.covariance);
        let (own, other) = (own.ln() + place, (1.0 - own).ln());
        self.track = Some(ObservedTrack { own, other, either: sum(own, other), saved });
        self.observe(look, sights, 0);
        self.observe(look, sights, 1);
    }

    /// Adds the next observation of the track. `other` is the log-likelihood of the observation if it is of another
    /// aircraft.
    pub(super) fn update(
        &mut self,
        look: &TrackObservation,
        sights: &[AxisRow; 2],
        other: f64,
        leaving: &DriftLogProbabilities,
    ) {
        let observed = self.observe(look, sights, 0) + self.observe(look, sights, 1);
        let Some(track) = &mut self.track else { return };
        track.other = sum(track.other, track.own + leaving.leaves);
        track.own += leaving.stays + (observed - other).clamp(LOOK_ADDS[0], LOOK_ADDS[1]);
        track.either = sum(track.own, track.other);
        if track.own - track.other > SURELY_OWN {
            track.saved = (self.mean, self.covariance);
        }
    }

    /// Ends the radar track, or its observation.
    pub(super) fn end_track(&mut self) {
        if let Some(track) = self.track.take() {
            self.log += track.either;
            if track.own < track.other {
                (self.mean, self.covariance) = track.saved;
            }
        }
    }

    /// Ends a radar track that drifted away; `log` is the log-likelihood of that.
    pub(super) fn end_walked(&mut self, log: f64) {
        if let Some(track) = self.track.take() {
            (self.mean, self.covariance) = track.saved;
        }
        self.log = log;
    }

    /// Natural logarithm of the likelihood.
    pub(super) fn log(&self) -> f64 {
        self.log + self.track.as_ref().map_or(0.0, |track| track.either)
    }

    /// Whether the observed radar track is more likely of this aircraft than of another.
    pub(super) fn is_own(&self) -> bool {
        self.track.as_ref().is_some_and(|track| track.own > track.other)
    }

    /// Log-likelihood ratio of the position for this aircraft to another one nearby.
    fn place(&self, look: &TrackObservation, sights: &[AxisRow; 2]) -> f64 {
        let mut expected = Matrix2::zeros();
        let mut elsewhere = Matrix2::zeros();
        let apart = Vector2::from_fn(|axis, _| look.offset_m[axis] - sights[axis].of(&self.mean));
        let found = Vector2::from(look.offset_m);
        for one in 0..2 {
            for other in 0..2 {
                expected[(one, other)] = sights[one].of(&sights[other].spread(&self.covariance));
            }
            expected[(one, one)] += look.white_m2[one];
            let slow_m = [look.slow.range_m, look.range_m * look.slow.azimuth][one];
            elsewhere[(one, one)] = ELSEWHERE_M * ELSEWHERE_M + slow_m * slow_m + look.white_m2[one];
        }
        log_density(&apart, &expected) - log_density(&found, &elsewhere)
    }

    /// Updates the state by one axis of an observation; returns its log-likelihood.
    pub(super) fn observe(&mut self, look: &TrackObservation, sights: &[AxisRow; 2], axis: usize) -> f64 {
        let sight = &sights[axis];
        let spread = sight.spread(&self.covariance);
        let variance = sight.of(&spread) + look.white_m2[axis];
        let sigma = variance.sqrt();
        let residual = (look.offset_m[axis] - sight.of(&self.mean)) / sigma;
        let (size, weight) = (residual.abs(), (HUBER / residual.abs()).min(1.0));
        let cost = if size <= HUBER { 0.5 * size * size } else { HUBER * (size - 0.5 * HUBER) };
        self.mean += spread * (weight * residual / sigma);
        for state in 0..STATES {
            let gain = spread[state] * (weight / variance);
            for other in 0..STATES {
                self.covariance[(other, state)] -= spread[other] * gain;
            }
        }
        -cost - 0.5 * (TAU * variance).ln()
    }

    /// Predicted offset of the reported positions at `time`, east and north, metres, and its covariance, for a drifting
    /// offset: o + Δt d, and cov(o) + Δt (cov(o, d) + cov(d, o)) + Δt² cov(d) + q Δt³ / 3.
    pub(super) fn offset(&self, time: Time) -> (Vector2<f64>, Matrix2<f64>) {
        let dt = time.seconds_since(self.at).max(0.0);
        let block = |row, column| self.covariance.fixed_view::<2, 2>(row, column).into_owned();
        let across = block(OFFSET, DRIFT);
        let white = Matrix2::identity() * (LIE_ACCELERATION_M2_S3 * dt * dt * dt / 3.0);
        (
            self.mean.fixed_rows::<2>(OFFSET) + self.mean.fixed_rows::<2>(DRIFT) * dt,
            block(OFFSET, OFFSET)
                + (across + across.transpose()) * dt
                + block(DRIFT, DRIFT) * (dt * dt)
                + white,
        )
    }

    /// Delay of the time stamps and its standard deviation, seconds.
    pub(super) fn late_s(&self) -> (f64, f64) {
        (self.mean[LATE], self.covariance[(LATE, LATE)].max(0.0).sqrt())
    }
}

/// Logarithm of the sum of two numbers given by their logarithms.
fn sum(one: f64, other: f64) -> f64 {
    let (less, more) = if one < other { (one, other) } else { (other, one) };
    more + (less - more).exp().ln_1p()
}

/// Row h of the observation matrix for one axis: the non-zero elements by which variables contribute to the offset of a
/// plot from the transponder's curve.
pub(super) struct AxisRow([(usize, f64); 5]);

impl AxisRow {
    /// The rows of both axes of an observation, the same for all hypotheses.
    pub(super) fn of_look(look: &TrackObservation) -> [Self; 2] {
        [Self::along(look, 0), Self::along(look, 1)]
    }

    fn along(look: &TrackObservation, axis: usize) -> Self {
        let along = look.axes[axis];
        let arm = if axis == 0 { 1.0 } else { look.range_m };
        Self([
            (OFFSET, -along.x),
            (OFFSET + 1, -along.y),
            (LATE, along.dot(&look.velocity)),
            (MISALIGNED + axis, arm),
            (SLOW + axis, arm),
        ])
    }

    /// hᵀ x.
    #[inline]
    fn of(&self, states: &SVector<f64, STATES>) -> f64 {
        self.0.iter().map(|&(state, weight)| weight * states[state]).sum()
    }

    /// P h.
    #[inline]
    fn spread(&self, covariance: &SMatrix<f64, STATES, STATES>) -> SVector<f64, STATES> {
        let mut spread = SVector::<f64, STATES>::zeros();
        for (state, weight) in self.0 {
            for other in 0..STATES {
                spread[other] += covariance[(other, state)] * weight;
            }
        }
        spread
    }
}

/// Logarithm of a normal density with a mean of zero.
fn log_density(apart: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let determinant = covariance.determinant().max(f64::MIN_POSITIVE);
    let inverse = covariance.try_inverse().unwrap_or_else(Matrix2::zeros);
    -0.5 * apart.dot(&(inverse * apart)) - TAU.ln() - 0.5 * determinant.ln()
}
