//! Plots, reports of transponders, and what is known beforehand.

use fusion::frames::Geodetic;
use fusion::time::Time;

/// One detection of a radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarPlot {
    /// The radar's track number.
    pub track: u16,
    /// Time stamp.
    pub time: Time,
    /// Slant range, metres, above zero.
    pub slant_range_m: f64,
    /// Azimuth, radians, clockwise from the radar's north mark.
    pub azimuth: f64,
    /// Measured height above the ellipsoid, metres.
    pub height_m: Option<f64>,
}

/// One position report of a transponder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionReport {
    /// Index of the transponder.
    pub transponder: usize,
    /// Time stamp.
    pub time: Time,
    /// Reported place; its height is above the ellipsoid.
    pub place: Geodetic,
}

/// Assumed pose of the radar before the recording is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstGuess {
    /// Antenna.
    pub antenna: Geodetic,
    /// Bearing, radians: azimuths are too large by it.
    pub bearing: f64,
}
