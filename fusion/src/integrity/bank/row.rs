//! One row of the bank: what the offsets would be if the transponder were honest, or lied since then.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
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

/// What a row supposes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Honest,
    /// The radar track walks off.
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

#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) kind: Kind,
    pub(super) since: Time,
    /// How many times rows were begun before.
    pub(super) number: u32,
    /// Natural logarithm of the likelihood.
    pub(super) log: f64,
    /// Of the state.
    pub(super) at: Time,
    mean: SVector<f64, STATES>,
    covariance: SMatrix<f64, STATES, STATES>,
    /// The radar track elsewhere that was looked at last.
    far: Option<Far>,
}

/// A radar track elsewhere.
#[derive(Clone, Copy, Debug)]
struct Far {
    track: u64,
    /// Likelihood before it.
    before: f64,
    /// How much likelier its first place is for the aircraft itself than for another one, natural logarithm.
    place: f64,
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
            far: None,
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

    /// Nothing is known of the offset but that the receiver is honest.
    pub(super) fn forget_offset(&mut self) {
        for state in OFFSET..LATE {
            self.reset(state, if state < DRIFT { HONEST_M } else { 0.0 });
        }
    }

    /// The state at that time.
    pub(super) fn turn(&mut self, time: Time, slow: &Slow) {
        let dt = time.seconds_since(self.at);
        if dt <= 0.0 {
            return;
        }
        self.at = time;
        let kept = (-dt / slow.lasts_s).exp();
        self.fade(SLOW, kept, slow.range_m);
        self.fade(SLOW + 1, kept, slow.azimuth);
        match self.kind {
            Kind::Honest | Kind::Late => {
                let kept = (-dt / HONEST_LASTS_S).exp();
                for axis in 0..2 {
                    self.fade(OFFSET + axis, kept, HONEST_M);
                }
            }
            Kind::Walk | Kind::Drift | Kind::Jump => self.drift(dt),
        }
    }

    /// The offset goes on with its drift.
    fn drift(&mut self, dt: f64) {
        let is_walk = self.kind == Kind::Walk;
        let white = if is_walk { 0.0 } else { LIE_ACCELERATION_M2_S3 };
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

    /// Takes a look in.
    pub(super) fn take(&mut self, look: &Look) {
        for axis in 0..2 {
            self.log += self.observe(look, axis);
        }
    }

    /// Takes in a look at what may be another aircraft.
    pub(super) fn take_far(&mut self, look: &Look, motion: f64, own_share: f64) {
        let far = match self.far {
            Some(far) if far.track == look.track => far,
            _ => Far { track: look.track, before: self.log, place: self.place(look) },
        };
        self.far = Some(far);
        let own = own_share * (motion + far.place).exp();
        self.log = far.before + (1.0 - own_share + own).ln();
        // Where it is likelier another one's it says nothing of this one's place.
        if own > 1.0 - own_share {
            for axis in 0..2 {
                self.observe(look, axis);
            }
        }
    }

    /// How much likelier the place is for the aircraft itself than for one somewhere around.
    fn place(&self, look: &Look) -> f64 {
        let sights = [0, 1].map(|axis| sight(look, axis));
        let mut expected = Matrix2::zeros();
        let mut elsewhere = Matrix2::zeros();
        let apart = Vector2::from_fn(|axis, _| look.offset_m[axis] - sights[axis].dot(&self.mean));
        let found = Vector2::from(look.offset_m);
        for one in 0..2 {
            for other in 0..2 {
                expected[(one, other)] = sights[one].dot(&(self.covariance * sights[other]));
            }
            expected[(one, one)] += look.white_m2[one];
            let slow_m = [look.slow.range_m, look.range_m * look.slow.azimuth][one];
            elsewhere[(one, one)] = ELSEWHERE_M * ELSEWHERE_M + slow_m * slow_m + look.white_m2[one];
        }
        log_density(&apart, &expected) - log_density(&found, &elsewhere)
    }

    /// Takes one axis of a look in; the logarithm of its likelihood.
    fn observe(&mut self, look: &Look, axis: usize) -> f64 {
        let sight = sight(look, axis);
        let spread = self.covariance * sight;
        let variance = sight.dot(&spread) + look.white_m2[axis];
        let residual = (look.offset_m[axis] - sight.dot(&self.mean)) / variance.sqrt();
        let (size, weight) = (residual.abs(), (HUBER / residual.abs()).min(1.0));
        let cost = if size <= HUBER { 0.5 * size * size } else { HUBER * (size - 0.5 * HUBER) };
        self.mean += spread * (weight * residual / variance.sqrt());
        self.covariance -= spread * spread.transpose() * (weight / variance);
        -cost - 0.5 * (TAU * variance).ln()
    }

    /// Offset of the places, east and north, metres, and its covariance.
    pub(super) fn offset(&self) -> (Vector2<f64>, Matrix2<f64>) {
        (
            self.mean.fixed_rows::<2>(OFFSET).into_owned(),
            self.covariance.fixed_view::<2, 2>(OFFSET, OFFSET).into_owned(),
        )
    }

    /// How late its stamps are, seconds.
    pub(super) fn late_s(&self) -> f64 {
        self.mean[LATE]
    }
}

/// What each state adds to the offset of a plot from the transponder's curve, along one axis.
fn sight(look: &Look, axis: usize) -> SVector<f64, STATES> {
    let along = look.axes[axis];
    let arm = if axis == 0 { 1.0 } else { look.range_m };
    let mut sight = SVector::zeros();
    sight[OFFSET] = -along.x;
    sight[OFFSET + 1] = -along.y;
    sight[LATE] = along.dot(&look.velocity);
    sight[MISALIGNED + axis] = arm;
    sight[SLOW + axis] = arm;
    sight
}

/// Natural logarithm of a normal density of zero mean.
fn log_density(apart: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let determinant = covariance.determinant().max(f64::MIN_POSITIVE);
    let inverse = covariance.try_inverse().unwrap_or_else(Matrix2::zeros);
    -0.5 * apart.dot(&(inverse * apart)) - TAU.ln() - 0.5 * determinant.ln()
}
