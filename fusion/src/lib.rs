//! The engine: slots and window, and the rules of two profiles.
//!
//! `reference`: interpolation, association, fusion, numbers. Source: Cisek, Brekke, Jahangir, Johansen, *Track-to-track data fusion for Unmanned Traffic Management System*;
//! what the paper leaves open is settled in `docs/ALGORITHM.md`. Everything is as if recomputed from the window at every
//! slot; what is kept between slots only saves work (`tests/engine` holds the two against each other). `operational` is in work (`docs/OPERATIONAL.md`).

pub mod assignment;
mod cells;
mod engine;
pub mod filter;
mod frames;
mod interpolation;
mod numbering;
pub mod operational;
mod point;
mod reference;
pub mod registration;
mod report;
mod settings;
mod slots;
pub mod time;

pub use engine::{Due, Engine, Offer, Refused};
pub use frames::{Ecef, Enu, Frame, Geodetic};
pub use interpolation::{Knot, evaluate};
pub use numbering::{
    Given, Keeping, LARGEST as LARGEST_TRANSPONDER_NUMBER, NOTED, NumberChange, Numbered, Numbers,
};
pub use point::{
    Association, Basis, Because, Competitor, Emission, Estimate, Point, RadarPart, Rival, Source,
    TransponderPart,
};
pub use reference::Evidence;
pub use report::{Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, UasItems};
pub use settings::{Gate, Settings};
pub use slots::{RING, Slot, SlotGrid};
