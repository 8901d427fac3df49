//! What stands on the ground: sensors, how far they see, areas.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::ask::{Answer, Ask, GEO_JSON, live};
use super::geometry::{CollectionType, Feature, Point};
use super::ground::{AreaCollection, area_collection, kind};
use super::learnt::{Learnt, LearntTypeJson};
use super::problem::Problem;
use crate::config::{self, Sensor, SensorKind};
use crate::json::rounded;
use crate::live::{Contested, LineStatus, RegistrationStatus, SensorState, SensorStatus, Unknown, values};
use crate::names::configured;
use crate::picture::{Rfc3339, serial_text};
use crate::pipeline::ContestReason;
use fusion::registration::{BiasValue, Misalignment};

/// GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
pub struct Sensors {
    r#type: CollectionType,
    unknown: Vec<UnknownSource>,
    features: Vec<Feature<'static, Option<Point>, SensorProperties>>,
    /// Of the sensors' states.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
}

/// A source that is no configured sensor.
#[derive(Serialize, JsonSchema)]
struct UnknownSource {
    category: u8,
    sac: u8,
    sic: u8,
    /// The service's own output comes back.
    own: bool,
    records: u64,
    last_seen: Rfc3339,
}

impl From<&Unknown> for UnknownSource {
    fn from(unknown: &Unknown) -> Self {
        let Unknown { category, source, own, records, last_seen } = *unknown;
        Self { category, sac: source.sac, sic: source.sic, own, records, last_seen: last_seen.into() }
    }
}

/// What is unknown is left out.
#[derive(Serialize, JsonSchema)]
pub struct SensorProperties {
    /// As configured.
    id: String,
    #[schemars(extend("enum" = configured::<SensorKind>()))]
    kind: &'static str,
    #[serde(flatten)]
    status: Option<Known>,
}

/// What a status tells of a sensor.
#[derive(Serialize, JsonSchema)]
struct Known {
    sac: u8,
    sic: u8,
    #[schemars(extend("enum" = SensorState::NAMES))]
    state: &'static str,
    /// Why it is not operational.
    reasons: Vec<String>,
    /// Reports per second, over the last 10 s.
    #[schemars(range(min = 0))]
    rate_hz: f64,
    accepted: u64,
    /// Records without a report, by reason.
    refused: BTreeMap<&'static str, u64>,
    lines: Vec<Line>,
    /// Of its last record of any kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_seen: Option<Rfc3339>,
    /// From the times of its reports to their reception, seconds: the least of the last ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    clock_offset_s: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contested: Vec<ContestedJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    registration: Option<Registration>,
    #[serde(skip_serializing_if = "Option::is_none")]
    learnt: Option<Learnt>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    transponder_types: Vec<LearntTypeJson>,
}

/// Datagrams of a multicast group or an address.
#[derive(Serialize, JsonSchema)]
struct Line {
    name: String,
    joined: bool,
    received: u64,
    duplicates: u64,
    foreign: u64,
    queue_full: u64,
    kernel_dropped: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    last_received: Option<Rfc3339>,
    /// Of a connection: what was not translated, by reason.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    untranslated: BTreeMap<&'static str, u64>,
}

