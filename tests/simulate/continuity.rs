//! Visibility of targets to a radar: visible periods, detection within them, hover, and the end of a track.

use std::collections::BTreeMap;

use utm_fusion::simulate::{Scenario, Span};

use crate::common::{Flown, between, fly, mean, perfect};

/// For each turn, whether there is a plot of the drone.
fn turns(flown: &Flown) -> Vec<Vec<bool>> {
    let count = (flown.duration_s() * 4.0) as usize;
    let mut seen = vec![vec![false; count]; flown.simulation.flights.len()];
    for plot in flown.plots.iter().filter(|plot| plot.drone.is_some()) {
        let turn = (flown.seconds(plot.time) * 4.0) as usize;
        seen[plot.drone.unwrap()][turn.min(count - 1)] = true;
    }
    seen
}

fn share(turns: &[Vec<bool>]) -> f64 {
    let all: Vec<f64> = turns.iter().flatten().map(|seen| f64::from(u8::from(*seen))).collect();
    mean(&all)
}

/// Lengths of periods of `wanted` in seconds, without those at the ends.
fn stretches(turns: &[Vec<bool>], wanted: bool) -> Vec<f64> {
    let mut lengths = Vec::new();
    for turns in turns {
        let groups: Vec<&[bool]> = turns.chunk_by(|a, b| a == b).collect();
        let inner = groups.get(1..groups.len().saturating_sub(1)).unwrap_or_default();
        lengths
            .extend(inner.iter().filter(|group| group[0] == wanted).map(|group| group.len() as f64 * 0.25));
    }
    lengths
}

fn continuity(seen_s: f64, unseen_s: f64) -> Scenario {
    let mut scenario = perfect(40, 0, 0);
    (scenario.radars[0].seen_s, scenario.radars[0].unseen_s) = (seen_s, unseen_s);
    scenario
}

#[test]
fn segments_take_turns_for_18_and_20_s() {
    let mut scenario = continuity(18.0, 20.0);
    scenario.duration_s = 2000.0;
    let turns = turns(&fly(&scenario, 1));
    between("share seen", 0.454, share(&turns), 0.494);
    between("mean segment, s", 17.0, mean(&stretches(&turns, true)), 19.0);
    between("mean pause, s", 19.0, mean(&stretches(&turns, false)), 21.0);
}

#[test]
fn inside_a_segment_95_percent_are_detected() {
    let mut scenario = perfect(20, 0, 0);
    scenario.radars[0].detection = 0.95;
    between("share detected", 0.947, share(&turns(&fly(&scenario, 1))), 0.953);
}

#[test]
fn in_hover_segments_are_half_as_long() {
    let mut scenario = continuity(18.0, 20.0);
    // All drones hover all the time, except for a first leg.
    scenario.duration_s = 2000.0;
    (scenario.multirotor.hover_share, scenario.multirotor.hover_s) = (1.0, Span::new(4000.0, 4000.0));
    scenario.radars[0].hover_factor = 2.0;
    let turns: Vec<Vec<bool>> =
        turns(&fly(&scenario, 1)).into_iter().map(|turns| turns[1200..].to_vec()).collect();
    between("mean segment, s", 8.4, mean(&stretches(&turns, true)), 9.6);
    between("mean pause, s", 19.0, mean(&stretches(&turns, false)), 21.0);
}

#[test]
fn a_track_ends_after_two_and_a_half_seconds_without_detection() {
    let flown = fly(&continuity(5.0, 3.0), 1);
    let (mut same, mut other) = (0, 0);
    for plots in flown.plots_by_drone().values() {
        for pair in plots.windows(2) {
            let silence_s = pair[1].time.seconds_since(pair[0].time);
            let is_same = pair[0].number == pair[1].number;
            // The exact detection times decide; the time stamps are rounded.
            match silence_s {
                s if s < 2.48 => assert!(is_same, "a new number after {s} s"),
                s if s > 2.77 => assert!(!is_same, "the old number after {s} s"),
                _ => {}
            }
            if silence_s > 0.3 {
                (same, other) = (same + usize::from(is_same), other + usize::from(!is_same));
            }
        }
    }
    println!("after a silence {same} old and {other} new numbers");
    assert!(same > 300 && other > 300);
}

/// A radar that confirms immediately shows the detections that the other one does not report.
#[test]
fn the_first_two_detections_of_a_track_are_not_reported() {
    let all = turns(&fly(&perfect(3, 0, 0), 1));
    assert!(all.iter().flatten().all(|seen| *seen), "a perfect radar sees every drone in every turn");
    let mut scenario = continuity(5.0, 3.0);
    let early = fly(&scenario, 1);
    scenario.radars[0].confirmed_by = 3;
    let late = fly(&scenario, 1);
    let tracks = |flown: &Flown| -> BTreeMap<u16, Vec<i64>> {
        let tracks = flown.plots_by_number();
        tracks.into_iter().map(|(n, plots)| (n, plots.iter().map(|p| p.time.nanos()).collect())).collect()
    };
    let late = tracks(&late);
    for (number, times) in tracks(&early) {
        let reported = late.get(&number).map_or(&[][..], Vec::as_slice);
        assert_eq!(reported, times.get(2..).unwrap_or_default(), "track {number}");
    }
}
