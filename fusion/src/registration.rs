//! A radar's misalignment, estimated from its tracks of drones with a transponder. Matrices have fixed sizes, so that the same
//! input gives the same bytes.
//!
//! | file | content |
//! |---|---|
//! | `parameters` | the estimated parameters and their priors |
//! | `along` | generalised least squares along one radar track |
//! | `qmethod` | bearing and tilts from vectors: Davenport's q-method |
//! | `sums` | information of the tracks, summed with slow decay |
//! | `tracks` | a radar's tracks in order of arrival: kept or rejected, and steps |
//! | `estimate` | misalignment and its covariance, from the sums |
//! | `correction` | the correction of a plot |
//! | `displaced`, `place` | the radar's position, checked |
//! | `mutual` | alignment of radars by aircraft that two of them see |
//! | `camera` | the orientation of a camera |
//! | `delay` | the delay of one type of transponders |
//! | `heights` | constant errors of heights, of radars or transponders |
//! | `creep` | detection of a common rotation of the offsets of several identities |
//! | `guard` | selection of the estimate during such a rotation, and the alarm |
//! | `state` | the state kept across restarts |
//!
//! Positions are [`Enu<AtRadar>`](crate::frames::AtRadar). A bias is measured minus true. The method: `docs/REGISTRATION.md`.
//!
//! Sources: P. B. Davenport's q-method as G. Fasano et al., *Radar/electro-optical data fusion for non-cooperative UAS sense
//! and avoid*, section 3.2, and *An Innovative Procedure for Calibration of Strapdown Electro-Optical Sensors Onboard Unmanned
//! Air Vehicles* use it; M. D. Shuster, *Maximum likelihood estimation of spacecraft attitude*, J. Astronautical Sciences 37
//! (1989): attitude profile and information; P. J. Huber, *Robust Statistics* (1981).

mod along;
mod camera;
mod correction;
mod creep;
mod delay;
mod displaced;
mod estimate;
mod guard;
mod heights;
mod mutual;
mod parameters;
mod place;
mod qmethod;
mod state;
mod sums;
#[cfg(test)]
pub(crate) mod tests;
mod tracks;

pub(crate) use along::{Residual, Sample, TrackComparison};
pub(crate) use camera::{CameraLook, direction, wrapped};
pub use camera::{CameraMisalignment, CameraOrientation};
pub use correction::Correction;
pub(crate) use delay::DelaySums;
pub(crate) use estimate::TimeInformation;
pub use estimate::{BiasValue, Misalignment};
pub use guard::Creep;
pub(crate) use guard::{CreepGuard, GuardResult};
pub(crate) use heights::{HeightAlignment, HeightOffset, HeightSums, height_verdict};
pub use mutual::LearntFromRadars;
pub(crate) use mutual::{MutualAlignment, SharedComparison, SharedLook};
pub use place::Displacement;
pub(crate) use place::PlaceCheck;
pub use qmethod::{DirectionPair, attitude};
pub use state::{RegistrationState, RegistrationStateError};
pub use tracks::{Registration, SampleOutcome};
