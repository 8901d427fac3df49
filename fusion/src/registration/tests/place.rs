//! The check of a radar's position, with simulated tracks.

use std::ops::Range;

use nalgebra::{Vector2, Vector3};

use super::World;
use crate::registration::PlaceCheck;
use crate::report::Identity;

/// Adds these tracks of a minute, in six segments each, of four drones in turn.
fn fly(world: &mut World, check: &mut PlaceCheck, tracks: Range<u32>) {
    for track in tracks {
        for sample in world.segments(60.0, 10.0) {
            check.add(Identity::of_address(track % 4), &sample);
        }
    }
}

/// Direction by number.
fn towards(number: u64, distance_m: f64) -> Vector3<f64> {
    let (sin, cos) = (number as f64 * 2.4).sin_cos();
    Vector3::new(distance_m * sin, distance_m * cos, 0.0)
}

#[test]
fn position_error_agrees_with_its_covariance() {
    let mut nees = 0.0;
    const RADARS: u64 = 200;
    for seed in 1..=RADARS {
        let mut world = World::wrong(seed);
        world.displaced = towards(seed, 60.0);
        let mut check = PlaceCheck::default();
        fly(&mut world, &mut check, 0..12);
        let found = check.found().unwrap();
        let off = Vector2::new(found.east_m - world.displaced.x, found.north_m - world.displaced.y);
        nees += off.dot(&found.covariance_m2.cholesky().unwrap().solve(&off)) / 2.0 / RADARS as f64;
    }
    println!("normalised squared error {nees:.2}");
    assert!((0.6..1.3).contains(&nees), "{nees}");
}

#[test]
fn displaced_radar_is_found_and_a_correct_one_is_not() {
    let mut found_after = Vec::new();
    for seed in 301..=340 {
        let mut world = World::wrong(seed);
        let mut check = PlaceCheck::default();
        for track in 0..60 {
            fly(&mut world, &mut check, track..track + 1);
            assert!(!check.found().unwrap().contradicts, "{seed}: {:?}", check.found());
        }
        world.displaced = towards(seed, 30.0);
        let contradicted = (1..=40).find(|&track| {
            fly(&mut world, &mut check, track..track + 1);
            check.found().unwrap().contradicts
        });
        found_after.push(contradicted);
    }
    found_after.sort_unstable();
    println!("drone-minutes until a radar moved by 30 m is found: {found_after:?}");
    assert!(found_after[0].is_some() && found_after[20] <= Some(12), "{found_after:?}");
}
