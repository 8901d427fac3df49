//! Conflicts as JSON: for `/api/v1/conflicts`, for the stream, and as a line of `replay --conflicts`.

use schemars::JsonSchema;
use serde::Serialize;

use super::Conflict;
use crate::{Rfc3339, StateName};
use conflict::{Level, Relative, Volume};
use fusion::frames::Geodetic;
use input::json::rounded;

/// Level of a conflict without a level.
pub const NO_LEVEL: &str = "none";

/// Names of all levels.
pub fn levels() -> Vec<&'static str> {
    [NO_LEVEL].into_iter().chain(Level::NAMES).collect()
}

/// Two aircraft that may come near each other, evaluated for one volume.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Conflict")]
pub struct ConflictJson {
    /// Id of the conflict: constant for the pair as long as a level holds; absent if none does.
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<String>,
    /// Time of the evaluation.
    time: Rfc3339,
    /// Last time at which both aircraft were present, if one is missing now. All figures are of that time.
    #[serde(skip_serializing_if = "Option::is_none")]
    seen: Option<Rfc3339>,
    /// Track id of aircraft a.
    a: String,
    /// Track id of aircraft b.
    b: String,
    /// Name of the volume.
    volume: String,
    #[schemars(extend("enum" = levels()))]
    level: &'static str,
    /// Time since which the level holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    since: Option<Rfc3339>,
    /// Time to the closest point of approach, seconds; 0 if the aircraft fly apart.
    #[schemars(range(min = 0))]
    t_cpa_s: f64,
    /// Horizontal distance at the closest point of approach, metres.
    #[schemars(range(min = 0))]
    d_cpa_h_m: f64,
    /// Vertical distance at the closest point of approach, metres; absent if the height of one aircraft is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    d_cpa_v_m: Option<f64>,
    /// Present horizontal distance, metres.
    #[schemars(range(min = 0))]
    d_now_h_m: f64,
    /// Present vertical distance, metres; absent if the height of one aircraft is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    d_now_v_m: Option<f64>,
    /// Time to the expected entry of the volume, seconds; 0 if it is violated now. If the expected paths miss the volume: time
    /// to the point where they come nearest to it.
    #[schemars(range(min = 0))]
    t_entry_s: f64,
    /// Time to the expected exit from the volume, seconds, at most the horizon; absent if the expected paths miss the volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    t_exit_s: Option<f64>,
    /// Probability of being inside the volume at any time within the horizon.
    #[schemars(range(min = 0, max = 1))]
    probability: f64,
    /// Whether the heights of both aircraft are known. If not, they are assumed to be equal or, if `vertical_coarse`, to differ as
    /// far as they are bounded, and the level is at most an advisory.
    vertical_known: bool,
    /// Whether the height of one aircraft is only a coarse bound.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    vertical_coarse: bool,
    /// Whether the volume is entered at the time of the figures.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    entered: bool,
    miss: MissJson,
    cpa: CpaJson,
    /// State of the less trustworthy of the two transponders.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrity: Option<StateName>,
}

/// Relative position of b to a at the closest point of approach, with its uncertainty.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct MissJson {
    /// Horizontal component across the relative velocity, metres.
    across_m: f64,
    /// Vertical component, upwards, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    vertical_m: Option<f64>,
    /// Covariance of the two components: across, vertical; the vertical variance is 0 if a height is unknown.
    covariance_m2: [[f64; 2]; 2],
}

