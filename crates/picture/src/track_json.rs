//! A track as JSON: the properties in the HTTP API, and one object per line in `replay --output-format ndjson`.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::integrity_json::TrackIntegrity;
use super::kinds::{ContributorKind, TrackState};
use super::remote_id_json::RemoteIdJson;
use super::texts::{name, serial_text, text};
use super::{
    Ellipse, HORIZONTAL, PictureMaker, PictureTrack, Rfc3339, TrackClass, TrackSource, VERTICAL, class_names,
};
use fusion::operational::{ASSOCIATE_LLR, DISSOCIATE_LLR};
use fusion::point::{AssociationEvidence, CameraPart, Competitor, Point, RadarPart, Rival, TransponderPart};
use fusion::report::Space;
use fusion::{Identity, Source};
use input::json::rounded;

/// A track. Unknown values are left out; in the reference profile these include motion and accuracy.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct TrackJson<'a> {
    /// Id of the track. Operational profile: one per aircraft, `U-…`. Reference profile: `F-…`, `R-…`, `T-…`, which change with
    /// its sources.
    id: String,
    /// Short name as on the map, unique among the tracks of a picture: callsign or address, end of the serial number, or `R` and the
    /// number of a radar's track.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    /// Kinds of sensors whose measurements make the track.
    #[schemars(extend("enum" = TrackSource::NAMES))]
    source: &'static str,
    /// Published track number, as in CAT129 and CAT062.
    track_number: u32,
    /// `coasting`: not measured since; the position is extrapolated.
    #[schemars(extend("enum" = TrackState::NAMES))]
    state: &'static str,
    /// Time of the position.
    time: Rfc3339,
    /// WGS-84 latitude, in degrees.
    lat: f64,
    /// WGS-84 longitude, in degrees.
    lng: f64,
    /// Height above the ellipsoid, in metres, if a height was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt: Option<f64>,
    /// Height above mean sea level, in metres, if a height was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt_msl: Option<f64>,
    /// Height of the geoid above the ellipsoid, in metres.
    geoid_separation: f64,
    /// Ground speed, in metres per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    speed: Option<f64>,
    /// Direction over ground, in degrees true; left out if it is uncertain.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0), extend("exclusiveMaximum" = 360))]
    track: Option<f64>,
    /// Vertical speed, in metres per second, positive up.
    #[serde(skip_serializing_if = "Option::is_none")]
    vertical_speed: Option<f64>,
    /// Radius that contains 95 % of the horizontal errors, as estimated by the filter, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    accuracy_h_m: Option<f64>,
    /// Bound of 95 % of the vertical errors, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    accuracy_v_m: Option<f64>,
    /// Class of `accuracy_h_m` in ASTM F3411.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = class_names(&HORIZONTAL)))]
    accuracy_h: Option<&'static str>,
    /// Class of `accuracy_v_m` in ASTM F3411.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = class_names(&VERTICAL)))]
    accuracy_v: Option<&'static str>,
    /// Ellipse that contains 95 % of the horizontal errors; only for a predicted position (`at=now`).
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy_ellipse: Option<EllipseJson>,
    /// Operational profile: the position lies between two measurements. Reference profile: there is a transponder.
    interpolated: bool,
    /// Whether the position lies after the last measurement or before the first.
    extrapolated: bool,
    /// Probability that it is a drone, according to the radar.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1))]
    uav_probability: Option<f64>,
    /// Class of the target.
    #[schemars(extend("enum" = TrackClass::NAMES))]
    aircraft_type: &'static str,
    /// Identity that the transponder reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    uas_id: Option<UasIdJson<'a>>,
    /// Identity of an aircraft with ADS-B.
    #[serde(skip_serializing_if = "Option::is_none")]
    aircraft: Option<AircraftJson<'a>>,
    /// Remote ID declarations of a drone.
    #[serde(skip_serializing_if = "Option::is_none")]
    remote_id: Option<RemoteIdJson<'a>>,
    /// Operational profile: further identities of the same aircraft, which carries several transponders.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    also: Vec<OtherIdentity<'a>>,
    #[serde(flatten)]
    integrity: TrackIntegrity<'a>,
    /// Centre of the first slot with the track.
    first_seen: Rfc3339,
    /// Time of the latest measurement up to `time`, by any sensor; left out before the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_measurement: Option<Rfc3339>,
    /// Sensor tracks that the track is made of.
    contributors: Vec<ContributorJson<'a>>,
}

/// An ellipse about a position.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Ellipse")]
struct EllipseJson {
    /// Semi-major axis, in metres.
    major_m: f64,
    /// Semi-minor axis, in metres.
    minor_m: f64,
    /// Direction of the major axis, in degrees true, 0 to 180.
    azimuth_deg: f64,
}

