//! Transponders whose heights have another reference.

use super::*;
use crate::integrity::Concern;
use crate::settings::RegistrationMode;

const OFFSET_M: f64 = 35.0;

/// Published height less true, and its deviation, of each aircraft, metres; and the identities with an alert.
type ComparedSecond = ([Option<(f64, f64)>; 2], Vec<Identity>);

/// Heights that are published of both, less true, and the identities that an alert is about, second by second: the first
/// reports heights that are too large. Radar tracks of both begin every 30 s.
fn flown(offset_m: f64) -> Vec<ComparedSecond> {
    let mut case = Case::new();
    case.settings.radars[0].as_mut().unwrap().registration = RegistrationMode::Apply;
    let mut seconds = Vec::new();
    for slot in 0..4 * 400 {
        let second = slot as f64 / 4.0;
        let ahead_s = second + 5.0;
        for which in 0..2 {
            let east_m = 900.0 * which as f64;
            if slot % 8 == 0 {
                let up_m = 100.0 + if which == 0 { offset_m } else { 0.0 };
                let place = Enu::new(east_m, 1500.0, up_m);
                case.air.handle(Report::Fix(Fix::new(SensorIndex(1), identity(which), at(ahead_s), place)));
            }
            let track = 10 * which as u16 + 1 + (slot / 120) as u16 % 5;
            if slot % 2 == 0 && slot % 120 < 90 {
                case.plot((0, track), ahead_s, east_m, 0.95);
            }
        }
        case.numbers.begin_slot(Slot(slot));
        let made = case.air.emit(Slot(slot), GRID, &case.settings, &mut case.numbers);
        case.numbers.take_changes();
        if slot % 4 != 0 {
            continue;
        }
        let of = |which| {
            let is_own = |point: &&Point| {
                point.source.transponder().is_some_and(|part| part.identity == identity(which))
            };
            let point = made.points.iter().find(is_own)?;
            Some((point.position.up() - 100.0, point.estimate?.vertical_m2.sqrt()))
        };
        assert!(
            made.concerns.iter().all(|concern| matches!(concern, Concern::Height { .. })),
            "{:?}",
            made.concerns
        );
        let about = made.concerns.iter().filter_map(|concern| match concern {
            Concern::Height { identity, .. } => Some(*identity),
            _ => None,
        });
        seconds.push(([of(0), of(1)], about.collect()));
    }
    seconds
}

#[test]
fn barometric_height_is_corrected_and_alerted() {
    let seconds = flown(OFFSET_M);
    let last = seconds.last().unwrap();
    let [Some((first_m, first_sigma_m)), Some((other_m, _))] = last.0 else { panic!("{last:?}") };
    assert!(first_m.abs() < 0.3 * OFFSET_M, "{last:?}");
    assert!(first_m.abs() < 3.0 * first_sigma_m, "{last:?}");
    assert!(other_m.abs() < 5.0, "{last:?}");
    assert_eq!(last.1, [identity(0)]);
    // No step is published.
    let heights: Vec<f64> = seconds.iter().filter_map(|second| second.0[0]).map(|height| height.0).collect();
    assert!(heights.windows(2).all(|two| (two[1] - two[0]).abs() < 2.0), "{heights:?}");
}

#[test]
fn honest_heights_stay_and_raise_no_alert() {
    for (heights, about) in flown(0.0) {
        assert!(about.is_empty());
        assert!(heights.iter().flatten().all(|height| height.0.abs() < 1.5), "{heights:?}");
    }
}
