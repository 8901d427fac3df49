//! Fuses the reports of radars and transponders of drones into one air picture.
//!
//! Sans-IO: no clock, no socket, no file, no random number. The [`Engine`] is told the time and the reports, and yields every
//! slot once, with its points; the same input gives the same output, to the byte. Two profiles: `reference` follows Cisek,
//! Brekke, Jahangir, Johansen, *Track-to-track data fusion for Unmanned Traffic Management System*; `operational` estimates
//! one target per aircraft.

pub mod assignment;
mod cells;
mod engine;
mod filter;
pub mod frames;
pub mod interpolation;
pub mod numbering;
pub mod operational;
pub mod point;
mod reference;
pub mod registration;
pub mod report;
pub mod settings;
pub mod slots;
pub mod time;

pub use engine::{Due, Engine, Refused};
pub use frames::Enu;
pub use point::{Emission, Point, Source};
pub use report::{Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex};
pub use settings::{Profile, Settings};
pub use time::Time;
