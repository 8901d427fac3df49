//! Facts of the paper: cameras (sections 3 and 4, tables 1 and 3) and the measurement of target and attitude (section 4).

/// A camera of the aircraft.
#[derive(Clone, Copy, Debug)]
pub struct AircraftCamera {
    pub name: &'static str,
    /// Field of view, horizontal and vertical, degrees.
    pub field_deg: [f64; 2],
    /// Angle of a pixel, degrees.
    pub pixel_deg: f64,
    /// Yaw, pitch and roll relative to the aircraft, degrees (table 3).
    pub angles_deg: [f64; 3],
    /// Number of target positions.
    pub points: usize,
    /// Root mean square of the angles between measured and computed directions, degrees (figure 12).
    pub residual_deg: f64,
}

pub const CAMERAS: [AircraftCamera; 3] = [
    AircraftCamera {
        name: "panchromatic",
        field_deg: [48.6, 37.6],
        pixel_deg: 0.041,
        angles_deg: [-3.94, 0.06, -1.06],
        points: 15,
        residual_deg: 0.28,
    },
    AircraftCamera {
        name: "colour",
        field_deg: [48.6, 37.6],
        pixel_deg: 0.041,
        angles_deg: [3.89, -1.48, -1.48],
        points: 15,
        residual_deg: 0.16,
    },
    AircraftCamera {
        name: "infrared",
        field_deg: [24.0, 18.0],
        pixel_deg: 0.075,
        angles_deg: [0.85, 0.29, -1.27],
        points: 8,
        residual_deg: 0.37,
    },
];

/// Distance of the targets, metres.
pub const DISTANCE_M: f64 = 4.0;
/// Width and height of the rectangle in which the target is moved, metres.
pub const RECTANGLE_M: [f64; 2] = [4.0, 3.0];
/// Mean uncertainty of a target position (figure 8), metres. Taken as the root mean square of the distance in space.
pub const UNCERTAINTY_M: f64 = 0.035;
/// Precision of the receiver (table 1), metres.
pub const PRECISION_M: f64 = 0.003;
/// Variation of heading, pitch and roll during an acquisition, degrees.
pub const ATTITUDE_DEG: [f64; 3] = [0.1, 0.01, 0.01];
