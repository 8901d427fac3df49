//! A track as JSON: the properties of the HTTP API, one object a line in `replay --output-format ndjson`.

use serde::Serialize;

use super::{PictureMaker, Track};
use crate::json::rounded;
use fusion::Identity;
use fusion::Source;
use fusion::operational::{ASSOCIATE_LLR, DISSOCIATE_LLR};
use fusion::point::{Competitor, RadarPart, Rival, TransponderPart};

/// Metres, degrees, RFC 3339 UTC; what is unknown is left out.
#[derive(Clone, Debug, Serialize)]
pub struct TrackJson<'a> {
    id: String,
    source: &'static str,
    track_number: u32,
    state: &'static str,
    time: String,
    lat: f64,
    lng: f64,
    /// Above the ellipsoid.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt: Option<f64>,
    /// Above mean sea level.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt_msl: Option<f64>,
    geoid_separation: f64,
    /// Over ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    track: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertical_speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy_h_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy_v_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy_h: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy_v: Option<&'static str>,
    interpolated: bool,
    extrapolated: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    uav_probability: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    uas_id: Option<UasId>,
    first_seen: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    last_measurement: Option<String>,
    contributors: Vec<Contributor<'a>>,
}

#[derive(Clone, Debug, Serialize)]
struct UasId {
    serial_number: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    manufacturer: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_country: Option<String>,
}

/// Who took part and, of a fused pair, why.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Contributor<'a> {
    Radar {
        sensor: &'a str,
        track_number: u16,
        time: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        weight: Option<f64>,
        height_measured: bool,
        #[serde(flatten)]
        association: Option<Association>,
        #[serde(skip_serializing_if = "Vec::is_empty")]
        competitors: Vec<CompetitorJson<'a>>,
    },
    Transponder {
        sensor: &'a str,
        track_number: u32,
        #[serde(skip_serializing_if = "Option::is_none")]
        time: Option<String>,
        #[serde(skip_serializing_if = "Option::is_none")]
        weight: Option<f64>,
        #[serde(skip_serializing_if = "Vec::is_empty")]
        competitors: Vec<CompetitorJson<'a>>,
    },
}

/// Who else could have taken this part of the track: of a radar's a transponder, of a transponder's a radar track.
#[derive(Clone, Debug, Serialize)]
struct CompetitorJson<'a> {
    sensor: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    track_number: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    uas_id: Option<Who>,
    log_likelihood_ratio: f64,
    /// An operator has said that it is not.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    decorrelated: bool,
}

/// A transponder by what it is told apart.
#[derive(Clone, Debug, Serialize)]
pub struct Who {
    serial_number: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_country: Option<String>,
}

impl Who {
    /// Of that identity.
    pub fn new(identity: Identity) -> Self {
        Self {
            serial_number: identity.serial().escape_ascii().to_string(),
            registration_country: text(identity.country()),
        }
    }
}

/// From where on two begin to be one, and below which they part: logarithms of likelihood ratios.
#[derive(Clone, Copy, Debug, Serialize)]
struct Threshold {
    join: f64,
    part: f64,
}

const THRESHOLD: Threshold = Threshold { join: ASSOCIATE_LLR, part: DISSOCIATE_LLR };

#[derive(Clone, Copy, Debug, Serialize)]
struct Association {
    distance_m: f64,
    #[serde(flatten)]
    because: Because,
}

#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
enum Because {
    Ratio {
        threshold_m: f64,
        ratio: f64,
        within: u32,
        co_present: u32,
    },
    Likelihood {
        log_likelihood_ratio: f64,
        threshold: Threshold,
    },
    Manual {
        manual: bool,
        #[serde(skip_serializing_if = "Option::is_none")]
        log_likelihood_ratio: Option<f64>,
        threshold: Threshold,
    },
}

impl<'a> TrackJson<'a> {
    /// Of a track of `maker`'s.
    pub fn new(track: &Track, maker: &'a PictureMaker) -> Self {
        Self::with(track, &track.point.competitors, maker)
    }

    /// Without who else could be its parts.
    pub fn lean(track: &Track, maker: &'a PictureMaker) -> Self {
        Self::with(track, &[], maker)
    }

