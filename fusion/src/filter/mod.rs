//! State of one target, position, velocity and covariance, from measurements of several sensors, each at its own time.
//! Arrays of fixed size, so that the same input gives the same bytes.
//!
//! | file | what |
//! |---|---|
//! | `motion`, `singer` | how drones move between two instants: several models, or one whose acceleration lasts |
//! | `symmetric` | covariances as plain arrays |
//! | `gaussian` | a state that moves and is observed, one number after another; the way back to it |
//! | `imm` | interacting multiple models, and the one Gaussian that stands for their mixture |
//! | `plane`, `height` | the state over ground, the state above it, each with the biases of radars |
//! | `errors`, `bias` | a radar's errors; the part of them that lasts for a while |
//! | `state` | what is known at an instant, and what a measurement adds |
//! | `departure` | a transponder far from where the motion led: did the aircraft fly there, or did its receiver jump? |
//! | `smoother` | measurements in order of their time: forward filter, backward smoother |
//! | `measurement`, `target` | measurements and state; the filter of one target, whichever the model |
//!
//! Sources: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (2001),
//! sections 6.3 (nearly constant velocity), 8.2 (Singer), 11.6 (interacting multiple models), 11.7 (coordinated turns),
//! 8.6 (fixed-interval smoothing); M. Rousseau, L. Ratton, T. Fournet, *Multiple sensor tracking in a sense & avoid context*.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over small arrays by their index are unrolled in every build; iterators leave calls"
)]

mod bias;
mod departure;
mod errors;
mod gaussian;
mod height;
mod imm;
mod measurement;
mod motion;
mod plane;
mod singer;
mod smoother;
mod state;
mod symmetric;
mod target;
#[cfg(test)]
mod tests;

pub use bias::{Bias, Moments};
pub use errors::{LineOfSight, RadarErrors};
pub(crate) use gaussian::{Gaussian, Motion, Slow};
pub(crate) use imm::Mixture;
pub use measurement::{By, Measurement, Owner, StateEstimate};
pub(crate) use motion::{Course, MODELS, speed_factor};
pub use motion::{Model, Models};
pub(crate) use singer::Axis;
pub use singer::Singer;
pub(crate) use symmetric::{Rows, Symmetric, Vector};
pub use target::{Dynamics, TargetFilter};
#[cfg(test)]
pub(crate) use tests::{noise_of, transition_of};
