//! Errors of the sensors: those of a radar, learnt from its tracks of aircraft with transponders, and those of each
//! transponder type.
//!
//! A data sheet states a radar's errors; the real ones are estimated from the offsets of its plots from the transponders'
//! curves. Changes of the offset between plots give the white noise. Changes over seconds, and the size of the offset,
//! give the bias and its correlation time. Robust sums of squares of such changes and offsets are kept and slowly
//! forgotten. The errors are those that explain them best, with the data sheet as prior. Without evidence they are the
//! data sheet's.
//!
//! | file | what |
//! |---|---|
//! | `track` | one radar track: straight flight and turns |
//! | `pyramid` | changes between means of successive plots |
//! | `sizes` | robust variance of numbers |
//! | `model` | variances expected for given bias and noise |
//! | `axis` | the errors of one axis, fitted |
//! | `range_rate` | a radar's velocities compared with its own plots |
//! | `velocity` | whether a radar's velocities are usable |
//! | `radar` | the evidence and errors of one radar |
//! | `state` | the state saved for a restart |
//! | `noise` | white noise of a transponder's positions |
//! | `transponders`, `type_state` | common errors of transponders of one type, and their state for a restart |

mod axis;
mod model;
mod noise;
mod pyramid;
mod radar;
mod range_rate;
mod sizes;
mod state;
#[cfg(test)]
mod tests;
mod track;
mod transponders;
mod type_state;
mod velocity;

pub(crate) use noise::{Likelihoods, WhiteNoise, likelihoods};
pub(crate) use radar::RadarLearning;
pub use radar::{LearntAxis, LearntRadar, LearntValue};
pub(crate) use range_rate::{RangeRate, RatePlot};
pub use state::{LearningState, LearningStateError};
pub(crate) use track::{ComparedPlot, TrackLearning};
pub use transponders::LearntType;
pub(crate) use transponders::TypeLearning;
pub use type_state::TypeState;
pub use velocity::{VelocityErrors, VelocityVerdict};
