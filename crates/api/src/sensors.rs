//! Sensors, coverage and areas.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::geometry::{CollectionType, Feature, Point};
use super::ground::{AreaCollection, area_collection, kind};
use super::learnt::{Learnt, LearntTypeJson};
use super::problem::Problem;
use super::request::{ApiRequest, ApiResult, GEO_JSON, live};
use fusion::operational::OrientedCamera;
use fusion::operational::Relocation;
use fusion::registration::{BiasValue, Misalignment};
use input::json::rounded;
use input::names::configured;
use input::pipeline::ContestReason;
use picture::{Rfc3339, serial_text};
use service::live::{
    Contested, LineStatus, PlaceStatus, RegistrationStatus, RelocatedRadar, SensorState, SensorStatus,
    UnconfiguredSource, ZoneRequests, values,
};
use site::config::{self, Sensor, SensorKind};

/// Sensors as GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Sensors")]
pub struct SensorCollection {
    r#type: CollectionType,
    unknown: Vec<UnknownSource>,
    features: Vec<Feature<'static, Option<Point>, SensorProperties>>,
    /// Time of the sensors' states.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
}

/// A source that is not a configured sensor.
#[derive(Serialize, JsonSchema)]
struct UnknownSource {
    category: u8,
    sac: u8,
    sic: u8,
    /// Whether it is the service's own output.
    own: bool,
    records: u64,
    last_seen: Rfc3339,
}

impl From<&UnconfiguredSource> for UnknownSource {
    fn from(unknown: &UnconfiguredSource) -> Self {
        let UnconfiguredSource { category, source, own, records, last_seen } = *unknown;
        Self { category, sac: source.sac, sic: source.sic, own, records, last_seen: last_seen.into() }
    }
}

/// Properties of a sensor. Unknown values are left out.
#[derive(Serialize, JsonSchema)]
pub struct SensorProperties {
    /// Configured id.
    id: String,
    #[schemars(extend("enum" = configured::<SensorKind>()))]
    kind: &'static str,
    #[serde(flatten)]
    status: Option<SensorStatusJson>,
}

/// Values from the status of a sensor.
#[derive(Serialize, JsonSchema)]
struct SensorStatusJson {
    sac: u8,
    sic: u8,
    #[schemars(extend("enum" = SensorState::NAMES))]
    state: &'static str,
    /// Reasons why the sensor is not operational.
    reasons: Vec<String>,
    /// Reports per second, averaged over the last 10 s.
    #[schemars(range(min = 0))]
    rate_hz: f64,
    accepted: u64,
    /// Number of records without a report, by reason.
    refused: BTreeMap<&'static str, u64>,
    lines: Vec<InputCounters>,
    /// Time of its last record of any kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_seen: Option<Rfc3339>,
    /// Minimum delay of recent reports from their time to their reception, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    clock_offset_s: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contested: Vec<ContestedJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    registration: Option<RegistrationJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation: Option<OrientationJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    learnt: Option<Learnt>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    transponder_types: Vec<LearntTypeJson>,
}

/// Counters of a UDP input: a multicast group or an address.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Line")]
struct InputCounters {
    name: String,
    joined: bool,
    received: u64,
    duplicates: u64,
    foreign: u64,
    queue_full: u64,
    kernel_dropped: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    last_received: Option<Rfc3339>,
    /// Number of messages that a connection could not translate, by reason.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    untranslated: BTreeMap<&'static str, u64>,
}

impl From<&LineStatus> for InputCounters {
    fn from(line: &LineStatus) -> Self {
        let &LineStatus {
            joined,
            received,
            duplicates,
            foreign,
            queue_full,
            kernel_dropped,
            last_received,
            ..
        } = line;
        let (name, last_received) = (line.name.clone(), last_received.map(Rfc3339));
        let untranslated = line.untranslated.iter().copied().filter(|(_, count)| *count > 0).collect();
        Self {
            name,
            joined,
            received,
            duplicates,
            foreign,
            queue_full,
            kernel_dropped,
            last_received,
            untranslated,
        }
    }
}

