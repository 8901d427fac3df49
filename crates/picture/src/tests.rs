//! Tests of the tracks that clients receive by default.

use fusion::RadarTrackKey;
use fusion::point::{RadarPart, TransponderPart};
use fusion::report::{Aircraft, UasItems};
use nalgebra::{Matrix2, Vector3};

use super::*;

/// A radar track with this standard deviation per axis, in metres; `None` means without an estimate.
fn track(estimate: Option<(Basis, f64)>) -> PictureTrack {
    let place = Geodetic::from_degrees(52.5, -0.5, 200.0);
    let frame = TangentPlane::at_site(place);
    let time = Time::default();
    let key = RadarTrackKey { sensor: SensorIndex(0), number: 7 };
    let estimate = estimate.map(|(basis, sigma_m)| Estimate {
        velocity: Vector3::new(10.0, 0.0, 0.0),
        horizontal: Matrix2::identity() * sigma_m * sigma_m,
        vertical_m2: 100.0,
        velocity_covariance: Matrix2::identity(),
        position_velocity: Matrix2::zeros(),
        height_climb: 0.0,
        climb_m2s2: 1.0,
        lie_m2: 0.0,
        basis,
        last_measurement: None,
    });
    let position = Enu::new(0.0, 0.0, 0.0);
    PictureTrack {
        motion: estimate.map(|estimate| PublishedMotion::new(&estimate, position, place, &frame)),
        point: Point {
            estimate,
            ..Point::new(
                7,
                position,
                time,
                Source::Radar(RadarPart { track: key, time, height_measured: true, uav_probability: None }),
            )
        },
        time,
        position: place,
        altitude_amsl_m: None,
        disputed: Vec::new(),
        id: None,
        name: String::new(),
        is_uncooperative: false,
    }
}

#[test]
fn extrapolated_track_is_left_out_beyond_its_95_percent_radius() {
    for basis in [Basis::Interpolated, Basis::Extrapolated] {
        // 2.4477 sigma: 99.87 and 100.11 m.
        assert!(track(Some((basis, 40.8))).is_within(MAX_ACCURACY_M));
        assert!(!track(Some((basis, 40.9))).is_within(MAX_ACCURACY_M));
        assert!(track(Some((basis, 102.0))).is_within(250.0));
        assert!(!track(Some((basis, 102.2))).is_within(250.0));
    }
}

#[test]
fn measured_track_is_never_left_out() {
    assert!(track(Some((Basis::Measured, 5_000.0))).is_within(1.0));
    assert!(track(None).is_within(1.0), "the reference profile estimates nothing");
}

/// An aircraft with an accuracy of 900 m whose transponder was last heard `heard_s` seconds ago.
fn reported(kind: AircraftKind, heard_s: Option<f64>) -> PictureTrack {
    let mut track = track(Some((Basis::Extrapolated, 900.0)));
    let identity = Identity::of_address(0x48_4A_F0);
    let before = |seconds: f64| Time::from_nanos(track.time.nanos() - (seconds * SECOND as f64) as i64);
    track.point.source = Source::Transponder(TransponderPart {
        number: 429_496,
        identity,
        sensor: SensorIndex(1),
        time: heard_s.map(before),
        items: UasItems::of(identity),
        aircraft: Aircraft { kind, ..Aircraft::default() },
        height_measured: true,
    });
    track
}

/// An aeroplane that reports an accuracy of half a mile is shown while it is heard.
#[test]
fn crewed_aircraft_is_never_left_out_while_received() {
    let crewed = |heard_s| reported(AircraftKind::Crewed, heard_s);
    for heard_s in [0.0, 1.0, 5.0, -2.0] {
        assert_eq!(crewed(Some(heard_s)).unmeasured_accuracy_m(), None, "{heard_s} s");
        assert!(crewed(Some(heard_s)).is_within(1.0));
    }
    // 2.4477 sigma.
    for heard_s in [Some(5.1), Some(60.0), None] {
        let accuracy_m = crewed(heard_s).unmeasured_accuracy_m().unwrap();
        assert!((accuracy_m - 2202.9).abs() < 0.5, "{heard_s:?}: {accuracy_m}");
        assert!(!crewed(heard_s).is_within(MAX_ACCURACY_M));
    }
    for kind in [AircraftKind::Unmanned, AircraftKind::Vehicle] {
        assert!(reported(kind, Some(1.0)).unmeasured_accuracy_m().is_some(), "{kind:?}");
    }
    // A transponder that is no longer trusted is shown too, heard or not.
    let mut lies = reported(AircraftKind::Unmanned, Some(60.0));
    lies.point.estimate.as_mut().unwrap().lie_m2 = 1.0;
    assert_eq!(lies.unmeasured_accuracy_m(), None);
}

#[test]
fn vehicles_are_not_in_the_air_picture() {
    let mut picture = Picture {
        slot: Slot(0),
        time: Time::default(),
        tracks: [AircraftKind::Vehicle, AircraftKind::Crewed].map(|kind| reported(kind, Some(0.0))).into(),
        concerns: Vec::new(),
        resolved: Vec::new(),
    };
    assert_eq!(picture.within(1e6).collect::<Vec<_>>(), [&picture.tracks[1]]);
    picture.keep_within(1e6);
    assert!(picture.tracks.len() == 1 && !picture.tracks[0].is_vehicle());
}

#[test]
fn filtered_picture_keeps_the_order() {
    let tracks = [
        Some((Basis::Measured, 90.0)),
        Some((Basis::Extrapolated, 90.0)),
        Some((Basis::Interpolated, 10.0)),
        Some((Basis::Interpolated, 60.0)),
        None,
    ];
    let mut picture = Picture {
        slot: Slot(0),
        time: Time::default(),
        tracks: tracks.map(track).into_iter().collect(),
        concerns: Vec::new(),
        resolved: Vec::new(),
    };
    let kept: Vec<PictureTrack> = [0, 2, 4].map(|index| picture.tracks[index].clone()).into();
    assert_eq!(picture.within(100.0).cloned().collect::<Vec<_>>(), kept);
    picture.keep_within(100.0);
    assert_eq!(picture.tracks, kept);
}
