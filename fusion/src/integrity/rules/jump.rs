//! `jump`: a report is far from the extrapolated motion, and the next two reports continue from its position.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::edge::{GapEdge, GapMiss};
use super::history::ReportHistory;
use crate::time::Time;

/// Longest gap for which a jump is reported, seconds.
const GAP_MAX_S: f64 = 8.0;
/// Longest gap for which the motions on both sides are compared, seconds.
const BREAK_GAP_MAX_S: f64 = 30.0;
/// Miss that reflections can cause at a poor receiver, metres: they shift it by 5 to 15.
const RECEIVER_M: f64 = 20.0;
/// Number of standard deviations allowed for noise.
const NOISE_SIGMAS: f64 = 6.0;
/// Acceleration on one side of the gap above which more than one report is false, m/s².
const MOTION_MAX_M_S2: f64 = 12.0;
/// Share of the limit above which a miss may be an exchange of positions with another nearby identity.
const BREAK_SHARE: f64 = 0.7;
/// Time for which a jump holds, in which radar can observe the new position several times.
const HOLDS: SignedDuration = SignedDuration::from_secs(30);
/// Time after which a gap without later reports is skipped.
const WAITED: SignedDuration = SignedDuration::from_secs(16);

/// A break: the motion ends at one position and continues at another.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct MotionBreak {
    pub(super) before: GapEdge,
    pub(super) after: GapEdge,
    /// Distance from a continuous motion, metres.
    pub(super) miss_m: f64,
    /// White noise of the receiver, metres on each axis.
    pub(super) noise_m: f64,
    /// Whether the motion cannot be continuous; otherwise there was only a long gap.
    pub(super) is_certain: bool,
}

/// State of the jump rule for a stream.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Jump {
    /// Time of the report up to which gaps were evaluated.
    judged: Time,
    noise: ReceiverNoise,
    /// Time of the last report that jumped.
    last: Option<Time>,
}

impl Default for Jump {
    fn default() -> Self {
        Self { judged: Time::from_nanos(i64::MIN), noise: ReceiverNoise::default(), last: None }
    }
}

impl Jump {
    /// Evaluates the next gap with reports on both sides; returns the break, if any. `None`: no gap can be evaluated yet.
    pub(super) fn evaluate_next_gap(&mut self, history: &ReportHistory) -> Option<Option<MotionBreak>> {
        let at = history.after(self.judged).max(1);
        let (earlier, later) = (history.get(at - 1)?, history.get(at)?);
        let gap_s = later.time.seconds_since(earlier.time);
        let after = GapEdge::new(history.from(at), gap_s).filter(GapEdge::is_whole);
        let is_waiting = history.newest().is_some_and(|newest| newest.time - later.time <= WAITED);
        if after.is_none() && gap_s <= BREAK_GAP_MAX_S && is_waiting {
            return None;
        }
        self.judged = later.time;
        if gap_s > BREAK_GAP_MAX_S {
            return Some(None);
        }
        let before = GapEdge::new(history.before(at), gap_s);
        Some(before.zip(after).and_then(|(before, after)| self.evaluate_gap(before, after)))
    }

    fn evaluate_gap(&mut self, before: GapEdge, after: GapEdge) -> Option<MotionBreak> {
        let miss = GapMiss::between(&before, &after)?;
        let was_silent = miss.gap_s > GAP_MAX_S;
        let fresh_m = miss.distance_m / miss.noise_gain;
        if miss.distance_m <= BREAK_SHARE * (RECEIVER_M + miss.by_turns_m) && !was_silent {
            self.noise.learn(fresh_m);
            return None;
        }
        let noise_m = self.noise_m();
        let limit_m = RECEIVER_M.max(NOISE_SIGMAS * noise_m * miss.noise_gain) + miss.by_turns_m;
        let is_motion = [&before, &after].iter().all(|edge| edge.is_motion(MOTION_MAX_M_S2, noise_m));
        let is_certain = before.has_motion() && miss.distance_m > BREAK_SHARE * limit_m;
        if !is_motion || !is_certain && !was_silent {
            self.noise.learn(fresh_m);
            return None;
        }
        if is_certain && miss.distance_m > limit_m && !was_silent {
            self.last = Some(after.time);
        }
        Some(MotionBreak { before, after, miss_m: miss.distance_m, noise_m, is_certain })
    }

    /// White noise of the receiver, metres on each axis.
    pub(super) fn noise_m(&self) -> f64 {
        self.noise.sigma_m()
    }

    pub(super) fn is_active(&self, deadline: Time) -> bool {
        self.last.is_some_and(|last| deadline <= last + HOLDS)
    }
}

/// White noise of a receiver on each axis, estimated from the misses over recent gaps: from the lowest sixth, since
/// turns add to many of the others.
#[derive(Debug, Serialize, Deserialize)]
struct ReceiverNoise {
    /// Recent misses, metres; the newest overwrite the oldest.
    #[serde(with = "crate::checkpoint::array")]
    lately_m: [f32; Self::GAPS],
    next: usize,
    known: usize,
}

impl Default for ReceiverNoise {
    fn default() -> Self {
        Self { lately_m: [Self::ASSUMED_M; Self::GAPS], next: Self::ASSUMED_GAPS, known: Self::ASSUMED_GAPS }
    }
}

impl ReceiverNoise {
    const GAPS: usize = 64;
    /// Prior: number of gaps and their miss, metres. Corresponds to a poor receiver, until a few gaps show a better one.
    const ASSUMED_GAPS: usize = 8;
    const ASSUMED_M: f32 = 10.0;
    /// One in this many misses is less than `LOWEST_SIGMAS`.
    const LOWEST: usize = 6;
    /// Quantile of the misses, in standard deviations of an axis: sqrt(2 ln(6/5)), Rayleigh distribution.
    const LOWEST_SIGMAS: f64 = 0.6039;

    fn learn(&mut self, miss_m: f64) {
        self.lately_m[self.next] = miss_m as f32;
        self.next = (self.next + 1) % Self::GAPS;
        self.known = (self.known + 1).min(Self::GAPS);
    }

    fn sigma_m(&self) -> f64 {
        let mut lately_m = self.lately_m;
        let known = &mut lately_m[..self.known];
        let (_, lowest, _) = known.select_nth_unstable_by(self.known / Self::LOWEST, f32::total_cmp);
        f64::from(*lowest) / Self::LOWEST_SIGMAS
    }
}