/// A sender that is refused because another one uses the SAC/SIC of a sensor.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Contested")]
struct ContestedJson {
    /// Address and port of the accepted sender. Port 0 stands for the host named by `source`.
    counts: String,
    /// Address and port of the refused sender.
    refused: String,
    /// `other_sender`: the accepted sender was received first. `foreign_source`: the refused one is not a host that the sensor's
    /// inputs name as `source`.
    #[schemars(extend("enum" = ContestReason::NAMES))]
    reason: &'static str,
    /// Serial numbers of the transponders that both senders report.
    transponders: Vec<String>,
}

impl From<&Contested> for ContestedJson {
    fn from(contested: &Contested) -> Self {
        let Contested { counts, refused, reason, transponders } = contested;
        let transponders = transponders.iter().map(|identity| serial_text(*identity)).collect();
        Self { counts: counts.to_string(), refused: refused.to_string(), reason: reason.name(), transponders }
    }
}

/// Misalignment of a radar, estimated from its tracks. Operational profile only; without values if the estimation is off.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Registration")]
struct RegistrationJson {
    #[schemars(extend("enum" = configured::<config::Registration>()))]
    mode: &'static str,
    /// Whether plots are corrected by any of the values.
    applied: bool,
    #[serde(flatten)]
    estimate: Option<RegistrationEstimate>,
    /// Advice to the operator if the estimate is doubtful.
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<String>,
    /// Advice to the operator after a step; present for an hour.
    #[serde(skip_serializing_if = "Option::is_none")]
    alarm: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<RegistrationStep>,
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<PlaceJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    relocated: Option<RelocatedJson>,
}

/// Where a radar stands according to its tracks, relative to the position that is used.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RadarPlace")]
struct PlaceJson {
    east_m: f64,
    north_m: f64,
    /// Standard deviation of `east_m`.
    #[schemars(range(min = 0))]
    east_sigma_m: f64,
    #[schemars(range(min = 0))]
    north_sigma_m: f64,
    latitude_deg: f64,
    longitude_deg: f64,
    /// The configured value that belongs to this position.
    bearing_correction_deg: f64,
    /// Time of the tracks on which it rests, in minutes of one drone.
    #[schemars(range(min = 0))]
    drone_minutes: f64,
    /// Whether the tracks contradict the position that is used. Then it can be applied.
    contradicts: bool,
}

impl From<&PlaceStatus> for PlaceJson {
    fn from(place: &PlaceStatus) -> Self {
        let [latitude_deg, longitude_deg] = place.latitude_longitude_deg.map(|degrees| rounded(degrees, 7));
        Self {
            east_m: rounded(place.east_m[0], 1),
            north_m: rounded(place.north_m[0], 1),
            east_sigma_m: rounded(place.east_m[1], 1),
            north_sigma_m: rounded(place.north_m[1], 1),
            latitude_deg,
            longitude_deg,
            bearing_correction_deg: rounded(place.bearing_correction_deg, 3),
            drone_minutes: rounded(place.drone_minutes, 1),
            contradicts: place.contradicts,
        }
    }
}

/// Correction of a radar's configured position that an operator applied.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RelocatedRadar")]
struct RelocatedJson {
    east_m: f64,
    north_m: f64,
    /// Angle taken off the azimuths, beside the configured correction.
    bearing_deg: f64,
    latitude_deg: f64,
    longitude_deg: f64,
}

impl From<&RelocatedRadar> for RelocatedJson {
    fn from(relocated: &RelocatedRadar) -> Self {
        let [latitude_deg, longitude_deg] =
            relocated.latitude_longitude_deg.map(|degrees| rounded(degrees, 7));
        let Relocation { east_m, north_m, bearing } = relocated.by;
        Self {
            east_m: rounded(east_m, 1),
            north_m: rounded(north_m, 1),
            bearing_deg: rounded(bearing.to_degrees(), 3),
            latitude_deg,
            longitude_deg,
        }
    }
}