impl From<&LineStatus> for Line {
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

/// A sender that is refused under the SAC/SIC of a sensor.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Contested")]
struct ContestedJson {
    /// Address and port of the sender that counts; with port 0 the host that `source` names.
    counts: String,
    /// Address and port of the sender that is refused.
    refused: String,
    /// `other_sender`: the one that counts was heard first. `foreign_source`: it is not a host that the sensor's inputs name as
    /// `source`.
    #[schemars(extend("enum" = ContestReason::NAMES))]
    reason: &'static str,
    /// Serial numbers of the transponders that both report.
    transponders: Vec<String>,
}

impl From<&Contested> for ContestedJson {
    fn from(contested: &Contested) -> Self {
        let Contested { counts, refused, reason, transponders } = contested;
        let transponders = transponders.iter().map(|identity| serial_text(*identity)).collect();
        Self { counts: counts.to_string(), refused: refused.to_string(), reason: reason.name(), transponders }
    }
}

/// Misalignment of a radar, estimated from its tracks; operational profile only, and without values where it is off.
#[derive(Serialize, JsonSchema)]
struct Registration {
    #[schemars(extend("enum" = configured::<config::Registration>()))]
    mode: &'static str,
    /// Whether plots are corrected by any of it.
    applied: bool,
    #[serde(flatten)]
    estimate: Option<Estimated>,
    /// What to look at where it is doubtful.
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<String>,
    /// What to look at after a step, until it is an hour old.
    #[serde(skip_serializing_if = "Option::is_none")]
    alarm: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<Step>,
}

#[derive(Serialize, JsonSchema)]
struct Estimated {
    /// Radar tracks that it rests upon; older ones count in part.
    #[schemars(range(min = 0))]
    tracks: f64,
    /// 1: tracks differ as the configured errors predict; above 4: doubtful.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    residual: Option<f64>,
    #[serde(flatten)]
    values: RegistrationValues,
}

/// The latest step since the start: the radar may have been moved.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RegistrationStep")]
struct Step {
    /// When it was detected.
    time: Rfc3339,
    /// Without the latest tracks.
    before: RegistrationValues,
    /// With them alone.
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

/// A bias: measured minus true.
#[derive(Serialize, JsonSchema)]
struct RegistrationValue {
    /// 0 where a tilt is not observable.
    value: f64,
    /// Standard deviation.
    #[schemars(range(min = 0))]
    deviation: f64,
    /// Whether the tracks determine it well enough to be of use; only then is it applied.
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

impl From<&RegistrationStatus> for Registration {
    fn from(status: &RegistrationStatus) -> Self {
        Self {
            mode: status.mode.name(),
            applied: status.is_applied(),
            estimate: status.estimate.as_ref().map(|estimate| Estimated {
                tracks: rounded(estimate.samples, 1),
                residual: estimate.residual.map(|residual| rounded(residual, 2)),
                values: estimate.into(),
            }),
            hint: status.hint(),
            alarm: status.alarm.clone(),
            step: status.step.as_ref().map(|step| Step {
                time: step.time.into(),
                before: (&step.before).into(),
                after: (&step.after).into(),
            }),
        }
    }
}

impl SensorProperties {
    /// The properties of a sensor, with its status where there is one.
    pub fn new(sensor: &Sensor, status: Option<&SensorStatus>) -> Self {
        let known = |status: &SensorStatus| Known {
            sac: sensor.sac,
            sic: sensor.sic,
            state: status.state.name(),
            reasons: status.reasons.clone(),
            rate_hz: rounded(status.rate_hz, 3),
            accepted: status.accepted,
            refused: status.refused.clone(),
            lines: status.lines.iter().map(Line::from).collect(),
            last_seen: status.last_seen.map(Rfc3339),
            clock_offset_s: status.clock_offset_s.map(|offset_s| rounded(offset_s, 3)),
            contested: status.contested.iter().map(ContestedJson::from).collect(),
            registration: status.registration.as_ref().map(Registration::from),
            learnt: status.registration.as_ref().and_then(|status| status.learnt.as_ref()).map(Learnt::from),
            transponder_types: status.types.iter().map(LearntTypeJson::from).collect(),
        };
        Self { id: sensor.id.clone(), kind: kind(sensor), status: status.map(known) }
    }
}

/// `/api/v1/sensors`.
pub fn sensors(ask: &Ask) -> Result<Sensors, Problem> {
    let hub = &ask.state.hub;
    let status = hub.status();
    let feature = |(index, sensor): (usize, &Sensor)| {
        let geometry = sensor.kind.place().map(|(latitude_deg, longitude_deg, height_amsl_m)| {
            let height_m = rounded(height_amsl_m + hub.maker.geoid_undulation_m(), 3);
            Point::new(longitude_deg, latitude_deg, Some(height_m))
        });
        let state = status.as_ref().and_then(|status| status.sensors.get(index));
        Feature::new(sensor.id.clone(), geometry, SensorProperties::new(sensor, state))
    };
    Ok(Sensors {
        r#type: CollectionType::default(),
        unknown: status.iter().flat_map(|status| &status.unknown).map(UnknownSource::from).collect(),
        features: hub.config.sensors.iter().enumerate().map(feature).collect(),
        time: status.as_ref().map(|status| status.at.into()),
    })
}

/// `/api/v1/coverage`.
pub fn coverage(ask: &Ask) -> Answer {
    Ok(live(GEO_JSON, ask.state.terms().coverage.clone()))
}

/// `/api/v1/areas`: which of them are in force is as of now.
pub fn areas(ask: &Ask) -> Result<AreaCollection, Problem> {
    let hub = &ask.state.hub;
    // A recording has times of its own.
    let replayed = ask.state.options.player.as_ref().and_then(|_| Some(hub.latest()?.due));
    let now = replayed.unwrap_or_else(|| ask.state.now());
    Ok(area_collection(&ask.state.terms().areas, now, hub.maker.geoid_undulation_m()))
}
