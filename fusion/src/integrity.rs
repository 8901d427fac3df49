//! Trust in a transponder's identity, and the evidence against it (`operational` profile).
//!
//! A flag moves no position. `docs/INTEGRITY.md` defines the states.

mod assessment;
mod bank;
mod concern;
mod motion;
mod rules;
mod settings;
mod state;
mod trust;

pub use assessment::{Assessment, Evidence, PointIntegrity};
pub(crate) use bank::{HypothesisBank, PersistentErrors, StampDelay, TrackObservation};
pub use concern::Concern;
pub(crate) use motion::{MotionComparison, MotionStep};
pub(crate) use rules::{Finding, Jammed, ReportRules};
pub use settings::{Action, IntegrityRules};
pub use state::{Reason, Reasons, State};
pub use trust::{ActiveOverride, Trust, TrustOverride};
