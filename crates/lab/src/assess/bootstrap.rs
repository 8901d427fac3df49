//! Confidence intervals by the block bootstrap: errors of one aircraft are correlated for a minute and more, so whole blocks are
//! drawn, never single reports.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use input::statistics::quantile;

/// Number of bootstrap replicates.
pub const REPLICATES: usize = 2000;
/// Fewest blocks from which an interval is computed.
pub const BLOCKS_MIN: usize = 5;
/// Number of events below which a rate has the interval of a Poisson distribution.
const EVENTS_MIN: f64 = 10.0;
/// Largest deviate: the level beyond it is that of the outermost replicate.
const DEVIATE_MAX: f64 = 6.0;
/// Allowance for rounding in the effective number of blocks.
const ROUNDING: f64 = 1e-6;
/// Probability beyond either end of an interval.
const TAIL: f64 = 0.025;

/// A block: the aircraft (or none), and the piece of its time.
pub(super) type BlockKey = (Option<usize>, i64);

/// Numerator and denominator of a figure, by block.
pub(super) type BlockSums = BTreeMap<BlockKey, [f64; 2]>;

/// How a figure follows from the sums A and B over all blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Estimator {
    /// 100 A / B, of trials that succeed or fail.
    Percent,
    /// A / B.
    Mean,
    /// sqrt(A / B).
    Root,
    /// A / B, where A counts events.
    Rate,
}

/// A value with its interval.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: Option<f64>,
    pub(super) interval: Option<[f64; 2]>,
    /// Number of blocks with a denominator.
    pub(super) blocks: usize,
    /// Effective number of blocks.
    pub(super) effective: usize,
    /// Value in each replicate; empty if the interval has another origin.
    pub(super) replicates: Vec<f64>,
}

/// Adds to the sums of a block.
pub(super) fn add(sums: &mut BlockSums, key: BlockKey, numerator: f64, denominator: f64) {
    let sum = sums.entry(key).or_default();
    sum[0] += numerator;
    sum[1] += denominator;
}

impl Estimator {
    fn of(self, [numerator, denominator]: [f64; 2]) -> Option<f64> {
        let ratio = (denominator > 0.0).then(|| numerator / denominator)?;
        Some(match self {
            Self::Percent => 100.0 * ratio,
            Self::Mean | Self::Rate => ratio,
            Self::Root => ratio.max(0.0).sqrt(),
        })
    }

    /// Value and 95 % interval. `seed` determines the draws.
    pub(super) fn estimate(self, sums: &BlockSums, seed: u64) -> Estimate {
        // Events in a block without exposure, as before the first slot that counts, belong to the total.
        let blocks: Vec<[f64; 2]> = sums.values().copied().collect();
        let total = sum(blocks.iter());
        let count = blocks.iter().filter(|block| block[1] > 0.0).count();
        let Some(value) = self.of(total) else { return Estimate { blocks: count, ..Estimate::default() } };
        let without_replicates = |interval| Estimate { interval, blocks: count, ..value_alone(value) };
        if self == Self::Rate && total[0] < EVENTS_MIN {
            let [low, high] = poisson(total[0]).map(|events| events / total[1]);
            return without_replicates(Some([low, high]));
        }
        if count < BLOCKS_MIN {
            return without_replicates(None);
        }
        if self == Self::Percent && (total[0] <= 0.0 || total[0] >= total[1]) {
            // Blocks that all agree: the share of other blocks is at most that of a Poisson distribution.
            let other = (100.0 * poisson(0.0)[1] / count as f64).min(100.0);
            let interval = if total[0] <= 0.0 { [0.0, other] } else { [100.0 - other, 100.0] };
            return without_replicates(Some(interval));
        }
        let (replicates, effective) = (self.replicates(&blocks, seed), effective(&blocks));
        let interval = percentiles(&replicates, effective);
        Estimate { value: Some(value), interval, blocks: count, effective, replicates }
    }

    /// Values of as many blocks, drawn with replacement. Draws without exposure are left out.
    fn replicates(self, blocks: &[[f64; 2]], seed: u64) -> Vec<f64> {
        let mut random = SplitMix64(seed);
        let mut draw = || {
            let mut total = [0.0; 2];
            for _ in 0..blocks.len() {
                let block = blocks[random.below(blocks.len())];
                total = [total[0] + block[0], total[1] + block[1]];
            }
            self.of(total)
        };
        (0..REPLICATES).filter_map(|_| draw()).collect()
    }
}

fn value_alone(value: f64) -> Estimate {
    Estimate { value: Some(value), ..Estimate::default() }
}

fn sum<'a>(blocks: impl Iterator<Item = &'a [f64; 2]>) -> [f64; 2] {
    blocks.fold([0.0; 2], |total, block| [total[0] + block[0], total[1] + block[1]])
}

/// Effective number of blocks of unequal weights, rounded down: the square of the sum of the weights over the sum of their squares (L.
/// Kish, *Survey Sampling*, 1965).
fn effective(blocks: &[[f64; 2]]) -> usize {
    let weights = || blocks.iter().map(|block| block[1]);
    let squares: f64 = weights().map(|weight| weight * weight).sum();
    (weights().sum::<f64>().powi(2) / squares + ROUNDING) as usize
}

