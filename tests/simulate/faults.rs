//! Faults of radars and transponders that are off by default: clocks, ghosts, stamps, heights, second transponders.
//! Also formations.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use fusion::time::Time;
use utm_fusion::evaluate::Labels;
use utm_fusion::simulate::{Pattern, Scenario, Span};

use crate::common::{
    Fix, Flown, Plot, Scratch, between, deviation, files, fly, kept, kept_path, mean, perfect,
};

#[test]
fn radar_clock_shifts_and_drifts_stamps_alone() {
    let mut scenario = perfect(1, 0, 0);
    let right = fly(&scenario, 1);
    scenario.radars[0].clock_s = 0.3;
    scenario.radars[0].clock_drift_ms_s = 1.0;
    let wrong = fly(&scenario, 1);
    assert_eq!(right.plots.len(), wrong.plots.len());
    for (right_plot, wrong_plot) in right.plots.iter().zip(&wrong.plots) {
        assert_eq!((right_plot.received, right_plot.position), (wrong_plot.received, wrong_plot.position));
        let time_s = right.seconds(right_plot.time);
        let off_s = wrong_plot.time.seconds_since(right_plot.time);
        assert!((off_s - 0.3 - 1e-3 * time_s).abs() < 0.0079, "{off_s} at {time_s}");
        assert_eq!(wrong_plot.drone, Some(0), "the label has the stamp of the record");
    }
    assert_eq!(reports(&right), reports(&wrong));
}

/// Times and contents of all reports.
fn reports(flown: &Flown) -> Vec<(Time, Time, String)> {
    let report = |fix: &Fix| (fix.time, fix.received, format!("{:?}", fix.record));
    flown.fixes.iter().map(report).collect()
}

#[test]
fn ghosts_lie_behind_their_drones_and_change_no_other_plot() {
    let mut scenario = perfect(4, 0, 0);
    let without = fly(&scenario, 1);
    assert!(without.plots.iter().all(|plot| plot.drone.is_some()));
    scenario.radars[0].ghost_share = 1.0;
    let with = fly(&scenario, 1);
    let drones = |flown: &Flown| -> BTreeSet<String> {
        let of_drones = flown.plots.iter().filter(|plot| plot.drone.is_some());
        of_drones.map(|plot| format!("{} {:?}", plot.time, plot.position)).collect()
    };
    assert_eq!(drones(&without), drones(&with));
    let ghosts: Vec<&Plot> = with.plots.iter().filter(|plot| plot.drone.is_none()).collect();
    between("plots of ghosts a plot of a drone", 0.3, ghosts.len() as f64 / without.plots.len() as f64, 0.8);
    // Half of the ghosts are in the direction of a drone, behind it by the scenario's distance. The others are
    // mirrored.
    let is_behind = |ghost: &&&Plot| {
        let (x, y) = (ghost.position.x, ghost.position.y);
        (0..4).any(|drone| {
            let truth = with.truth(drone, with.seconds(ghost.time));
            let behind_m = x.hypot(y) - truth.position.x.hypot(truth.position.y);
            let off = (x.atan2(y) - truth.position.x.atan2(truth.position.y)).abs();
            off < 2e-3 && (58.0..202.0).contains(&behind_m)
        })
    };
    let behind = ghosts.iter().filter(is_behind).count();
    between("share of ghosts in the direction of a drone", 0.3, behind as f64 / ghosts.len() as f64, 0.8);
    // A ghost has its own track and moves; near the radar it is two or three times as fast as its drone. Two ghosts in
    // quick succession may share a number.
    let mut by_number: BTreeMap<u16, Vec<&Plot>> = BTreeMap::new();
    ghosts.iter().for_each(|ghost| by_number.entry(ghost.number).or_default().push(ghost));
    for track in by_number.values() {
        for pair in track.windows(2) {
            let past_s = pair[1].time.seconds_since(pair[0].time);
            let moved_m = (pair[1].position - pair[0].position).norm();
            assert!(past_s > 0.3 || moved_m < 60.0 * past_s, "{moved_m} m in {past_s} s");
        }
    }
}

#[test]
fn ghost_share_is_that_of_the_drones() {
    let mut scenario = perfect(1, 0, 0);
    scenario.radars[0].ghost_share = 0.4;
    scenario.duration_s = 60.0;
    scenario.radars[0].ghost_every_s = 5.0;
    let has_ghost =
        |seed| f64::from(u8::from(fly(&scenario, seed).plots.iter().any(|plot| plot.drone.is_none())));
    between("share", 0.27, mean(&(1..=100).map(has_ghost).collect::<Vec<_>>()), 0.53);
}

