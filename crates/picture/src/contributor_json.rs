//! Sensor tracks that a track is made of, as JSON, and the other candidates.

use schemars::JsonSchema;
use serde::Serialize;

use super::kinds::ContributorKind;
use super::transponder_id::TransponderId;
use super::{PictureMaker, Rfc3339};
use fusion::Source;
use fusion::operational::{ASSOCIATE_LLR, DISSOCIATE_LLR};
use fusion::point::{AssociationEvidence, CameraPart, Competitor, Point, RadarPart, Rival, TransponderPart};
use input::json::rounded;

/// A sensor that contributes to a track. For the radar of a fused track, also the evidence of the association.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
#[schemars(rename = "Contributor")]
pub(crate) struct ContributorJson<'a> {
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

/// Thresholds of an association, as logarithms of likelihood ratios.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Threshold")]
struct AssociationThreshold {
    /// A pair is associated above this value.
    join: f64,
    /// A pair is separated below this value.
    part: f64,
}

pub(crate) fn contributors<'a>(
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
        Source::Cameras => Vec::new(),
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
