//! One row of the bank: what the offsets would be if the transponder were honest, or lied since then.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::{Delay, ELSEWHERE_M, Look, Slow};
use crate::time::Time;

/// Offset and drift of the transponder's places, east and north; how late its stamps are; the radar's misalignment, and the
/// slow error of its track, each in range and azimuth.
const STATES: usize = 9;
const OFFSET: usize = 0;
const DRIFT: usize = 2;
const LATE: usize = 4;
const MISALIGNED: usize = 5;
const SLOW: usize = 7;

/// Offset of an honest receiver, each axis, metres, and how long it lasts, seconds.
const HONEST_M: f64 = 2.2;
const HONEST_LASTS_S: f64 = 60.0;
/// White acceleration of a lie, m²/s³.
const LIE_ACCELERATION_M2_S3: f64 = 0.02;
/// A residual beyond so many standard deviations counts no more than linearly (Huber).
const HUBER: f64 = 3.5;
/// A radar track leaves its aircraft after this, on average, seconds: it walks off, or exchanges its number with another one.
const LEAVES_AFTER_S: f64 = 70.0;
/// What one look adds to the log-likelihood that it is the aircraft's own: least and most.
const LOOK_ADDS: [f64; 2] = [-6.0, 4.0];
/// It is the aircraft's own for sure where that is so much likelier, natural logarithm.
const SURELY_OWN: f64 = 3.0;

/// What a row supposes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Kind {
    Honest,
    /// Honest; the radar track begins to walk off.
    Walk,
    /// The places begin to drift away.
    Drift,
    /// They are off at once.
    Jump,
    /// The time stamps are off at once.
    Late,
}

impl Kind {
    /// Standard deviations that a row begins with beside those of honesty: offset and drift, each axis, metres and metres a
    /// second; how late, seconds.
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
pub(super) struct Row {
    pub(super) kind: Kind,
    pub(super) since: Time,
    /// How many times rows were begun before.
    pub(super) number: u32,
    /// Natural logarithm of the likelihood, but for the radar track that is looked at.
    log: f64,
    /// Of the state.
    pub(super) at: Time,
    mean: SVector<f64, STATES>,
    covariance: SMatrix<f64, STATES, STATES>,
    track: Option<Track>,
}

/// The radar track that is looked at: natural logarithms of the likelihoods that it is the aircraft's own, and that it is
/// another one's or has become one, beside that of another one's.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Track {
    own: f64,
    other: f64,
    /// The sum of both likelihoods.
    either: f64,
    /// Mean and covariance when it was the aircraft's own for sure, or before it.
    saved: (SVector<f64, STATES>, SMatrix<f64, STATES, STATES>),
}

/// A passage of time: the same for all rows.
pub(super) struct Passage {
    until: Time,
    /// Seconds.
    dt: f64,
    /// The slow errors of the radar track that was looked at, and the share of them that lasts; that of an honest offset.
    slow: Slow,
    slow_kept: f64,
    honest_kept: f64,
}

impl Passage {
    /// `None` where no time passes.
    pub(super) fn between(from: Time, until: Time, slow: Slow) -> Option<Self> {
        let dt = until.seconds_since(from);
        let kept = |lasts_s: f64| (-dt / lasts_s).exp();
        let (slow_kept, honest_kept) = (kept(slow.lasts_s), kept(HONEST_LASTS_S));
        (dt > 0.0).then_some(Self { until, dt, slow, slow_kept, honest_kept })
    }
}

/// Natural logarithms of the probabilities that a radar track leaves its aircraft from one look to the next, and that it stays.
pub(super) struct Leaving {
    leaves: f64,
    stays: f64,
}

impl Leaving {
    /// Within so many seconds.
    pub(super) fn within(dt: f64) -> Self {
        let leaves = (dt / LEAVES_AFTER_S).min(0.5);
        Self { leaves: leaves.ln(), stays: (1.0 - leaves).ln() }
    }
}