/// 95 % interval from replicates of a figure of effectively `blocks` blocks: the expanded percentile interval of T. Hesterberg, *What Teachers
/// Should Know About the Bootstrap*, The American Statistician 69, 2015. Its levels are those of Student's t, and of the
/// variance with n - 1. `None` for a single block, or if fewer than half of the replicates have a value.
pub(super) fn percentiles(replicates: &[f64], blocks: usize) -> Option<[f64; 2]> {
    if replicates.len() < REPLICATES / 2 || blocks < 2 {
        return None;
    }
    let count = blocks as f64;
    let deviate = student(blocks - 1) * (count / (count - 1.0)).sqrt();
    let level = normal(-deviate.min(DEVIATE_MAX));
    let mut sorted = replicates.to_vec();
    sorted.sort_by(f64::total_cmp);
    Some([quantile(&sorted, level)?, quantile(&sorted, 1.0 - level)?])
}

/// Interval of the mean of a Poisson distribution of which `events` were observed (F. Garwood, Biometrika 28, 1936).
fn poisson(events: f64) -> [f64; 2] {
    let at_most = |count: f64, mean: f64| {
        let (mut term, mut total, mut index) = ((-mean).exp(), 0.0, 0.0);
        while index <= count {
            total += term;
            index += 1.0;
            term *= mean / index;
        }
        total
    };
    let low =
        if events > 0.0 { bisect(0.0, 100.0, |mean| 1.0 - at_most(events - 1.0, mean) < TAIL) } else { 0.0 };
    [low, bisect(0.0, 100.0, |mean| at_most(events, mean) > TAIL)]
}

/// 97.5 % point of Student's t with whole degrees of freedom.
fn student(freedom: usize) -> f64 {
    bisect(0.0, 100.0, |t| student_within(t, freedom) < 1.0 - 2.0 * TAIL)
}

/// Probability that Student's t lies within ± `t` (M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, 26.7.3 and
/// 26.7.4).
fn student_within(t: f64, freedom: usize) -> f64 {
    let angle = (t / (freedom as f64).sqrt()).atan();
    let (sin, cos) = angle.sin_cos();
    let is_odd = freedom % 2 == 1;
    let (mut term, mut total) = if is_odd { (cos, 0.0) } else { (1.0, 0.0) };
    let mut index = if is_odd { 1 } else { 0 };
    while index + 2 <= freedom {
        total += term;
        index += 2;
        term *= cos * cos * (index - 1) as f64 / index as f64;
    }
    if is_odd { 2.0 / PI * (angle + sin * total) } else { sin * total }
}

/// Normal distribution function, for |x| below 6: the series of Abramowitz and Stegun, 26.2.11.
fn normal(x: f64) -> f64 {
    let (mut term, mut total, mut index) = (x, 0.0, 1.0);
    while term.abs() > 1e-18 {
        total += term;
        index += 2.0;
        term *= x * x / index;
    }
    0.5 + total * (-0.5 * x * x).exp() / (2.0 * PI).sqrt()
}

/// The place in a range below which `is_below` holds.
fn bisect(mut low: f64, mut high: f64, is_below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// SplitMix64: G. L. Steele, D. Lea, C. H. Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// A number below `count`.
    fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next()) * count as u128) >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64) {
        assert!((value - expected).abs() < 5e-4 * expected.abs().max(1.0), "{value} instead of {expected}");
    }

    #[test]
    fn distributions_agree_with_tables() {
        for (freedom, expected) in [(1, 12.7062), (2, 4.3027), (4, 2.7764), (9, 2.2622), (30, 2.0423)] {
            near(student(freedom), expected);
        }
        near(normal(-1.959_964), 0.025);
        near(normal(-3.0), 0.001_350);
        for (events, low, high) in [(0.0, 0.0, 3.6889), (1.0, 0.0253, 5.5716), (9.0, 4.1154, 17.0848)] {
            let interval = poisson(events);
            near(interval[0], low);
            near(interval[1], high);
        }
    }

    #[test]
    fn generator_gives_the_published_numbers() {
        let mut random = SplitMix64(1_234_567);
        let expected = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973];
        assert_eq!([random.next(), random.next()], expected);
    }

    #[test]
    fn intervals_need_blocks_and_events_need_none() {
        let sums = |blocks: usize, hit: f64| -> BlockSums {
            (0..blocks).map(|block| ((Some(block), 0), [hit, 10.0])).collect()
        };
        let few = Estimator::Percent.estimate(&sums(4, 5.0), 1);
        assert_eq!((few.value, few.interval, few.blocks), (Some(50.0), None, 4));
        let alike = Estimator::Percent.estimate(&sums(10, 10.0), 1).interval.unwrap();
        near(alike[0], 100.0 - 36.889);
        assert_eq!(alike[1], 100.0);
        let none = Estimator::Rate.estimate(&sums(1, 0.0), 1).interval.unwrap();
        near(none[1], 0.36889);
        assert_eq!(Estimator::Mean.estimate(&BlockSums::new(), 1), Estimate::default());
    }

    #[test]
    fn effective_blocks_are_fewer_if_one_outweighs_the_others() {
        assert_eq!(effective(&[[0.0, 0.1]; 10]), 10);
        assert_eq!(effective(&[[0.0, 1.0], [0.0, 1.0], [0.0, 8.0]]), 1);
    }

    #[test]
    fn interval_of_a_mean_is_that_of_student() {
        // 40 blocks of mean 0 to 39: the deviation is 11.69, the standard error 1.848, t 2.0227.
        let sums: BlockSums = (0..40).map(|block| ((Some(block), 0), [block as f64, 1.0])).collect();
        let estimate = Estimator::Mean.estimate(&sums, 1);
        let [low, high] = estimate.interval.unwrap();
        assert_eq!(estimate.value, Some(19.5));
        assert!((low - (19.5 - 3.74)).abs() < 0.3 && (high - (19.5 + 3.74)).abs() < 0.3, "{low} {high}");
    }
}
