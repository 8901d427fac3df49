//! Where an aircraft is, how it moves, and how well that is known: from measurements of several sensors, each at its own
//! time. Sans-IO: no clock, no socket, no randomness; matrices of fixed size, so that the same input gives the same bytes.
//!
//! | file | what |
//! |---|---|
//! | `motion`, `singer` | how drones move between two instants: several models, or one whose acceleration lasts |
//! | `imm` | interacting multiple models, and the one Gaussian that stands for their mixture |
//! | `plane`, `height` | the state over ground, the state above it, each with the radar's slow error |
//! | `slow` | the error of a radar that lasts for a while |
//! | `filter` | measurements in order of their time: forward filter, backward smoother |
//! | `track` | what is measured and what is told of it, whichever the model |
//!
//! Sources: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (2001),
//! sections 6.3 (nearly constant velocity), 8.2 (Singer), 11.6 (interacting multiple models), 11.7 (coordinated turns),
//! 8.6 (fixed-interval smoothing); M. Rousseau, L. Ratton, T. Fournet, *Multiple sensor tracking in a sense & avoid context*.

mod bias;
mod filter;
mod height;
mod imm;
mod motion;
mod plane;
mod singer;
#[cfg(test)]
mod tests;
mod track;

pub use bias::Bias;
pub use motion::{Model, Models};
pub use singer::Singer;
pub use track::{By, Dynamics, LineOfSight, Measurement, Owner, RadarErrors, StateEstimate, TargetFilter};
