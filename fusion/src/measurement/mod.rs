//! What any sensor measures of an aircraft, and the tracker of one aircraft by all of them.
//!
//! A [`Reading`] is what one sensor measured at one instant: ranges, angles, range rates, places or altitudes with the
//! covariance of their noise, and where the sensor was. A [`Tracker`] takes readings of any sensor in any order of arrival;
//! the filter's state is position and velocity (and, with [`Flight::Singer`], acceleration) in space.
//!
//! | file | what |
//! |---|---|
//! | `quantity` | what can be measured: its value for a state, and its row of the Jacobian |
//! | `reading` | what a sensor measured at once, with the noise |
//! | `sensors` | radar, interrogator of transponders, camera; positions that an aircraft reports |
//! | `update` | a reading taken into a Gaussian state: whitened, one number after another, in Joseph's form |
//! | `flight` | how aircraft move: Singer's acceleration, or straight on and turns that interact |
//! | `tracker` | readings in order of their time; what comes late is filtered at its time |
//!
//! The rooms of `operational` take plots and transponder reports as positions and do not use this one.
//!
//! Sources: M. Rousseau, L. Ratton, T. Fournet, *Multiple sensor tracking in a sense & avoid context* (ICAS 2010),
//! section 3.2; G. Fasano, D. Accardo, A. E. Tirri, A. Moccia, E. De Lellis, *Radar/electro-optical data fusion for
//! non-cooperative UAS sense and avoid* (2015), section 3.1; Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with
//! Applications to Tracking and Navigation* (2001), sections 7.2 (Joseph's form, sequential updates), 10.3 and 10.5
//! (extended filter, iterated).

mod flight;
mod quantity;
mod reading;
mod sensors;
#[cfg(test)]
mod tests;
mod tracker;
mod update;

pub use flight::{Flight, Turning};
pub use quantity::{Expected, Observer, Quantity, wrapped};
pub use reading::{Measured, Reading, Taken};
pub use sensors::{Camera, Interrogator, Radar, over_ground};
pub use tracker::{Estimate, TooOld, Tracker};
