//! Reports of transponders: contents, times and errors.

use nalgebra::Vector3;
use utm_fusion::simulate::Span;

use crate::common::{Fix, Flown, between, deviation, fly, mean, perfect};

/// Error of a report at its stated time: east, north, up.
fn error(flown: &Flown, fix: &Fix) -> Vector3<f64> {
    fix.position - flown.truth(fix.drone, flown.seconds(fix.time)).position
}

fn intervals(fixes: &[&Fix]) -> Vec<f64> {
    fixes.windows(2).map(|pair| pair[1].time.seconds_since(pair[0].time)).collect()
}

fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)))
}

#[test]
fn reports_come_every_2_to_4_s_with_10_percent_jitter() {
    let mut scenario = perfect(100, 0, 0);
    let fixed = fly(&scenario, 1);
    scenario.transponder.jitter = 0.1;
    let jittering = fly(&scenario, 1);
    let mut periods = Vec::new();
    for (drone, fixes) in fixed.fixes_by_drone() {
        let steady = intervals(&fixes);
        let (shortest, longest) = ends(&steady);
        // Stamps have a resolution of 1/128 s.
        assert!(longest - shortest < 0.0157, "{shortest} {longest}");
        let period_s = mean(&steady);
        periods.push(period_s);
        let jittered: Vec<f64> =
            intervals(&jittering.fixes_by_drone()[&drone]).iter().map(|s| s / period_s).collect();
        let (shortest, longest) = ends(&jittered);
        assert!(shortest > 0.895 && longest < 1.105, "{shortest} {longest}");
        assert!(shortest < 0.93 && longest > 1.07, "{shortest} {longest}");
    }
    between("shortest period, s", 1.99, ends(&periods).0, 2.1);
    between("longest period, s", 3.9, ends(&periods).1, 4.01);
}

#[test]
fn twentieth_of_reports_is_dropped() {
    let mut scenario = perfect(200, 0, 0);
    let all = fly(&scenario, 1).fixes.len() as f64;
    scenario.transponder.dropped = 0.05;
    between("dropped", 0.044, 1.0 - fly(&scenario, 1).fixes.len() as f64 / all, 0.056);
}

#[test]
fn gaps_of_6_to_20_s_come_every_90_s() {
    let mut scenario = perfect(200, 0, 0);
    scenario.transponder.period_s = Span::new(0.5, 0.5);
    scenario.transponder.gap_every_s = 90.0;
    let flown = fly(&scenario, 1);
    let (mut gaps, mut speaking_s) = (Vec::new(), 0.0);
    for fixes in flown.fixes_by_drone().values() {
        let (silent, steady): (Vec<f64>, Vec<f64>) = intervals(fixes).into_iter().partition(|s| *s > 0.6);
        speaking_s += steady.iter().sum::<f64>();
        gaps.extend(silent);
    }
    let count = gaps.len();
    // Occasionally one gap follows another between two reports.
    gaps.retain(|gap| *gap < 20.6);
    println!("{count} gaps, {} of one piece", gaps.len());
    assert!(gaps.len() > count * 97 / 100);
    between("seconds from gap to gap", 82.0, speaking_s / count as f64, 98.0);
    between("shortest gap, s", 6.0, ends(&gaps).0, 6.6);
    between("longest gap, s", 19.5, ends(&gaps).1, 20.6);
}

#[test]
fn the_first_and_last_report_come_in_flight() {
    let mut scenario = perfect(200, 0, 0);
    (scenario.transponder.starts_after_s, scenario.transponder.ends_before_s) =
        (Span::new(0.0, 6.0), Span::new(0.0, 6.0));
    scenario.transponder.period_s = Span::new(0.1, 0.1);
    scenario.duration_s = 60.0;
    let flown = fly(&scenario, 1);
    let fixes = flown.fixes_by_drone();
    let first: Vec<f64> = fixes.values().map(|fixes| flown.seconds(fixes[0].time)).collect();
    let last: Vec<f64> =
        fixes.values().map(|fixes| 60.0 - flown.seconds(fixes[fixes.len() - 1].time)).collect();
    for (what, values) in [("after take-off, s", first), ("before the end, s", last)] {
        between(what, 0.0, ends(&values).0, 0.3);
        between(what, 5.7, ends(&values).1, 6.11);
    }
}

