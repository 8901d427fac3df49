//! Integrals over a disc and their bounds, compared with fine slices and exact chords.

use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;

use crate::conflicts::normal::{at_most_in_disc, at_most_within, in_disc, within};

/// Covariance of two standard deviations, rotated.
fn covariance(sigmas: [f64; 2], turned: f64) -> Matrix2<f64> {
    let (sin, cos) = turned.sin_cos();
    let rotation = Matrix2::new(cos, -sin, sin, cos);
    rotation
        * Matrix2::from_diagonal(&Vector2::from(sigmas.map(|sigma| sigma * sigma)))
        * rotation.transpose()
}

/// Probability of the disc with the axes in the other order, by the midpoint rule with 40,000 slices.
fn sliced(radius: f64, mean: [f64; 2], sigmas: [f64; 2]) -> f64 {
    let slices = 40_000;
    let step = 2.0 * radius / f64::from(slices);
    let slice = |index: i32| {
        let at = -radius + (f64::from(index) + 0.5) * step;
        let away = (at - mean[0]) / sigmas[0];
        let density = (-away * away / 2.0).exp() / (sigmas[0] * std::f64::consts::TAU.sqrt());
        density * step * within((radius * radius - at * at).sqrt(), mean[1], sigmas[1] * sigmas[1])
    };
    (0..slices).map(slice).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_rule_for_a_disc_is_that_of_fine_slices(
        radius in 10.0..200.0_f64, away in 0.0..2.0_f64, bearing in 0.0..6.3_f64, turned in 0.0..6.3_f64,
        wide in 0.05..20.0_f64, narrow in 0.1..1.0_f64,
    ) {
        let sigmas = [radius * wide, radius * wide * narrow];
        let mean = [radius * away * bearing.cos(), radius * away * bearing.sin()];
        let expected = sliced(radius, mean, sigmas);
        let (sin, cos) = turned.sin_cos();
        let place = Vector2::new(cos * mean[0] - sin * mean[1], sin * mean[0] + cos * mean[1]);
        let covariance = covariance(sigmas, turned);
        let found = in_disc(radius, &place, &covariance);
        prop_assert!((found - expected).abs() < 3e-4, "{found} instead of {expected}");
        let most = at_most_in_disc(radius, &place, &covariance);
        prop_assert!(most >= expected - 1e-9, "{expected} above its bound {most}");
        // The disc lies between two parallel lines across the direction to the position.
        let across = place.normalize();
        let between = at_most_within(radius, place.norm(), across.dot(&(covariance * across)));
        prop_assert!(between >= expected - 1e-9, "{expected} above its bound {between}");
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
