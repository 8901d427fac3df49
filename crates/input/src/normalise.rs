//! Conversion of sensor records to reports in one frame and one time.

mod adsb;
mod barometer;
mod camera;
mod clock;
mod normaliser;
mod polar;
mod refusal;
mod remote_id;
mod service;

pub use barometer::Barometer;
pub use camera::camera_place;
pub use clock::{nearest_day, on_day, time_of_day_count};
pub use normaliser::{Normaliser, undulation_m};
pub use polar::RadarSite;
pub use refusal::{Refusal, Refused};
pub use remote_id::{identity, operator};
pub use service::Service;
