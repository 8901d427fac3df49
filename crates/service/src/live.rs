//! The live service: the engine, driven by the clock.
//!
//! ```text
//! line tasks ──► bounded queue ──► Driver (one thread, one owner) ──► sinks (UDP)      never waited for
//!                                                                └──► Hub: pictures, status ──► readers (HTTP, archive)
//! ```
//!
//! [`Driver`] is sans-IO: it takes arrivals and ticks, and returns what is to be recorded, sent and shown. A replay of its
//! recording gives the same octets.

mod alert_requests;
mod alerts;
mod condition;
mod conflict_reports;
mod connections;
mod contests;
mod correlations;
mod driver;
mod health;
mod http_input;
mod hub;
mod integrity;
mod learning;
mod lines;
mod members;
mod observer;
mod ongoing_losses;
mod player;
mod published;
mod recent_reports;
mod registration;
mod relocations;
mod requests;
mod service;
mod state_troubles;
mod timings;
mod warning_limiter;
mod zone_requests;

pub use crate::clock::{WallClock, now};
pub use alert_requests::{AlertRecordQueue, AlertRequests};
pub use alerts::{
    Acknowledgement, Alert, AlertAction, AlertChange, AlertDetails, AlertJson, AlertKind, AlertMonitor,
    AlertRequest, AlertRequestError, AlertSettings, AreaName, PredictionPicture, ServiceFault, Severity,
    Shelved, UnknownArea,
};
pub use condition::{
    Condition, ConditionInputs, ConditionReason, LatenessCause, PictureLateness, Punctuality, ServiceLevel,
};
pub use conflict_reports::{ConflictPublisher, ConflictReports};
pub use contests::Contested;
pub use correlations::{CorrelationRequest, CorrelationRequestQueue, CorrelationRequests, TransponderName};
pub use driver::{Driver, DriverEvent};
pub use health::SensorMonitor;
pub use health::{LineStatus, SensorState, SensorStatus, UnconfiguredSource};
pub use http_input::{HttpInput, PostError, PostResult};
pub use hub::{Hub, HubWriter};
pub use integrity::{TrustAssessments, TrustRequest, TrustRequestQueue, TrustRequests};
pub use learning::{
    VelocityUse, in_words, make_and_model, of_data_sheet, type_in_words, type_name, velocity_errors,
};
pub use lines::{Listening, listen};
pub use members::milliseconds;
pub use members::{
    CellState, ClockDifference, ClockSource, ClockStanding, ClusterMembers, GatewayState, NodePart, NodeState,
};
pub use observer::observe;
pub(crate) use ongoing_losses::OngoingLosses;
pub use player::{OpenCaptures, Player, PlayerState, ReplayCommand};
pub use published::{Archive, Followers, Messenger, Outgoing, PresentPicture, PublishedPicture, Status};
pub use recent_reports::RecentReports;
pub use registration::{PlaceStatus, RelocatedRadar};
pub use registration::{RegistrationStatus, values};
pub use relocations::{RelocationRequest, RelocationRequestQueue, RelocationRequests};
pub use requests::{RequestError, RequestSender};
pub use service::{
    KeeperQueues, LiveService, OperatorDecision, Outlets, Viewer, ViewerCounts, ViewerInput, decisions,
};
pub use state_troubles::state_troubles;
pub use timings::{DurationHistogram, SlotTimings};
pub use zone_requests::{
    OperatorZones, PendingZoneRequest, ZoneAction, ZoneRequest, ZoneRequestError, ZoneRequests,
};
