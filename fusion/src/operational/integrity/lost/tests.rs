use super::*;
use crate::frames::Enu;
use crate::point::{RadarPart, Source};
use crate::report::{RadarTrackKey, SensorIndex};

fn at(seconds: f64) -> Time {
    Time::from_nanos((seconds * 1e9) as i64)
}

/// An aircraft at this distance east, detected only by radar since then.
fn seen(east_m: f64, since_s: f64) -> Point {
    let track = RadarTrackKey { sensor: SensorIndex(0), number: 7 };
    let part = RadarPart { track, time: at(100.0), height_measured: true, uav_probability: None };
    Point {
        is_unexplained: true,
        ..Point::new(7, Enu::new(east_m, 0.0, 50.0), at(since_s), Source::Radar(part))
    }
}

/// An identity expected at the origin, with a standard deviation of 100 m on each axis.
fn lost(heard_s: Option<f64>) -> LostIdentity {
    let covariance = Matrix2::identity() * 100.0_f64.powi(2);
    LostIdentity { heard: heard_s.map(at), place: Vector2::zeros(), covariance }
}

/// Which of the aircraft are unexplained.
fn unexplained<const N: usize>(
    mut points: [Point; N],
    lost: impl IntoIterator<Item = LostIdentity>,
) -> [bool; N] {
    assign(&mut points, lost.into_iter());
    points.map(|point| point.is_unexplained)
}

#[test]
fn silent_transponder_explains_tracks_within_three_sigma() {
    assert_eq!(unexplained([seen(299.0, 95.0)], [lost(Some(90.0))]), [false]);
    assert_eq!(unexplained([seen(301.0, 95.0)], [lost(Some(90.0))]), [true]);
}

#[test]
fn each_explains_one_aircraft_and_that_the_likeliest() {
    let three = || [seen(-150.0, 95.0), seen(20.0, 95.0), seen(80.0, 95.0)];
    assert_eq!(unexplained(three(), [lost(Some(90.0))]), [true, false, true]);
    assert_eq!(unexplained(three(), [lost(Some(90.0)), lost(Some(80.0))]), [true, false, false]);
}

#[test]
fn track_seen_during_reports_elsewhere_is_not_explained() {
    assert_eq!(unexplained([seen(0.0, 87.0)], [lost(Some(90.0))]), [true]);
    // An identity without an earlier report was nowhere else.
    assert_eq!(unexplained([seen(0.0, 87.0)], [lost(None)]), [false]);
}
