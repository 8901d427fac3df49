//! Counters of one receiver, with the time of each.

use fusion::time::{DAY, SECOND};

use super::Unit;

/// Maximum difference of two stamps of one counter, in either direction, unless the recording pauses, in seconds.
const JUMP_S: i64 = 60;
/// Maximum number of counters in a stream that does not identify its receivers.
const BASES_MOST: usize = 64;

/// Clock of a receiver: one counter, or several where a stream merges receivers without their identities.
#[derive(Debug)]
pub(super) struct ReceiverClock {
    pub(super) unit: Unit,
    /// Counters, the last used one at the end.
    bases: Vec<TimeBase>,
    /// Last stamp that is far from all counters.
    astray: Option<i64>,
    /// Whether a stamp of a known counter followed that one.
    is_interleaved: bool,
}

/// Time of one counter.
#[derive(Clone, Copy, Debug)]
struct TimeBase {
    /// Time from the start of the recording to the first stamp, in nanoseconds.
    first_ns: i64,
    /// Ticks from the first stamp to the last.
    elapsed: i64,
    /// Ticks of the last stamp.
    last: i64,
}

impl TimeBase {
    /// Time from the start of the recording to the last stamp, in nanoseconds.
    fn now_ns(&self, unit: Unit) -> i64 {
        let (hz, _) = unit.scale();
        let elapsed_ns = i128::from(self.elapsed) * i128::from(SECOND) / i128::from(hz);
        self.first_ns.saturating_add(elapsed_ns as i64)
    }

    fn advance(&mut self, ticks: i64, unit: Unit) {
        self.elapsed = self.elapsed.saturating_add(difference(ticks, self.last, unit.scale().1));
        self.last = ticks;
    }
}

impl ReceiverClock {
    /// Clock before its first stamp.
    pub(super) fn new(unit: Unit) -> Self {
        Self { unit, bases: Vec::new(), astray: None, is_interleaved: false }
    }

    /// Whether no stamp was received yet.
    pub(super) fn is_new(&self) -> bool {
        self.bases.is_empty()
    }

    /// Adds a counter whose stamp `ticks` is at the time `first_ns`, in nanoseconds from the start of the recording.
    pub(super) fn begin(&mut self, ticks: i64, first_ns: i64) {
        if self.bases.len() == BASES_MOST {
            self.bases.remove(0);
        }
        self.bases.push(TimeBase { first_ns, elapsed: 0, last: ticks });
    }

    /// Time of a stamp by a counter that is at most `within_ns` away from it.
    pub(super) fn time_near(&self, ticks: i64, within_ns: i64) -> Option<i64> {
        let (hz, round) = self.unit.scale();
        let base = self.bases[self.nearest(ticks)?];
        let apart_ns = i128::from(difference(ticks, base.last, round)) * i128::from(SECOND) / i128::from(hz);
        (apart_ns.abs() <= i128::from(within_ns)).then(|| base.now_ns(self.unit) + apart_ns as i64)
    }

    /// Whether the stamp may belong to one of the counters.
    pub(super) fn has(&self, ticks: i64) -> bool {
        self.nearest(ticks).is_some()
    }

    /// Index of the counter nearest to this stamp, within [`JUMP_S`].
    fn nearest(&self, ticks: i64) -> Option<usize> {
        let (hz, round) = self.unit.scale();
        let distance = |base: &TimeBase| difference(ticks, base.last, round).abs();
        let nearest = self.bases.iter().enumerate().min_by_key(|(_, base)| distance(base));
        nearest.filter(|(_, base)| distance(base) <= JUMP_S * hz).map(|(index, _)| index)
    }

    /// Time of a stamp, in nanoseconds from the start of the recording. `None` for a stamp far from all counters, until
    /// another one agrees with it. Such stamps are from another receiver's counter, or a restarted one, whose first stamp
    /// is then at `now_ns`; or the recording has paused. `recurs` returns whether stamps of known counters follow.
    pub(super) fn time_ns(
        &mut self,
        ticks: i64,
        now_ns: i64,
        recurs: impl FnOnce(&Self) -> bool,
    ) -> Option<i64> {
        let (hz, round) = self.unit.scale();
        if let Some(index) = self.nearest(ticks) {
            let mut base = self.bases.remove(index);
            base.advance(ticks, self.unit);
            self.bases.push(base);
            self.is_interleaved = true;
            return Some(base.now_ns(self.unit));
        }
        let agrees = self.astray.replace(ticks).is_some_and(|before| {
            let apart = difference(ticks, before, round).abs();
            apart > 0 && apart <= JUMP_S * hz
        });
        let is_interleaved = std::mem::replace(&mut self.is_interleaved, false);
        if !agrees {
            return None;
        }
        self.astray = None;
        let last = self.bases.last()?.last;
        let is_counter = self.unit == Unit::Counter;
        if is_counter && (is_interleaved || difference(ticks, last, round) < 0 || recurs(self)) {
            self.begin(ticks, now_ns);
            return Some(now_ns);
        }
        let base = self.bases.last_mut()?;
        base.advance(ticks, self.unit);
        Some(base.now_ns(self.unit))
    }
}

/// Difference from `before` to `ticks`, over the shorter way round.
pub(super) fn difference(ticks: i64, before: i64, round: i64) -> i64 {
    let ahead = (ticks - before).rem_euclid(round);
    if ahead > round / 2 { ahead - round } else { ahead }
}

/// Time of the first GPS stamp of a receiver, in nanoseconds from the start of the recording: the one nearest to `now_ns`
/// with its time of day. `start_ns` is the time of day at which the recording starts.
pub(super) fn gps_first_ns(ticks: i64, start_ns: i64, now_ns: i64) -> i64 {
    let now_of_day = start_ns.saturating_add(now_ns).rem_euclid(DAY);
    now_ns + difference(ticks, now_of_day, DAY)
}
