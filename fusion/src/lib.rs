//! Fuses the reports of radars and transponders of drones into one air picture.
//!
//! Sans-IO: no clock, no socket, no file, no random number. The [`Engine`] takes times and reports and returns every
//! slot once, with its points. The same input gives the same output, to the byte. Two profiles: `reference` follows
//! Cisek, Brekke, Jahangir, Johansen, *Track-to-track data fusion for Unmanned Traffic Management System*;
//! `operational` estimates one target per aircraft.
//!
//! A complete loop (`cargo run -p utm-fusion-engine --example embed`):
//!
//! ```
#![doc = include_str!("../examples/embed.rs")]
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`settings`] | sensors, their errors, and the parameters of the two profiles |
//! | [`report`] | the input: plots, fixes and bearings |
//! | [`point`] | the output: points |
//! | [`time`], [`slots`] | instants, and slots of equal length |
//! | [`frames`] | WGS-84, Earth-centred and east-north-up positions, each a type |
//! | [`numbering`] | track numbers of transponders, and their state for a restart |
//! | [`operational`] | operators' correlations, and the state of each radar |
//! | [`registration`] | a radar's misalignment, and its state for a restart |
//! | [`learning`] | a radar's errors, estimated from its tracks, and their state for a restart |
//! | [`integrity`] | whether a transponder's reports can be trusted, and the evidence against them |
//! | [`filter`] | Gaussian filters with interacting motion models, and the filter of one target |
//! | [`interpolation`], [`assignment`], [`cells`] | shape-preserving interpolation; the optimal one-to-one assignment; a search for neighbours |

pub mod assignment;
pub mod cells;
mod checkpoint;
mod decimals;
pub mod declaration;
mod engine;
pub mod filter;
pub mod frames;
pub mod integrity;
pub mod interpolation;
pub mod learning;
mod names;
pub mod numbering;
pub mod operational;
pub mod point;
mod reference;
pub mod registration;
pub mod report;
pub mod settings;
pub mod slots;
pub mod time;

pub use checkpoint::CheckpointError;
pub use engine::{Due, Engine, Offer, ReportRefusal};
pub use frames::Enu;
pub use point::{Emission, Point, Source};
pub use report::{Departed, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex};
pub use settings::{Profile, Settings};
pub use time::Time;

/// The README's example, compiled and run with the doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
