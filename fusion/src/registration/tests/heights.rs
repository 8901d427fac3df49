//! Which heights are wrong by a constant, by the tracks of one radar.

use super::super::heights::{HeightOffset, HeightSums, HeightVerdict, height_verdict};
use super::super::parameters::{HEIGHT, TILT_EAST, TILT_NORTH};
use super::{REFERENCE_M, World, sample_of};

const SEEDS: u64 = 20;

/// The verdict on a levelled radar with a height bias of `height_m`, by six tracks of a minute of each transponder, whose
/// heights have these offsets, metres.
fn verdict(seed: u64, height_m: f64, offsets_m: &[f64]) -> HeightVerdict {
    let mut world = World::wrong(7000 + seed);
    (world.bias[TILT_EAST], world.bias[TILT_NORTH], world.bias[HEIGHT]) = (0.0, 0.0, height_m);
    let mut told = |offset_m: f64| {
        let mut sums = HeightSums::NONE;
        for _ in 0..6 {
            let mut plots = world.plots(60.0, 2.0);
            plots.iter_mut().for_each(|plot| plot.target.0.z += offset_m);
            sums.add(&sample_of(&plots));
        }
        (sums, REFERENCE_M)
    };
    let told: Vec<(HeightSums, f64)> = offsets_m.iter().map(|&offset_m| told(offset_m)).collect();
    height_verdict(&told).unwrap()
}

fn assert_found(offset: &HeightOffset, true_m: f64, seed: u64) {
    assert!(offset.probability > 0.7, "{seed}: {offset:?}");
    assert!((offset.mean_m - true_m).powi(2) < 16.0 * offset.variance_m2, "{seed}: {offset:?}");
    assert!((offset.mean_m - true_m).abs() < 0.5 * true_m.abs(), "{seed}: {offset:?}");
}

fn height_m(verdict: &HeightVerdict) -> f64 {
    verdict.alignment.mean[2]
}

#[test]
fn offset_of_one_in_three_leaves_the_radar_alone() {
    for seed in 0..SEEDS {
        let verdict = verdict(seed, 3.0, &[30.0, 0.0, 0.0]);
        let [first, others @ ..] = &verdict.offsets[..] else { panic!("none") };
        assert_found(first, 30.0, seed);
        assert!(others.iter().all(|other| other.probability < 0.5), "{seed}: {others:?}");
        assert!((height_m(&verdict) - 3.0).abs() < 10.0, "{seed}: {verdict:?}");
    }
}

#[test]
fn different_offsets_of_all_are_found() {
    for seed in 0..SEEDS {
        let offsets_m = [40.0, -35.0, 50.0];
        let verdict = verdict(seed, 2.0, &offsets_m);
        for (offset, true_m) in verdict.offsets.iter().zip(offsets_m) {
            assert_found(offset, true_m, seed);
        }
    }
}

#[test]
fn offset_that_all_share_is_not_the_radars() {
    for seed in 0..SEEDS {
        let verdict = verdict(seed, 0.0, &[35.0; 4]);
        verdict.offsets.iter().for_each(|offset| assert_found(offset, 35.0, seed));
        assert!(height_m(&verdict).abs() < 15.0, "{seed}: {verdict:?}");
    }
}

#[test]
fn bias_of_the_radar_is_no_offset() {
    for seed in 0..SEEDS {
        let verdict = verdict(seed, 6.0, &[0.0; 4]);
        assert!(verdict.offsets.iter().all(|offset| offset.probability < 0.5), "{seed}: {verdict:?}");
    }
}

#[test]
fn no_tracks_give_no_verdict() {
    assert!(height_verdict(&[]).is_none());
}
