//! Means of 1, 2, 4, … successive plots, and how they change from one to the next.
//!
//! Changes of means over successive spans are the Haar wavelet's coefficients; their mean squares are twice the Allan variance, by
//! which the noise of clocks and gyroscopes is taken apart (D. W. Allan, *Statistics of atomic frequency standards*, Proc. IEEE
//! 54 (1966); IEEE Std 952). Of white noise and a Gauss–Markov process they are nearly independent of one another, so each counts as
//! one sample.

use serde::{Deserialize, Serialize};

use crate::time::Time;

/// Changes between single plots up to those between means of 256.
pub(super) const LEVELS: usize = 9;

/// The offset of one plot along one axis, and the variances of what the transponder adds to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) time: Time,
    pub(super) offset: f64,
    /// Of the transponder's bias.
    pub(super) slow: f64,
    /// Of the curve through its reports.
    pub(super) curve: f64,
}

/// The mean of successive plots.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Block {
    first: Time,
    last: Time,
    mean: f64,
    slow: f64,
    curve: f64,
}

/// A change from one mean to the next.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Change {
    pub(super) level: usize,
    pub(super) size: f64,
    /// Time between two plots, seconds.
    pub(super) spacing_s: f64,
    pub(super) slow: f64,
    pub(super) curve: f64,
}

/// One stretch of a radar track.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Pyramid {
    /// By level: the first of two.
    waiting: [Option<Block>; LEVELS],
}

impl Pyramid {
    /// One plot more, and the changes that it completes.
    pub(super) fn add(&mut self, sample: &Sample, mut found: impl FnMut(Change)) {
        let Sample { time, offset, slow, curve } = *sample;
        let mut block = Block { first: time, last: time, mean: offset, slow, curve };
        for (level, waiting) in self.waiting.iter_mut().enumerate() {
            let Some(before) = waiting.take() else {
                *waiting = Some(block);
                return;
            };
            let plots = (2_u32 << level) as f64;
            let both = Block {
                first: before.first,
                last: block.last,
                mean: (before.mean + block.mean) / 2.0,
                slow: (before.slow + block.slow) / 2.0,
                curve: (before.curve + block.curve) / 2.0,
            };
            found(Change {
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
