//! Definition of conflicts: volumes, assumed motion and thresholds.

use super::encounter::Relative;
use super::extrapolation::Extrapolation;
use super::level::LevelVote;
use super::motion::PairMotion;
use super::passage::Passage;
use super::volume::Volume;

/// Share of a level's probability down to which the level is kept.
const KEPT_PROBABILITY: f64 = 0.5;

/// Probability that both fly straight to the entry below which a level needs a larger probability, and the factor on it:
/// turns end in any direction.
const TURNING: f64 = 0.25;
const TURNING_FACTOR: f64 = 2.0;
/// Probability from which on, and time to the entry (seconds) within which, one evaluation raises a level of two aircraft on
/// known legs.
const CLEAR: f64 = 0.3;
const URGENT_S: f64 = 15.0;

/// Factor on the size of a volume within which a violation is kept.
const KEPT_VOLUME: f64 = 1.1;

/// Minimum probability of a pair that is listed without a level; a lower one counts as zero.
pub(super) const WORTH_A_LINE: f64 = 0.01;

/// Thresholds of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelThreshold {
    /// Minimum probability.
    pub probability: f64,
    /// Maximum time to the entry of the volume, seconds.
    pub time_s: f64,
}

/// Definition of conflicts.
#[derive(Clone, Debug, PartialEq)]
pub struct ConflictRules {
    /// The volumes.
    pub volumes: Vec<Volume>,
    /// Assumed motion of the aircraft.
    pub ahead: Extrapolation,
    /// Thresholds of an advisory.
    pub advisory: LevelThreshold,
    /// Thresholds of a warning.
    pub warning: LevelThreshold,
}

impl ConflictRules {
    /// Result for each level.
    pub(super) fn level_votes(
        &self,
        volume: &Volume,
        relative: &Relative,
        passage: &Passage,
        motion: &PairMotion,
    ) -> [LevelVote; 3] {
        let is_entered = volume.is_entered(relative, 1.0);
        let is_kept = is_entered || volume.is_entered(relative, KEPT_VOLUME);
        let Passage { probability, entry_s, .. } = *passage;
        let is_turning = motion.share_at(entry_s) < TURNING;
        let factor = if is_turning { TURNING_FACTOR } else { 1.0 };
        let by = |threshold: LevelThreshold| LevelVote {
            reached: is_entered
                || (probability >= (factor * threshold.probability).min(1.0) && entry_s <= threshold.time_s),
            kept: is_kept || probability >= KEPT_PROBABILITY * threshold.probability,
            is_clear: probability >= CLEAR && entry_s <= URGENT_S && motion.are_legs_known && !is_turning,
        };
        [
            by(self.advisory),
            by(self.warning),
            LevelVote { reached: is_entered, kept: is_kept, is_clear: false },
        ]
    }
}
