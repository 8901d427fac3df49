//! Means of 1, 2, 4, … successive plots, and their changes from one to the next.
//!
//! Changes of means over successive spans are Haar wavelet coefficients; their mean squares are twice the Allan
//! variance, which is used to analyse the noise of clocks and gyroscopes (D. W. Allan, *Statistics of atomic frequency
//! standards*, Proc. IEEE 54 (1966); IEEE Std 952). For white noise and a Gauss–Markov process they are nearly
//! independent, so each counts as one sample.

use serde::{Deserialize, Serialize};

use crate::time::Time;

/// Number of levels: changes between single plots up to those between means of 256.
pub(super) const LEVELS: usize = 9;

/// Offset of one plot along one axis, and the variances of the transponder's contributions.
#[derive(Clone, Copy, Debug)]
pub(super) struct OffsetSample {
    pub(super) time: Time,
    pub(super) offset: f64,
    /// Variance of the transponder's bias.
    pub(super) slow: f64,
    /// Variance of the curve through its reports.
    pub(super) curve: f64,
}

/// Mean of successive plots.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct PlotBlock {
    first: Time,
    last: Time,
    mean: f64,
    slow: f64,
    curve: f64,
}

/// Change from one mean to the next.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct MeanChange {
    pub(super) level: usize,
    pub(super) size: f64,
    /// Time between two plots, seconds.
    pub(super) spacing_s: f64,
    pub(super) slow: f64,
    pub(super) curve: f64,
}

/// Means of one track segment.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Pyramid {
    /// First mean of each pair, by level.
    waiting: [Option<PlotBlock>; LEVELS],
}

impl Pyramid {
    /// Adds a plot; reports the changes that it completes.
    pub(super) fn add(&mut self, sample: &OffsetSample, mut found: impl FnMut(MeanChange)) {
        let OffsetSample { time, offset, slow, curve } = *sample;
        let mut block = PlotBlock { first: time, last: time, mean: offset, slow, curve };
        for (level, waiting) in self.waiting.iter_mut().enumerate() {
            let Some(before) = waiting.take() else {
                *waiting = Some(block);
                return;
            };
            let plots = (2_u32 << level) as f64;
            let both = PlotBlock {
                first: before.first,
                last: block.last,
                mean: (before.mean + block.mean) / 2.0,
                slow: (before.slow + block.slow) / 2.0,
                curve: (before.curve + block.curve) / 2.0,
            };
            found(MeanChange {
                level,
                size: block.mean - before.mean,
                spacing_s: both.last.seconds_since(both.first) / (plots - 1.0),
                slow: both.slow,
                curve: both.curve,
            });
            block = both;
        }
    }
}
