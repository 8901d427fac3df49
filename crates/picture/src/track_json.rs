//! A track as JSON: the properties in the HTTP API, and one object per line in `replay --output-format ndjson`.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::contributor_json::{ContributorJson, contributors};
use super::integrity_json::TrackIntegrity;
use super::kinds::TrackState;
use super::remote_id_json::RemoteIdJson;
use super::texts::{name, text};
use super::{
    Ellipse, HORIZONTAL, PictureMaker, PictureTrack, Rfc3339, TrackClass, TrackSource, VERTICAL, class_names,
};
use fusion::point::{Competitor, TransponderPart};
use fusion::report::Space;
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
