//! Aircraft for tests.

use fusion::frames::Geodetic;
use fusion::point::{Basis, Estimate, Point, RadarPart};
use fusion::slots::{Slot, SlotGrid};
use fusion::{Enu, RadarTrackKey, SensorIndex, Source};
use nalgebra::{Matrix2, Vector3};

use picture::PictureTrack;

/// Longitude of the border between the two cells, in degrees, and metres per degree there.
pub(super) const BORDER: f64 = 4.4;
const DEGREE_M: f64 = 69_900.0;

/// An aircraft in a cell's engine that a radar sees `east_m` metres east of the border.
pub(super) fn track(number: u32, since: Slot, slot: Slot, east_m: f64) -> PictureTrack {
    let grid = SlotGrid::default();
    let time = grid.centre(slot);
    let position = Geodetic::from_degrees(51.25, BORDER + east_m / DEGREE_M, 100.0);
    let estimate = Estimate {
        velocity: Vector3::zeros(),
        horizontal: Matrix2::identity() * 100.0,
        vertical_m2: 100.0,
        velocity_covariance: Matrix2::identity(),
        position_velocity: Matrix2::zeros(),
        height_climb: 0.0,
        climb_m2s2: 1.0,
        lie_m2: 0.0,
        basis: Basis::Measured,
        last_measurement: None,
    };
    let track = RadarTrackKey { sensor: SensorIndex(0), number: 7 };
    PictureTrack {
        motion: None,
        point: Point {
            estimate: Some(estimate),
            ..Point::new(
                number,
                Enu::new(0.0, 0.0, 0.0),
                grid.centre(since),
                Source::Radar(RadarPart { track, time, height_measured: true, uav_probability: None }),
            )
        },
        time,
        position,
        altitude_amsl_m: None,
        disputed: Vec::new(),
        id: None,
        name: String::new(),
        is_uncooperative: false,
    }
}
