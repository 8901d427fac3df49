//! Integrals and their bounds, compared with fine slices.

use proptest::prelude::*;

use crate::normal::{above_both, at_most_within, within};

/// Probability that both exceed their limits, by the midpoint rule over the first with 40,000 slices.
fn sliced(h: f64, k: f64, correlation: f64) -> f64 {
    let slices = 40_000;
    let step = (9.0 - h) / f64::from(slices);
    let rest = (1.0 - correlation * correlation).sqrt();
    let slice = |index: i32| {
        let x = h + (f64::from(index) + 0.5) * step;
        let above = 0.5 * libm::erfc((k - correlation * x) / (rest * std::f64::consts::SQRT_2));
        (-x * x / 2.0).exp() / std::f64::consts::TAU.sqrt() * step * above
    };
    (0..slices).map(slice).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn both_above_is_the_sum_of_fine_slices(
        h in -4.0..4.0_f64, k in -4.0..4.0_f64, correlation in -0.99..0.999_f64,
    ) {
        let (found, expected) = (above_both(h, k, correlation), sliced(h, k, correlation));
        prop_assert!((found - expected).abs() < 2e-3, "{found} instead of {expected}");
        prop_assert!((found - above_both(k, h, correlation)).abs() < 1e-12);
    }

    #[test]
    fn no_interval_has_more_than_its_bound(
        half in 1.0..100.0_f64, mean in -500.0..500.0_f64, sigma in 0.1..500.0_f64,
    ) {
        let (exact, most) = (within(half, mean, sigma * sigma), at_most_within(half, mean, sigma * sigma));
        prop_assert!((exact..=1.0).contains(&most), "{exact} above {most}");
        // The bound is useful: beyond the edge it is at most several times the exact value.
        let beyond = (mean.abs() - half) / sigma;
        prop_assert!(!(0.5..2.5).contains(&beyond) || most < 6.0 * exact, "{most} for {exact}");
    }
}
