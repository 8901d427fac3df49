//! Learning of radars' and transponders' delays from reports.

use nalgebra::Vector3;

use super::two_drones::{START, identity, reports, settings};
use crate::report::Report;
use crate::settings::{RegistrationMode, Sensor};
use crate::time::SECOND;
use crate::{Engine, Enu};

/// Learnt and applied delay of the transponders after two minutes in which the first drone reports every four seconds.
/// The report of second `damaged` has a position error of `off`, metres.
fn delay_s(damaged: i64, off: [f64; 3]) -> (f64, f64) {
    let mut settings = settings(true);
    for sensor in &mut settings.sensors {
        match sensor {
            Sensor::Radar(radar) => radar.registration = RegistrationMode::Apply,
            Sensor::Receiver(receiver) => receiver.delay_s = None,
            Sensor::Camera(_) => {}
        }
    }
    let mut engine = Engine::new(settings).unwrap();
    for (received, mut report) in reports(120) {
        if let Report::Fix(fix) = &mut report
            && fix.identity == identity(0)
        {
            let second = fix.time.nanos() / SECOND - START;
            if second % 4 != 0 {
                continue;
            }
            if second == damaged {
                fix.position = Enu::from(fix.position.0 + Vector3::from(off));
            }
        }
        engine.advance(received).for_each(drop);
        engine.handle(report).unwrap();
    }
    let learnt = engine.learnt_types();
    let [(_, learnt)] = &learnt[..] else { panic!("{} types", learnt.len()) };
    (learnt.delay_s.value, learnt.applied_s)
}

/// Around such a report the curve is far from the radar's plots, in proportion to its speed. A delay would explain it,
/// and the faster the curve, the more certainly.
#[test]
fn a_report_from_far_away_is_no_evidence_of_a_delay() {
    let (undamaged_s, _) = delay_s(0, [0.0; 3]);
    let off = [[30_000.0, 0.0, 0.0], [-400.0, 0.0, 0.0], [0.0, 5_000.0, 0.0], [-150.0, 50.0, 0.0]];
    let too_high = [[0.0, 0.0, 3_000.0], [0.0, 0.0, -300.0]];
    for off in off.into_iter().chain(too_high) {
        for damaged in [8, 20, 60, 100] {
            let (known_s, applied_s) = delay_s(damaged, off);
            let what = format!("{known_s} s, {applied_s} s taken off, by {off:?} m at {damaged} s");
            assert!((known_s - undamaged_s).abs() < 0.05 && applied_s == known_s.max(0.0), "{what}");
        }
    }
}
