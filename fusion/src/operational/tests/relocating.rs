//! Radars that are moved to where their tracks show them.

use nalgebra::{Rotation3, Vector3};

use super::two_drones::{reports, settings};
use crate::frames::{Enu, RadarFrame};
use crate::operational::{RadarRelocation, Relocation};
use crate::report::{Report, SensorIndex};
use crate::settings::Sensor;
use crate::{Emission, Engine};

/// Where the radar stands, and by how much its azimuths are too large, radians.
const TRUE_PLACE: [f64; 3] = [40.0, -25.0, 0.0];
const TURNED: f64 = 0.02;

/// Points of a flight seen by a radar that is configured at the site's origin. `is_wrong`: it stands at [`TRUE_PLACE`] and is turned;
/// otherwise it is aligned and configured there. It is moved by `relocations` before the slot of that index.
fn fly(is_wrong: bool, relocations: &[(usize, Option<Relocation>)]) -> Vec<Emission> {
    let mut settings = settings(true);
    if !is_wrong && let Sensor::Radar(radar) = &mut settings.sensors[0] {
        radar.frame = RadarFrame::parallel(Vector3::from(TRUE_PLACE).into());
    }
    let mut engine = Engine::new(settings).unwrap();
    let mut emitted: Vec<Emission> = Vec::new();
    for (received, mut report) in reports(60) {
        if let Report::Plot(plot) = &mut report
            && is_wrong
        {
            let seen = plot.position.0 - Vector3::from(TRUE_PLACE);
            plot.position = Enu::from(Rotation3::from_axis_angle(&Vector3::z_axis(), -TURNED) * seen);
        }
        emitted.extend(engine.advance(received));
        for (slots, to) in relocations {
            if *slots == emitted.len() && engine.relocations().first().map(|active| active.to) != *to {
                assert!(engine.relocate(RadarRelocation { radar: SensorIndex(0), to: *to }));
            }
        }
        engine.handle(report).unwrap();
    }
    emitted.extend(engine.finish());
    emitted
}

#[test]
fn relocated_radar_shows_what_a_correct_one_shows() {
    let [east_m, north_m, _] = TRUE_PLACE;
    let to = Relocation { east_m, north_m, bearing: TURNED };
    let (correct, relocated) = (fly(false, &[]), fly(true, &[(0, Some(to))]));
    assert_eq!(correct.len(), relocated.len());
    for (one, other) in correct.iter().zip(&relocated) {
        assert_eq!(one.points.len(), other.points.len(), "{:?}", one.slot);
        for (one, other) in one.points.iter().zip(&other.points) {
            assert!((one.position.0 - other.position.0).norm() < 1e-6, "{one:?} {other:?}");
        }
    }
    assert!(correct.iter().any(|emission| !emission.points.is_empty()));
}

#[test]
fn relocation_holds_from_its_slot_until_it_is_revoked() {
    let to = Relocation { east_m: 40.0, north_m: -25.0, bearing: TURNED };
    let (never, always) = (fly(true, &[]), fly(true, &[(60, Some(to))]));
    let for_a_while = fly(true, &[(60, Some(to)), (100, None)]);
    assert!((0..60).all(|index| never[index].points == for_a_while[index].points));
    assert!((70..100).any(|index| never[index].points != for_a_while[index].points), "it has no effect");
    assert!((60..100).all(|index| always[index].points == for_a_while[index].points));
    assert!((110..140).any(|index| always[index].points != for_a_while[index].points), "it is never revoked");
}