impl From<Ellipse> for EllipseJson {
    fn from(ellipse: Ellipse) -> Self {
        let [major_m, minor_m] = ellipse.half_axes_m.map(|metres| rounded(metres, 2));
        Self { major_m, minor_m, azimuth_deg: rounded(ellipse.azimuth_deg, 1) % 180.0 }
    }
}

/// Identity of a drone as it reports it, in one of the kinds of ASTM F3411.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
#[schemars(rename = "UasId")]
struct UasIdJson<'a> {
    /// Serial number.
    #[serde(skip_serializing_if = "Option::is_none")]
    serial_number: Option<Cow<'a, str>>,
    /// Registration id assigned by an authority.
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_id: Option<Cow<'a, str>>,
    /// UUID assigned by a traffic management service for a flight.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("format" = "uuid"))]
    utm_id: Option<Cow<'a, str>>,
    /// Session id: 20 octets in hexadecimal, the first of which is its kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    specific_session_id: Option<Cow<'a, str>>,
    /// Manufacturer code.
    #[serde(skip_serializing_if = "Option::is_none")]
    manufacturer: Option<Cow<'a, str>>,
    /// Model code.
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<Cow<'a, str>>,
    /// Country of registration, ISO 3166-1 alpha-2.
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_country: Option<Cow<'a, str>>,
}

/// Properties that an aircraft reports by ADS-B.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct AircraftJson<'a> {
    /// ICAO aircraft address, six hexadecimal digits.
    icao24: Cow<'a, str>,
    /// Callsign, or flight identification.
    #[serde(skip_serializing_if = "Option::is_none")]
    callsign: Option<Cow<'a, str>>,
    /// Emitter category, as in I021/020.
    #[serde(skip_serializing_if = "Option::is_none")]
    emitter_category: Option<u8>,
}

/// A further transponder of the aircraft, linked by evidence: the same motion for most of a minute.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Also")]
struct OtherIdentity<'a> {
    /// Identity that the transponder reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    uas_id: Option<UasIdJson<'a>>,
    /// Identity of an aircraft with ADS-B.
    #[serde(skip_serializing_if = "Option::is_none")]
    aircraft: Option<AircraftJson<'a>>,
    /// Configured id of the sensor that received it last.
    sensor: &'a str,
    /// Track number of the transponder.
    track_number: u32,
    /// Time of its latest report.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
}

impl<'a> OtherIdentity<'a> {
    fn new(part: &'a TransponderPart, maker: &'a PictureMaker) -> Self {
        Self {
            uas_id: UasIdJson::new(part),
            aircraft: AircraftJson::new(part),
            sensor: maker.sensor(part.sensor),
            track_number: part.number,
            time: part.time.map(Rfc3339),
        }
    }
}

/// A sensor that contributes to a track. For the radar of a fused track, also the evidence of the association.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
#[schemars(rename = "Contributor")]
struct ContributorJson<'a> {
    /// Kind of the sensor.
    #[schemars(extend("enum" = ContributorKind::NAMES))]
    kind: &'static str,
    /// Configured id of the sensor.
    sensor: &'a str,
    /// Track number at the sensor; of a transponder its published number.
    track_number: u32,
    /// Time of its measurement; for a camera, of the latest bearing used.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// Weight in the position, if it is fixed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1))]
    weight: Option<f64>,
    /// Whether the radar measured a height.
    #[serde(skip_serializing_if = "Option::is_none")]
    height_measured: Option<bool>,
    /// Distance between radar and transponder, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    distance_m: Option<f64>,
    /// Reference profile: association distance, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    threshold_m: Option<f64>,
    /// Reference profile: share of the common slots with a distance within the association distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1))]
    ratio: Option<f64>,
    /// Reference profile: number of slots within the association distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    within: Option<u32>,
    /// Reference profile: number of common slots.
    #[serde(skip_serializing_if = "Option::is_none")]
    co_present: Option<u32>,
    /// Operational profile: whether an operator has decided that both are one aircraft.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    manual: bool,
    /// Operational profile: natural logarithm of the likelihood ratio of one aircraft to two.
    #[serde(skip_serializing_if = "Option::is_none")]
    log_likelihood_ratio: Option<f64>,
    /// Operational profile: thresholds of `log_likelihood_ratio`.
    #[serde(skip_serializing_if = "Option::is_none")]
    threshold: Option<AssociationThreshold>,
    /// Operational profile, for a single track or with `include=competitors`: alternative associations, likeliest first. They are
    /// transponders for a radar track, radar tracks for a transponder.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 3))]
    competitors: Vec<CompetitorJson<'a>>,
}

