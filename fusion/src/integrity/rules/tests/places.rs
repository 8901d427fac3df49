//! The index against a list that is searched.

use super::super::places::{Places, Seen};
use super::*;

#[test]
fn it_finds_what_a_list_finds() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut places = Places::default();
    let mut list: Vec<([u64; 3], Seen)> = Vec::new();
    for step in 0..30_000_u32 {
        let place = [random.random_range(0..4000), 7, random.random_range(0..2)];
        let found: Vec<Seen> = places.seen(place).collect();
        let listed: Vec<Seen> =
            list.iter().rev().filter(|(known, _)| *known == place).map(|(_, seen)| *seen).collect();
        assert_eq!(found, listed);
        let seen = Seen { stream: step, time: at(f64::from(step)) };
        places.insert(place, seen.stream, seen.time);
        list.push((place, seen));
        if step == 20_000 {
            // Whole blocks go: those of which the last report is too old.
            places.forget_before(at(9_000.0));
            list.drain(..8192);
        }
    }
}

#[test]
fn it_stays_bounded_and_forgets_the_oldest() {
    let mut places = Places::default();
    let total = 4_000_000_u32;
    for step in 0..total {
        places.insert([u64::from(step), 0, 0], step, at(f64::from(step)));
    }
    assert_eq!(places.seen([0, 0, 0]).next(), None);
    for step in [total - 3_600_000, total - 1] {
        assert_eq!(places.seen([u64::from(step), 0, 0]).next().map(|seen| seen.stream), Some(step));
    }
}
