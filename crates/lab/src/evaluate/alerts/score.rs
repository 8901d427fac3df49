//! Score of a flight's alerts.

use std::collections::BTreeMap;

use serde::Serialize;

/// Score of a flight's alerts.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AlertScore {
    /// Duration of the flight, hours.
    pub duration_h: f64,
    /// Number of items.
    pub items: usize,
    /// Number of items in the first two minutes.
    pub items_first_2_min: usize,
    /// Number of items that were critical.
    pub critical: usize,
    /// Items by kind.
    pub kinds: BTreeMap<String, usize>,
    /// Number of items about what another item is or was about less than a minute before.
    pub duplicates: usize,
    /// Number of items without a cause in the truth.
    pub unfounded: usize,
    /// Number of critical items without a cause in the truth.
    pub unfounded_critical: usize,
    /// Events that have to be raised, by kind: `conflict`, a violation of the volume of two aircraft that both report their
    /// positions and heights; `area`; `integrity`, a lie. `conflict-unreported`, a violation with an aircraft that reports no
    /// position or no height, or lies, cannot always be raised: they are not known well enough.
    pub events: BTreeMap<&'static str, EventScore>,
    /// Events that were not raised.
    pub missed: Vec<MissedEvent>,
    /// Items that are duplicates or without a cause.
    pub questionable: Vec<ScoredItem>,
}

/// Events of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EventScore {
    /// Number of events.
    pub events: usize,
    /// Number of these that were raised.
    pub raised: usize,
    /// Mean time from the beginning of an event until it is raised, seconds; negative if it was foreseen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_delay_s: Option<f64>,
    /// Longest such time, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest_delay_s: Option<f64>,
}

/// An event that was not raised.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissedEvent {
    /// Kind of the event.
    pub kind: &'static str,
    /// Ids of the aircraft.
    pub aircraft: Vec<String>,
    /// Beginning, RFC 3339.
    pub begin: String,
}

/// An item of the operator's list.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoredItem {
    /// Id of the alert.
    pub id: String,
    /// Whether it was critical.
    pub is_critical: bool,
    /// Whether another item was about the same.
    pub is_duplicate: bool,
    /// Whether the truth has no cause for it.
    pub is_unfounded: bool,
    /// Text at the end.
    pub text: String,
}

impl AlertScore {
    /// Number of items an operator sees in an hour.
    pub fn items_per_h(&self) -> f64 {
        if self.duration_h > 0.0 { self.items as f64 / self.duration_h } else { 0.0 }
    }
}
