//! A track as JSON: the properties of the HTTP API, one object per line in `replay --output-format ndjson`.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::integrity_json::TrackIntegrity;
use super::kinds::{ContributorKind, TrackState};
use super::remote_id_json::RemoteIdJson;
use super::{
    Ellipse, HORIZONTAL, PictureMaker, PictureTrack, Rfc3339, TrackClass, TrackSource, VERTICAL, class_names,
};
use crate::json::rounded;
use fusion::operational::{ASSOCIATE_LLR, DISSOCIATE_LLR};
use fusion::point::{Because, CameraPart, Competitor, Point, RadarPart, Rival, TransponderPart};
use fusion::report::Space;
use fusion::{Identity, Source};

/// A track. What is unknown is left out; in the reference profile that includes motion and accuracy.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct TrackJson<'a> {
    /// Operational: one per aircraft, U-…; reference: F-…, R-…, T-…, which change with its sources.
    id: String,
    #[schemars(extend("enum" = TrackSource::NAMES))]
    source: &'static str,
    track_number: u32,
    /// Coasting: nothing has been measured since; the position is extrapolated.
    #[schemars(extend("enum" = TrackState::NAMES))]
    state: &'static str,
    /// Of the position.
    time: Rfc3339,
    /// WGS-84, degrees.
    lat: f64,
    /// WGS-84, degrees.
    lng: f64,
    /// Metres above the ellipsoid, where a height was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt: Option<f64>,
    /// Metres above mean sea level, where a height was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt_msl: Option<f64>,
    /// Geoid above ellipsoid, metres.
    geoid_separation: f64,
    /// Over ground, metres per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    speed: Option<f64>,
    /// Direction over ground, degrees true; left out where it could be any.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0), extend("exclusiveMaximum" = 360))]
    track: Option<f64>,
    /// Metres per second, up.
    #[serde(skip_serializing_if = "Option::is_none")]
    vertical_speed: Option<f64>,
    /// Radius that holds 95 % of the horizontal error, as the filter estimates it, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    accuracy_h_m: Option<f64>,
    /// Bound of 95 % of the vertical error, metres.
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
    /// Of a predicted position (at=now): holds 95 % of the horizontal error.
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy_ellipse: Option<EllipseJson>,
    /// Operational: the position lies between two measurements; reference: there is a transponder.
    interpolated: bool,
    /// The position lies after the last measurement or before the first.
    extrapolated: bool,
    /// Probability that it is a drone, according to the radar.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1))]
    uav_probability: Option<f64>,
    /// What it is taken for.
    #[schemars(extend("enum" = TrackClass::NAMES))]
    aircraft_type: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    uas_id: Option<UasId<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    aircraft: Option<AircraftJson<'a>>,
    /// What a drone declares by Remote ID.
    #[serde(skip_serializing_if = "Option::is_none")]
    remote_id: Option<RemoteIdJson<'a>>,
    #[serde(flatten)]
    integrity: TrackIntegrity<'a>,
    /// Centre of the first slot with it.
    first_seen: Rfc3339,
    /// The latest one up to `time`, of any sensor; left out before the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_measurement: Option<Rfc3339>,
    contributors: Vec<Contributor<'a>>,
}

/// An ellipse about a position.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Ellipse")]
struct EllipseJson {
    /// Longer half axis, metres.
    major_m: f64,
    /// Shorter half axis, metres.
    minor_m: f64,
    /// Direction of the longer one, degrees true, 0 to 180.
    azimuth_deg: f64,
}

impl From<Ellipse> for EllipseJson {
    fn from(ellipse: Ellipse) -> Self {
        let [major_m, minor_m] = ellipse.half_axes_m.map(|metres| rounded(metres, 2));
        Self { major_m, minor_m, azimuth_deg: rounded(ellipse.azimuth_deg, 1) % 180.0 }
    }
}

/// Identity of a drone as it reports it, by one of the kinds of ASTM F3411.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
struct UasId<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    serial_number: Option<Cow<'a, str>>,
    /// Given by an authority.
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_id: Option<Cow<'a, str>>,
    /// Given by a traffic management service for a flight: a UUID.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("format" = "uuid"))]
    utm_id: Option<Cow<'a, str>>,
    /// Of a session: 20 octets, hexadecimal; the first octet says of which kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    specific_session_id: Option<Cow<'a, str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    manufacturer: Option<Cow<'a, str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<Cow<'a, str>>,
    /// ISO 3166-1 alpha-2.
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_country: Option<Cow<'a, str>>,
}

/// What an aircraft says of itself by ADS-B.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct AircraftJson<'a> {
    /// ICAO aircraft address, six hexadecimal digits.
    icao24: Cow<'a, str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    callsign: Option<Cow<'a, str>>,
    /// As in I021/020.
    #[serde(skip_serializing_if = "Option::is_none")]
    emitter_category: Option<u8>,
}

