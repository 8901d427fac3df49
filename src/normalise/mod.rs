//! From what sensors send to reports in one frame and one time.

mod clock;
mod geodesy;
mod normaliser;
mod polar;
mod report;

pub use clock::{nearest_day, on_day, time_of_day_count};
pub use geodesy::{Ecef, Enu, Frame, Geodetic};
pub use normaliser::{Normaliser, Refusal, Refused};
pub use polar::RadarSite;
pub use report::{Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, Service, UasItems};
