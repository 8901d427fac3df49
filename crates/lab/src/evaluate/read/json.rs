//! Reads points as JSON: the NDJSON and the GeoJSON of `replay`.

use serde::Deserialize;

use super::cells;
use super::error::InputFileError;
use crate::evaluate::conflicts::ConflictPrediction;
use crate::evaluate::integrity::AlertLine;
use crate::evaluate::place::GeodeticPlace;
use crate::evaluate::types::{OutputPoint, PointFlags, PointSource};
use conflict::Level;

/// Fields of a track that are scored (`crates/picture/src/track_json.rs`).
#[derive(Deserialize)]
struct TrackRow {
    time: String,
    source: PointSource,
    track_number: u32,
    lat: f64,
    lng: f64,
    alt_msl: Option<f64>,
    uas_id: Option<UasIdRow>,
    aircraft: Option<AircraftRow>,
    #[serde(default)]
    contributors: Vec<ContributorRow>,
    integrity: Option<String>,
    #[serde(default)]
    reasons: Vec<String>,
    #[serde(default)]
    uncooperative: bool,
}

/// Identity of a drone; one of the names is present.
#[derive(Deserialize)]
struct UasIdRow {
    serial_number: Option<String>,
    registration_id: Option<String>,
    utm_id: Option<String>,
    specific_session_id: Option<String>,
}

#[derive(Deserialize)]
struct AircraftRow {
    icao24: Option<String>,
}