#[test]
fn stamp_jitter_is_drawn_by_report() {
    let mut scenario = perfect(40, 0, 0);
    scenario.transponder.period_s = Span::new(2.0, 2.0);
    let exact = fly(&scenario, 1);
    scenario.transponder.stamp_jitter_s = Span::new(0.2, 1.0);
    let late = fly(&scenario, 1);
    let mut all = Vec::new();
    for (drone, fixes) in late.fixes_by_drone() {
        let exact = &exact.fixes_by_drone()[&drone];
        assert_eq!(fixes.len(), exact.len());
        let late_s: Vec<f64> =
            fixes.iter().zip(exact).map(|(late, exact)| late.time.seconds_since(exact.time)).collect();
        // Uniform over 0.8 s.
        between("deviation within a drone, s", 0.2, deviation(&late_s), 0.26);
        for (late, exact) in fixes.iter().zip(exact) {
            assert_eq!(late.position, exact.position, "of the time of the measurement");
        }
        all.extend(late_s);
    }
    between("mean, s", 0.59, mean(&all), 0.61);
    assert!(all.iter().all(|s| (0.19..1.01).contains(s)));
}

#[test]
fn positions_are_rounded_to_the_step() {
    let mut scenario = perfect(4, 0, 0);
    scenario.transponder.rounded_deg = 1e-5;
    let flown = fly(&scenario, 1);
    let mut off = Vec::new();
    for fix in &flown.fixes {
        let position = fix.record.position.unwrap();
        for degrees in [position.latitude_deg(), position.longitude_deg()] {
            let steps = degrees / 1e-5;
            // CAT129 itself rounds to 180/2^30 degrees.
            assert!((steps - steps.round()).abs() < 0.02, "{degrees}");
        }
        let truth = flown.truth(fix.drone, flown.seconds(fix.time));
        off.push((fix.position - truth.position).xy().norm());
    }
    between("mean error, m", 0.2, mean(&off), 0.5);
}

#[test]
fn stated_accuracy_is_that_of_the_key() {
    let mut scenario = perfect(200, 0, 0);
    scenario.transponder.accuracy_share = 1.0;
    scenario.transponder.gnss_horizontal_m = 10.0;
    scenario.transponder.stated_m = Span::new(2.0, 4.0);
    let stated: BTreeSet<u32> = (fly(&scenario, 1).fixes.iter())
        .map(|fix| fix.record.gnss_accuracy.unwrap().metres().unwrap() as u32)
        .collect();
    assert_eq!(stated, [2, 3, 4].into());
}

#[test]
fn barometric_heights_are_off_by_a_constant_of_the_drone() {
    let mut scenario = perfect(200, 0, 0);
    scenario.transponder.barometric_share = 0.5;
    scenario.transponder.barometric_m = Span::new(25.0, 35.0);
    let exact = fly(&perfect(200, 0, 0), 1);
    let flown = fly(&scenario, 1);
    let mut barometric = 0;
    for (drone, fixes) in flown.fixes_by_drone() {
        let exact = &exact.fixes_by_drone()[&drone];
        let errors: Vec<f64> =
            fixes.iter().zip(exact).map(|(fix, exact)| fix.position.z - exact.position.z).collect();
        // The resolution of CAT129 is 0.1 m.
        assert!(errors.iter().all(|error| (error - errors[0]).abs() < 0.11), "constant");
        match errors[0] {
            error if error.abs() < 0.11 => {}
            error => {
                assert!((24.8..35.2).contains(&error), "{error}");
                barometric += 1;
            }
        }
        for (fix, exact) in fixes.iter().zip(exact) {
            assert_eq!(fix.record.position, exact.record.position, "over ground nothing changes");
        }
    }
    between("share", 0.4, f64::from(barometric) / 200.0, 0.6);
}

/// Reports by serial number.
fn by_serial(flown: &Flown) -> BTreeMap<String, Vec<&Fix>> {
    let mut all: BTreeMap<String, Vec<&Fix>> = BTreeMap::new();
    for fix in &flown.fixes {
        let serial = fix.record.serial_number.unwrap();
        all.entry(String::from_utf8_lossy(&serial[..]).into_owned()).or_default().push(fix);
    }
    all
}

