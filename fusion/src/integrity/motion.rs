//! Does a radar track fly as a transponder does, wherever it is? Its plots, less the transponder's curve, are a constant offset
//! that changes slowly if it is the same aircraft; if it is another one they move by themselves or hover.

use serde::{Deserialize, Serialize};

use std::f64::consts::TAU;

/// How fast the offset of the same aircraft may change, metres a second, and how much that changes, m²/s³.
const SAME_RATE_M_S: f64 = 1.7;
const SAME_ACCELERATION_M2_S3: f64 = 0.02;
/// Speed of another aircraft on each axis, metres a second, and its changes, m²/s³.
const OTHER_SPEED_M_S: f64 = 10.0;
const OTHER_ACCELERATION_M2_S3: f64 = 3.0;
/// Share of other aircraft that hover.
const HOVER_SHARE: f64 = 0.4;
/// How far a place may have jumped while nobody knew, metres.
const ANEW_M: f64 = 50.0;
/// A residual counts no more than this, squared standard deviations.
const SQUARED_MAX: f64 = 25.0;
/// Bound of what one look adds, and of the sum, natural logarithms.
const LOOK_MAX: f64 = 4.0;
const SUM: [f64; 2] = [-10.0, 14.0];

/// A second of plots along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Step {
    /// Mean of the plots less the transponder's curve, metres.
    pub(crate) offset_m: f64,
    /// Mean of the plots from where the track began, metres.
    pub(crate) flown_m: f64,
    /// Variance of the plots' mean that is new with each second, and that of the curve, m².
    pub(crate) plots_m2: f64,
    pub(crate) curve_m2: f64,
    /// Slow error of the radar track, metres, and its correlation time, seconds.
    pub(crate) slow_m: f64,
    pub(crate) lasts_s: f64,
}

/// Sum of the log-likelihood ratios so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Motion {
    /// Outward and clockwise; `None` before the first look.
    axes: Option<[[Model; 3]; 2]>,
    /// Log-likelihoods: the same aircraft; another one that moves; one that hovers.
    logs: [f64; 3],
    /// The last two of these together.
    other: f64,
    sum: f64,
}

impl Motion {
    /// How much likelier it is the same aircraft than another one by the way it flies, natural logarithm.
    pub(crate) fn llr(&self) -> f64 {
        self.sum
    }

    /// The same where the offset may be another one than it was.
    pub(crate) fn take_elsewhere(&mut self, steps: [Step; 2], dt: f64) -> f64 {
        if let Some(axes) = &mut self.axes {
            for models in axes {
                models[0].place_anew();
            }
        }
        self.take(steps, dt)
    }

    /// Another second, `dt` after the one before; its log-likelihood if it is another aircraft, 0 of the first.
    pub(crate) fn take(&mut self, steps: [Step; 2], dt: f64) -> f64 {
        let Some(axes) = &mut self.axes else {
            self.axes = Some(steps.map(|step| {
                [
                    Model::new(step.offset_m, step.plots_m2 + step.curve_m2, &step, SAME_RATE_M_S),
                    Model::new(step.flown_m, step.plots_m2, &step, OTHER_SPEED_M_S),
                    Model::new(step.flown_m, step.plots_m2, &step, 0.0),
                ]
            }));
            return 0.0;
        };
        let before = (self.logs[0] - self.other, self.other);
        let mut seen = [Seen::NOTHING; 3];
        for (models, step) in axes.iter_mut().zip(&steps) {
            let both_m2 = step.plots_m2 + step.curve_m2;
            let kept = (-dt / step.lasts_s).exp();
            let [same, moving, hovering] = models;
            seen[0].add(same.take(step.offset_m, both_m2, step, SAME_ACCELERATION_M2_S3, (dt, kept)));
            seen[1].add(moving.take(step.flown_m, step.plots_m2, step, OTHER_ACCELERATION_M2_S3, (dt, kept)));
            seen[2].add(hovering.take(step.flown_m, step.plots_m2, step, 0.0, (dt, kept)));
        }
        self.logs.iter_mut().zip(&seen).for_each(|(log, seen)| *log += seen.log());
        self.other = other(&self.logs);
        let added = (self.logs[0] - self.other - before.0).clamp(-LOOK_MAX, LOOK_MAX);
        self.sum = (self.sum + added).clamp(SUM[0], SUM[1]);
        self.other - before.1
    }
}

/// How likely a look is along both axes: a normal density.
#[derive(Clone, Copy)]
struct Seen {
    /// Sum of the squared residuals in standard deviations.
    squared: f64,
    /// Product of 2 π times the variances.
    variances: f64,
}

impl Seen {
    const NOTHING: Self = Self { squared: 0.0, variances: 1.0 };

    /// Along another axis.
    fn add(&mut self, other: Self) {
        self.squared += other.squared;
        self.variances *= other.variances;
    }

    /// Natural logarithm of the density.
    fn log(&self) -> f64 {
        -0.5 * (self.squared + self.variances.ln())
    }
}