/// A sensor's part in a track and, of a fused track's radar, why it was associated.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
struct Contributor<'a> {
    #[schemars(extend("enum" = ContributorKind::NAMES))]
    kind: &'static str,
    /// Its configured id.
    sensor: &'a str,
    track_number: u32,
    /// Of its measurement; of a camera, of the latest bearing that is used.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// Its share in the position, where that is fixed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1))]
    weight: Option<f64>,
    /// Whether the radar measured a height.
    #[serde(skip_serializing_if = "Option::is_none")]
    height_measured: Option<bool>,
    /// Between radar and transponder, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    distance_m: Option<f64>,
    /// Reference: gate, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    threshold_m: Option<f64>,
    /// Reference: share of the slots in which the distance was within the gate.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1))]
    ratio: Option<f64>,
    /// Reference: slots within the gate.
    #[serde(skip_serializing_if = "Option::is_none")]
    within: Option<u32>,
    /// Reference: slots with both.
    #[serde(skip_serializing_if = "Option::is_none")]
    co_present: Option<u32>,
    /// Operational: an operator has decided that they are one.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    manual: bool,
    /// Operational: natural logarithm of the likelihood ratio of one aircraft to two.
    #[serde(skip_serializing_if = "Option::is_none")]
    log_likelihood_ratio: Option<f64>,
    /// Operational: thresholds of that logarithm.
    #[serde(skip_serializing_if = "Option::is_none")]
    threshold: Option<Threshold>,
    /// Operational, of a single track or with include=competitors: who else could be it, the likeliest first; of a radar
    /// track transponders, of a transponder radar tracks.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 3))]
    competitors: Vec<CompetitorJson<'a>>,
}

/// A candidate that was not associated: for a radar track a transponder, for a transponder a radar track.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Competitor")]
struct CompetitorJson<'a> {
    /// Its configured id.
    sensor: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    track_number: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    uas_id: Option<TransponderId>,
    /// Natural logarithm of the likelihood ratio of one aircraft to two.
    log_likelihood_ratio: f64,
    /// An operator has decided that it is another.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    decorrelated: bool,
}

/// What tells a transponder from all others.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct TransponderId {
    serial_number: String,
    /// ISO 3166-1 alpha-2.
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_country: Option<String>,
}

impl TransponderId {
    /// The published form of an identity.
    pub fn new(identity: Identity) -> Self {
        let country = text(identity.country()).map(Cow::into_owned);
        Self { serial_number: serial_text(identity), registration_country: country }
    }
}

/// Where an association begins and ends: logarithms of likelihood ratios.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
struct Threshold {
    /// A pair is associated above it.
    join: f64,
    /// And separated below it.
    part: f64,
}

impl<'a> TrackJson<'a> {
    /// A track with its competitors; `maker` made the picture.
    pub fn new(track: &'a PictureTrack, maker: &'a PictureMaker) -> Self {
        Self::with(track, &track.point.competitors, maker)
    }

    /// The same without competitors.
    pub fn lean(track: &'a PictureTrack, maker: &'a PictureMaker) -> Self {
        Self::with(track, &[], maker)
    }

    fn with(track: &'a PictureTrack, competitors: &[Competitor], maker: &'a PictureMaker) -> Self {
        let source = &track.point.source;
        let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
        Self {
            id: maker.track_id(track),
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
            // What is rounded up to 360 is north.
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
            uas_id: source.transponder().and_then(UasId::new),
            aircraft: source.transponder().and_then(AircraftJson::new),
            remote_id: source.transponder().and_then(|part| RemoteIdJson::new(&part.aircraft.declared)),
            integrity: TrackIntegrity::new(track),
            first_seen: track.point.first_seen.into(),
            last_measurement: motion.and_then(|motion| motion.last_measurement).map(Rfc3339),
            contributors: contributors(&track.point, competitors, maker),
        }
    }
}

impl TrackJson<'_> {
    /// The track's id.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Longitude, degrees.
    pub fn lng(&self) -> f64 {
        self.lng
    }

    /// Latitude, degrees.
    pub fn lat(&self) -> f64 {
        self.lat
    }

    /// Height above the ellipsoid, metres, where it was measured.
    pub fn alt(&self) -> Option<f64> {
        self.alt
    }
}

