//! The figures of a score, and the streams and groups that have them.

use utm_fusion::evaluate::{ErrorStatistics, Nees, Score};

use crate::score::{Groups, Scores};

/// A figure of a score.
pub type Figure = fn(&Score) -> Option<f64>;
/// The score of one stream and group.
pub type Group = fn(&Scores) -> &Score;

pub const PU: Figure = |score| score.pu_percent;
pub const EPOS: Figure = |score| mean_of(score.epos);
pub const EPOSH: Figure = |score| mean_of(score.eposh);
pub const EPOSV: Figure = |score| mean_of(score.eposv);
pub const COVERED: Figure = |score| mean_of(score.epos_covered);
pub const GAP: Figure = |score| mean_of(score.epos_gap);
pub const PRECISION: Figure = |score| score.precision;
pub const RECALL: Figure = |score| score.recall;
pub const ID_CHANGES: Figure = |score| score.id_changes;
pub const FALSE_TRACK: Figure = |score| score.false_track_s;
pub const GOSPA: Figure = |score| score.gospa_m;
pub const NEES: Figure = |score| horizontal(score.nees);
pub const NEES_COVERED: Figure = |score| horizontal(score.nees_covered);
pub const NEES_GAP: Figure = |score| horizontal(score.nees_gap);

fn mean_of(error: Option<ErrorStatistics>) -> Option<f64> {
    error.map(|error| error.mean_m)
}

fn horizontal(nees: Option<Nees>) -> Option<f64> {
    nees.map(|nees| nees.horizontal)
}

/// Covered slots of the profile that is told the transponders' delay, over the transponder's.
pub fn covered_with_delay(scores: &Scores) -> Option<f64> {
    Some(COVERED(&scores.delayed.as_ref()?.equipped)? / COVERED(&scores.transponder.equipped)?)
}

/// Of each drone that carries a transponder, what the `operational` profile scores.
pub fn each_equipped(scores: &Scores) -> &[Score] {
    &scores.operational.each_equipped
}

/// Of each drone that carries none.
pub fn each_unequipped(scores: &Scores) -> &[Score] {
    &scores.operational.each_unequipped
}

macro_rules! groups {
    ($($name:ident: $stream:ident $group:ident;)*) => {
        $(pub fn $name(scores: &Scores) -> &Score {
            let Groups { $group, .. } = &scores.$stream;
            $group
        })*
    };
}
groups! {
    reference: reference all;
    reference_equipped: reference equipped;
    reference_unequipped: reference unequipped;
    operational: operational all;
    operational_equipped: operational equipped;
    operational_unequipped: operational unequipped;
    radar: radar all;
    radar_equipped: radar equipped;
    radar_unequipped: radar unequipped;
    transponder: transponder all;
    transponder_equipped: transponder equipped;
}