#[test]
fn second_transponder_has_its_own_identity_phase_and_errors() {
    let mut scenario = perfect(200, 0, 0);
    scenario.transponder.gnss_white_m = 1.0;
    let first_only = fly(&scenario, 1);
    scenario.transponder.second_share = 0.5;
    scenario.transponder.second_errors = 3.0;
    let flown = fly(&scenario, 1);
    let (seconds, firsts): (Vec<_>, Vec<_>) =
        by_serial(&flown).into_iter().partition(|(serial, _)| serial.as_str() > "000000100000");
    assert_eq!(firsts.len(), 200);
    between("share with a second one", 0.4, seconds.len() as f64 / 200.0, 0.6);
    let before = by_serial(&first_only);
    let records = |fixes: &[&Fix]| -> Vec<String> {
        fixes.iter().map(|fix| format!("{} {:?}", fix.received, fix.record)).collect()
    };
    for (serial, fixes) in &firsts {
        assert_eq!(records(fixes), records(&before[serial]), "a second one changes nothing of the first");
    }
    let east_m = |fixes: &[&Fix]| -> Vec<f64> {
        let error = |fix: &&Fix| fix.position.x - flown.truth(fix.drone, flown.seconds(fix.time)).position.x;
        fixes.iter().map(error).collect()
    };
    let mut errors = Vec::new();
    for (serial, fixes) in &seconds {
        let number: usize = serial.parse().unwrap();
        assert!(fixes.iter().all(|fix| fix.drone == number - 100_001), "the label says whose it is");
        let period_s = flown.duration_s() / fixes.len() as f64;
        assert!((0.99..2.02).contains(&period_s), "{period_s}");
        errors.extend(east_m(fixes));
    }
    between("errors, m", 2.9, deviation(&errors), 3.1);
}

#[test]
fn labels_distinguish_two_transponders_from_a_radar() {
    let scratch = Scratch::new();
    let directory = scratch.path("two");
    files(&kept_path("two-transponders"), 1, &directory);
    let text = fs::read_to_string(directory.join("labels.csv")).unwrap();
    assert!(text.starts_with("time,sensor,number,id,seduced,identity\n"));
    let labels = Labels::new(utm_fusion::evaluate::read::labels("labels.csv", text.as_bytes()).unwrap());
    for (identity, number) in [("000000000003", 3), ("000000100003", 100_003)] {
        let carrier = labels.transponder(Some(identity), number).unwrap();
        assert_eq!(carrier.id, Some("D3"));
    }
}

fn formation() -> Scenario {
    let mut scenario = perfect(20, 0, 0);
    scenario.drones.pattern = Pattern::Formation;
    scenario.drones.separation_m = 8.0;
    scenario
}

#[test]
fn formation_keeps_neighbours_at_their_distance() {
    let flown = fly(&formation(), 1);
    let (mut nearest, mut travelled_m) = (Vec::new(), 0.0);
    for step in (0..3000).step_by(50) {
        let places: Vec<_> = (0..20).map(|drone| flown.samples(drone)[step].position).collect();
        for (index, place) in places.iter().enumerate() {
            let others = places.iter().enumerate().filter(|(other, _)| *other != index);
            let distances = others.map(|(_, other)| (other - place).norm());
            nearest.push(distances.fold(f64::INFINITY, f64::min));
        }
        travelled_m += (flown.samples(0)[step + 50].position - flown.samples(0)[step].position).norm();
    }
    // Distance to the nearest of two to four adjacent drones, each with a deviation of one metre.
    between("distance of the nearest, m", 12.5, mean(&nearest), 15.0);
    assert!(nearest.iter().all(|metres| *metres >= 8.0));
    assert!(travelled_m > 500.0, "it flies");
    for drone in 0..20 {
        for pair in flown.samples(drone).windows(2) {
            let moved = (pair[1].position - pair[0].position) * 10.0;
            assert!((moved - (pair[0].velocity + pair[1].velocity) / 2.0).norm() < 0.6, "velocities fit");
        }
    }
}

#[test]
fn formation_closer_than_the_separation_is_refused() {
    let text = formation().show().replace("separation_m = 8.0", "separation_m = 13.0");
    let error = Scenario::parse(&text, "close.toml").unwrap_err().to_string();
    assert!(error.contains("separation_m") && error.contains("at most 0.8 of formation_m"), "{error}");
}

#[test]
fn single_fault_scenarios_contain_their_fault() {
    let swarm = kept("swarm").drones;
    assert_eq!((swarm.multirotors, swarm.equipped, swarm.formation_m), (20, 16, 15.0));
    assert_eq!(kept("barometric").transponder.barometric_share, 1.0);
    assert_eq!(kept("two-transponders").transponder.second_share, 1.0);
    let networks = kept("two-networks");
    assert_eq!((networks.remote_id.drones, networks.remote_id.same_serial), (8, false));
    assert_eq!(kept("slow-gnss").transponder.stated_m, Span::new(2.0, 4.0));
    let late = kept("late-stamps").transponder;
    assert_eq!((late.stamp_jitter_s, late.rounded_deg), (Span::new(0.0, 1.0), 1e-5));
    let clock = &kept("radar-clock").radars[0];
    assert_eq!((clock.clock_s, clock.clock_drift_ms_s), (0.3, 1.0));
    assert_eq!(kept("ghosts").radars[0].ghost_share, 1.0);
    assert_eq!(kept("flocks-40").birds.flock_size, 40);
    assert_eq!(kept("swaps").radars[0].swap_share, 1.0);
}
