//! From what sensors send to reports in one frame and one time.

mod clock;
mod normaliser;
mod polar;
mod service;

pub use clock::{nearest_day, on_day, time_of_day_count};
pub use normaliser::{Normaliser, Refusal, Refused};
pub use polar::RadarSite;
pub use service::Service;
