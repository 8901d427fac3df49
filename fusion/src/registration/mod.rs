//! How a radar is set up wrongly: estimated from its tracks of drones whose transponder tells where they are. Sans-IO: no
//! clock, no socket, no randomness; matrices of fixed size, so that the same input gives the same bytes.
//!
//! | file | what |
//! |---|---|
//! | `along` | generalised least squares along one radar track |
//! | `qmethod` | bearing and tilts from vectors: Davenport's q-method |
//! | `sums` | what the tracks told, added up and slowly forgotten |
//! | `tracks` | a radar's tracks as they come: which are kept, which rejected, and whether the radar was moved |
//! | `estimate` | what follows from the sums, and how well that is known |
//! | `correction` | what is taken away from a plot |
//! | `state` | what outlives a restart |
//!
//! The frame is east-north-up at the radar. A bias is measured minus true. How it is done: `docs/REGISTRATION.md`.
//!
//! Sources: P. B. Davenport's q-method as G. Fasano et al., *Radar/electro-optical data fusion for non-cooperative UAS sense
//! and avoid*, section 3.2, and *An Innovative Procedure for Calibration of Strapdown Electro-Optical Sensors Onboard Unmanned
//! Air Vehicles* use it; M. D. Shuster, *Maximum likelihood estimation of spacecraft attitude*, J. Astronautical Sciences 37
//! (1989): attitude profile and information; P. J. Huber, *Robust Statistics* (1981).

mod along;
mod correction;
mod estimate;
mod qmethod;
mod state;
mod sums;
#[cfg(test)]
mod tests;
mod tracks;

pub(crate) use along::{Residual, TrackComparison};
pub(crate) use correction::Correction;
pub use estimate::{BiasValue, Misalignment};
pub use state::{RegistrationState, RegistrationStateError};
pub use tracks::{Registration, Taken};

/// What is estimated, in this order: bearing, tilt about east, tilt about north (radians), range, height (metres), time (s).
const PARAMETERS: usize = 6;
const BEARING: usize = 0;
const TILT_EAST: usize = 1;
const TILT_NORTH: usize = 2;
const RANGE: usize = 3;
const HEIGHT: usize = 4;
const TIME: usize = 5;

/// Before anything is measured, one standard deviation each: radars are set up by a compass and a spirit level, and better.
const PRIOR: [f64; PARAMETERS] =
    [5.0_f64.to_radians(), 1.0_f64.to_radians(), 1.0_f64.to_radians(), 20.0, 15.0, 0.2];

/// Known to less than this, a value is of use. None is above half its [`PRIOR`], so it is the tracks that tell it.
const USEFUL: [f64; PARAMETERS] =
    [0.5_f64.to_radians(), 0.25_f64.to_radians(), 0.25_f64.to_radians(), 5.0, 5.0, 0.1];

/// What a plot is compared in: azimuth, range, height.
const AXES: usize = 3;
const AZIMUTH: usize = 0;
/// The parameter that shifts an axis as it is.
const OWN: [usize; AXES] = [BEARING, RANGE, HEIGHT];
