//! What flies in a scenario, and what radars and transponders measure of it: true motion, then errors as real sensors have them
//! (`docs/SIMULATION.md`). Nothing is encoded here, and nothing sent.
//!
//! ```text
//! scenario ──► motion ──► radar (sight) ──► detections
//! seed         truth      transponder   ──► reports
//! ```
//!
//! The same [`scenario::Scenario`] and seed give the same numbers. It is a library of its own because it is arithmetic: tests that
//! fly hours of it want it optimised, and the service around it compiled at once.

pub mod attack;
pub mod ground;
pub mod motion;
pub mod radar;
pub mod scenario;
mod sight;
pub mod streams;
pub mod transponder;
