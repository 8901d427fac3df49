//! Compares the motion of a radar track with that of a transponder at any distance. If both are one aircraft, the plots
//! have an offset from the transponder's curve that changes slowly. Another aircraft moves independently or hovers.

use serde::{Deserialize, Serialize};

use std::f64::consts::TAU;

/// Rate of change of the offset for the same aircraft, metres a second, and its random acceleration, m²/s³.
const SAME_RATE_M_S: f64 = 1.7;
const SAME_ACCELERATION_M2_S3: f64 = 0.02;
/// Speed of another aircraft on each axis, metres a second, and its random acceleration, m²/s³.
const OTHER_SPEED_M_S: f64 = 10.0;
const OTHER_ACCELERATION_M2_S3: f64 = 3.0;
/// Share of other aircraft that hover.
const HOVER_SHARE: f64 = 0.4;
/// Standard deviation of an unnoticed jump of the position, metres.
const ANEW_M: f64 = 50.0;
/// Maximum weight of a residual, squared standard deviations.
const SQUARED_MAX: f64 = 25.0;
/// Bounds on the log-likelihood ratio of one second, and of the sum.
const LOOK_MAX: f64 = 4.0;
const SUM: [f64; 2] = [-10.0, 14.0];

/// One second of plots along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MotionStep {
    /// Mean offset of the plots from the transponder's curve, metres.
    pub(crate) offset_m: f64,
    /// Mean distance of the plots from the start of the track, metres.
    pub(crate) flown_m: f64,
    /// Variance of the plots' mean that is independent between seconds, and that of the curve, m².
    pub(crate) plots_m2: f64,
    pub(crate) curve_m2: f64,
    /// Persistent error of the radar track, metres, and its correlation time, seconds.
    pub(crate) slow_m: f64,
    pub(crate) lasts_s: f64,
}

/// Accumulated log-likelihood ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct MotionComparison {
    /// Outward and clockwise; `None` before the first second.
    axes: Option<[[AxisModel; 3]; 2]>,
    /// Log-likelihoods: the same aircraft; another one that moves; another one that hovers.
    logs: [f64; 3],
    /// Log-likelihood of another aircraft, moving or hovering.
    other: f64,
    sum: f64,
}

impl MotionComparison {
    /// Log-likelihood ratio of the same aircraft against another one, from their motion.
    pub(crate) fn llr(&self) -> f64 {
        self.sum
    }

    /// Like [`Self::update`], if the offset may have changed since the last second.
    pub(crate) fn take_elsewhere(&mut self, steps: [MotionStep; 2], dt: f64) -> f64 {
        if let Some(axes) = &mut self.axes {
            for models in axes {
                models[0].reset_position();
            }
        }
        self.update(steps, dt)
    }

    /// Adds a second, `dt` seconds after the previous one; returns its log-likelihood for another aircraft, 0 for the
    /// first.
    pub(crate) fn update(&mut self, steps: [MotionStep; 2], dt: f64) -> f64 {
        let Some(axes) = &mut self.axes else {
            self.axes = Some(steps.map(|step| {
                [
                    AxisModel::new(step.offset_m, step.plots_m2 + step.curve_m2, &step, SAME_RATE_M_S),
                    AxisModel::new(step.flown_m, step.plots_m2, &step, OTHER_SPEED_M_S),
                    AxisModel::new(step.flown_m, step.plots_m2, &step, 0.0),
                ]
            }));
            return 0.0;
        };
        let before = (self.logs[0] - self.other, self.other);
        let mut seen = [SecondDensity::NOTHING; 3];
        for (models, step) in axes.iter_mut().zip(&steps) {
            let both_m2 = step.plots_m2 + step.curve_m2;
            let kept = (-dt / step.lasts_s).exp();
            let [same, moving, hovering] = models;
            seen[0].add(same.update(step.offset_m, both_m2, step, SAME_ACCELERATION_M2_S3, (dt, kept)));
            seen[1].add(moving.update(
                step.flown_m,
                step.plots_m2,
                step,
                OTHER_ACCELERATION_M2_S3,
                (dt, kept),
            ));
            seen[2].add(hovering.update(step.flown_m, step.plots_m2, step, 0.0, (dt, kept)));
        }
        self.logs.iter_mut().zip(&seen).for_each(|(log, seen)| *log += seen.log());
        self.other = other(&self.logs);
        let added = (self.logs[0] - self.other - before.0).clamp(-LOOK_MAX, LOOK_MAX);
        self.sum = (self.sum + added).clamp(SUM[0], SUM[1]);
        self.other - before.1
    }
}

/// Normal density of a second's observations on both axes.
#[derive(Clone, Copy)]
struct SecondDensity {
    /// Sum of the squared residuals in standard deviations.
    squared: f64,
    /// Product of 2 π times the variances.
    variances: f64,
}

impl SecondDensity {
    const NOTHING: Self = Self { squared: 0.0, variances: 1.0 };

