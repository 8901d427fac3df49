//! An alert as JSON: of `/api/v1/alerts`, of the stream, and a line of `replay --alerts`.

use schemars::JsonSchema;
use serde::Serialize;

use super::details::AreaName;
use super::{Acknowledged, Alert, AlertKind, Details, Shelved};
use crate::areas::ZoneKind;
use crate::config::Severity;
use crate::json::rounded;
use crate::names::configured;
use crate::picture::{ReasonName, Rfc3339, StateName, serial_text};
use fusion::Identity;

/// What is wrong, or was.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Alert")]
pub struct AlertJson {
    id: String,
    #[schemars(extend("enum" = configured::<AlertKind>()))]
    kind: &'static str,
    #[schemars(extend("enum" = configured::<Severity>()))]
    severity: &'static str,
    since: Rfc3339,
    /// In words.
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
    /// Part of the service.
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<String>,
    #[serde(flatten)]
    about: About,
    /// Who has seen it; left out while nobody has, and again once it has become worse.
    #[serde(skip_serializing_if = "Option::is_none")]
    acknowledged: Option<AcknowledgedJson>,
    /// Nobody is to be bothered with it for a while.
    #[serde(skip_serializing_if = "Option::is_none")]
    shelved: Option<ShelvedJson>,
    /// Left out while it lasts.
    #[serde(skip_serializing_if = "Option::is_none")]
    until: Option<Rfc3339>,
}

/// That somebody has seen an alert.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
struct AcknowledgedJson {
    /// Who: the name of the token, or what was given.
    by: String,
    at: Rfc3339,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

/// That nobody is to be bothered with an alert.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
struct ShelvedJson {
    /// Who says so: the name of the token, or what was given.
    by: String,
    at: Rfc3339,
    until: Rfc3339,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

impl From<&Acknowledged> for AcknowledgedJson {
    fn from(Acknowledged { by, at, note }: &Acknowledged) -> Self {
        Self { by: by.clone(), at: (*at).into(), note: note.clone() }
    }
}

impl From<&Shelved> for ShelvedJson {
    fn from(Shelved { by, at, until, note }: &Shelved) -> Self {
        Self { by: by.clone(), at: (*at).into(), until: (*until).into(), note: note.clone() }
    }
}

/// What alerts about areas, transponders and conflicts have beside the others.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
struct About {
    /// Serial number of the transponder.
    #[serde(skip_serializing_if = "Option::is_none")]
    identity: Option<String>,
    /// Id of its track.
    #[serde(skip_serializing_if = "Option::is_none")]
    track_id: Option<String>,
    /// Id of the track that radar sees where it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    twin_id: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<StateName>,
    /// What speaks against it; empty where only an operator does.
    #[serde(skip_serializing_if = "Option::is_none")]
    reasons: Option<Vec<ReasonName>>,
    /// How far its positions are off, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    offset_m: Option<f64>,
    /// Ids of the tracks of both aircraft.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tracks: Vec<String>,
    /// Name of the volume that one may enter, or has entered.
    #[serde(skip_serializing_if = "Option::is_none")]
    volume: Option<String>,
    /// Serial numbers of those that fell silent together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    identities: Vec<String>,
    /// Where they were heard last, with 100 m around it.
    #[serde(skip_serializing_if = "Option::is_none")]
    hull: Option<Hull>,
    /// It has ended because a transponder was heard after all, or because it is the twin of one that lies.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    resolved: bool,
    /// The area that the track is in, or about to enter.
    #[serde(skip_serializing_if = "Option::is_none")]
    area: Option<AreaJson>,
    /// The area begins or ends at a height, and nobody knows that of the track.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    height_unknown: bool,
    /// When the track enters if it flies on as it does, seconds; 0: it is inside by now. Left out while it would pass it by,
    /// and enter at a course one standard deviation beside its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    time_to_entry_s: Option<f64>,
    /// The same at the earliest of its course and those one standard deviation beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    earliest_s: Option<f64>,
}

/// An area, as `/api/v1/areas` names it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
struct AreaJson {
    name: String,
    /// Its authority's.
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

/// GeoJSON, RFC 7946.
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
            text: alert.text.clone(),
            sensor: subject(&[AlertKind::Sensor, AlertKind::Registration]),
            track: subject(&[AlertKind::Area, AlertKind::AreaPredicted, AlertKind::Uncooperative]),
            conflict: match &alert.details {
                Details::Conflict { id, .. } => Some(format!("C-{id}")),
                _ => None,
            },
            part: subject(&[AlertKind::Service]),
            about: About::from(&alert.details),
            acknowledged: alert.acknowledged.as_ref().map(AcknowledgedJson::from),
            shelved: alert.shelved.as_ref().map(ShelvedJson::from),
            until: alert.until.map(Rfc3339),
        }
    }
}

impl From<&Details> for About {
    fn from(details: &Details) -> Self {
        let serial = |identity: &Identity| serial_text(*identity);
        match details {
            Details::None => Self::default(),
            Details::Integrity { identity, track_id, twin_id, state, reasons, offset_m } => Self {
                identity: Some(serial(identity)),
                track_id: track_id.clone(),
                twin_id: twin_id.clone(),
                state: Some((*state).into()),
                reasons: Some(ReasonName::all(*reasons)),
                offset_m: *offset_m,
                ..Self::default()
            },
            Details::Jamming { identities, hull } => Self {
                identities: identities.iter().map(serial).collect(),
                hull: Some(Hull { r#type: POLYGON, coordinates: [hull.clone()] }),
                ..Self::default()
            },
            Details::Silent { identity, track_id } | Details::Emergency { identity, track_id } => {
                Self { identity: Some(serial(identity)), track_id: track_id.clone(), ..Self::default() }
            }
            Details::Conflict { tracks, volume, .. } => {
                Self { tracks: tracks.to_vec(), volume: Some(volume.clone()), ..Self::default() }
            }
            Details::Uncooperative { is_resolved } => Self { resolved: *is_resolved, ..Self::default() },
            Details::Area { area, is_height_unknown } => {
                Self { area: Some(area.into()), height_unknown: *is_height_unknown, ..Self::default() }
            }
            Details::AreaPredicted { area, time_to_entry_s, earliest_s } => Self {
                area: Some(area.into()),
                time_to_entry_s: time_to_entry_s.map(|seconds| rounded(seconds, 1)),
                earliest_s: Some(rounded(*earliest_s, 1)),
                ..Self::default()
            },
        }
    }
}