impl<'a> UasId<'a> {
    /// `None` of an aircraft that has no identity of a drone.
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
    /// `None` of an aircraft without an ICAO address.
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
) -> Vec<Contributor<'a>> {
    let rivals = |of_radar: bool| {
        let is_of = |rival: &&Competitor| matches!(rival.who, Rival::Transponder { .. }) == of_radar;
        competitors.iter().filter(is_of).map(|rival| competitor(rival, maker)).collect()
    };
    let radar = |part: &RadarPart, weight| Contributor {
        kind: ContributorKind::Radar.name(),
        sensor: maker.sensor(part.track.sensor),
        track_number: part.track.number.into(),
        time: Some(part.time.into()),
        weight,
        height_measured: Some(part.height_measured),
        competitors: rivals(true),
        ..Contributor::default()
    };
    let transponder = |part: &TransponderPart, weight| Contributor {
        kind: ContributorKind::Transponder.name(),
        sensor: maker.sensor(part.sensor),
        track_number: part.number,
        time: part.time.map(Rfc3339),
        weight,
        competitors: rivals(false),
        ..Contributor::default()
    };
    let camera = |part: &CameraPart| Contributor {
        kind: ContributorKind::Camera.name(),
        sensor: maker.sensor(part.track.sensor),
        track_number: part.track.number.into(),
        time: Some(part.time.into()),
        ..Contributor::default()
    };
    // With a direction beside it, no share is fixed.
    let alone = point.cameras.is_empty().then_some(1.0);
    let mut contributors = match &point.source {
        Source::Fused(radar_part, transponder_part, pair) => {
            let mut radar = radar(radar_part, None);
            let mut transponder = transponder(transponder_part, None);
            radar.distance_m = Some(rounded(pair.distance_m, 3));
            match pair.because {
                Because::Ratio { threshold_m, ratio } => {
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
                Because::Likelihood { score } => {
                    radar.log_likelihood_ratio = Some(rounded(score, 2));
                    radar.threshold = Some(Threshold { join: ASSOCIATE_LLR, part: DISSOCIATE_LLR });
                }
                Because::Manual { score } => {
                    radar.manual = true;
                    radar.log_likelihood_ratio = score.map(|score| rounded(score, 2));
                    radar.threshold = Some(Threshold { join: ASSOCIATE_LLR, part: DISSOCIATE_LLR });
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

/// The name of an identity: of a text, what is not printable ASCII is escaped; a flight's is a UUID with hyphens, a session's
/// is hexadecimal.
pub fn serial_text(identity: Identity) -> String {
    name(&identity).into_owned()
}

fn name(identity: &Identity) -> Cow<'_, str> {
    match identity.space() {
        Space::Serial | Space::Address | Space::Registration => escaped(identity.name()),
        Space::Flight => Cow::Owned(uuid(identity.name())),
        Space::Session => Cow::Owned(crate::hex::text(identity.name())),
    }
}

/// 16 octets as the text of a UUID (RFC 9562).
fn uuid(octets: &[u8]) -> String {
    let mut text = crate::hex::text(octets);
    [20, 16, 12, 8].into_iter().for_each(|at| text.insert(at, '-'));
    text
}

/// Octets as text without the padding; what is not printable ASCII is escaped. `None` where nothing is left.
pub fn text(octets: &[u8]) -> Option<Cow<'_, str>> {
    let text = match escaped(octets) {
        Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
        Cow::Owned(text) => Cow::Owned(text.replace("\\x00", " ").trim().to_owned()),
    };
    (!text.is_empty()).then_some(text)
}

/// Octets as text; what is not printable ASCII is escaped, and so are quotes and backslashes.
fn escaped(octets: &[u8]) -> Cow<'_, str> {
    let is_plain = |octet: &u8| matches!(octet, b' '..=b'~') && !matches!(octet, b'\'' | b'"' | b'\\');
    match str::from_utf8(octets) {
        Ok(text) if octets.iter().all(is_plain) => Cow::Borrowed(text),
        _ => Cow::Owned(octets.escape_ascii().to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        #[test]
        fn a_text_is_escaped_where_it_must_be(octets: Vec<u8>, ascii in "[ -~]{0,12}") {
            for octets in [&octets[..], ascii.as_bytes()] {
                proptest::prop_assert_eq!(escaped(octets), octets.escape_ascii().to_string());
            }
        }
    }

    #[test]
    fn flight_identity_is_named_as_a_uuid() {
        let octets = *b"\x00\x11\xaa\x11\xbb\x22\xcc\x43\x4d\x8d\x00\x11\x22\x33\x44\x20";
        let flight = Identity::of_name(Space::Flight, &octets).unwrap();
        assert_eq!(serial_text(flight), "0011aa11-bb22-cc43-4d8d-001122334420");
        let session = Identity::of_name(Space::Session, b"\x01XYZ").unwrap();
        assert_eq!(serial_text(session), format!("0158595a{}", "00".repeat(16)));
    }

    #[test]
    fn padding_is_no_text() {
        assert_eq!(
            [text(b" \0 "), text(b"DJI\0"), text(b" N O"), text(b"a\xff ")]
                .map(|text| text.map(Cow::into_owned)),
            [None, Some("DJI".to_owned()), Some("N O".to_owned()), Some("a\\xff".to_owned())]
        );
    }
}
