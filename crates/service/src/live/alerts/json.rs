//! JSON of an alert: in `/api/v1/alerts`, in the event stream, and as a line of `replay --alerts`.

use schemars::JsonSchema;
use serde::Serialize;

use super::details::AreaName;
use super::{Acknowledgement, Alert, AlertDetails, AlertKind, Shelved};
use fusion::Identity;
use input::json::rounded;
use input::names::configured;
use picture::{ReasonName, Rfc3339, StateName, serial_text};
use site::areas::ZoneKind;
use site::config::Severity;

/// An alert, active or ended.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Alert")]
pub struct AlertJson {
    id: String,
    #[schemars(extend("enum" = configured::<AlertKind>()))]
    kind: &'static str,
    #[schemars(extend("enum" = configured::<Severity>()))]
    severity: &'static str,
    since: Rfc3339,
    /// Highest severity so far, if it is not the present one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = configured::<Severity>()))]
    worst: Option<&'static str>,
    /// Text of the alert. It names aircraft as the map does.
    text: String,
    /// Id of the sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensor: Option<String>,
    /// Id of the track.
    #[serde(skip_serializing_if = "Option::is_none")]
    track: Option<String>,
    /// Id of the conflict.
    #[serde(skip_serializing_if = "Option::is_none")]
    conflict: Option<String>,
    /// Affected part of the service.
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<String>,
    #[serde(flatten)]
    about: AlertDetailsJson,
    /// Acknowledgement by an operator. Absent until acknowledged; removed when the severity increases.
    #[serde(skip_serializing_if = "Option::is_none")]
    acknowledged: Option<AcknowledgedJson>,
    /// Shelving by an operator: notifications are suppressed until it expires or is removed.
    #[serde(skip_serializing_if = "Option::is_none")]
    shelved: Option<ShelvedJson>,
    /// End of the alert; absent while it is active.
    #[serde(skip_serializing_if = "Option::is_none")]
    until: Option<Rfc3339>,
    /// The alert has ended, was critical, and waits for an acknowledgement.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    latched: bool,
}

/// Acknowledgement of an alert by an operator.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
struct AcknowledgedJson {
    /// Operator: the name of the API token, or the name given in the request.
    by: String,
    at: Rfc3339,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

/// Shelving of an alert: suppresses its notifications until it expires or is removed.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
struct ShelvedJson {
    /// Operator: the name of the API token, or the name given in the request.
    by: String,
    at: Rfc3339,
    until: Rfc3339,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

impl From<&Acknowledgement> for AcknowledgedJson {
    fn from(Acknowledgement { by, at, note }: &Acknowledgement) -> Self {
        Self { by: by.clone(), at: (*at).into(), note: note.clone() }
    }
}

impl From<&Shelved> for ShelvedJson {
    fn from(Shelved { by, at, until, note }: &Shelved) -> Self {
        Self { by: by.clone(), at: (*at).into(), until: (*until).into(), note: note.clone() }
    }
}

/// Fields of alerts about areas, transponders and conflicts.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
#[schemars(rename = "About")]
struct AlertDetailsJson {
    /// Serial number of the transponder.
    #[serde(skip_serializing_if = "Option::is_none")]
    identity: Option<String>,
    /// Id of the transponder's track.
    #[serde(skip_serializing_if = "Option::is_none")]
    track_id: Option<String>,
    /// Id of the track that radar sees elsewhere, most likely the real aircraft.
    #[serde(skip_serializing_if = "Option::is_none")]
    twin_id: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<StateName>,
    /// Reasons against the transponder; empty if only an operator distrusts it.
    #[serde(skip_serializing_if = "Option::is_none")]
    reasons: Option<Vec<ReasonName>>,
    /// Error of its reported position, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    offset_m: Option<f64>,
    /// How far its heights are above those of radars, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    height_offset_m: Option<f64>,
    /// Ids of the tracks of all aircraft that are in conflict with one another; the pair of the highest level first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tracks: Vec<String>,
    /// Name of the protection volume that is, or is about to be, infringed.
    #[serde(skip_serializing_if = "Option::is_none")]
    volume: Option<String>,
    /// Closest approach of the situation so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    closest: Option<ClosestJson>,
    /// Whether a protection volume is entered now.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    entered: bool,
    /// Serial numbers of the transponders that fell silent together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    identities: Vec<String>,
    /// Area of their last positions, with a margin of 100 m.
    #[serde(skip_serializing_if = "Option::is_none")]
    hull: Option<Hull>,
    /// Ended because a transponder was received after all, or because the drone is the twin of a suspect transponder.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    resolved: bool,
    /// The area that the track is inside, or about to enter.
    #[serde(skip_serializing_if = "Option::is_none")]
    area: Option<AreaJson>,
    /// The area is limited in height, and the track's height is unknown.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    height_unknown: bool,
    /// Time until the track enters on its present course, in seconds; 0 if it is predicted to be inside now. Absent if the
    /// present course misses the area, and only a course one standard deviation beside it enters.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    time_to_entry_s: Option<f64>,
    /// Earliest time to entry, in seconds: on the present course or one standard deviation beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    earliest_s: Option<f64>,
}

/// Closest approach of two aircraft.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
struct ClosestJson {
    at: Rfc3339,
    /// Distance over ground, metres.
    #[schemars(range(min = 0))]
    horizontal_m: f64,
    /// Difference of the heights, metres; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    vertical_m: Option<f64>,
}

/// An area, named as in `/api/v1/areas`.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
struct AreaJson {
    name: String,
    /// Identifier given by the authority.
    #[serde(skip_serializing_if = "Option::is_none")]
    identifier: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = ZoneKind::NAMES))]
    r#type: Option<&'static str>,
}

