//! Data reported by aircraft, in items shared by several categories.

mod altitude;
mod identity;
mod intent;
mod mode_5;
mod motion;
mod place;
mod register;

pub use altitude::{AltitudeSource, BarometricLevel, FinalAltitude, GeometricHeight, SelectedAltitude};
pub use identity::{AircraftAddress, AircraftIdentification};
pub use intent::{IntentStatus, PointType, TrajectoryPoint, TurnDirection};
pub use mode_5::{FigureOfMerit, XPulses};
pub use motion::{AirSpeed, MagneticHeading, RollAngle};
pub use place::{CoarsePosition, Position};
pub use register::BdsRegister;
