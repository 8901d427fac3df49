//! Whether a radar track and a transponder are one aircraft: the likelihood of what lies between them, over time.
//!
//! If they are, the offset from the transponder's curve to the radar's plots is the radar's slow error, a first-order
//! Gauss–Markov process, and the noise of plots. If they are not, it is the distance of two aircraft that move on by
//! themselves. Each plot tells how likely either is; the logarithm of the ratio is summed up.

use super::settings::{Radar, Settings};
use super::target::Target;
use crate::estimation::{RadarErrors, Seen, SlowError};
use crate::normalise::Plot;
use crate::time::Time;

/// Range, azimuth (as metres across), height.
const AXES: usize = 3;
/// The sum is held within this, so that what was long ago does not outweigh what is now.
pub(super) const MOST: f64 = 12.0;
/// One axis of one plot says no more than this: a radar's slow error is not always slow.
const CLIP: f64 = 2.0;
/// The slow error that would explain an offset is easily believed up to this squared multiple of its deviation; what is
/// beyond counts against the pair however long it lasts,
const EASY: f64 = 9.0;
/// up to this.
const STRAIN_MOST: f64 = 20.0;
/// From this score on two are likely to be one.
const LIKELY: f64 = 1.0;
/// Two aircraft that are not one are so far apart, one standard deviation, metres: over ground and in height.
const APART_M: [f64; AXES] = [300.0, 300.0, 40.0];
/// And pass each other at so much, metres a second.
const PASSING: [f64; AXES] = [14.0, 14.0, 2.0];
/// Power spectral density of their acceleration, m²/s³.
const ACCELERATION: [f64; AXES] = [4.0, 4.0, 0.5];

/// The offset of a plot from the curve, and how well either is known.
#[derive(Clone, Copy, Debug)]
struct Offset {
    /// Outward, clockwise, up, metres; the last `None` where no height was measured.
    metres: [Option<f64>; AXES],
    /// Slow errors, metres.
    slow_m: [f64; AXES],
    /// Errors that are new with each plot, metres.
    fast_m: [f64; AXES],
    /// The slow errors last so long, seconds.
    correlation_s: f64,
}

impl Offset {
    /// Of a plot at this distance over ground; `curve_m`: deviation of the curve.
    fn new(metres: [Option<f64>; AXES], range_m: f64, errors: &RadarErrors, curve_m: f64) -> Self {
        let fast = |metres: f64| metres.hypot(curve_m);
        Self {
            metres,
            slow_m: [errors.slow_range_m, range_m * errors.slow_azimuth, errors.slow_height_m],
            fast_m: [
                fast(errors.fast_range_m),
                fast(range_m * errors.fast_azimuth),
                fast(errors.fast_height_m),
            ],
            correlation_s: errors.correlation_s,
        }
    }
}

/// The sum, and what is expected of the next plot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Evidence {
    /// Logarithm of the likelihood ratio, natural.
    pub(super) score: f64,
    /// The last plot after which they were likely to be one.
    pub(super) likely: Option<Time>,
    /// What the size of the slow error that would explain the offset says against the pair, which the score, made of
    /// changes from plot to plot, does not.
    pub(super) strain: f64,
    expected: Option<[Axis; AXES]>,
}

#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Mean and variance of the slow error.
    same: (f64, f64),
    /// Offset and its rate, and their covariance.
    other: ([f64; 2], [f64; 3]),
}

impl Evidence {
    /// How much better it explains the plots so far that they are one than that they are not: logarithm, natural, with what
    /// the size of the offset says against it; `None` where nothing was compared.
    pub(super) fn weight(&self) -> Option<f64> {
        self.expected.map(|_| self.score - self.strain)
    }

    /// The same where it is worth a word: not where the plots have said against it all that they can say.
    pub(super) fn doubt(&self) -> Option<f64> {
        self.weight().filter(|&weight| weight > -MOST)
    }