impl From<&AreaName> for AreaJson {
    fn from(area: &AreaName) -> Self {
        let AreaName { name, identifier, kind } = area;
        Self { name: name.clone(), identifier: identifier.clone(), r#type: kind.map(ZoneKind::name) }
    }
}

/// Type of a GeoJSON geometry.
const POLYGON: &str = "Polygon";

/// GeoJSON polygon (RFC 7946).
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct Hull {
    #[schemars(extend("const" = POLYGON))]
    r#type: &'static str,
    coordinates: [Vec<(f64, f64)>; 1],
}

impl From<&Alert> for AlertJson {
    fn from(alert: &Alert) -> Self {
        let subject = |kinds: &[AlertKind]| kinds.contains(&alert.kind).then(|| alert.subject.clone());
        Self {
            id: alert.name(),
            kind: alert.kind.name(),
            severity: alert.severity.name(),
            since: alert.since.into(),
            worst: (alert.worst != alert.severity).then(|| alert.worst.name()),
            text: alert.text.clone(),
            sensor: subject(&[AlertKind::Sensor, AlertKind::Registration]),
            track: subject(&[AlertKind::Area, AlertKind::AreaPredicted, AlertKind::Uncooperative]),
            conflict: match &alert.details {
                AlertDetails::Conflict { id, .. } => Some(format!("C-{id}")),
                _ => None,
            },
            part: subject(&[AlertKind::Service]),
            about: AlertDetailsJson::from(&alert.details),
            acknowledged: alert.acknowledged.as_ref().map(AcknowledgedJson::from),
            shelved: alert.shelved.as_ref().map(ShelvedJson::from),
            until: alert.until.map(Rfc3339),
            latched: alert.is_latched,
        }
    }
}

impl From<&AlertDetails> for AlertDetailsJson {
    fn from(details: &AlertDetails) -> Self {
        let serial = |identity: &Identity| serial_text(*identity);
        match details {
            AlertDetails::None => Self::default(),
            AlertDetails::Integrity { identity, track_id, twin_id, state, reasons, offset_m } => Self {
                identity: Some(serial(identity)),
                track_id: track_id.clone(),
                twin_id: twin_id.clone(),
                state: Some((*state).into()),
                reasons: Some(ReasonName::all(*reasons)),
                offset_m: *offset_m,
                ..Self::default()
            },
            AlertDetails::Jamming { identities, hull } => Self {
                identities: identities.iter().map(serial).collect(),
                hull: Some(Hull { r#type: POLYGON, coordinates: [hull.clone()] }),
                ..Self::default()
            },
            AlertDetails::Silent { identity, track_id } | AlertDetails::Emergency { identity, track_id } => {
                Self { identity: Some(serial(identity)), track_id: track_id.clone(), ..Self::default() }
            }
            AlertDetails::Height { identity, track_id, offset_m } => Self {
                identity: Some(serial(identity)),
                track_id: track_id.clone(),
                height_offset_m: *offset_m,
                ..Self::default()
            },
            AlertDetails::Conflict { tracks, volume, closest, is_entered, .. } => Self {
                tracks: tracks.clone(),
                volume: Some(volume.clone()),
                closest: Some(ClosestJson {
                    at: closest.at.into(),
                    horizontal_m: rounded(closest.horizontal_m, 1),
                    vertical_m: closest.vertical_m.map(|metres| rounded(metres, 1)),
                }),
                entered: *is_entered,
                ..Self::default()
            },
            AlertDetails::Uncooperative { is_resolved } => Self { resolved: *is_resolved, ..Self::default() },
            AlertDetails::Area { area, is_height_unknown, .. } => {
                Self { area: Some(area.into()), height_unknown: *is_height_unknown, ..Self::default() }
            }
            AlertDetails::AreaPredicted { area, time_to_entry_s, earliest_s, .. } => Self {
                area: Some(area.into()),
                time_to_entry_s: time_to_entry_s.map(|seconds| rounded(seconds, 1)),
                earliest_s: Some(rounded(*earliest_s, 1)),
                ..Self::default()
            },
        }
    }
}
