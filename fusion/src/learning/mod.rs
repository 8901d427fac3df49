//! How large a radar's errors are, learnt from its tracks of aircraft with transponders.
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

mod axis;
mod model;
mod pyramid;
mod radar;
mod range_rate;
mod sizes;
mod state;
#[cfg(test)]
mod tests;
mod track;
mod velocity;

/// Range (metres), azimuth (milliradians), height (metres).
const AXES: usize = 3;

pub(crate) use radar::RadarLearning;
pub use radar::{LearntAxis, LearntRadar, LearntValue};
pub(crate) use range_rate::{RangeRate, Seen};
pub use state::{LearningState, LearningStateError};
pub(crate) use track::{Compared, TrackLearning};
pub use velocity::{VelocityErrors, VelocityVerdict};
