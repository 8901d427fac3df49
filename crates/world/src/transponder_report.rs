//! A report of a simulated transponder.

use nalgebra::Vector3;

/// One report, with errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransponderReport {
    /// Number of the drone.
    pub drone: usize,
    /// Number of the drone whose identity is sent; it differs from `drone` only if transponders are swapped.
    pub identity: usize,
    /// Whether the drone's own transponder sent the report; false for reports that an attacker sends under its
    /// identity.
    pub is_own: bool,
    /// Time at which the position was measured, s since take-off.
    pub measured_s: f64,
    /// Time stamp, s since take-off.
    pub stamped_s: f64,
    /// Time of arrival at the receiver, s since take-off.
    pub arrives_s: f64,
    /// Reported east, north and height above ground, metres.
    pub position: Vector3<f64>,
    /// Velocity, m/s.
    pub velocity: Vector3<f64>,
    /// Reported accuracy (I129/110), metres.
    pub accuracy_m: Option<f64>,
}