#[derive(Serialize, JsonSchema)]
struct RegistrationEstimate {
    /// Effective number of radar tracks used; older ones have less weight.
    #[schemars(range(min = 0))]
    tracks: f64,
    /// Minutes of aircraft without a transponder that other radars see as well; bearing and range rest on these, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    shared_minutes: Option<f64>,
    /// Residual: 1 if tracks differ as the configured errors predict; above 4 the estimate is doubtful.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    residual: Option<f64>,
    #[serde(flatten)]
    values: RegistrationValues,
}

/// Latest step since the start: the radar may have been moved.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RegistrationStep")]
struct RegistrationStep {
    /// Time of the detection.
    time: Rfc3339,
    /// Estimate without the latest tracks.
    before: RegistrationValues,
    /// Estimate from the latest tracks alone.
    after: RegistrationValues,
}

#[derive(Serialize, JsonSchema)]
struct RegistrationValues {
    bearing_deg: RegistrationValue,
    tilt_east_deg: RegistrationValue,
    tilt_north_deg: RegistrationValue,
    range_m: RegistrationValue,
    height_m: RegistrationValue,
    time_s: RegistrationValue,
}

/// Orientation of a camera, learnt from aircraft with transponders. Bearings are corrected by it.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CameraOrientation")]
struct OrientationJson {
    bearing_deg: RegistrationValue,
    tilt_east_deg: RegistrationValue,
    tilt_north_deg: RegistrationValue,
    /// Number of looks learnt from.
    looks: u64,
    /// Root mean square of what is left of an angle after the correction, of the latest looks.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    residual_deg: Option<f64>,
    /// Latest time at which the camera was found to have been turned. Its orientation was then learnt again.
    #[serde(skip_serializing_if = "Option::is_none")]
    turned: Option<Rfc3339>,
}

impl From<&OrientedCamera> for OrientationJson {
    fn from(oriented: &OrientedCamera) -> Self {
        let value = |BiasValue { value, deviation, observable }: BiasValue| RegistrationValue {
            value: rounded(value.to_degrees(), 4),
            deviation: rounded(deviation.to_degrees(), 4),
            observable,
        };
        let misalignment = oriented.orientation.misalignment();
        Self {
            bearing_deg: value(misalignment.bearing),
            tilt_east_deg: value(misalignment.tilt_east),
            tilt_north_deg: value(misalignment.tilt_north),
            looks: misalignment.looks,
            residual_deg: misalignment.residual.map(|residual| rounded(residual.to_degrees(), 4)),
            turned: oriented.turned.map(Rfc3339),
        }
    }
}

/// A bias: measured value minus true value.
#[derive(Serialize, JsonSchema)]
struct RegistrationValue {
    /// Estimated value; 0 if a tilt is not observable.
    value: f64,
    /// Standard deviation.
    #[schemars(range(min = 0))]
    deviation: f64,
    /// Whether the value is known well enough to be used. Only then is it applied.
    observable: bool,
}

impl From<&Misalignment> for RegistrationValues {
    fn from(estimate: &Misalignment) -> Self {
        let value = |BiasValue { value, deviation, observable }: BiasValue| RegistrationValue {
            value: rounded(value, 4),
            deviation: rounded(deviation, 4),
            observable,
        };
        let [bearing_deg, tilt_east_deg, tilt_north_deg, range_m, height_m, time_s] =
            values(estimate).map(|(.., estimated)| value(estimated));
        Self { bearing_deg, tilt_east_deg, tilt_north_deg, range_m, height_m, time_s }
    }
}

