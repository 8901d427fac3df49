//! The live service: the engine, driven by the clock.
//!
//! ```text
//! line tasks ──► bounded queue ──► Driver (one thread, one owner) ──► sinks (UDP)      never waited for
//!                                                                └──► Hub: pictures, status ──► readers (HTTP, archive)
//! ```
//!
//! [`Driver`] is sans-IO: arrivals and ticks in, what is to be recorded, sent and shown out. The recording of what it
//! handled, replayed, gives the same octets.

mod alert_desk;
mod alerts;
mod clock;
mod condition;
mod contests;
mod correlations;
mod doors;
mod driver;
mod health;
mod hub;
mod inputs;
mod integrity;
mod learning;
mod lines;
mod losses;
mod members;
mod observer;
mod outlooks;
mod player;
mod posts;
mod published;
mod quiet;
mod registration;
mod requests;
mod service;
mod state_troubles;
mod timings;

pub use alert_desk::{AlertDesk, AlertRecords};
pub use alerts::{
    Acknowledged, Ahead, Alert, AlertJson, AlertKind, AlertSettings, AlertWish, Alerts, AreaName, Change,
    Details, NotDone, Severity, Shelved, Trouble, UnknownArea, Wanted,
};
pub use clock::{Clock, now};
pub use condition::{Cause, Condition, Facts, Lateness, Level, Punctuality, Reason};
pub use contests::Contested;
pub use correlations::{Correlations, Correlator, Named, Wish};
pub use driver::{Driver, Made};
pub(crate) use health::Health;
pub use health::{LineStatus, SensorState, SensorStatus, Unknown};
pub use hub::{Hub, HubWriter};
pub use inputs::Inputs;
pub use integrity::{Integrities, IntegrityDesk, IntegrityRequests, Saying};
pub use learning::{
    VelocityUse, in_words, make_and_model, of_data_sheet, type_in_words, type_name, velocity_errors,
};
pub(crate) use lines::{Listening, listen};
pub(crate) use losses::Losses;
#[cfg(feature = "cluster")]
pub(crate) use members::milliseconds;
pub use members::{
    CellState, ClockDifference, ClockSource, ClockStanding, GatewayState, Members, NodePart, NodeState,
};
pub use observer::observe;
pub use outlooks::{OutlookWriter, Outlooks};
pub use player::{OpenCaptures, Order, Player, PlayerState};
pub use posts::{NotPosted, Posted, Posts};
pub use published::{Archive, Fleeting, Followers, Messenger, Outgoing, PublishedPicture, Status};
pub use registration::{RegistrationStatus, values};
pub use requests::{Denied, Operators};
pub use service::{Decision, KeeperQueues, Outlets, Seen, SeenCounts, Service, Viewer, decisions};
pub use state_troubles::state_troubles;
pub use timings::{Histogram, Timings};
