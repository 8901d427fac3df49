//! A located radar: its pose and errors, each with a standard deviation.

use fusion::frames::Geodetic;
use fusion::time::Time;
use nalgebra::Matrix2;

use crate::not_located::Unobservable;

/// An estimated value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Standard deviation before the recording was read.
    pub prior_sigma: f64,
}

impl Estimate {
    /// Whether the recording, rather than the assumption before it, determines the value.
    pub fn is_observable(&self) -> bool {
        self.sigma < 0.5 * self.prior_sigma
    }
}

/// A located radar. A bias is measured minus true.
#[derive(Clone, Debug, PartialEq)]
pub struct LocatedRadar {
    /// Antenna.
    pub antenna: Geodetic,
    /// Covariance of the antenna's position, east and north, m².
    pub covariance_m2: Matrix2<f64>,
    /// Height of the antenna above the ellipsoid, metres.
    pub height_m: Estimate,
    /// Bearing, degrees: azimuths are too large by it.
    pub bearing_deg: Estimate,
    /// Offset of slant ranges, metres.
    pub range_offset_m: Estimate,
    /// Relative error of slant ranges: 0.001 is 1 m in a kilometre.
    pub range_scale: Estimate,
    /// Clock, seconds: time stamps are too late by it.
    pub clock_s: Estimate,
    /// Tilt about east, degrees: targets in the north appear too high.
    pub tilt_east_deg: Option<Estimate>,
    /// Tilt about north, degrees: targets in the east appear too low.
    pub tilt_north_deg: Option<Estimate>,
    /// Offset of measured heights against the transponders', metres.
    pub height_offset_m: Option<Estimate>,
    /// Standard deviation of a plot's azimuth, degrees.
    pub azimuth_sigma_deg: f64,
    /// Standard deviation of a plot's slant range, metres.
    pub range_sigma_m: f64,
    /// Standard deviation of a plot's height, metres.
    pub height_sigma_m: Option<f64>,
    /// Values that the recording does not show, with what would show them.
    pub unobservable: Vec<Unobservable>,
    /// Data that the result rests on.
    pub evidence: Evidence,
    /// Plots that are used, in order of time.
    pub residuals: Vec<PlotResidual>,
}

impl LocatedRadar {
    /// Standard deviation of the position over ground, metres: the root of the sum of both variances.
    pub fn position_sigma_m(&self) -> f64 {
        self.covariance_m2.trace().sqrt()
    }
}

/// Evidence for a result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Number of transponders.
    pub transponders: usize,
    /// Number of radar tracks.
    pub tracks: usize,
    /// Time in which both a transponder and the radar reported an aircraft, summed over aircraft, seconds.
    pub common_s: f64,
    /// Score of the best other pose, as a share of this one's.
    pub runner_up: f64,
}

/// A plot compared with the transponder's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlotResidual {
    /// Time stamp of the plot.
    pub time: Time,
    /// Index of the transponder.
    pub transponder: usize,
    /// Position of the transponder.
    pub reported: Geodetic,
    /// Measured minus reported azimuth, degrees, and slant range, metres: with the first guess, or else as the search found it.
    pub before: (f64, f64),
    /// Residuals with the located radar, in the same units.
    pub after: (f64, f64),
}
