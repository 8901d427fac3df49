//! A radar's position, alignment and clock, from a recording with transponders and without a first guess.
//!
//! | file | content |
//! |---|---|
//! | `path` | the path of one transponder, interpolated between its reports |
//! | `pieces` | radar tracks in pieces of a few seconds |
//! | `search` | global search: each piece and each path vote for a pose |
//! | `pairing` | which piece belongs to which path, at a given pose |
//! | `whitening` | a Kalman filter that makes correlated residuals independent, and their likelihood |
//! | `noise` | sizes and durations of the radar's errors, by restricted maximum likelihood |
//! | `fit` | Gauss–Newton on pose, ranges and clock, with Huber's weights |
//! | `vertical` | tilts and height offset |
//! | `verdict` | whether the result can be trusted, and what would show what is unknown |
//!
//! The slant range and azimuth of a plot change with the pose as
//!
//! | | antenna position | bearing | range offset | range scale | time |
//! |---|---|---|---|---|---|
//! | azimuth | (-cos θ, sin θ, 0) / g | 1 | | | v · clockwise / g |
//! | slant range | -d / ρ | | 1 | ρ | v · outward |
//!
//! with θ the true azimuth, g the distance over ground, d the vector from antenna to target and ρ its length. A bias is measured
//! minus true. Each transponder has a time delay of its own, which is eliminated (Schur complement). The method and its figures:
//! `docs/REGISTRATION.md`.
//!
//! Sources: B. K. P. Horn, *Closed-form solution of absolute orientation*, JOSA A 4 (1987): rotation and shift between two
//! curves; D. H. Ballard, Pattern Recognition 13 (1981): votes for a pose; P. J. Huber, *Robust Statistics* (1981); H. D. Patterson
//! and R. Thompson, Biometrika 58 (1971): restricted likelihood.

mod fit;
mod noise;
mod pairing;
mod path;
mod pieces;
mod search;
mod verdict;
mod vertical;
mod whitening;

use nalgebra::Matrix2;

use crate::frames::Geodetic;
use crate::time::Time;

pub use verdict::{NotLocated, Unobservable};

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

/// Locates the radar of these plots.
///
/// Plots and reports may be in any order. With a `guess`, the neighbourhood of it is searched first.
///
/// # Errors
/// [`NotLocated`]: the recording does not determine where the radar is; the reason names what is missing.
pub fn locate(
    plots: &[PolarPlot],
    reports: &[PositionReport],
    guess: Option<FirstGuess>,
) -> Result<LocatedRadar, NotLocated> {
    verdict::locate(plots, reports, guess)
}
