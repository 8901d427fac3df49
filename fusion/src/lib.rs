//! Fuses the reports of radars and transponders of drones into one air picture.
//!
//! Sans-IO: no clock, no socket, no file, no random number. The [`Engine`] is told the time and the reports, and yields every
//! slot once, with its points; the same input gives the same output, to the byte. Two profiles: `reference` follows Cisek,
//! Brekke, Jahangir, Johansen, *Track-to-track data fusion for Unmanned Traffic Management System*; `operational` estimates
//! one target per aircraft.
//!
//! A whole loop (`cargo run -p utm-fusion-engine --example embed`):
//!
//! ```
#![doc = include_str!("../examples/embed.rs")]
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`settings`] | sensors, their errors, and the numbers of the two profiles |
//! | [`report`] | what the engine is told |
//! | [`point`] | what it yields |
//! | [`time`], [`slots`] | instants, and the slots that time is cut into |
//! | [`frames`] | WGS-84, Earth-centred and east-north-up positions, each a type |
//! | [`numbering`] | track numbers of transponders, and what a restart must know of them |
//! | [`operational`] | an operator's correlations, and what is known of each radar |
//! | [`registration`] | a radar's misalignment, and what a restart must know of it |
//! | [`learning`] | a radar's errors as they have shown themselves, and what a restart must know of them |
//! | [`integrity`] | whether a transponder can be trusted, and what speaks against it |
//! | [`conflicts`] | who will come near whom |
//! | [`measurement`] | what any sensor measures of an aircraft, and a tracker by all of them |
//! | [`interpolation`], [`assignment`] | shape-preserving interpolation; the optimal one-to-one assignment |

pub mod assignment;
mod cells;
mod checkpoint;
pub mod conflicts;
mod decimals;
pub mod declaration;
mod engine;
mod filter;
pub mod frames;
pub mod integrity;
pub mod interpolation;
pub mod learning;
pub mod measurement;
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
pub use engine::{Due, Engine, Offer, Refused};
pub use frames::Enu;
pub use point::{Emission, Point, Source};
pub use report::{Fix, Identity, Left, Plot, RadarTrackKey, Report, SensorIndex};
pub use settings::{Profile, Settings};
pub use time::Time;

/// The example of the crate's README, which is compiled and run with the others.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
