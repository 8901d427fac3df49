use super::*;
use crate::frames::Enu;
use crate::point::{RadarPart, Source};
use crate::report::{RadarTrackKey, SensorIndex};

fn at(seconds: f64) -> Time {
    Time::from_nanos((seconds * 1e9) as i64)
}

/// An aircraft so far east, seen by radar alone since then.
fn seen(east_m: f64, since_s: f64) -> Point {
    let track = RadarTrackKey { sensor: SensorIndex(0), number: 7 };
    let part = RadarPart { track, time: at(100.0), height_measured: true, uav_probability: None };
    Point {
        is_unexplained: true,
        ..Point::new(7, Enu::new(east_m, 0.0, 50.0), at(since_s), Source::Radar(part))
    }
}

/// An identity that would be at the origin, within 100 m an axis.
fn lost(heard_s: Option<f64>) -> Lost {
    let covariance = Matrix2::identity() * 100.0_f64.powi(2);
    Lost { heard: heard_s.map(at), place: Vector2::zeros(), covariance }
}

/// Which of the aircraft nothing explains.
fn unexplained<const N: usize>(mut points: [Point; N], lost: impl IntoIterator<Item = Lost>) -> [bool; N] {
    assign(&mut points, lost.into_iter());
    points.map(|point| point.is_unexplained)
}

#[test]
fn it_explains_what_is_within_three_deviations() {
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
fn what_was_seen_while_it_was_heard_elsewhere_is_another_one() {
    assert_eq!(unexplained([seen(0.0, 87.0)], [lost(Some(90.0))]), [true]);
    // Who was not heard yet was nowhere else.
    assert_eq!(unexplained([seen(0.0, 87.0)], [lost(None)]), [false]);
}
