//! Whether a radar track and a transponder are one aircraft: the likelihood of what lies between them, over time.
//!
//! If they are, the offset from the transponder's curve to the radar's plots is the radar's slow error, a first-order
//! Gauss–Markov process of a size that the plots tell, and the noise of plots. If they are not, it is the distance of two
//! aircraft that move on by themselves ([`axis`]). Each plot tells how likely either is; the logarithm of the ratio is
//! summed up.

mod axis;

use axis::{Apart, Axis, Errors};

use super::settings::{Radar, Settings};
use super::target::{Lasting, Target};
use crate::filter::{Bias, LineOfSight, RadarErrors};
use crate::report::Plot;
use crate::time::Time;

/// Range, azimuth (as metres across), height.
const AXES: usize = 3;
/// The sum is held within this, so that what was long ago does not outweigh what is now.
pub(super) const MOST: f64 = 12.0;
/// One axis of one plot says no more than this: a radar's slow error is not always slow.
const CLIP: f64 = 2.0;
/// What the size of an offset says against a pair counts up to this.
const STRAIN_MOST: f64 = 20.0;
/// From this score on two are likely to be one.
const LIKELY: f64 = 1.0;
/// Two aircraft that are not one: over ground, over ground, in height.
const APART: [Apart; AXES] = [OVER_GROUND, OVER_GROUND, IN_HEIGHT];
const OVER_GROUND: Apart = Apart { distance_m: 300.0, speed_m_s: 14.0, acceleration: 4.0 };
const IN_HEIGHT: Apart = Apart { distance_m: 40.0, speed_m_s: 2.0, acceleration: 0.5 };

/// The offset of a plot from the curve, and how well either is known.
#[derive(Clone, Copy, Debug)]
struct Offset {
    /// Outward, clockwise, up, metres; the last `None` where no height was measured.
    metres: [Option<f64>; AXES],
    errors: [Errors; AXES],
    /// The slow errors last so long, seconds.
    correlation_s: f64,
}

impl Offset {
    /// Of a plot at this distance over ground; `curve_m`: deviation of the curve; `lasting`: of the transponder.
    fn new(
        metres: [Option<f64>; AXES],
        range_m: f64,
        errors: &RadarErrors,
        curve_m: f64,
        lasting: &Lasting,
    ) -> Self {
        let of = |bias_m, white_m, lasting_m2| Errors { bias_m, white_m, curve_m, lasting_m2 };
        Self {
            metres,
            errors: [
                of(errors.bias_range_m, errors.noise_range_m, lasting.horizontal_m2),
                of(range_m * errors.bias_azimuth, range_m * errors.noise_azimuth, lasting.horizontal_m2),
                of(errors.bias_height_m, errors.noise_height_m, lasting.vertical_m2),
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
    pub(super) fn bias(&self, range_m: f64, dt: f64, errors: &RadarErrors) -> Option<Bias> {
        let axes = self.expected?;
        let kept = (-dt / errors.correlation_s).exp();
        let later = |axis: usize, slow: f64, scale: f64| {
            let (mean, variance) = axes[axis].bias();
            let slow = slow * slow * (1.0 - kept * kept);
            (mean * kept * scale, variance * kept * kept * scale * scale + slow)
        };
        Some(Bias {
            range_m: later(0, errors.bias_range_m, 1.0),
            azimuth: later(1, errors.bias_azimuth, 1.0 / range_m),
            height_m: later(2, errors.bias_height_m, 1.0),
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
        let lasting = target.lasting(settings);
        for plot in plots {
            let Some(curve) = target.on_curve(plot.time, settings) else { continue };
            let seen = LineOfSight::from(radar.position, plot.position);
            let apart = plot.position.0 - curve.position.0;
            let metres = [
                Some(seen.outward.dot(&apart.xy())),
                Some(seen.clockwise.dot(&apart.xy())),
                plot.height_measured.then_some(apart.z),
            ];
            let offset = Offset::new(metres, seen.range_m, &radar.errors, curve.sigma_m, &lasting);
            let dt = before.map_or(radar.period_s, |before| plot.time.seconds_since(before).abs());
            before = Some(plot.time);
            self.add(&offset, plot.time, dt);
        }
    }

    /// Takes in a plot, `dt` seconds after the one before.
    fn add(&mut self, offset: &Offset, time: Time, dt: f64) {
        let errors = &offset.errors;
        let axes = match self.expected {
            Some(mut axes) => {
                let kept = (-dt / offset.correlation_s).exp();
                for (index, axis) in axes.iter_mut().enumerate() {
                    axis.predict(dt, kept, &errors[index], &APART[index]);
                }
                self.expected.insert(axes)
            }
            None => {
                let new = |index: usize| Axis::new(&errors[index], &APART[index]);
                self.expected.insert(std::array::from_fn(new))
            }
        };
        self.strain = 0.0;
        for ((axis, metres), errors) in axes.iter_mut().zip(offset.metres).zip(errors) {
            if let Some(metres) = metres {
                self.score += axis.observe(metres, errors).clamp(-CLIP, CLIP);
            }
            self.strain += axis.strain(errors);
        }
        self.strain = self.strain.min(STRAIN_MOST);
        self.score = self.score.clamp(-MOST, MOST);
        if self.score >= LIKELY {
            self.likely = Some(time);
        }
    }
}

#[cfg(test)]
mod tests;