impl TrackRow {
    /// Name of the transponder's identity.
    fn identity(&mut self) -> Option<String> {
        let of_drone = self
            .uas_id
            .take()
            .and_then(|id| id.serial_number.or(id.registration_id).or(id.utm_id).or(id.specific_session_id));
        of_drone.or_else(|| self.aircraft.take()?.icao24)
    }
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum ContributorRow {
    Radar {
        sensor: Option<String>,
        track_number: u16,
    },
    Transponder {
        track_number: u32,
    },
    /// A camera; the other contributors determine the drone.
    Camera,
}

#[derive(Deserialize)]
struct FeatureCollection {
    features: Vec<FeatureRow>,
}

#[derive(Deserialize)]
struct FeatureRow {
    properties: TrackRow,
}

/// Fields of an alert that are scored (`crates/service/src/live/alerts/json.rs`).
#[derive(Deserialize)]
struct AlertRow {
    id: String,
    kind: String,
    since: String,
    until: Option<String>,
    #[serde(default)]
    severity: String,
    #[serde(default)]
    text: String,
    track: Option<String>,
    track_id: Option<String>,
    #[serde(default)]
    tracks: Vec<String>,
    identity: Option<String>,
    area: Option<AreaRow>,
}

#[derive(Deserialize)]
struct AreaRow {
    name: String,
}

/// Reads alerts, one object per line, written when an alert is raised, changes or ends.
pub(super) fn alerts(name: &str, text: &str) -> Result<Vec<AlertLine>, InputFileError> {
    let alert = |(line, number): (&str, u64)| {
        let error = |what: String| InputFileError::at(name, number, what);
        let row: AlertRow = serde_json::from_str(line)
            .map_err(|cause| error(format!("this is no alert as `replay --alerts` writes it: {cause}")))?;
        let time =
            |text: &str| cells::time(text).ok_or_else(|| error(format!("{text:?} is no time in RFC 3339")));
        let mut tracks = row.tracks;
        tracks.extend(row.track.or(row.track_id));
        Ok(AlertLine {
            since: time(&row.since)?,
            until: row.until.as_deref().map(time).transpose()?,
            id: row.id,
            kind: row.kind,
            is_critical: row.severity == "critical",
            tracks,
            identity: row.identity,
            area: row.area.map(|area| area.name),
            text: row.text,
        })
    };
    let lines = text.lines().zip(1_u64..).filter(|(line, _)| !line.trim().is_empty());
    lines.map(alert).collect()
}

/// Fields of a conflict that are scored (`crates/picture/src/conflicts/json.rs`).
#[derive(Deserialize)]
struct ConflictRow {
    id: Option<String>,
    time: String,
    seen: Option<String>,
    a: String,
    b: String,
    volume: String,
    level: String,
    t_cpa_s: f64,
    /// Absent in lines of older versions.
    t_entry_s: Option<f64>,
    probability: f64,
    miss: MissRow,
    relative: RelativeRow,
}

#[derive(Deserialize)]
struct MissRow {
    across_m: f64,
    covariance_m2: [[f64; 2]; 2],
}

#[derive(Deserialize)]
struct RelativeRow {
    position_m: [Option<f64>; 3],
    velocity_ms: [Option<f64>; 3],
}

/// Reads conflicts, one object per line for a pair, a volume and a second. Returns each with the name of the volume.
pub(super) fn conflicts(name: &str, text: &str) -> Result<Vec<(String, ConflictPrediction)>, InputFileError> {
    let conflict = |(line, number): (&str, u64)| {
        let error = |what: String| InputFileError::at(name, number, what);
        let row: ConflictRow = serde_json::from_str(line).map_err(|cause| {
            error(format!("this is no conflict as `replay --conflicts` writes it: {cause}"))
        })?;
        let time = cells::time(&row.time)
            .ok_or_else(|| error(format!("time: {:?} is no time in RFC 3339", row.time)))?;
        let track = |id: &str| {
            let number = id.strip_prefix("U-").and_then(|rest| rest.split('-').next()?.parse().ok());
            number.ok_or_else(|| error(format!("{id:?} is no track of the operational profile")))
        };
        let number = |text: &str| text.strip_prefix("C-").and_then(|number| number.parse().ok());
        let id = row
            .id
            .as_deref()
            .map(|id| number(id).ok_or_else(|| error(format!("{id:?} is no id of a conflict"))));
        let level = Level::ALL.into_iter().find(|level| level.name() == row.level);
        if level.is_none() && row.level != "none" {
            return Err(error(format!("{:?} is no level of a conflict", row.level)));
        }
        let over_ground = |[east, north, _]: [Option<f64>; 3]| [east, north].map(Option::unwrap_or_default);
        let foreseen = ConflictPrediction {
            time,
            is_seen: row.seen.is_none(),
            id: id.transpose()?,
            numbers: [track(&row.a)?, track(&row.b)?],
            level,
            t_cpa_s: row.t_cpa_s,
            t_entry_s: row.t_entry_s.unwrap_or(row.t_cpa_s),
            probability: row.probability,
            across: (row.miss.across_m, row.miss.covariance_m2[0][0]),
            relative: [row.relative.position_m, row.relative.velocity_ms].map(over_ground),
        };
        Ok((row.volume, foreseen))
    };
    let lines = text.lines().zip(1_u64..).filter(|(line, _)| !line.trim().is_empty());
    lines.map(conflict).collect()
}

/// Reads one object per line, or one feature collection.
pub(super) fn output(name: &str, text: &str) -> Result<Vec<OutputPoint>, InputFileError> {
    let error = |line: u64, error: &serde_json::Error| {
        let what = format!("this is no track as `replay` writes it: {error}");
        InputFileError::at(name, line, what)
    };
    // The first line of a feature collection contains its type.
    if text.lines().next().is_some_and(|line| line.contains("\"FeatureCollection\"")) {
        let all: FeatureCollection =
            serde_json::from_str(text).map_err(|cause| error(cause.line() as u64, &cause))?;
        let lines = all.features.into_iter().enumerate();
        // In a feature collection of `replay`, the first feature is in the second line.
        return lines.map(|(index, feature)| point(name, index as u64 + 2, feature.properties)).collect();
    }
    let lines = text.lines().zip(1_u64..).filter(|(line, _)| !line.trim().is_empty());
    lines
        .map(|(line, number)| {
            let track: TrackRow = serde_json::from_str(line).map_err(|cause| error(number, &cause))?;
            point(name, number, track)
        })
        .collect()
}

fn point(name: &str, line: u64, mut track: TrackRow) -> Result<OutputPoint, InputFileError> {
    let time = cells::time(&track.time).ok_or_else(|| {
        InputFileError::at(name, line, format!("time: {:?} is no time in RFC 3339", track.time))
    })?;
    if !(-90.0..=90.0).contains(&track.lat) || !(-180.0..=180.0).contains(&track.lng) {
        let what = format!("latitude {} and longitude {} are no place in degrees", track.lat, track.lng);
        return Err(InputFileError::at(name, line, what));
    }
    let reasons = track.reasons.iter().map(String::as_str);
    let integrity = track.integrity.as_deref().map(|state| cells::integrity(state, reasons)).transpose();
    let integrity = integrity.map_err(|what| InputFileError::at(name, line, what))?;
    let mut point = OutputPoint {
        time,
        place: GeodeticPlace {
            latitude_deg: track.lat,
            longitude_deg: track.lng,
            altitude_amsl_m: track.alt_msl,
        },
        source: track.source,
        number: track.track_number,
        radar_track: None,
        sensor: None,
        transponder: None,
        identity: None,
        covariance: None,
        flags: PointFlags { integrity, is_uncooperative: track.uncooperative },
    };
    let mut identity = track.identity();
    for contributor in track.contributors {
        match contributor {
            ContributorRow::Radar { sensor, track_number } => {
                point.radar_track = Some(track_number);
                point.sensor = sensor;
            }
            ContributorRow::Transponder { track_number } => {
                point.transponder = Some(track_number);
                point.identity = identity.take();
            }
            ContributorRow::Camera => {}
        }
    }
    Ok(point)
}
