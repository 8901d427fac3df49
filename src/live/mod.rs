//! The live service: the same engine, told the time by the clock.
//!
//! ```text
//! line tasks ──► bounded queue ──► Driver (one thread, one owner) ──► sinks (UDP)      never waited for
//!                                                                └──► Hub: frames, status ──► readers (HTTP, history)
//! ```
//!
//! [`Driver`] is sans-IO: it is handed arrivals and ticks, and hands out what is to be recorded, sent and shown. The
//! recording of what it handled, replayed, gives the same octets.

mod alerts;
mod clock;
mod condition;
mod contests;
mod correlations;
mod driver;
mod health;
mod hub;
mod inputs;
mod lines;
mod losses;
mod observer;
mod player;
mod quiet;
mod registration;
mod service;

pub use alerts::{Alert, AlertKind, Alerts, Change, Severity, Trouble};
pub use clock::{Clock, now};
pub use condition::{Cause, Condition, Facts, Lateness, Level, Punctuality, Reason};
pub use contests::Contested;
pub use correlations::{AllCorrelations, Correlations, Correlator, Denied, Wish};
pub use driver::{Driver, Made};
pub(crate) use health::Health;
pub use health::{LineStatus, SensorState, SensorStatus, Unknown};
pub use hub::{Frame, Hub, HubWriter, Status};
pub use inputs::Inputs;
pub(crate) use lines::{Listening, listen};
pub use observer::observe;
pub use player::{OpenCaptures, Order, Player, PlayerState};
pub use registration::{RegistrationStatus, values};
pub use service::{Outlets, Service};