#[test]
fn positions_have_slow_and_white_errors() {
    let mut scenario = perfect(200, 0, 0);
    let model = &mut scenario.transponder;
    model.period_s = Span::new(2.0, 2.0);
    (model.gnss_horizontal_m, model.gnss_vertical_m) = (18.0, 25.0);
    let slow = fly(&scenario, 1);
    let model = &mut scenario.transponder;
    (model.gnss_horizontal_m, model.gnss_vertical_m, model.gnss_white_m) = (0.0, 0.0, 5.0);
    let white = fly(&scenario, 1);
    for (flown, sizes, forgotten_s) in [(slow, [18.0, 18.0, 25.0], 60.0), (white, [5.0, 5.0, 5.0], 0.001)] {
        for (axis, size) in sizes.into_iter().enumerate() {
            let errors: Vec<Vec<f64>> = flown
                .fixes_by_drone()
                .values()
                .map(|fixes| fixes.iter().map(|fix| error(&flown, fix)[axis]).collect())
                .collect();
            between("size", 0.9, deviation(&errors.concat()) / size, 1.1);
            for later in [1, 30] {
                let pairs = || errors.iter().flat_map(|list| list.iter().zip(&list[later..]));
                let correlation =
                    pairs().map(|(a, b)| a * b).sum::<f64>() / pairs().map(|(a, _)| a * a).sum::<f64>();
                let expected = (-2.0 * later as f64 / forgotten_s).exp();
                let tolerance = if later == 1 { 0.02 } else { 0.1 };
                between("correlation", expected - tolerance, correlation, expected + tolerance);
            }
        }
    }
}

#[test]
fn positions_jump_if_configured() {
    let mut scenario = perfect(100, 0, 0);
    let model = &mut scenario.transponder;
    (model.jump_every_s, model.jump_m, model.jump_s) = (50.0, Span::new(20.0, 60.0), Span::new(5.0, 20.0));
    model.period_s = Span::new(0.5, 0.5);
    let flown = fly(&scenario, 1);
    let (mut jumps, mut honest_s, mut lengths_s) = (Vec::new(), 0.0, Vec::new());
    for fixes in flown.fixes_by_drone().values() {
        for part in fixes.chunk_by(|a, b| (error(&flown, a) - error(&flown, b)).norm() < 1.0) {
            let off = error(&flown, part[0]);
            if off.norm() < 1.0 {
                honest_s += part.len() as f64 * 0.5;
            } else {
                assert!(off.z.abs() < 0.5, "sideways only: {off:?}");
                jumps.push(off.xy().norm());
                lengths_s.push(part.len() as f64 * 0.5);
            }
        }
    }
    between("seconds to a jump", 42.0, honest_s / jumps.len() as f64, 58.0);
    between("nearest, m", 19.7, ends(&jumps).0, 22.0);
    between("farthest, m", 58.0, ends(&jumps).1, 60.3);
    between("longest, s", 19.0, ends(&lengths_s).1, 20.6);
    between("mean, s", 11.0, mean(&lengths_s), 13.5);
}

#[test]
fn a_spoofed_position_drifts_100_m_away_in_60_s() {
    let mut scenario = perfect(40, 0, 0);
    scenario.drones.spoofed = 20;
    let flown = fly(&scenario, 1);
    let (mut spoofed, mut begins_s) = (0, Vec::new());
    for fixes in flown.fixes_by_drone().values() {
        let last = error(&flown, fixes[fixes.len() - 1]);
        if last.norm() < 1.0 {
            assert!(fixes.iter().all(|fix| error(&flown, fix).norm() < 1.0));
            continue;
        }
        spoofed += 1;
        assert!((last.norm() - 100.0).abs() < 0.5, "{last:?}");
        let begun = fixes.iter().find(|fix| error(&flown, fix).norm() > 2.0).unwrap();
        let begin_s = flown.seconds(begun.time) - error(&flown, begun).norm() / 100.0 * 60.0;
        begins_s.push(begin_s);
        for fix in fixes {
            let share = ((flown.seconds(fix.time) - begin_s) / 60.0).clamp(0.0, 1.0);
            let off = error(&flown, fix);
            assert!((off - last * share).norm() < 1.5, "{off:?}, {share} of {last:?}");
        }
    }
    assert_eq!(spoofed, 20);
    between("begins at the earliest, s", 59.0, ends(&begins_s).0, 75.0);
    between("begins at the latest, s", 105.0, ends(&begins_s).1, 121.0);
}

#[test]
fn a_jammed_transponder_is_silent_for_a_while() {
    let mut scenario = perfect(40, 0, 0);
    scenario.drones.jammed = 20;
    let flown = fly(&scenario, 1);
    let mut jammed = 0;
    for fixes in flown.fixes_by_drone().values() {
        let silences: Vec<(f64, f64)> = fixes
            .windows(2)
            .map(|pair| (flown.seconds(pair[0].time), flown.seconds(pair[1].time)))
            .filter(|(from, to)| to - from > 5.0)
            .collect();
        assert!(silences.len() <= 1);
        for (from, to) in silences {
            jammed += 1;
            assert!((56.0..=120.1).contains(&from), "from {from} s");
            assert!((60.0..=124.1).contains(&(to - from)), "for {} s", to - from);
        }
    }
    assert_eq!(jammed, 20);
}

