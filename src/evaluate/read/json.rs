//! Points as JSON: the NDJSON and the GeoJSON of `replay`.

use serde::Deserialize;

use super::cells;
use super::error::FileError;
use crate::evaluate::conflicts::Foreseen;
use crate::evaluate::integrity::Alert;
use crate::evaluate::place::Place;
use crate::evaluate::types::{Flags, OutputPoint, PointSource};
use fusion::conflicts::Level;

/// The fields of a track that are scored (`src/picture/track_json.rs`).
#[derive(Deserialize)]
struct TrackRow {
    time: String,
    source: PointSource,
    track_number: u32,
    lat: f64,
    lng: f64,
    alt_msl: Option<f64>,
    uas_id: Option<UasId>,
    aircraft: Option<Aircraft>,
    #[serde(default)]
    contributors: Vec<Contributor>,
    integrity: Option<String>,
    #[serde(default)]
    reasons: Vec<String>,
    #[serde(default)]
    uncooperative: bool,
}

/// Of a drone's identity one name is there.
#[derive(Deserialize)]
struct UasId {
    serial_number: Option<String>,
    registration_id: Option<String>,
    utm_id: Option<String>,
    specific_session_id: Option<String>,
}

#[derive(Deserialize)]
struct Aircraft {
    icao24: Option<String>,
}

impl TrackRow {
    /// The name of its transponder's identity.
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
enum Contributor {
    Radar {
        sensor: Option<String>,
        track_number: u16,
    },
    Transponder {
        track_number: u32,
    },
    /// Whose point it is the others say.
    Camera,
}

#[derive(Deserialize)]
struct FeatureCollection {
    features: Vec<Feature>,
}

#[derive(Deserialize)]
struct Feature {
    properties: TrackRow,
}

/// The fields of an alert that are scored (`src/live/alerts/json.rs`).
#[derive(Deserialize)]
struct AlertRow {
    id: String,
    kind: String,
    since: String,
    until: Option<String>,
}

/// One object a line: as an alert is raised, changes and ends.
pub(super) fn alerts(name: &str, text: &str) -> Result<Vec<Alert>, FileError> {
    let alert = |(line, number): (&str, u64)| {
        let error = |what: String| FileError::at(name, number, what);
        let AlertRow { id, kind, since, until } = serde_json::from_str(line)
            .map_err(|cause| error(format!("this is no alert as `replay --alerts` writes it: {cause}")))?;
        let time =
            |text: &str| cells::time(text).ok_or_else(|| error(format!("{text:?} is no time in RFC 3339")));
        Ok(Alert { since: time(&since)?, until: until.as_deref().map(time).transpose()?, id, kind })
    };
    let lines = text.lines().zip(1_u64..).filter(|(line, _)| !line.trim().is_empty());
    lines.map(alert).collect()
}

/// The fields of a conflict that are scored (`src/conflicts/json.rs`).
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
    probability: f64,
    miss: Miss,
    relative: Relative,
}

#[derive(Deserialize)]
struct Miss {
    across_m: f64,
    covariance_m2: [[f64; 2]; 2],
}

#[derive(Deserialize)]
struct Relative {
    position_m: [Option<f64>; 3],
    velocity_ms: [Option<f64>; 3],
}

/// One object a line: a pair, a volume and a second; with the name of the volume.
pub(super) fn conflicts(name: &str, text: &str) -> Result<Vec<(String, Foreseen)>, FileError> {
    let conflict = |(line, number): (&str, u64)| {
        let error = |what: String| FileError::at(name, number, what);
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
        let foreseen = Foreseen {
            time,
            is_seen: row.seen.is_none(),
            id: id.transpose()?,
            numbers: [track(&row.a)?, track(&row.b)?],
            level,
            t_cpa_s: row.t_cpa_s,
            probability: row.probability,
            across: (row.miss.across_m, row.miss.covariance_m2[0][0]),
            relative: [row.relative.position_m, row.relative.velocity_ms].map(over_ground),
        };
        Ok((row.volume, foreseen))
    };
    let lines = text.lines().zip(1_u64..).filter(|(line, _)| !line.trim().is_empty());
    lines.map(conflict).collect()
}

/// One object a line, or one feature collection.
pub(super) fn output(name: &str, text: &str) -> Result<Vec<OutputPoint>, FileError> {
    let error = |line: u64, error: &serde_json::Error| {
        let what = format!("this is no track as `replay` writes it: {error}");
        FileError::at(name, line, what)
    };
    // Of a feature collection the name of its type stands in front.
    if text.lines().next().is_some_and(|line| line.contains("\"FeatureCollection\"")) {
        let all: FeatureCollection =
            serde_json::from_str(text).map_err(|cause| error(cause.line() as u64, &cause))?;
        let lines = all.features.into_iter().enumerate();
        // Where it is one of `replay`, the first feature is in the second line.
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

fn point(name: &str, line: u64, mut track: TrackRow) -> Result<OutputPoint, FileError> {
    let time = cells::time(&track.time)
        .ok_or_else(|| FileError::at(name, line, format!("time: {:?} is no time in RFC 3339", track.time)))?;
    if !(-90.0..=90.0).contains(&track.lat) || !(-180.0..=180.0).contains(&track.lng) {
        let what = format!("latitude {} and longitude {} are no place in degrees", track.lat, track.lng);
        return Err(FileError::at(name, line, what));
    }
    let reasons = track.reasons.iter().map(String::as_str);
    let integrity = track.integrity.as_deref().map(|state| cells::integrity(state, reasons)).transpose();
    let integrity = integrity.map_err(|what| FileError::at(name, line, what))?;
    let mut point = OutputPoint {
        time,
        place: Place { latitude_deg: track.lat, longitude_deg: track.lng, altitude_amsl_m: track.alt_msl },
        source: track.source,
        number: track.track_number,
        radar_track: None,
        sensor: None,
        transponder: None,
        identity: None,
        covariance: None,
        flags: Flags { integrity, is_uncooperative: track.uncooperative },
    };
    let mut identity = track.identity();
    for contributor in track.contributors {
        match contributor {
            Contributor::Radar { sensor, track_number } => {
                point.radar_track = Some(track_number);
                point.sensor = sensor;
            }
            Contributor::Transponder { track_number } => {
                point.transponder = Some(track_number);
                point.identity = identity.take();
            }
            Contributor::Camera => {}
        }
    }
    Ok(point)
}
