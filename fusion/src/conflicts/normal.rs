//! Normal errors: probabilities of an interval and of a disc, and upper bounds that cost less.

use std::f64::consts::{FRAC_2_PI, SQRT_2, TAU};

use nalgebra::{Matrix2, Vector2};

/// Standard deviations beyond which a disc's density is not summed: less than one in ten million lies there.
const TAIL: f64 = 5.5;
/// Upper half of the Gauss-Legendre rule with 24 points on -1 to 1: points and weights.
const RULE: [(f64, f64); 12] = [
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

/// Probability that a normally distributed position lies in the disc of this radius around the origin. It is exact
/// across the axis with the smaller variance. Along that axis it is integrated over the angle at which the disc's edge
/// is seen, in which the chord is smooth.
pub(super) fn in_disc(radius: f64, mean: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let eigen = covariance.symmetric_eigen();
    let (narrow, wide) = if eigen.eigenvalues.x <= eigen.eigenvalues.y { (0, 1) } else { (1, 0) };
    let along = |axis: usize| eigen.eigenvectors.column(axis).dot(mean);
    let (x, y) = (along(narrow), along(wide));
    let sigma = eigen.eigenvalues[narrow].max(0.0).sqrt();
    let chord = |half: f64| within(half, y, eigen.eigenvalues[wide]);
    let (from, to) = ((x - TAIL * sigma).max(-radius), (x + TAIL * sigma).min(radius));
    if from > to {
        return 0.0;
    }
    if sigma <= 0.0 {
        return chord((radius * radius - x * x).sqrt());
    }
    let (from, to) = (libm::asin(from / radius), libm::asin(to / radius));
    let (middle, half) = ((from + to) / 2.0, (to - from) / 2.0);
    let slice = |angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        let away = (radius * sin - x) / sigma;
        cos * libm::exp(-away * away / 2.0) * chord(radius * cos)
    };
    let sum: f64 = RULE
        .iter()
        .map(|&(at, weight)| weight * (slice(middle - half * at) + slice(middle + half * at)))
        .sum();
    half * radius * sum / (sigma * TAU.sqrt())
}

/// Upper bound of [`in_disc`]: the highest density in the disc times its area.
pub(super) fn at_most_in_disc(radius: f64, mean: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let determinant = covariance.determinant();
    if determinant <= 0.0 {
        return 1.0;
    }
    let beyond = (mean.norm() - radius).max(0.0);
    // The variance along any axis is at most the trace.
    let least = at_most_exp(beyond * beyond / (2.0 * covariance.trace()));
    (radius * radius / (2.0 * determinant.sqrt()) * least).min(1.0)
}

/// Upper bound of exp(-x) for x of 0 or more: the reciprocal of the first terms of the series of exp(x).
fn at_most_exp(x: f64) -> f64 {
    (1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0)))).recip()
}
