//! The index compared with a linear search.

use super::super::places::{EarlierReport, ReportPlaces};
use super::*;

#[test]
fn position_index_matches_a_list() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut places = ReportPlaces::default();
    let mut list: Vec<([u64; 3], EarlierReport)> = Vec::new();
    for step in 0..30_000_u32 {
        let place = [random.random_range(0..4000), 7, random.random_range(0..2)];
        let found: Vec<EarlierReport> = places.reports_at(place).collect();
        let listed: Vec<EarlierReport> =
            list.iter().rev().filter(|(known, _)| *known == place).map(|(_, seen)| *seen).collect();
        assert_eq!(found, listed);
        let seen = EarlierReport { stream: step, time: at(f64::from(step)) };
        places.insert(place, seen.stream, seen.time);
        list.push((place, seen));
        if step == 20_000 {
            // Whole blocks are removed, if their last report is too old.
            places.forget_before(at(9_000.0));
            list.drain(..8192);
        }
    }
}

#[test]
fn position_index_is_bounded_and_evicts_the_oldest() {
    let mut places = ReportPlaces::default();
    let total = 4_000_000_u32;
    for step in 0..total {
        places.insert([u64::from(step), 0, 0], step, at(f64::from(step)));
    }
    assert_eq!(places.reports_at([0, 0, 0]).next(), None);
    for step in [total - 3_600_000, total - 1] {
        assert_eq!(places.reports_at([u64::from(step), 0, 0]).next().map(|seen| seen.stream), Some(step));
    }
}