/// Positions at the closest point of approach: longitude, latitude (degrees) and, if known, height above the ellipsoid (metres).
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct CpaJson {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl From<&Conflict> for ConflictJson {
    fn from(conflict: &Conflict) -> Self {
        let Conflict { time, seen, found, tracks: [a, b], volume, cpa, integrity, .. } = conflict;
        let approach = &found.approach;
        let is_known = conflict.are_heights_known;
        let vertical_m = approach.vertical.filter(|_| is_known).map(|(height_m, _)| height_m);
        let height_m2 = approach.vertical.filter(|_| is_known).map_or(0.0, |(_, m2)| m2);
        let now = found.relative.vertical.filter(|_| is_known);
        let [cpa_a, cpa_b] = cpa.map(|(place, height_m)| position(place, height_m));
        Self {
            id: found.id.map(|id| format!("C-{id}")),
            time: (*time).into(),
            seen: (!conflict.is_seen()).then(|| (*seen).into()),
            a: a.clone(),
            b: b.clone(),
            volume: volume.clone(),
            level: conflict.level().map_or(NO_LEVEL, Level::name),
            since: found.level.map(|(_, since)| since.into()),
            t_cpa_s: rounded(approach.t_cpa_s, 2),
            d_cpa_h_m: rounded(approach.horizontal_m(), 2),
            d_cpa_v_m: vertical_m.map(|height_m| rounded(height_m.abs(), 2)),
            d_now_h_m: rounded(found.relative.position.norm(), 2),
            d_now_v_m: now.map(|vertical| rounded(vertical.height_m.abs(), 2)),
            t_entry_s: rounded(found.entry_s, 2),
            t_exit_s: found.exit_s.map(|exit_s| rounded(exit_s, 2)),
            probability: rounded(found.probability, 4),
            vertical_known: is_known,
            vertical_coarse: found.relative.vertical.is_some() && !is_known,
            entered: conflict.is_entered(),
            miss: MissJson {
                across_m: rounded(approach.across.dot(&approach.miss), 2),
                vertical_m: vertical_m.map(|height_m| rounded(height_m, 2)),
                covariance_m2: [[rounded(approach.across_m2(), 2), 0.0], [0.0, rounded(height_m2, 2)]],
            },
            cpa: CpaJson { a: cpa_a, b: cpa_b },
            integrity: integrity.map(StateName::from),
        }
    }
}

fn position(place: Geodetic, height_m: Option<f64>) -> Vec<f64> {
    let over_ground = [rounded(place.longitude_deg(), 7), rounded(place.latitude_deg(), 7)];
    over_ground.into_iter().chain(height_m.map(|height_m| rounded(height_m, 2))).collect()
}

/// A line of `replay --conflicts`: the conflict and the values from which it was calculated.
#[derive(Serialize)]
pub struct ConflictLine {
    #[serde(flatten)]
    conflict: ConflictJson,
    relative: RelativeJson,
}

/// Position and velocity of b relative to a, before the covariance grows.
#[derive(Serialize)]
struct RelativeJson {
    /// East, north, up, metres.
    position_m: [Option<f64>; 3],
    /// East, north, up, metres per second.
    velocity_ms: [Option<f64>; 3],
    /// Covariance of east, north and their rates.
    covariance: [[f64; 4]; 4],
}

impl From<&Conflict> for ConflictLine {
    fn from(conflict: &Conflict) -> Self {
        Self { conflict: conflict.into(), relative: (&conflict.found.relative).into() }
    }
}

impl From<&Relative> for RelativeJson {
    fn from(relative: &Relative) -> Self {
        let Relative { position, velocity, covariance, vertical } = relative;
        let with = |plane: &nalgebra::Vector2<f64>, up: Option<f64>| {
            [Some(plane.x), Some(plane.y), up].map(|number| number.map(|number| rounded(number, 3)))
        };
        Self {
            position_m: with(position, vertical.map(|vertical| vertical.height_m)),
            velocity_ms: with(velocity, vertical.map(|vertical| vertical.climb)),
            covariance: std::array::from_fn(|row| {
                std::array::from_fn(|column| rounded(covariance[(row, column)], 4))
            }),
        }
    }
}

/// A volume around each aircraft.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Volume")]
pub struct VolumeJson {
    name: String,
    /// Radius, metres.
    horizontal_m: f64,
    /// Half of the height, metres.
    vertical_m: f64,
    /// Modified tau up to which the volume counts as entered, seconds; 0: not used.
    tau_s: f64,
}

impl From<&Volume> for VolumeJson {
    fn from(volume: &Volume) -> Self {
        let Volume { name, horizontal_m, vertical_m, tau_s, .. } = volume;
        Self {
            name: name.clone(),
            horizontal_m: rounded(*horizontal_m, 2),
            vertical_m: rounded(*vertical_m, 2),
            tau_s: *tau_s,
        }
    }
}
