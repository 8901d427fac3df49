//! How large the sensors' errors are: a radar's, learnt from its tracks of aircraft with transponders; and those of each type of
//! transponders.
//!
//! A data sheet is a promise. What a radar does shows in how its plots lie about the curves of the transponders they go with: how
//! much the offset changes from plot to plot tells the white noise, how much it changes over seconds and how far it lies from
//! zero tells the bias and how long that lasts. Sums of squares of such changes and offsets are kept, robustly, and slowly
//! forgotten; the errors are those that explain them best, with the data sheet as what is known beforehand. Without
//! evidence they are the data sheet's.
//!
//! | file | what |
//! |---|---|
//! | `track` | one radar track: straight flight and turns |
//! | `pyramid` | changes between means of successive plots |
//! | `sizes` | how large numbers are, robustly |
//! | `model` | what bias and noise let expect of them |
//! | `axis` | the errors of one axis, fitted |
//! | `range_rate` | a radar's velocities against its own plots |
//! | `velocity` | whether the velocities that the radar tells are of use |
//! | `radar` | all of it, of one radar |
//! | `state` | what outlives a restart |
//! | `noise` | how large the white noise of a transponder's positions is |
//! | `transponders`, `type_state` | what transponders of one type have in common, and what outlives a restart |

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

/// Range (metres), azimuth (milliradians), height (metres).
const AXES: usize = 3;

pub(crate) use noise::{Likelihoods, WhiteNoise, likelihoods};
pub(crate) use radar::RadarLearning;
pub use radar::{LearntAxis, LearntRadar, LearntValue};
pub(crate) use range_rate::{RangeRate, Seen};
pub use state::{LearningState, LearningStateError};
pub(crate) use track::{Compared, TrackLearning};
pub use transponders::LearntType;
pub(crate) use transponders::TypeLearning;
pub use type_state::TypeState;
pub use velocity::{VelocityErrors, VelocityVerdict};