impl From<&RegistrationStatus> for RegistrationJson {
    fn from(status: &RegistrationStatus) -> Self {
        Self {
            mode: status.mode.name(),
            applied: status.is_applied(),
            estimate: status.estimate.as_ref().map(|estimate| RegistrationEstimate {
                tracks: rounded(estimate.samples, 1),
                shared_minutes: status.shared_minutes.map(|minutes| rounded(minutes, 1)),
                residual: estimate.residual.map(|residual| rounded(residual, 2)),
                values: estimate.into(),
            }),
            hint: status.hint(),
            alarm: status.alarm.clone(),
            step: status.step.as_ref().map(|step| RegistrationStep {
                time: step.time.into(),
                before: (&step.before).into(),
                after: (&step.after).into(),
            }),
            place: status.place.as_ref().map(PlaceJson::from),
            relocated: status.relocated.as_ref().map(RelocatedJson::from),
        }
    }
}

impl SensorProperties {
    /// Properties of a sensor, with its status if there is one.
    pub fn new(sensor: &Sensor, status: Option<&SensorStatus>) -> Self {
        let known = |status: &SensorStatus| SensorStatusJson {
            sac: sensor.sac,
            sic: sensor.sic,
            state: status.state.name(),
            reasons: status.reasons.clone(),
            rate_hz: rounded(status.rate_hz, 3),
            accepted: status.accepted,
            refused: status.refused.clone(),
            lines: status.lines.iter().map(InputCounters::from).collect(),
            last_seen: status.last_seen.map(Rfc3339),
            clock_offset_s: status.clock_offset_s.map(|offset_s| rounded(offset_s, 3)),
            contested: status.contested.iter().map(ContestedJson::from).collect(),
            registration: status.registration.as_ref().map(RegistrationJson::from),
            orientation: status.orientation.as_ref().map(OrientationJson::from),
            learnt: status.registration.as_ref().and_then(|status| status.learnt.as_ref()).map(Learnt::from),
            transponder_types: status.types.iter().map(LearntTypeJson::from).collect(),
        };
        Self { id: sensor.id.clone(), kind: kind(sensor), status: status.map(known) }
    }
}

/// `/api/v1/sensors`.
pub fn sensors(request: &ApiRequest) -> Result<SensorCollection, Problem> {
    let hub = &request.state.hub;
    let status = hub.status();
    let feature = |(index, sensor): (usize, &Sensor)| {
        let state = status.as_ref().and_then(|status| status.sensors.get(index));
        let relocated = state.and_then(|state| state.registration.as_ref()?.relocated);
        let geometry = sensor.kind.place().map(|(latitude_deg, longitude_deg, height_amsl_m)| {
            let [latitude_deg, longitude_deg] =
                relocated.map_or([latitude_deg, longitude_deg], |relocated| relocated.latitude_longitude_deg);
            let height_m = rounded(height_amsl_m + hub.maker.geoid_undulation_m(), 3);
            Point::new(longitude_deg, latitude_deg, Some(height_m))
        });
        Feature::new(sensor.id.clone(), geometry, SensorProperties::new(sensor, state))
    };
    Ok(SensorCollection {
        r#type: CollectionType::default(),
        unknown: status.iter().flat_map(|status| &status.unknown).map(UnknownSource::from).collect(),
        features: hub.config.sensors.iter().enumerate().map(feature).collect(),
        time: status.as_ref().map(|status| status.at.into()),
    })
}

/// `/api/v1/coverage`.
pub fn coverage(request: &ApiRequest) -> ApiResult {
    Ok(live(GEO_JSON, request.state.access().coverage.clone()))
}

/// `/api/v1/areas`: areas, with the state at the present time.
pub fn areas(request: &ApiRequest) -> Result<AreaCollection, Problem> {
    let hub = &request.state.hub;
    // A recording has its own time.
    let replayed = request.state.options.player.as_ref().and_then(|_| Some(hub.latest()?.due));
    let now = replayed.unwrap_or_else(|| request.state.now());
    let zones = request.state.options.zones.as_ref().map(ZoneRequests::in_force).unwrap_or_default();
    Ok(area_collection(&request.state.access().areas, &zones, now, hub.maker.geoid_undulation_m()))
}
