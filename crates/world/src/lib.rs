//! Simulated flights and sensors: true motion, and what radars and transponders measure of it, with realistic errors
//! (`docs/SIMULATION.md`). This crate encodes and sends nothing.
//!
//! ```text
//! scenario ──► motion ──► radar (target state) ──► detections
//! seed         truth      transponder   ──► reports
//! ```
//!
//! The same [`scenario::Scenario`] and seed give the same numbers. This is a crate of its own so that its arithmetic
//! can be optimised in tests that fly for hours, while the service around it compiles quickly.

pub mod attack;
pub mod ghost;
pub mod ground;
pub mod motion;
pub mod radar;
mod radar_detection;
pub mod random;
pub mod scenario;
pub mod streams;
mod target_state;
pub mod transponder;
mod transponder_report;