impl Row {
    pub(super) fn honest(time: Time, delay: Delay) -> Self {
        let mut row = Self {
            kind: Kind::Honest,
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

    /// From here on it is of another kind.
    pub(super) fn branch(&self, kind: Kind, since: Time) -> Self {
        let mut row = Self { kind, since, ..self.clone() };
        let [offset_m, drift_m_s, late_s] = kind.begins_with();
        for axis in 0..2 {
            row.covariance[(OFFSET + axis, OFFSET + axis)] += offset_m * offset_m;
            row.covariance[(DRIFT + axis, DRIFT + axis)] += drift_m_s * drift_m_s;
        }
        row.covariance[(LATE, LATE)] += late_s * late_s;
        row
    }

    /// Takes so much off the logarithm of the likelihood.
    pub(super) fn relate(&mut self, to: f64) {
        self.log -= to;
    }

    /// Nothing is known of the offset but that the receiver is honest.
    pub(super) fn forget_offset(&mut self) {
        for state in OFFSET..LATE {
            self.reset(state, if state < DRIFT { HONEST_M } else { 0.0 });
        }
    }

    /// The state after that passage of time.
    pub(super) fn turn(&mut self, passage: &Passage) {
        let Passage { until, dt, slow, slow_kept, honest_kept } = *passage;
        self.at = until;
        self.fade(SLOW, slow_kept, slow.range_m);
        self.fade(SLOW + 1, slow_kept, slow.azimuth);
        match self.kind {
            Kind::Honest | Kind::Late => {
                for axis in 0..2 {
                    self.fade(OFFSET + axis, honest_kept, HONEST_M);
                }
            }
            Kind::Walk | Kind::Drift | Kind::Jump => self.drift(dt),
        }
    }

    /// The offset goes on with its drift.
    fn drift(&mut self, dt: f64) {
        let white = if self.kind == Kind::Walk { 0.0 } else { LIE_ACCELERATION_M2_S3 };
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

    /// A state that lasts for a while: x' = kept · x, and what is new.
    fn fade(&mut self, state: usize, kept: f64, sigma: f64) {
        self.mean[state] *= kept;
        for other in 0..STATES {
            self.covariance[(state, other)] *= kept;
            self.covariance[(other, state)] *= kept;
        }
        self.covariance[(state, state)] += sigma * sigma * (1.0 - kept * kept);
    }

    /// Nothing is known of a state but its standard deviation.
    fn reset(&mut self, state: usize, sigma: f64) {
        self.mean[state] = 0.0;
        for other in 0..STATES {
            self.covariance[(state, other)] = 0.0;
            self.covariance[(other, state)] = 0.0;
        }
        self.covariance[(state, state)] = sigma * sigma;
    }

    /// Another radar, with a misalignment of its own.
    pub(super) fn meet_radar(&mut self, look: &Look) {
        self.reset(MISALIGNED, look.alignment[0]);
        self.reset(MISALIGNED + 1, look.alignment[1]);
    }

    /// Another radar track, with slow errors of its own.
    pub(super) fn meet_track(&mut self, look: &Look) {
        self.reset(SLOW, look.slow.range_m);
        self.reset(SLOW + 1, look.slow.azimuth);
    }

    /// Begins to look at another radar track, that is the aircraft's own with probability `own` before it is looked at.
    pub(super) fn begin_track(&mut self, look: &Look, sights: &[Sight; 2], own: f64) {
        let place = self.place(look, sights);
        let saved = (self.mean, self.covariance);
        let (own, other) = (own.ln() + place, (1.0 - own).ln());
        self.track = Some(Track { own, other, either: sum(own, other), saved });
        self.observe(look, sights, 0);
        self.observe(look, sights, 1);
    }

    /// Takes in the next look at it. `other`: log-likelihood of the look if it is another aircraft.
    pub(super) fn take(&mut self, look: &Look, sights: &[Sight; 2], other: f64, leaving: &Leaving) {
        let observed = self.observe(look, sights, 0) + self.observe(look, sights, 1);
        let Some(track) = &mut self.track else { return };
        track.other = sum(track.other, track.own + leaving.leaves);
        track.own += leaving.stays + (observed - other).clamp(LOOK_ADDS[0], LOOK_ADDS[1]);
        track.either = sum(track.own, track.other);
        if track.own - track.other > SURELY_OWN {
            track.saved = (self.mean, self.covariance);
        }
    }

    /// The radar track has ended, or another one is looked at.
    pub(super) fn end_track(&mut self) {
        if let Some(track) = self.track.take() {
            self.log += track.either;
            if track.own < track.other {
                (self.mean, self.covariance) = track.saved;
            }
        }
    }

    /// The radar track has ended and had walked off: it is worth what that says.
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

    /// Whether the radar track that is looked at is rather the aircraft's own.
    pub(super) fn is_own(&self) -> bool {
        self.track.as_ref().is_some_and(|track| track.own > track.other)
    }

    /// How much likelier the place is for the aircraft itself than for one somewhere around.
    fn place(&self, look: &Look, sights: &[Sight; 2]) -> f64 {
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

    /// Takes one axis of a look in; the logarithm of its likelihood.
    pub(super) fn observe(&mut self, look: &Look, sights: &[Sight; 2], axis: usize) -> f64 {
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

    /// Offset of the places at `time`, east and north, metres, and its covariance, of a row whose offset drifts:
    /// o + Δt d, and cov(o) + Δt (cov(o, d) + cov(d, o)) + Δt² cov(d) + q Δt³ / 3.
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

    /// How late its stamps are, and the standard deviation of that, seconds.
    pub(super) fn late_s(&self) -> (f64, f64) {
        (self.mean[LATE], self.covariance[(LATE, LATE)].max(0.0).sqrt())
    }
}

/// Logarithm of the sum of two numbers that are given by their logarithms.
fn sum(one: f64, other: f64) -> f64 {
    let (less, more) = if one < other { (one, other) } else { (other, one) };
    more + (less - more).exp().ln_1p()
}

/// What the states add to the offset of a plot from the transponder's curve along one axis: those that add something, and by
/// how much.
pub(super) struct Sight([(usize, f64); 5]);

impl Sight {
    /// Of a look: the same for all rows.
    pub(super) fn of_look(look: &Look) -> [Self; 2] {
        [Self::along(look, 0), Self::along(look, 1)]
    }

    fn along(look: &Look, axis: usize) -> Self {
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

/// Natural logarithm of a normal density of zero mean.
fn log_density(apart: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let determinant = covariance.determinant().max(f64::MIN_POSITIVE);
    let inverse = covariance.try_inverse().unwrap_or_else(Matrix2::zeros);
    -0.5 * apart.dot(&(inverse * apart)) - TAU.ln() - 0.5 * determinant.ln()
}