/// A position measured at t is stamped t + delay, so it lies behind the true position by that time.
#[test]
fn stamps_are_up_to_a_quarter_of_a_second_late_fixed_per_drone() {
    let mut scenario = perfect(0, 60, 0);
    scenario.transponder.stamped_late_s = Span::new(0.0, 0.25);
    let flown = fly(&scenario, 1);
    let mut delays = Vec::new();
    for fixes in flown.fixes_by_drone().values() {
        let behind: Vec<f64> = fixes
            .iter()
            .filter(|fix| flown.seconds(fix.time) < 299.0)
            .map(|fix| {
                let velocity = flown.truth(fix.drone, flown.seconds(fix.time)).velocity;
                -error(&flown, fix).dot(&velocity) / velocity.norm_squared()
            })
            .collect();
        // Stamps are rounded by up to 1/256 s.
        assert!(deviation(&behind) < 0.004, "{behind:?}");
        delays.push(mean(&behind));
    }
    between("earliest, s", -0.001, ends(&delays).0, 0.015);
    between("latest, s", 0.235, ends(&delays).1, 0.251);
}

#[test]
fn reports_arrive_up_to_1_5_s_later_some_out_of_order() {
    let mut scenario = perfect(100, 0, 0);
    // Latencies count from the time stamp, not from the measurement.
    scenario.transponder.stamped_late_s = Span::new(0.2, 0.25);
    let latencies = |flown: &Flown| -> Vec<f64> {
        flown.fixes.iter().map(|fix| fix.received.seconds_since(fix.time)).collect()
    };
    let overtaken = |flown: &Flown| {
        let mut latest = vec![i64::MIN; 100];
        let overtaken = flown.fixes.iter().filter(|fix| {
            let before = latest[fix.drone];
            latest[fix.drone] = before.max(fix.time.nanos());
            fix.time.nanos() < before
        });
        overtaken.count()
    };
    let plain = fly(&scenario, 1);
    let (soonest, latest) = ends(&latencies(&plain));
    between("soonest, s", 0.29, soonest, 0.31);
    between("latest, s", 1.49, latest, 1.51);
    assert_eq!(overtaken(&plain), 0);
    scenario.transponder.held_up = 0.2;
    let held_up = fly(&scenario, 1);
    let all = latencies(&held_up);
    let late = all.iter().filter(|latency| **latency > 2.0).count() as f64;
    between("share held up", 0.18, late / all.len() as f64, 0.22);
    between("latest, s", 6.2, ends(&all).1, 6.51);
    assert!(overtaken(&held_up) > 300, "{}", overtaken(&held_up));
}

#[test]
fn half_of_drones_report_accuracy_and_velocity_if_configured() {
    let mut scenario = perfect(400, 0, 0);
    scenario.duration_s = 20.0;
    (scenario.transponder.gnss_horizontal_m, scenario.transponder.gnss_white_m) = (1.8, 0.5);
    let flown = fly(&scenario, 1);
    let mut telling = 0;
    for fixes in flown.fixes_by_drone().values() {
        let told = fixes[0].record.gnss_accuracy;
        assert!(fixes.iter().all(|fix| fix.record.gnss_accuracy == told));
        // 1.18 · hypot(1.8, 0.5) is 2.2.
        assert!(told.is_none_or(|accuracy| accuracy.metres() == Some(3.0)), "{told:?}");
        telling += usize::from(told.is_some());
    }
    between("share that tells", 0.43, telling as f64 / 400.0, 0.57);
    assert!(flown.fixes.iter().all(|fix| fix.record.horizontal_velocity.is_none()));
    scenario.transponder.velocities = true;
    let flown = fly(&scenario, 1);
    for fix in &flown.fixes {
        let truth = flown.truth(fix.drone, flown.seconds(fix.time)).velocity;
        let told = fix.record.horizontal_velocity.unwrap();
        assert!((told.east_m_s() - truth.x).abs() < 0.6 && (told.north_m_s() - truth.y).abs() < 0.6);
        assert!((fix.record.vertical_velocity.unwrap().up_m_s() - truth.z).abs() < 0.6);
    }
}

/// The error of a perfect transponder is the resolution of CAT129.
#[test]
fn perfect_transponder_errs_by_cat129_resolution_only() {
    let flown = fly(&perfect(20, 0, 0), 1);
    let largest =
        |axis: usize| flown.fixes.iter().map(|fix| error(&flown, fix)[axis].abs()).fold(0.0, f64::max);
    // A stamp is rounded by up to 1/256 s, in which a drone moves 0.06 m; the position to 1.9 cm, the height to 0.1 m.
    between("east, m", 0.03, largest(0), 0.09);
    between("north, m", 0.03, largest(1), 0.09);
    between("up, m", 0.045, largest(2), 0.09);
}
