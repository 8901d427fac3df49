//! A radar's position, alignment and clock, from a recording with transponders and without a first guess. No I/O, no clock.
//!
//! | file | content |
//! |---|---|
//! | `alignment_data` | plots and reports of a recording |
//! | `measurements`, `located_radar`, `not_located` | what comes in, and what comes out |
//! | `path` | the path of one transponder, interpolated between its reports |
//! | `pieces` | radar tracks in pieces of a few seconds |
//! | `pose` | position, alignment and clock of a radar, and what it would measure |
//! | `search` | global search: each piece and each path vote for a pose |
//! | `pairing` | which piece belongs to which path, at a given pose |
//! | `whitening` | a Kalman filter that makes correlated residuals independent, and their likelihood |
//! | `noise` | sizes and durations of the radar's errors, by restricted maximum likelihood |
//! | `fit` | Gauss–Newton on pose, ranges and clock, with Huber's weights |
//! | `vertical` | tilts and height offset |
//! | `verdict` | from plots and reports to a located radar, or to the reason why there is none |
//! | `consistency` | whether the parts of the recording agree with each other |
//! | `advice` | flights that would show what is unknown |
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

mod advice;
mod alignment_data;
mod consistency;
mod fit;
mod located_radar;
mod measurements;
mod noise;
mod not_located;
mod pairing;
mod path;
mod pieces;
mod pose;
mod search;
mod verdict;
mod vertical;
mod whitening;

pub use alignment_data::{AlignmentData, RadarData};
pub use located_radar::{Estimate, Evidence, LocatedRadar, PlotResidual};
pub use measurements::{FirstGuess, PolarPlot, PositionReport};
pub use not_located::{NotLocated, Remedy, Unobservable};
pub use verdict::locate;
