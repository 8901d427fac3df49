//! `jump`: a report lies where the motion before it did not lead, and the next two go on from there.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::edge::{Edge, Miss};
use super::history::History;
use crate::time::Time;

/// After a longer silence the motion before it says too little, seconds;
const GAP_MAX_S: f64 = 8.0;
/// after a longer one than this nothing.
const BREAK_GAP_MAX_S: f64 = 30.0;
/// A miss that reflections make at a poor receiver, metres: they shift it by 5 to 15.
const RECEIVER_M: f64 = 20.0;
/// Noise in standard deviations.
const NOISE_SIGMAS: f64 = 6.0;
/// What turns faster than this on one side of the gap, m/s², is no aircraft: more than one report lies.
const MOTION_MAX_M_S2: f64 = 12.0;
/// A miss of this share may be a change of places with another one near by.
const BREAK_SHARE: f64 = 0.7;
/// A jump holds so long: by then radar has had a few looks at what it led to.
const HOLDS: SignedDuration = SignedDuration::from_secs(30);
/// Without the reports after it, a gap is passed over after this time.
const WAITED: SignedDuration = SignedDuration::from_secs(16);

/// The motion broke off at one place and went on at another one.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Break {
    pub(super) before: Edge,
    pub(super) after: Edge,
    /// How far it is from being one motion, metres.
    pub(super) miss_m: f64,
    /// White noise of its receiver, metres an axis.
    pub(super) noise_m: f64,
    /// Whether it cannot be one motion; otherwise it only was not heard for long.
    pub(super) is_certain: bool,
}

/// What is known of the jumps of a stream.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Jump {
    /// Gaps up to the report of this time have been judged.
    judged: Time,
    noise: Noise,
    /// Time of the report that jumped last.
    last: Option<Time>,
}

impl Default for Jump {
    fn default() -> Self {
        Self { judged: Time::from_nanos(i64::MIN), noise: Noise::default(), last: None }
    }
}

impl Jump {
    /// Judges the next gap that both sides are known of; the break that it is. `None`: there is none to judge.
    pub(super) fn judge(&mut self, history: &History) -> Option<Option<Break>> {
        let at = history.after(self.judged).max(1);
        let (earlier, later) = (history.get(at - 1)?, history.get(at)?);
        let gap_s = later.time.seconds_since(earlier.time);
        let after = Edge::new(history.from(at), gap_s).filter(Edge::is_whole);
        let is_waiting = history.newest().is_some_and(|newest| newest.time - later.time <= WAITED);
        if after.is_none() && gap_s <= BREAK_GAP_MAX_S && is_waiting {
            return None;
        }
        self.judged = later.time;
        if gap_s > BREAK_GAP_MAX_S {
            return Some(None);
        }
        let before = Edge::new(history.before(at), gap_s);
        Some(before.zip(after).and_then(|(before, after)| self.look(before, after)))
    }

    fn look(&mut self, before: Edge, after: Edge) -> Option<Break> {
        let miss = Miss::between(&before, &after)?;
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
        Some(Break { before, after, miss_m: miss.distance_m, noise_m, is_certain })
    }

    /// White noise of the receiver, metres an axis.
    pub(super) fn noise_m(&self) -> f64 {
        self.noise.sigma_m()
    }

    pub(super) fn holds(&self, deadline: Time) -> bool {
        self.last.is_some_and(|last| deadline <= last + HOLDS)
    }
}

/// White noise of a receiver, an axis, by how far motion misses over the gaps of late: the lowest sixth, since turns add to
/// many of the others.
#[derive(Debug, Serialize, Deserialize)]
struct Noise {
    /// The newest overwrite the oldest, metres.
    #[serde(with = "crate::checkpoint::array")]
    lately_m: [f32; Self::GAPS],
    next: usize,
    known: usize,
}

impl Default for Noise {
    fn default() -> Self {
        Self { lately_m: [Self::ASSUMED_M; Self::GAPS], next: Self::ASSUMED_GAPS, known: Self::ASSUMED_GAPS }
    }
}

impl Noise {
    const GAPS: usize = 64;
    /// As if so many gaps had missed by so much, metres, before the first: a poor receiver, until a few gaps show a better one.
    const ASSUMED_GAPS: usize = 8;
    const ASSUMED_M: f32 = 10.0;
    /// One in so many misses by less than
    const LOWEST: usize = 6;
    /// this, in standard deviations of an axis: sqrt(2 ln(6/5)), Rayleigh's distribution.
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