    /// Multiplies by the density of another axis.
    fn add(&mut self, other: Self) {
        self.squared += other.squared;
        self.variances *= other.variances;
    }

    /// Natural logarithm of the density.
    fn log(&self) -> f64 {
        -0.5 * (self.squared + self.variances.ln())
    }
}

/// Log-likelihood of another aircraft.
fn other(&[_, moving, hovering]: &[f64; 3]) -> f64 {
    let most = moving.max(hovering);
    most + ((1.0 - HOVER_SHARE) * (moving - most).exp() + HOVER_SHARE * (hovering - most).exp()).ln()
}

/// Position, rate, and the radar track's persistent error along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct AxisModel {
    mean: [f64; 3],
    /// Upper half of the covariance, row by row.
    covariance: [f64; 6],
}

impl AxisModel {
    /// State after the first second: the position is the observation minus the persistent error.
    fn new(seen_m: f64, white_m2: f64, step: &MotionStep, rate_m_s: f64) -> Self {
        let slow = step.slow_m * step.slow_m;
        Self {
            mean: [seen_m, 0.0, 0.0],
            covariance: [white_m2 + slow, 0.0, -slow, rate_m_s * rate_m_s, 0.0, slow],
        }
    }

    /// Enlarges the variance of the position, which may have jumped.
    fn reset_position(&mut self) {
        self.covariance[0] += ANEW_M * ANEW_M;
    }

    /// Updates the state `dt` seconds later, when a share `kept` of the persistent error remains.
    #[inline]
    fn update(
        &mut self,
        seen_m: f64,
        white_m2: f64,
        step: &MotionStep,
        acceleration_m2_s3: f64,
        (dt, kept): (f64, f64),
    ) -> SecondDensity {
        let Self { mean: [place, rate, slow], covariance: [pp, pr, ps, rr, rs, ss] } = *self;
        let q = acceleration_m2_s3;
        let (place, slow) = (place + dt * rate, slow * kept);
        let pp = pp + 2.0 * dt * pr + dt * dt * rr + q * dt * dt * dt / 3.0;
        let pr = pr + dt * rr + q * dt * dt / 2.0;
        let ps = (ps + dt * rs) * kept;
        let rr = rr + q * dt;
        let rs = rs * kept;
        let ss = ss * kept * kept + step.slow_m * step.slow_m * (1.0 - kept * kept);
        // The observation is the sum of position and persistent error.
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
        SecondDensity {
            squared: (residual * residual / variance).min(SQUARED_MAX),
            variances: TAU * variance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Log-likelihood ratio of a track of 15 s and a transponder; the arguments are the ranges of both, metres.
    fn motion(radar_m: impl Fn(f64) -> f64, transponder_m: impl Fn(f64) -> f64) -> f64 {
        let mut motion = MotionComparison::default();
        for second in 0..15 {
            let second = f64::from(second);
            let (flown_m, curve_m) = (radar_m(second), transponder_m(second));
            let step = MotionStep {
                offset_m: flown_m - curve_m,
                flown_m,
                plots_m2: 1.0,
                curve_m2: 1.0,
                slow_m: 4.0,
                lasts_s: 20.0,
            };
            motion.update([step, MotionStep { offset_m: 0.0, flown_m: 0.0, slow_m: 30.0, ..step }], 1.0);
        }
        motion.llr()
    }

    /// Range of a flight outward and back.
    fn turns(second: f64) -> f64 {
        12.0 * (7.0 - (second - 7.0).abs())
    }

    #[test]
    fn equal_turns_elsewhere_are_similar_motion() {
        assert!(motion(|second| 80.0 + turns(second), turns) > 3.0);
    }

    #[test]
    fn straight_flight_during_a_turn_is_another_aircraft() {
        assert!(motion(|second| 80.0 + 12.0 * second, turns) < -6.0);
    }

    #[test]
    fn two_that_hover_are_no_evidence_of_each_other() {
        assert!(motion(|_| 80.0, |_| 0.0) < 1.0);
    }

    #[test]
    fn a_place_that_jumps_costs_nothing_where_that_is_known() {
        let jumps = |known: bool| {
            let mut motion = MotionComparison::default();
            for second in 0..16 {
                let offset_m = if second < 8 { 0.0 } else { 100.0 };
                let flown_m = turns(f64::from(second));
                let step = MotionStep {
                    offset_m,
                    flown_m,
                    plots_m2: 1.0,
                    curve_m2: 1.0,
                    slow_m: 4.0,
                    lasts_s: 20.0,
                };
                match known && second == 8 {
                    true => motion.take_elsewhere([step; 2], 1.0),
                    false => motion.update([step; 2], 1.0),
                };
            }
            motion.llr()
        };
        assert!(jumps(true) > jumps(false) + 3.0, "{} {}", jumps(true), jumps(false));
    }
}
