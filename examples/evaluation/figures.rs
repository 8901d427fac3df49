//! Figures of a score, and the streams and groups that have them.

use utm_fusion::evaluate::{ErrorStatistics, Nees, StreamMetrics};

use crate::score::FlightScores;

/// A figure of a score.
pub type ScoreFigure = fn(&StreamMetrics) -> Option<f64>;
/// The score of one stream and group of drones.
pub type ScoreGroup = fn(&FlightScores) -> &StreamMetrics;
/// The score of each drone of a group.
pub type DroneScores = fn(&FlightScores) -> &[StreamMetrics];

pub const PU: ScoreFigure = |score| score.pu_percent;
pub const EPOS: ScoreFigure = |score| mean_of(score.epos);
pub const SEM_EPOS: ScoreFigure = |score| sem_of(score.epos);
pub const EPOSH: ScoreFigure = |score| mean_of(score.eposh);
pub const SEM_EPOSH: ScoreFigure = |score| sem_of(score.eposh);
pub const EPOSV: ScoreFigure = |score| mean_of(score.eposv);
pub const SEM_EPOSV: ScoreFigure = |score| sem_of(score.eposv);
pub const COVERED: ScoreFigure = |score| mean_of(score.epos_covered);
pub const GAP: ScoreFigure = |score| mean_of(score.epos_gap);
pub const ONE_RADAR: ScoreFigure = |score| mean_of(score.epos_one_radar);
pub const SEVERAL_RADARS: ScoreFigure = |score| mean_of(score.epos_radars);
pub const PRECISION: ScoreFigure = |score| score.precision;
pub const RECALL: ScoreFigure = |score| score.recall;
pub const F1: ScoreFigure = |score| {
    let (precision, recall) = score.precision.zip(score.recall)?;
    Some(2.0 * precision * recall / (precision + recall))
};
pub const ID_CHANGES: ScoreFigure = |score| score.id_changes;
pub const GAP_WITHIN_50_M: ScoreFigure = |score| score.gap_within_50_m_percent;
pub const TWO_NUMBERS: ScoreFigure = |score| score.two_numbers_percent;
pub const GHOSTS: ScoreFigure = |score| score.ghosts_s;
pub const FALSE_TRACK: ScoreFigure = |score| score.false_track_s;
pub const GOSPA: ScoreFigure = |score| score.gospa_m;
pub const NEES: ScoreFigure = |score| horizontal(score.nees);
pub const NEES_COVERED: ScoreFigure = |score| horizontal(score.nees_covered);
pub const NEES_GAP: ScoreFigure = |score| horizontal(score.nees_gap);
pub const NEES_STRAIGHT: ScoreFigure = |score| horizontal(score.nees_straight);
pub const NEES_TURNING: ScoreFigure = |score| horizontal(score.nees_turning);
pub const NEES_WALKED_OFF: ScoreFigure = |score| horizontal(score.nees_walked_off);
pub const NEES_V: ScoreFigure = |score| score.nees?.vertical;
pub const NEES_V_COVERED: ScoreFigure = |score| score.nees_covered?.vertical;
pub const NEES_V_GAP: ScoreFigure = |score| score.nees_gap?.vertical;

fn mean_of(error: Option<ErrorStatistics>) -> Option<f64> {
    error.map(|error| error.mean_m)
}

fn sem_of(error: Option<ErrorStatistics>) -> Option<f64> {
    error.map(|error| error.sem_m)
}

fn horizontal(nees: Option<Nees>) -> Option<f64> {
    nees.map(|nees| nees.horizontal)
}

/// Points of one kind.
pub struct ScoreStream {
    pub all: ScoreGroup,
    pub equipped: ScoreGroup,
    pub unequipped: ScoreGroup,
    pub each_equipped: DroneScores,
    pub each_unequipped: DroneScores,
}

macro_rules! streams {
    ($($name:ident: $stream:ident;)*) => {
        $(pub const $name: ScoreStream = ScoreStream {
            all: |scores| &scores.$stream.all,
            equipped: |scores| &scores.$stream.equipped,
            unequipped: |scores| &scores.$stream.unequipped,
            each_equipped: |scores| &scores.$stream.each_equipped,
            each_unequipped: |scores| &scores.$stream.each_unequipped,
        };)*
    };
}
streams! {
    REFERENCE: reference;
    OPERATIONAL: operational;
    RADAR: radar;
    TRANSPONDER: transponder;
}
