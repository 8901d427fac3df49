//! Filter of one target: estimates position, velocity and covariance from measurements of several sensors, each at its
//! own time. Arrays of fixed size, so that the same input gives the same bytes.
//!
//! | file | what |
//! |---|---|
//! | `motion`, `singer` | motion models: several interacting ones, or one with a correlated acceleration |
//! | `symmetric` | covariances as plain arrays |
//! | `gaussian` | prediction, sequential scalar updates and smoothing of a Gaussian state |
//! | `imm` | interacting multiple models, and the Gaussian that approximates their mixture |
//! | `plane`, `height` | the state over ground and the vertical state, each with the biases of radars |
//! | `errors`, `bias` | a radar's errors, and their persistent part |
//! | `state` | the state at an instant, and its update by a measurement |
//! | `departure` | a transponder's report far from the prediction: flight of the aircraft or jump of the receiver |
//! | `smoother` | measurements in order of time: forward filter, backward smoother |
//! | `measurement`, `target` | measurements and estimated state; the filter of one target with any model |
//!
//! Sources: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (2001),
//! sections 6.3 (nearly constant velocity), 8.2 (Singer), 11.6 (interacting multiple models), 11.7 (coordinated turns),
//! 8.6 (fixed-interval smoothing); M. Rousseau, L. Ratton, T. Fournet, *Multiple sensor tracking in a sense & avoid
//! context*.

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
pub use gaussian::{BiasTransition, Gaussian, LinearMotion};
pub use imm::Mixture;
pub use measurement::{By, Measurement, Owner, StateEstimate};
pub(crate) use motion::speed_factor;
pub use motion::{Course, MODELS, Model, Models};
pub use singer::{Singer, SingerTransition};
pub use symmetric::{Rows, Symmetric, Vector};
pub use target::{Dynamics, TargetFilter};