/// A candidate that was not associated: a transponder for a radar track, or a radar track for a transponder.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Competitor")]
struct CompetitorJson<'a> {
    /// Configured id of the sensor.
    sensor: &'a str,
    /// Track number of the radar.
    #[serde(skip_serializing_if = "Option::is_none")]
    track_number: Option<u32>,
    /// Identity of the transponder.
    #[serde(skip_serializing_if = "Option::is_none")]
    uas_id: Option<TransponderId>,
    /// Natural logarithm of the likelihood ratio of one aircraft to two.
    log_likelihood_ratio: f64,
    /// Whether an operator has decided that it is another aircraft.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    decorrelated: bool,
}

/// Unique identity of a transponder.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct TransponderId {
    /// Serial number.
    serial_number: String,
    /// Country of registration, ISO 3166-1 alpha-2.
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_country: Option<String>,
}

impl TransponderId {
    /// Published form of an identity.
    pub fn new(identity: Identity) -> Self {
        let country = text(identity.country()).map(Cow::into_owned);
        Self { serial_number: serial_text(identity), registration_country: country }
    }
}

/// Thresholds of an association, as logarithms of likelihood ratios.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Threshold")]
struct AssociationThreshold {
    /// A pair is associated above this value.
    join: f64,
    /// A pair is separated below this value.
    part: f64,
}

impl<'a> TrackJson<'a> {
    /// A track with its competitors, in a picture made by `maker`.
    pub fn new(track: &'a PictureTrack, maker: &'a PictureMaker) -> Self {
        Self::with(track, &track.point.competitors, maker)
    }

    /// A track without its competitors.
    pub fn lean(track: &'a PictureTrack, maker: &'a PictureMaker) -> Self {
        Self::with(track, &[], maker)
    }

    /// Adds the name. Files have none, since it depends on when a picture was first shown.
    #[must_use]
    pub fn named(self, track: &'a PictureTrack) -> Self {
        Self { name: Some(&*track.name).filter(|name| !name.is_empty()), ..self }
    }

    fn with(track: &'a PictureTrack, competitors: &[Competitor], maker: &'a PictureMaker) -> Self {
        let source = &track.point.source;
        let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
        Self {
            id: maker.track_id(track),
            name: None,
            source: track.source_name(),
            track_number: track.point.number,
            state: if track.is_coasting() { TrackState::Coasting } else { TrackState::Active }.name(),
            time: track.time.into(),
            lat: rounded(track.position.latitude_deg(), 9),
            lng: rounded(track.position.longitude_deg(), 9),
            alt: track.altitude_amsl_m.map(|_| rounded(track.position.height_m, 3)),
            alt_msl: track.altitude_amsl_m.map(|metres| rounded(metres, 3)),
            geoid_separation: rounded(maker.undulation_m, 3),
            speed: motion.map(|motion| rounded(motion.speed(), 2)),
            // A direction rounded up to 360 is north.
            track: motion.and_then(|motion| motion.track_deg).map(|degrees| rounded(degrees, 1) % 360.0),
            vertical_speed: vertical.map(|motion| rounded(motion.climb(), 2)),
            accuracy_h_m: motion.map(|motion| rounded(motion.accuracy_h_m, 2)),
            accuracy_v_m: vertical.map(|motion| rounded(motion.accuracy_v_m, 2)),
            accuracy_h: motion.map(|motion| motion.class_h().name),
            accuracy_v: vertical.map(|motion| motion.class_v().name),
            accuracy_ellipse: motion.and_then(|motion| motion.ellipse).map(EllipseJson::from),
            interpolated: track.is_interpolated(),
            extrapolated: track.is_extrapolated(),
            uav_probability: source.radar().and_then(|radar| radar.uav_probability).map(|p| rounded(p, 4)),
            aircraft_type: maker.class(track).name(),
            uas_id: source.transponder().and_then(UasIdJson::new),
            aircraft: source.transponder().and_then(AircraftJson::new),
            remote_id: source.transponder().and_then(|part| RemoteIdJson::new(&part.aircraft.declared)),
            also: track.point.also.iter().map(|part| OtherIdentity::new(part, maker)).collect(),
            integrity: TrackIntegrity::new(track),
            first_seen: track.point.first_seen.into(),
            last_measurement: motion.and_then(|motion| motion.last_measurement).map(Rfc3339),
            contributors: contributors(&track.point, competitors, maker),
        }
    }
}

impl TrackJson<'_> {
    /// Id of the track.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Longitude, in degrees.
    pub fn lng(&self) -> f64 {
        self.lng
    }

    /// Latitude, in degrees.
    pub fn lat(&self) -> f64 {
        self.lat
    }

    /// Height above the ellipsoid, in metres, if it was measured.
    pub fn alt(&self) -> Option<f64> {
        self.alt
    }
}

