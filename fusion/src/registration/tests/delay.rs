//! Delays of two types of transponders, from the tracks of one misaligned radar.

use super::super::delay::DelaySums;
use super::super::parameters::{PARAMETERS, TIME};
use super::{Registration, World};

const RUNS: u64 = 200;
const DELAYS_S: [f64; 2] = [0.0, 0.2];
/// Number of tracks, a minute each.
const TRACKS: usize = 40;

/// Mean normalised squared error of the delay of each type, and mean of its standard deviation; `dt`: time between plots,
/// seconds.
fn errors(jitter_s: f64, dt: f64) -> [(f64, f64); 2] {
    let mut found = [(0.0, 0.0); 2];
    for seed in 0..RUNS {
        let mut world = World { jitter_s, ..World::wrong(5000 + seed) };
        let mut registration = Registration::default();
        let mut sums = [DelaySums::NONE; 2];
        for track in 0..TRACKS {
            let which = track % 2;
            world.bias[TIME] = DELAYS_S[which];
            let sample = world.sample(60.0, dt);
            registration.add(&sample);
            sums[which].add(&sample);
        }
        for ((found, sums), delay_s) in found.iter_mut().zip(&sums).zip(DELAYS_S) {
            let known = sums.given(&registration.estimate());
            let error = known.weighted_mean / known.inverse_variance - delay_s;
            found.0 += error * error * known.inverse_variance / RUNS as f64;
            found.1 += known.inverse_variance.powf(-0.5) / RUNS as f64;
        }
    }
    found
}

#[test]
fn each_type_has_its_own_delay_with_an_honest_deviation() {
    for (nees, sigma_s) in errors(0.0, 2.0) {
        assert!((0.7..1.4).contains(&nees), "{nees}");
        // Twenty minutes of tracks.
        assert!((0.01..0.08).contains(&sigma_s), "{sigma_s}");
    }
}

/// Plots between the same two reports share the error of their time stamps.
#[test]
fn delay_of_random_time_stamps_has_an_honest_deviation() {
    for (nees, sigma_s) in errors(1.0, 0.25) {
        assert!((0.5..1.5).contains(&nees), "{nees}");
        assert!((0.01..0.1).contains(&sigma_s), "{sigma_s}");
    }
}

#[test]
fn nothing_follows_from_nothing_and_from_numbers_that_are_none() {
    let estimate = World::wrong(1).estimate(10);
    let none = DelaySums::NONE.given(&estimate);
    assert_eq!((none.inverse_variance, none.weighted_mean), (0.0, 0.0));
    for own in [1e-300, -1.0, 1e12] {
        let mut numbers = [1e12; PARAMETERS + 1];
        numbers[TIME] = own;
        let known = DelaySums::from_numbers(&numbers).given(&estimate);
        assert!(known.inverse_variance.is_finite() && known.weighted_mean.is_finite(), "{own}: {known:?}");
    }
}