    /// The slow error as known now, for a plot at this distance over ground, `dt` seconds later; `None`: nothing is known.
    pub(super) fn slow_error(&self, range_m: f64, dt: f64, errors: &RadarErrors) -> Option<SlowError> {
        let axes = self.expected?;
        let kept = (-dt / errors.correlation_s).exp();
        let later = |axis: usize, slow: f64, scale: f64| {
            let (mean, variance) = axes[axis].same;
            let slow = slow * slow * (1.0 - kept * kept);
            (mean * kept * scale, variance * kept * kept * scale * scale + slow)
        };
        Some(SlowError {
            range_m: later(0, errors.slow_range_m, 1.0),
            azimuth: later(1, errors.slow_azimuth, 1.0 / range_m),
            height_m: later(2, errors.slow_height_m, 1.0),
        })
    }

    /// Takes in plots where the target's transponder tells where it was, in the order in which they are given: forward or
    /// backward in time.
    pub(super) fn add_plots<'a>(
        &mut self,
        plots: impl Iterator<Item = &'a Plot>,
        target: &Target,
        radar: &Radar,
        settings: &Settings,
    ) {
        let mut before: Option<Time> = None;
        for plot in plots {
            let Some(curve) = target.on_curve(plot.time, settings) else { continue };
            let seen = Seen::from(radar.position, plot.position);
            let apart = plot.position.0 - curve.position.0;
            let metres = [
                Some(seen.outward.dot(&apart.xy())),
                Some(seen.clockwise.dot(&apart.xy())),
                plot.height_measured.then_some(apart.z),
            ];
            let offset = Offset::new(metres, seen.range_m, &radar.errors, curve.deviation_m);
            let dt = before.map_or(radar.period_s, |before| plot.time.seconds_since(before).abs());
            before = Some(plot.time);
            self.add(&offset, plot.time, dt);
        }
    }

    /// Takes in a plot, `dt` seconds after the one before.
    fn add(&mut self, offset: &Offset, time: Time, dt: f64) {
        let mut axes = self.expected.unwrap_or_else(|| {
            std::array::from_fn(|axis| Axis {
                same: (0.0, offset.slow_m[axis].powi(2)),
                other: ([0.0; 2], [APART_M[axis].powi(2), 0.0, PASSING[axis].powi(2)]),
            })
        });
        let kept = if self.expected.is_some() { (-dt / offset.correlation_s).exp() } else { 1.0 };
        let dt = if self.expected.is_some() { dt } else { 0.0 };
        for (index, axis) in axes.iter_mut().enumerate() {
            let slow = offset.slow_m[index].powi(2);
            axis.same = (axis.same.0 * kept, axis.same.1 * kept * kept + slow * (1.0 - kept * kept));
            let ([x, v], [p, c, q]) = axis.other;
            let noise = ACCELERATION[index];
            axis.other = (
                [x + v * dt, v],
                [
                    p + 2.0 * dt * c + dt * dt * q + noise * dt.powi(3) / 3.0,
                    c + dt * q + noise * dt * dt / 2.0,
                    q + noise * dt,
                ],
            );
            if let Some(metres) = offset.metres[index] {
                let fast = offset.fast_m[index].powi(2);
                self.score += axis.observe(metres, fast).clamp(-CLIP, CLIP);
            }
        }
        self.score = self.score.clamp(-MOST, MOST);
        let strain = |(axis, slow_m): (&Axis, f64)| 0.5 * ((axis.same.0 / slow_m).powi(2) - EASY).max(0.0);
        self.strain = axes.iter().zip(offset.slow_m).map(strain).sum::<f64>().min(STRAIN_MOST);
        if self.score >= LIKELY {
            self.likely = Some(time);
        }
        self.expected = Some(axes);
    }
}

impl Axis {
    /// Takes an offset in; the logarithm of how much likelier it is if both are one.
    fn observe(&mut self, metres: f64, fast: f64) -> f64 {
        let (mean, variance) = self.same;
        let spread = variance + fast;
        let innovation = metres - mean;
        let same = -0.5 * (innovation * innovation / spread + spread.ln());
        let gain = variance / spread;
        self.same = (mean + gain * innovation, variance * (1.0 - gain));

        let ([x, v], [p, c, q]) = self.other;
        let spread = p + fast;
        let innovation = metres - x;
        let other = -0.5 * (innovation * innovation / spread + spread.ln());
        let (g, h) = (p / spread, c / spread);
        self.other = ([x + g * innovation, v + h * innovation], [p * (1.0 - g), c * (1.0 - g), q - h * c]);
        same - other
    }
}