/// Another aircraft.
fn other(&[_, moving, hovering]: &[f64; 3]) -> f64 {
    let most = moving.max(hovering);
    most + ((1.0 - HOVER_SHARE) * (moving - most).exp() + HOVER_SHARE * (hovering - most).exp()).ln()
}

/// Place, rate, and the radar track's slow error along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Model {
    mean: [f64; 3],
    /// Upper half, row by row.
    covariance: [f64; 6],
}

impl Model {
    /// After the first look: the place is what was seen less the slow error.
    fn new(seen_m: f64, white_m2: f64, step: &Step, rate_m_s: f64) -> Self {
        let slow = step.slow_m * step.slow_m;
        Self {
            mean: [seen_m, 0.0, 0.0],
            covariance: [white_m2 + slow, 0.0, -slow, rate_m_s * rate_m_s, 0.0, slow],
        }
    }

    /// Nothing is known of the place any more.
    fn place_anew(&mut self) {
        self.covariance[0] += ANEW_M * ANEW_M;
    }

    /// A look `dt` seconds later, of which a share `kept` of the slow error lasts.
    #[inline]
    fn take(
        &mut self,
        seen_m: f64,
        white_m2: f64,
        step: &Step,
        acceleration_m2_s3: f64,
        (dt, kept): (f64, f64),
    ) -> Seen {
        let Self { mean: [place, rate, slow], covariance: [pp, pr, ps, rr, rs, ss] } = *self;
        let q = acceleration_m2_s3;
        let (place, slow) = (place + dt * rate, slow * kept);
        let pp = pp + 2.0 * dt * pr + dt * dt * rr + q * dt * dt * dt / 3.0;
        let pr = pr + dt * rr + q * dt * dt / 2.0;
        let ps = (ps + dt * rs) * kept;
        let rr = rr + q * dt;
        let rs = rs * kept;
        let ss = ss * kept * kept + step.slow_m * step.slow_m * (1.0 - kept * kept);
        // Seen is place and slow error together.
        let spread = [pp + ps, pr + rs, ps + ss];
        let variance = spread[0] + spread[2] + white_m2;
        let residual = seen_m - place - slow;
        let gain = [spread[0] / variance, spread[1] / variance, spread[2] / variance];
        self.mean = [place + gain[0] * residual, rate + gain[1] * residual, slow + gain[2] * residual];
        self.covariance = [
            pp - gain[0] * spread[0],
            pr - gain[0] * spread[1],
            ps - gain[0] * spread[2],
            rr - gain[1] * spread[1],
            rs - gain[1] * spread[2],
            ss - gain[2] * spread[2],
        ];
        Seen { squared: (residual * residual / variance).min(SQUARED_MAX), variances: TAU * variance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A track of 15 s against a transponder that flies so: range of both, metres.
    fn motion(radar_m: impl Fn(f64) -> f64, transponder_m: impl Fn(f64) -> f64) -> f64 {
        let mut motion = Motion::default();
        for second in 0..15 {
            let second = f64::from(second);
            let (flown_m, curve_m) = (radar_m(second), transponder_m(second));
            let step = Step {
                offset_m: flown_m - curve_m,
                flown_m,
                plots_m2: 1.0,
                curve_m2: 1.0,
                slow_m: 4.0,
                lasts_s: 20.0,
            };
            motion.take([step, Step { offset_m: 0.0, flown_m: 0.0, slow_m: 30.0, ..step }], 1.0);
        }
        motion.llr()
    }

    /// Out, and back again.
    fn turns(second: f64) -> f64 {
        12.0 * (7.0 - (second - 7.0).abs())
    }

    #[test]
    fn who_turns_alike_elsewhere_flies_alike() {
        assert!(motion(|second| 80.0 + turns(second), turns) > 3.0);
    }

    #[test]
    fn who_flies_on_while_the_other_turns_is_another() {
        assert!(motion(|second| 80.0 + 12.0 * second, turns) < -6.0);
    }

    #[test]
    fn two_that_hover_are_no_evidence_of_each_other() {
        assert!(motion(|_| 80.0, |_| 0.0) < 1.0);
    }

    #[test]
    fn a_place_that_jumps_costs_nothing_where_that_is_known() {
        let jumps = |known: bool| {
            let mut motion = Motion::default();
            for second in 0..16 {
                let offset_m = if second < 8 { 0.0 } else { 100.0 };
                let flown_m = turns(f64::from(second));
                let step =
                    Step { offset_m, flown_m, plots_m2: 1.0, curve_m2: 1.0, slow_m: 4.0, lasts_s: 20.0 };
                match known && second == 8 {
                    true => motion.take_elsewhere([step; 2], 1.0),
                    false => motion.take([step; 2], 1.0),
                };
            }
            motion.llr()
        };
        assert!(jumps(true) > jumps(false) + 3.0, "{} {}", jumps(true), jumps(false));
    }
}
