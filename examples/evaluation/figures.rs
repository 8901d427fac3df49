//! The figures of a score, and the streams and groups that have them.

use utm_fusion::evaluate::{ErrorStatistics, Nees, Score};

use crate::score::Scores;

/// A figure of a score.
pub type Figure = fn(&Score) -> Option<f64>;
/// The score of one stream and group of drones.
pub type Group = fn(&Scores) -> &Score;
/// The score of each drone of a group.
pub type Each = fn(&Scores) -> &[Score];

pub const PU: Figure = |score| score.pu_percent;
pub const EPOS: Figure = |score| mean_of(score.epos);
pub const SEM_EPOS: Figure = |score| sem_of(score.epos);
pub const EPOSH: Figure = |score| mean_of(score.eposh);
pub const SEM_EPOSH: Figure = |score| sem_of(score.eposh);
pub const EPOSV: Figure = |score| mean_of(score.eposv);
pub const SEM_EPOSV: Figure = |score| sem_of(score.eposv);
pub const COVERED: Figure = |score| mean_of(score.epos_covered);
pub const GAP: Figure = |score| mean_of(score.epos_gap);
pub const ONE_RADAR: Figure = |score| mean_of(score.epos_one_radar);
pub const SEVERAL_RADARS: Figure = |score| mean_of(score.epos_radars);
pub const PRECISION: Figure = |score| score.precision;
pub const RECALL: Figure = |score| score.recall;
pub const F1: Figure = |score| {
    let (precision, recall) = score.precision.zip(score.recall)?;
    Some(2.0 * precision * recall / (precision + recall))
};
pub const ID_CHANGES: Figure = |score| score.id_changes;
pub const GAP_WITHIN_50_M: Figure = |score| score.gap_within_50_m_percent;
pub const TWO_NUMBERS: Figure = |score| score.two_numbers_percent;
pub const GHOSTS: Figure = |score| score.ghosts_s;
pub const FALSE_TRACK: Figure = |score| score.false_track_s;
pub const GOSPA: Figure = |score| score.gospa_m;
pub const NEES: Figure = |score| horizontal(score.nees);
pub const NEES_COVERED: Figure = |score| horizontal(score.nees_covered);
pub const NEES_GAP: Figure = |score| horizontal(score.nees_gap);
pub const NEES_STRAIGHT: Figure = |score| horizontal(score.nees_straight);
pub const NEES_TURNING: Figure = |score| horizontal(score.nees_turning);
pub const NEES_WALKED_OFF: Figure = |score| horizontal(score.nees_walked_off);
pub const NEES_V: Figure = |score| score.nees?.vertical;
pub const NEES_V_COVERED: Figure = |score| score.nees_covered?.vertical;
pub const NEES_V_GAP: Figure = |score| score.nees_gap?.vertical;

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
pub struct Stream {
    pub all: Group,
    pub equipped: Group,
    pub unequipped: Group,
    pub each_equipped: Each,
    pub each_unequipped: Each,
}

macro_rules! streams {
    ($($name:ident: $stream:ident;)*) => {
        $(pub const $name: Stream = Stream {
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
