//! Measured quantities: the expected value for a state, and its derivatives.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use fusion::frames::Enu;

/// Minimum distance to the sensor for a relative quantity, and minimum distance over ground for an azimuth, metres.
/// Nearer, a change by the estimate's own error would turn the line of sight.
const NEAREST_M: f64 = 5.0;

/// A sensor: its position and velocity, in the site's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// Position of the sensor.
    pub position: Enu,
    /// Velocity east, north and up, metres a second; zero on the ground.
    pub velocity: Vector3<f64>,
}

impl Observer {
    /// A sensor that does not move.
    pub fn at_rest(position: Enu) -> Self {
        Self { position, velocity: Vector3::zeros() }
    }
}

/// A quantity that a sensor measures, in metres, radians or metres a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Distance in space from the sensor.
    Range,
    /// Direction over ground from the sensor, clockwise from north.
    Azimuth,
    /// Angle above the sensor's horizon.
    Elevation,
    /// Rate of the range, positive if it increases.
    RangeRate,
    /// Position on the site's axis to the east.
    East,
    /// Position on the site's axis to the north.
    North,
    /// Position on the site's upward axis: an altitude corrected for the geoid or the barometer, and for the Earth's
    /// curvature.
    Altitude,
}

/// Expected value of a quantity for a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedValue {
    /// The value.
    pub value: f64,
    /// Derivative by the position, east, north, up.
    pub by_position: Vector3<f64>,
    /// Derivative by the velocity, east, north, up.
    pub by_velocity: Vector3<f64>,
}

impl Quantity {
    /// Expected value for an aircraft at `position` with `velocity`; `None` if it is too close to the sensor.
    pub fn expected(
        self,
        observer: &Observer,
        position: &Vector3<f64>,
        velocity: &Vector3<f64>,
    ) -> Option<ExpectedValue> {
        let place =
            |value, axis| Some(ExpectedValue { value, by_position: axis, by_velocity: Vector3::zeros() });
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
            Self::Azimuth => ExpectedValue {
                value: away.x.atan2(away.y),
                by_position: Vector3::new(away.y, -away.x, 0.0) / (ground * ground),
                by_velocity: Vector3::zeros(),
            },
            Self::Elevation => {
                // Directly above the sensor every direction leads down, and the derivatives are zero.
                let outward = if ground > 0.0 { away.xy() / ground } else { away.xy() };
                let by_position = Vector3::new(-outward.x * away.z, -outward.y * away.z, ground);
                ExpectedValue {
                    value: away.z.atan2(ground),
                    by_position: by_position / (range * range),
                    by_velocity: Vector3::zeros(),
                }
            }
            Self::RangeRate => {
                let apart = velocity - observer.velocity;
                let (outward, rate) = (away / range, away.dot(&apart) / range);
                let by_position = (apart - outward * rate) / range;
                ExpectedValue { value: rate, by_position, by_velocity: outward }
            }
            _ => ExpectedValue { value: range, by_position: away / range, by_velocity: Vector3::zeros() },
        })
    }

    /// Measured minus expected value; for angles the shorter way around.
    pub fn innovation(self, measured: f64, expected: f64) -> f64 {
        match self {
            Self::Azimuth | Self::Elevation => wrapped(measured - expected),
            _ => measured - expected,
        }
    }
}

/// The equivalent angle above -π, up to π.
pub fn wrapped(angle: f64) -> f64 {
    angle - TAU * ((angle - PI) / TAU).ceil()
}