    fn with(track: &Track, competitors: &[Competitor], maker: &'a PictureMaker) -> Self {
        let source = &track.point.source;
        let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
        Self {
            id: maker.track_id(track),
            source: track.source_name(),
            track_number: track.point.number,
            state: if track.is_coasting() { "coasting" } else { "active" },
            time: track.time.to_string(),
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
            interpolated: track.is_interpolated(),
            extrapolated: track.is_extrapolated(),
            uav_probability: source.radar().and_then(|radar| radar.uav_probability).map(|p| rounded(p, 4)),
            uas_id: source.transponder().map(UasId::new),
            first_seen: track.point.first_seen.to_string(),
            last_measurement: motion.and_then(|motion| motion.last_measurement).map(|time| time.to_string()),
            contributors: contributors(source, competitors, maker),
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

impl UasId {
    fn new(part: &TransponderPart) -> Self {
        Self {
            serial_number: part.identity.serial().escape_ascii().to_string(),
            manufacturer: part.items.manufacturer.and_then(|octets| text(&octets)),
            model: part.items.model.and_then(|octets| text(&octets)),
            registration_country: part.items.registration_country.and_then(|octets| text(&octets)),
        }
    }
}

fn contributors<'a>(
    source: &Source,
    competitors: &[Competitor],
    maker: &'a PictureMaker,
) -> Vec<Contributor<'a>> {
    let rivals = |of_radar: bool| {
        let is_of = |rival: &&Competitor| matches!(rival.who, Rival::Transponder { .. }) == of_radar;
        competitors.iter().filter(is_of).map(|rival| competitor(rival, maker)).collect()
    };
    let radar = |part: &RadarPart, weight, association| Contributor::Radar {
        sensor: maker.sensor(part.track.sensor),
        track_number: part.track.number,
        time: part.time.to_string(),
        weight,
        height_measured: part.height_measured,
        association,
        competitors: rivals(true),
    };
    let transponder = |part: &TransponderPart, weight| Contributor::Transponder {
        sensor: maker.sensor(part.sensor),
        track_number: part.number,
        time: part.time.map(|time| time.to_string()),
        weight,
        competitors: rivals(false),
    };
    match source {
        Source::Fused(radar_part, transponder_part, pair) => {
            let (because, weights) = match pair.because {
                fusion::point::Because::Ratio { threshold_m, ratio } => {
                    let because = Because::Ratio {
                        threshold_m: rounded(threshold_m, 3),
                        ratio: rounded(ratio.value(), 4),
                        within: ratio.within,
                        co_present: ratio.co_present,
                    };
                    let super::Weights { radar, transponder } = maker.weights;
                    let share = |weight: f64| Some(rounded(weight / (radar + transponder), 4));
                    (because, [share(radar), share(transponder)])
                }
                // Nothing is weighted by a fixed number.
                fusion::point::Because::Likelihood { score } => {
                    let log_likelihood_ratio = rounded(score, 2);
                    (Because::Likelihood { log_likelihood_ratio, threshold: THRESHOLD }, [None; 2])
                }
                fusion::point::Because::Manual { score } => {
                    let log_likelihood_ratio = score.map(|score| rounded(score, 2));
                    let because =
                        Because::Manual { manual: true, log_likelihood_ratio, threshold: THRESHOLD };
                    (because, [None; 2])
                }
            };
            let association = Association { distance_m: rounded(pair.distance_m, 3), because };
            vec![radar(radar_part, weights[0], Some(association)), transponder(transponder_part, weights[1])]
        }
        Source::Radar(part) => vec![radar(part, Some(1.0), None)],
        Source::Transponder(part) => vec![transponder(part, Some(1.0))],
    }
}

fn competitor<'a>(rival: &Competitor, maker: &'a PictureMaker) -> CompetitorJson<'a> {
    let (sensor, track_number, uas_id) = match rival.who {
        Rival::Radar(track) => (track.sensor, Some(track.number.into()), None),
        Rival::Transponder { sensor, number, identity } => (sensor, number, Some(Who::new(identity))),
    };
    CompetitorJson {
        sensor: maker.sensor(sensor),
        track_number,
        uas_id,
        log_likelihood_ratio: rounded(rival.score, 2),
        decorrelated: rival.decorrelated,
    }
}

/// Octets as text without the padding; what is not printable ASCII is escaped. `None` where nothing is left.
fn text(octets: &[u8]) -> Option<String> {
    let escaped = octets.escape_ascii().to_string().replace("\\x00", " ");
    let trimmed = escaped.trim();
    (!trimmed.is_empty()).then(|| trimmed.to_owned())
}
