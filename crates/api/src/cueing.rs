//! `/api/v1/cueing`: directions in which cameras should look next.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::conflicts::latest;
use super::problem::Problem;
use super::request::ApiRequest;
use conflict::Level;
use fusion::frames::{AtRadar, Geodetic, TangentPlane};
use fusion::integrity::State;
use fusion::operational::OrientedCamera;
use input::json::rounded;
use picture::{PictureTrack, Rfc3339};
use site::config::Sensor;

/// Default number of targets for each camera.
const TARGETS: usize = 10;
/// Maximum number of targets for each camera.
const MAX_TARGETS: usize = 100;

/// Reason to look at an aircraft, the most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CueReason {
    /// Another aircraft is within the volume.
    Violation,
    /// Another aircraft comes near.
    Warning,
    /// No transponder is heard where one would be.
    Uncooperative,
    /// Evidence contradicts the transponder.
    Untrusted,
    /// Only radars see it.
    Unidentified,
}

fusion::interface_names!(CueReason {
    Violation = "violation",
    Warning = "warning",
    Uncooperative = "uncooperative",
    Untrusted = "untrusted",
    Unidentified = "unidentified",
});

/// Aircraft that cameras should look at, with their directions.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Cueing")]
pub struct CueList {
    /// Time of the positions. Present time if there is no picture.
    time: Rfc3339,
    /// Configured cameras.
    cameras: Vec<CameraCues>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CameraCues")]
struct CameraCues {
    /// Id of the camera.
    sensor: String,
    /// Whether the orientation of the camera is known. If so, `stated_azimuth_deg` and `stated_elevation_deg` allow for it.
    oriented: bool,
    /// Targets, the most urgent first, then the nearest.
    targets: Vec<Cue>,
}

/// Direction of an aircraft from a camera. Azimuths are clockwise from north.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Cue")]
struct Cue {
    /// Id of the track.
    track: String,
    /// Name of the track on the map.
    name: String,
    #[schemars(extend("enum" = CueReason::NAMES))]
    reason: &'static str,
    #[schemars(range(min = 0, max = 360))]
    azimuth_deg: f64,
    /// Elevation above the horizontal; absent if no height is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    elevation_deg: Option<f64>,
    /// Standard deviation of the azimuth.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    azimuth_deviation_deg: Option<f64>,
    /// Standard deviation of the elevation.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    elevation_deviation_deg: Option<f64>,
    /// Azimuth in the camera's own axes, as it states bearings.
    #[schemars(range(min = 0, max = 360))]
    stated_azimuth_deg: f64,
    /// Elevation in the camera's own axes; absent if no height is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    stated_elevation_deg: Option<f64>,
    #[schemars(range(min = 0))]
    distance_m: f64,
}

/// Cues for all cameras, or for that of `?sensor=`.
pub fn cues(request: &ApiRequest) -> Result<CueList, Problem> {
    let hub = &request.state.hub;
    let rule = format!("a whole number from 1 to {MAX_TARGETS}");
    let limit =
        request.query.value("limit", &rule, |limit| (1..=MAX_TARGETS).contains(limit))?.unwrap_or(TARGETS);
    let wanted = request.query.text("sensor");
    let cameras = || hub.config.sensors.iter().enumerate().filter(|(_, sensor)| sensor.kind.is_camera());
    if wanted.is_some_and(|id| !cameras().any(|(_, sensor)| sensor.id == id)) {
        return Err(Problem::parameter("sensor", "the id of a camera"));
    }
    let status = hub.status();
    let published = hub.latest();
    let predicted = published.as_ref().and_then(|published| published.now.get());
    let picture = predicted.as_deref().or(published.as_ref().map(|published| &published.picture));
    let conflicts = conflict_levels(request);
    let mut tracks: Vec<(CueReason, &PictureTrack)> = picture
        .into_iter()
        .flat_map(|picture| picture.within(hub.config.output.max_accuracy_m))
        .filter_map(|track| {
            let level = conflicts.get(&hub.maker.track_id(track)).copied();
            Some((reason(track, level)?, track))
        })
        .collect();
    tracks.sort_by_key(|(reason, _)| *reason);
    let of_camera = |(index, sensor): (usize, &Sensor)| {
        let oriented = status.as_ref().and_then(|status| status.sensors.get(index)?.orientation);
        let (latitude_deg, longitude_deg, height_amsl_m) = sensor.kind.place()?;
        let height_m = height_amsl_m + hub.maker.geoid_undulation_m();
        let plane =
            TangentPlane::<AtRadar>::at(Geodetic::from_degrees(latitude_deg, longitude_deg, height_m));
        let mut targets: Vec<(CueReason, Cue)> = tracks
            .iter()
            .map(|&(reason, track)| {
                let id = hub.maker.track_id(track);
                (reason, cue((id, reason, track), &plane, oriented.as_ref()))
            })
            .collect();
        targets.sort_by(|(reason, one), (other_reason, other)| {
            reason.cmp(other_reason).then(one.distance_m.total_cmp(&other.distance_m))
        });
        Some(CameraCues {
            sensor: sensor.id.clone(),
            oriented: oriented.is_some_and(|oriented| oriented.orientation.misalignment().bearing.observable),
            targets: targets.into_iter().take(limit).map(|(_, cue)| cue).collect(),
        })
    };
    let shown = cameras().filter(|(_, sensor)| wanted.is_none_or(|id| sensor.id == id));
    Ok(CueList {
        time: picture.map_or_else(|| request.state.now(), |picture| picture.time).into(),
        cameras: shown.filter_map(of_camera).collect(),
    })
}

/// Highest level of each track in a conflict; empty if conflicts are not computed.
fn conflict_levels(request: &ApiRequest) -> BTreeMap<String, Level> {
    let mut levels = BTreeMap::new();
    for conflict in latest(request).iter().flat_map(|outlook| &outlook.conflicts) {
        let Some(level) = conflict.level() else { continue };
        for track in &conflict.tracks {
            let known = levels.entry(track.clone()).or_insert(level);
            *known = (*known).max(level);
        }
    }
    levels
}

/// Reason to look at a track; `None`: there is none.
fn reason(track: &PictureTrack, level: Option<Level>) -> Option<CueReason> {
    let is_doubted = track.point.integrity.is_some_and(|known| known.state >= State::Suspect);
    match level {
        Some(Level::Violation) => Some(CueReason::Violation),
        Some(Level::Warning) => Some(CueReason::Warning),
        _ if track.is_uncooperative => Some(CueReason::Uncooperative),
        _ if is_doubted => Some(CueReason::Untrusted),
        _ if track.point.source.transponder().is_none() => Some(CueReason::Unidentified),
        _ => None,
    }
}

/// Direction of a track from a camera at the origin of `plane`.
fn cue(
    (id, reason, track): (String, CueReason, &PictureTrack),
    plane: &TangentPlane<AtRadar>,
    oriented: Option<&OrientedCamera>,
) -> Cue {
    let there = plane.from_geodetic(track.position).0;
    let ground_m = there.xy().norm();
    let has_height = track.altitude_amsl_m.is_some();
    let (azimuth, elevation) = (there.x.atan2(there.y), there.z.atan2(ground_m));
    let [stated_azimuth, stated_elevation] =
        oriented.map_or([azimuth, elevation], |camera| camera.orientation.stated([azimuth, elevation]));
    let degrees = |radians: f64| rounded(radians.to_degrees(), 2);
    let clockwise = |radians: f64| rounded(radians.to_degrees().rem_euclid(360.0), 2);
    let estimate = track.point.estimate.as_ref();
    let azimuth_deviation =
        estimate.map(|estimate| (estimate.sigma_m() / ground_m.max(1.0)).min(std::f64::consts::PI));
    let elevation_deviation = estimate
        .map(|estimate| (estimate.vertical_m2.sqrt() / there.norm().max(1.0)).min(std::f64::consts::PI));
    Cue {
        track: id,
        name: track.name.clone(),
        reason: reason.name(),
        azimuth_deg: clockwise(azimuth),
        elevation_deg: has_height.then(|| degrees(elevation)),
        azimuth_deviation_deg: azimuth_deviation.map(degrees),
        elevation_deviation_deg: elevation_deviation.filter(|_| has_height).map(degrees),
        stated_azimuth_deg: clockwise(stated_azimuth),
        stated_elevation_deg: has_height.then(|| degrees(stated_elevation)),
        distance_m: rounded(there.norm(), 1),
    }
}
