//! Measurement models of all sensors, and a tracker of one aircraft that uses them.
//!
//! A [`Reading`] is the measurement of one sensor at one instant: ranges, angles, range rates, positions or altitudes
//! with the covariance of their noise, and the sensor's position. A [`Tracker`] accepts readings of any sensor in any
//! order of arrival; the filter's state is position and velocity (and, with [`Flight::Singer`], acceleration) in space.
//!
//! | file | what |
//! |---|---|
//! | `quantity` | measured quantities: expected value for a state, and row of the Jacobian |
//! | `reading` | the simultaneous values of a sensor, with their noise |
//! | `sensors` | radar, interrogator of transponders, camera; positions reported by an aircraft |
//! | `update` | update of a Gaussian state by a reading: whitened, one value after another, in Joseph's form |
//! | `flight` | motion models: Singer's acceleration, or constant velocity and turns that interact |
//! | `tracker` | readings in order of time; a late one is filtered at its time |
//!
//! The `operational` module takes plots and transponder reports as positions and does not use this module.
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
pub use quantity::{ExpectedValue, Observer, Quantity, wrapped};
pub use reading::{MeasuredValue, Reading, ReadingOrigin};
pub use sensors::{CameraModel, InterrogatorModel, RadarModel, over_ground};
pub use tracker::{TooOld, Tracker, TrackerEstimate};
