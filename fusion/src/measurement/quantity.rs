//! What can be measured of an aircraft: the value that a state leads to, and how that changes with the state.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use crate::frames::Enu;

/// Closer to the sensor than this a relative quantity says nothing, and closer over ground an azimuth, metres: a step of the
/// estimate's own error would turn the line of sight round.
const NEAREST_M: f64 = 5.0;

/// A sensor: where it is and how it moves, in the site's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// Where.
    pub position: Enu,
    /// Metres a second, east, north, up; zero on the ground.
    pub velocity: Vector3<f64>,
}

impl Observer {
    /// One that does not move.
    pub fn at_rest(position: Enu) -> Self {
        Self { position, velocity: Vector3::zeros() }
    }
}

/// One number that a sensor measures. Metres, radians, metres a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Distance in space from the sensor.
    Range,
    /// Direction over ground from the sensor, clockwise from north.
    Azimuth,
    /// Angle above the sensor's horizon.
    Elevation,
    /// Rate of the range, growing positive.
    RangeRate,
    /// Place on the site's axis to the east.
    East,
    /// Place on the site's axis to the north.
    North,
    /// Place on the site's upward axis: an altitude corrected for the geoid or the barometer, and for the Earth's curvature.
    Altitude,
}

/// What a state leads a sensor to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// The value.
    pub value: f64,
    /// Its derivative by the position, east, north, up.
    pub by_position: Vector3<f64>,
    /// Its derivative by the velocity, east, north, up.
    pub by_velocity: Vector3<f64>,
}

impl Quantity {
    /// What is expected of an aircraft at `position` with `velocity`; `None` where it is too close for the quantity to say
    /// anything.
    pub fn expected(
        self,
        observer: &Observer,
        position: &Vector3<f64>,
        velocity: &Vector3<f64>,
    ) -> Option<Expected> {
        let place = |value, axis| Some(Expected { value, by_position: axis, by_velocity: Vector3::zeros() });
        match self {
            Self::East => return place(position.x, Vector3::x()),
            Self::North => return place(position.y, Vector3::y()),
            Self::Altitude => return place(position.z, Vector3::z()),
            Self::Range | Self::Azimuth | Self::Elevation | Self::RangeRate => {}
        }
        let away = position - observer.position.0;
        let (range, ground) = (away.norm(), away.x.hypot(away.y));
        if range < NEAREST_M || self == Self::Azimuth && ground < NEAREST_M {
            return None;
        }
        Some(match self {
            Self::Azimuth => Expected {
                value: away.x.atan2(away.y),
                by_position: Vector3::new(away.y, -away.x, 0.0) / (ground * ground),
                by_velocity: Vector3::zeros(),
            },
            Self::Elevation => {
                // Straight above, where every way leads down, it changes with none.
                let outward = if ground > 0.0 { away.xy() / ground } else { away.xy() };
                let by_position = Vector3::new(-outward.x * away.z, -outward.y * away.z, ground);
                Expected {
                    value: away.z.atan2(ground),
                    by_position: by_position / (range * range),
                    by_velocity: Vector3::zeros(),
                }
            }
            Self::RangeRate => {
                let apart = velocity - observer.velocity;
                let (outward, rate) = (away / range, away.dot(&apart) / range);
                let by_position = (apart - outward * rate) / range;
                Expected { value: rate, by_position, by_velocity: outward }
            }
            _ => Expected { value: range, by_position: away / range, by_velocity: Vector3::zeros() },
        })
    }

    /// What was measured less what was expected; of angles the short way round.
    pub fn innovation(self, measured: f64, expected: f64) -> f64 {
        match self {
            Self::Azimuth | Self::Elevation => wrapped(measured - expected),
            _ => measured - expected,
        }
    }
}

/// An angle above -π, up to π.
pub fn wrapped(angle: f64) -> f64 {
    angle - TAU * ((angle - PI) / TAU).ceil()
}
