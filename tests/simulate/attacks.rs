//! Reports of spoofed transponders. Truth and labels are unchanged.

use nalgebra::Vector3;
use utm_fusion::simulate::{Attack, Scenario};

use crate::common::{Fix, Flown, between, fly, perfect};

/// Ten drones, all of them spoofed in this way from 100 s on.
fn attacked(attack: Attack) -> Scenario {
    let mut scenario = perfect(10, 0, 0);
    scenario.drones.spoofed = 10;
    scenario.transponder.attack = attack;
    scenario.transponder.velocities = true;
    (scenario.transponder.spoof_after_s.low, scenario.transponder.spoof_after_s.high) = (100.0, 100.0);
    scenario
}

fn error(flown: &Flown, fix: &Fix) -> Vector3<f64> {
    fix.position - flown.truth(fix.drone, flown.seconds(fix.time)).position
}

fn velocity_error(flown: &Flown, fix: &Fix) -> Vector3<f64> {
    let velocity = fix.record.horizontal_velocity.unwrap();
    let truth = flown.truth(fix.drone, flown.seconds(fix.time)).velocity;
    Vector3::new(velocity.east_m_s() - truth.x, velocity.north_m_s() - truth.y, 0.0)
}

/// Checks each drone's honest reports before the attack, and those after.
fn each(flown: &Flown, mut check: impl FnMut(&[&Fix], &[&Fix])) {
    assert_eq!(flown.simulation.attacks.len(), 10);
    for (drone, fixes) in flown.fixes_by_drone() {
        let begins = fixes.partition_point(|fix| flown.seconds(fix.time) < 100.0);
        let (before, after) = fixes.split_at(begins);
        assert!(before.len() > 20 && after.len() > 40, "{drone}: {} {}", before.len(), after.len());
        assert!(before.iter().all(|fix| error(flown, fix).norm() < 0.2));
        check(before, after);
    }
    for attack in &flown.simulation.attacks {
        assert_eq!(flown.seconds(attack.from), 100.0);
        assert_eq!(flown.seconds(attack.until), flown.duration_s());
    }
}

#[test]
fn velocity_of_a_drifting_transponder_drifts_too() {
    let flown = fly(&attacked(Attack::Drift), 1);
    each(&flown, |before, after| {
        assert!(before.iter().all(|fix| velocity_error(&flown, fix).norm() < 0.6));
        for fix in after {
            let off_m_s = velocity_error(&flown, fix).norm();
            // Stamps are rounded by up to 1/256 s.
            let second = flown.seconds(fix.time);
            let expected = if second < 160.0 { 100.0 / 60.0 } else { 0.0 };
            assert!((off_m_s - expected).abs() < 0.6 || (second - 160.0).abs() < 0.004, "{off_m_s}");
        }
    });
}

#[test]
fn jump_has_full_distance_from_the_first_report() {
    let mut scenario = attacked(Attack::Jump);
    (scenario.transponder.spoof_drift_m, scenario.transponder.spoof_lasts_s) = (70.0, 60.0);
    let flown = fly(&scenario, 1);
    for fix in &flown.fixes {
        let (off_m, second) = (error(&flown, fix).norm(), flown.seconds(fix.time));
        let expected = if (100.0..160.0).contains(&second) { 70.0 } else { 0.0 };
        let is_rounded = (second - 100.0).abs().min((second - 160.0).abs()) < 0.004;
        assert!((off_m - expected).abs() < 0.3 || is_rounded, "{second}: {off_m} {expected}");
    }
    assert!(flown.simulation.attacks.iter().all(|attack| flown.seconds(attack.until) == 160.0));
}

#[test]
fn frozen_transponder_repeats_the_same_octets() {
    let flown = fly(&attacked(Attack::Frozen), 1);
    each(&flown, |before, after| {
        let last = &before[before.len() - 1].record;
        for fix in after {
            assert_eq!(fix.record.position, last.position);
            assert_eq!(fix.record.altitude_amsl, last.altitude_amsl);
            assert_eq!(fix.record.horizontal_velocity, last.horizontal_velocity);
        }
    });
}

#[test]
fn replayed_transponder_repeats_the_last_minute() {
    let mut scenario = attacked(Attack::Replay);
    scenario.transponder.replay_s = 60.0;
    let flown = fly(&scenario, 1);
    each(&flown, |before, after| {
        for fix in after {
            let ago_s = 60.0 * ((flown.seconds(fix.time) - 100.0) / 60.0 + 1e-9).ceil();
            let there = before.iter().find(|earlier| {
                (fix.time.seconds_since(earlier.time) - ago_s).abs() < 0.02
                    && earlier.record.position == fix.record.position
            });
            assert!(there.is_some_and(|earlier| earlier.record.altitude_amsl == fix.record.altitude_amsl));
        }
    });
    // Their labels name no drone.
    let replayed = flown.simulation.labels.iter().filter(|label| flown.seconds(label.time) > 101.0);
    assert!(replayed.clone().count() > 400);
    assert!(replayed.filter(|label| label.sensor == "drone-it").all(|label| label.id.is_none()));
}

#[test]
fn duplicate_reports_between_from_another_position() {
    let flown = fly(&attacked(Attack::Duplicate), 1);
    each(&flown, |_, after| {
        let others: Vec<f64> =
            after.iter().map(|fix| error(&flown, fix).norm()).filter(|&off_m| off_m > 100.0).collect();
        between("share of the second", 0.45, others.len() as f64 / after.len() as f64, 0.55);
        assert!(others.iter().all(|off_m| (off_m - 500.0).abs() < 30.0), "{others:?}");
    });
}

#[test]
fn swapped_transponders_exchange_identities() {
    let flown = fly(&attacked(Attack::Swapped), 1);
    let serial = |fix: &Fix| {
        let octets = fix.record.serial_number.unwrap();
        std::str::from_utf8(&octets).unwrap().parse::<usize>().unwrap() - 1
    };
    let mut partners = [None; 10];
    each(&flown, |before, after| {
        let drone = before[0].drone;
        assert!(before.iter().all(|fix| serial(fix) == drone));
        let partner = serial(after[0]);
        assert_ne!(partner, drone);
        assert!(after.iter().all(|fix| serial(fix) == partner && error(&flown, fix).norm() < 0.2));
        partners[drone] = Some(partner);
    });
    for (drone, partner) in partners.iter().enumerate() {
        assert_eq!(partners[partner.unwrap()], Some(drone));
    }
    // Labels name the true drone.
    let wrong = flown
        .simulation
        .labels
        .iter()
        .filter(|label| label.sensor == "drone-it" && label.id != Some(format!("D{}", label.number)));
    assert!(wrong.count() > 400);
}

#[test]
fn time_stamps_are_off_and_positions_are_not() {
    for shift_s in [2.0, -2.0] {
        let mut scenario = attacked(Attack::Time);
        scenario.transponder.time_shift_s = shift_s;
        let flown = fly(&scenario, 1);
        for fix in &flown.fixes {
            let second = flown.seconds(fix.time);
            let measured_s = if second > 100.0 + shift_s { second - shift_s } else { second };
            if (98.0..102.1).contains(&second) || measured_s > flown.duration_s() {
                continue;
            }
            let off_m = (fix.position - flown.truth(fix.drone, measured_s).position).norm();
            assert!(off_m < 0.3, "{second}: {off_m}");
        }
    }
}