impl<'a> UasIdJson<'a> {
    /// Identity of a drone; `None` if the aircraft has none.
    fn new(part: &'a TransponderPart) -> Option<Self> {
        let TransponderPart { identity, items, .. } = part;
        let id = || Some(name(identity));
        let id = match identity.space() {
            Space::Serial => Self { serial_number: id(), ..Self::default() },
            Space::Address => return None,
            Space::Registration => Self { registration_id: id(), ..Self::default() },
            Space::Flight => Self { utm_id: id(), ..Self::default() },
            Space::Session => Self { specific_session_id: id(), ..Self::default() },
        };
        Some(Self {
            manufacturer: items.manufacturer.as_ref().and_then(|octets| text(octets)),
            model: items.model.as_ref().and_then(|octets| text(octets)),
            registration_country: items.registration_country.as_ref().and_then(|octets| text(octets)),
            ..id
        })
    }
}

impl<'a> AircraftJson<'a> {
    /// ADS-B properties of an aircraft; `None` without an ICAO address.
    fn new(part: &'a TransponderPart) -> Option<Self> {
        let TransponderPart { identity, aircraft, .. } = part;
        (identity.space() == Space::Address).then(|| Self {
            icao24: name(identity),
            callsign: text(&aircraft.callsign),
            emitter_category: aircraft.emitter_category,
        })
    }
}

fn contributors<'a>(
    point: &Point,
    competitors: &[Competitor],
    maker: &'a PictureMaker,
) -> Vec<ContributorJson<'a>> {
    let rivals = |of_radar: bool| {
        let is_of = |rival: &&Competitor| matches!(rival.who, Rival::Transponder { .. }) == of_radar;
        competitors.iter().filter(is_of).map(|rival| competitor(rival, maker)).collect()
    };
    let radar = |part: &RadarPart, weight| ContributorJson {
        kind: ContributorKind::Radar.name(),
        sensor: maker.sensor(part.track.sensor),
        track_number: part.track.number.into(),
        time: Some(part.time.into()),
        weight,
        height_measured: Some(part.height_measured),
        competitors: rivals(true),
        ..ContributorJson::default()
    };
    let transponder = |part: &TransponderPart, weight| ContributorJson {
        kind: ContributorKind::Transponder.name(),
        sensor: maker.sensor(part.sensor),
        track_number: part.number,
        time: part.time.map(Rfc3339),
        weight,
        competitors: rivals(false),
        ..ContributorJson::default()
    };
    let camera = |part: &CameraPart| ContributorJson {
        kind: ContributorKind::Camera.name(),
        sensor: maker.sensor(part.track.sensor),
        track_number: part.track.number.into(),
        time: Some(part.time.into()),
        ..ContributorJson::default()
    };
    // No weight is fixed if a camera contributes.
    let alone = point.cameras.is_empty().then_some(1.0);
    let mut contributors = match &point.source {
        Source::Fused(radar_part, transponder_part, pair) => {
            let mut radar = radar(radar_part, None);
            let mut transponder = transponder(transponder_part, None);
            radar.distance_m = Some(rounded(pair.distance_m, 3));
            match pair.because {
                AssociationEvidence::Ratio { threshold_m, ratio } => {
                    let share = |weight: f64| {
                        Some(rounded(weight / (maker.weights.radar + maker.weights.transponder), 4))
                    };
                    radar.weight = share(maker.weights.radar);
                    transponder.weight = share(maker.weights.transponder);
                    radar.threshold_m = Some(rounded(threshold_m, 3));
                    radar.ratio = Some(rounded(ratio.value(), 4));
                    radar.within = Some(ratio.within);
                    radar.co_present = Some(ratio.co_present);
                }
                AssociationEvidence::Likelihood { score } => {
                    radar.log_likelihood_ratio = Some(rounded(score, 2));
                    radar.threshold =
                        Some(AssociationThreshold { join: ASSOCIATE_LLR, part: DISSOCIATE_LLR });
                }
                AssociationEvidence::Manual { score } => {
                    radar.manual = true;
                    radar.log_likelihood_ratio = score.map(|score| rounded(score, 2));
                    radar.threshold =
                        Some(AssociationThreshold { join: ASSOCIATE_LLR, part: DISSOCIATE_LLR });
                }
            }
            vec![radar, transponder]
        }
        Source::Radar(part) => vec![radar(part, alone)],
        Source::Transponder(part) => vec![transponder(part, alone)],
    };
    contributors.extend(point.cameras.iter().map(camera));
    contributors
}

fn competitor<'a>(rival: &Competitor, maker: &'a PictureMaker) -> CompetitorJson<'a> {
    let (sensor, track_number, uas_id) = match rival.who {
        Rival::Radar(track) => (track.sensor, Some(track.number.into()), None),
        Rival::Transponder { sensor, number, identity } => {
            (sensor, number, Some(TransponderId::new(identity)))
        }
    };
    CompetitorJson {
        sensor: maker.sensor(sensor),
        track_number,
        uas_id,
        log_likelihood_ratio: rounded(rival.score, 2),
        decorrelated: rival.decorrelated,
    }
}
