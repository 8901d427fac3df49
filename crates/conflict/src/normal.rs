//! Normal errors: probabilities of an interval and of two variables, and an upper bound that costs less.

use std::f64::consts::{FRAC_2_PI, SQRT_2, TAU};

/// Correlation from which on two variables count as one.
const ONE: f64 = 0.999_99;

/// Standard deviations beyond which a density is not summed: less than one in ten million lies there.
pub(super) const TAIL: f64 = 5.5;
/// Upper half of the Gauss-Legendre rule with 24 points on -1 to 1: points and weights.
pub(super) const HALF_RULE: [(f64, f64); 12] = [
    (0.064_056_892_862_605_63, 0.127_938_195_346_752_16),
    (0.191_118_867_473_616_3, 0.125_837_456_346_828_3),
    (0.315_042_679_696_163_4, 0.121_670_472_927_803_39),
    (0.433_793_507_626_045_1, 0.115_505_668_053_725_6),
    (0.545_421_471_388_839_6, 0.107_444_270_115_965_63),
    (0.648_093_651_936_975_5, 0.097_618_652_104_113_88),
    (0.740_124_191_578_554_4, 0.086_190_161_531_953_27),
    (0.820_001_985_973_903, 0.073_346_481_411_080_3),
    (0.886_415_527_004_401_1, 0.059_298_584_915_436_78),
    (0.938_274_552_002_732_8, 0.044_277_438_817_419_81),
    (0.974_728_555_971_309_5, 0.028_531_388_628_933_66),
    (0.995_187_219_997_021_3, 0.012_341_229_799_987_2),
];

/// Probability that a normal variable lies within ± `half`.
pub(super) fn within(half: f64, mean: f64, variance: f64) -> f64 {
    let sigma = variance.max(0.0).sqrt();
    if sigma <= 0.0 {
        return f64::from(mean.abs() <= half);
    }
    // The tails of erfc keep their digits where those of erf cancel.
    let beyond = |x: f64| 0.5 * libm::erfc((x - mean) / (sigma * SQRT_2));
    (beyond(-half) - beyond(half)).max(0.0)
}

/// Upper bound of [`within`]: the tail beyond the nearer edge, or the highest density between the edges times the
/// width.
pub(super) fn at_most_within(half: f64, mean: f64, variance: f64) -> f64 {
    let beyond = mean.abs() - half;
    if variance <= 0.0 {
        return f64::from(beyond <= 0.0);
    }
    let dense = half * (FRAC_2_PI / variance).sqrt();
    if beyond <= 0.0 {
        dense.min(1.0)
    } else {
        dense.min(0.5) * at_most_exp(beyond * beyond / (2.0 * variance))
    }
}

/// Probability that a normal variable is at most `limit`.
pub(super) fn below(limit: f64, mean: f64, sigma: f64) -> f64 {
    if sigma <= 0.0 {
        return f64::from(mean <= limit);
    }
    0.5 * libm::erfc((mean - limit) / (sigma * SQRT_2))
}

/// Probability that two standard normal variables exceed `h` and `k`.
///
/// Z. Drezner and G. O. Wesolowsky, *On the computation of the bivariate normal integral*, 1990, equation 2, integrated over
/// the arc sine of the correlation (A. Genz, 2004).
pub(super) fn above_both(h: f64, k: f64, correlation: f64) -> f64 {
    let upper = |x: f64| 0.5 * libm::erfc(x / SQRT_2);
    if correlation >= ONE {
        return upper(h.max(k));
    }
    let half = libm::asin(correlation.max(-1.0)) / 2.0;
    let density = |angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        libm::exp((h * k * sin - (h * h + k * k) / 2.0) / (cos * cos).max(f64::MIN_POSITIVE))
    };
    let sum: f64 = HALF_RULE
        .iter()
        .map(|&(at, weight)| weight * (density(half * (1.0 - at)) + density(half * (1.0 + at))))
        .sum();
    (upper(h) * upper(k) + half * sum / TAU).clamp(0.0, 1.0)
}

/// Upper bound of the probability that a normal variable differs from its mean, on one side, by at least `beyond`, for any
/// variance up to this one.
pub(super) fn at_most_beyond(beyond: f64, variance: f64) -> f64 {
    if beyond <= 0.0 { 1.0 } else { 0.5 * at_most_exp(beyond * beyond / (2.0 * variance)) }
}

/// Upper bound of exp(-x) for x of 0 or more: the reciprocal of the first terms of the series of exp(x).
fn at_most_exp(x: f64) -> f64 {
    (1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0)))).recip()
}
