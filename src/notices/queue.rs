//! Notices that wait for one receiver: bounded, the most severe first, and one of an alert at most. Sans-IO.

use std::collections::VecDeque;
use std::sync::Arc;

use super::batch::Batch;
use super::counts::Loss;
use crate::live::{Alert, Change, Severity};
use fusion::time::{SECOND, Time};

/// Most notices that wait. By judgement: every drone of a city raising one at once.
pub(super) const WAITING: usize = 512;
/// Where more notices wait that are alike, they are delivered as one summary. By judgement: as many as a person reads.
pub(super) const ALIKE: usize = 16;
/// A notice of what has been over for longer than this bothers more than it helps, nanoseconds. By judgement.
const STALE_NS: i64 = 3_600 * SECOND;

/// That something has become of an alert.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notice {
    /// Counts the notices of a receiver: another content has another number.
    pub(super) number: u64,
    /// What has become of it at last.
    pub(super) change: Change,
    /// What else had become of it before, each once, and is not known to the receiver.
    pub(super) earlier: Vec<Change>,
    /// As it is since.
    pub(super) alert: Arc<Alert>,
    /// Since when.
    pub(super) at: Time,
    /// The greatest severity of the alert since the last notice that was sent.
    pub(super) severity: Severity,
}

/// The effect of a notice, as far as a summary distinguishes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// The alert is new to the receiver, and lasts.
    Began,
    /// The alert lasts, and has changed.
    Changed,
    /// The alert has ended.
    Ended,
    /// The alert has ended before its beginning was sent.
    Passed,
}

impl Effect {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Began => "began",
            Self::Changed => "changed",
            Self::Ended => "ended",
            Self::Passed => "began and ended",
        }
    }
}

impl Notice {
    /// This one stands for an earlier one of the same alert too.
    fn supersede(&mut self, older: &Self) {
        let mut earlier = Vec::new();
        for change in older.earlier.iter().chain([&older.change]).chain(&self.earlier) {
            if *change != self.change && !earlier.contains(change) {
                earlier.push(*change);
            }
        }
        self.earlier = earlier;
        self.severity = self.severity.max(older.severity);
    }

    fn is_stale(&self, now: Time) -> bool {
        self.alert.until.is_some() && now.nanos() - self.at.nanos() > STALE_NS
    }

    /// Whether the receiver does not know the alert yet.
    pub(super) fn is_first(&self) -> bool {
        self.change == Change::Began || self.earlier.contains(&Change::Began)
    }

    /// `None`: an operator did it, so that there is no flood of it, and it stays by itself.
    pub(super) fn effect(&self) -> Option<Effect> {
        match (self.change, self.is_first()) {
            (Change::Acknowledged | Change::Shelved | Change::Unshelved, _) => None,
            (Change::Ended, false) => Some(Effect::Ended),
            (Change::Ended, true) => Some(Effect::Passed),
            (Change::Began | Change::Changed | Change::Amended, true) => Some(Effect::Began),
            (Change::Began | Change::Changed | Change::Amended, false) => Some(Effect::Changed),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        let key = |notice: &Self| Some((notice.effect()?, notice.severity, notice.alert.kind));
        key(self).is_some_and(|own| key(other) == Some(own))
    }
}

/// The queue of one receiver.
#[derive(Debug)]
pub(super) struct Queue {
    bound: usize,
    alike: usize,
    /// Number of the next notice.
    next: u64,
    /// Waiting notices; of each severity the oldest comes first.
    waiting: VecDeque<Notice>,
    /// Alerts of the delivery that was taken last, and those of them of which a newer notice was dropped since: the older one
    /// is not sent again then.
    taken: Vec<u64>,
    outdated: Vec<u64>,
    /// Alerts of the delivery that failed last: others have the next turn.
    failed: Vec<u64>,
}

impl Queue {
    /// At most `bound` notices wait; more than `alike` of the same kind, severity and effect are summarised.
    pub(super) fn new(bound: usize, alike: usize) -> Self {
        Self {
            bound,
            alike,
            next: 1,
            waiting: VecDeque::new(),
            taken: Vec::new(),
            outdated: Vec::new(),
            failed: Vec::new(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Whether a critical notice waits.
    pub(super) fn is_urgent(&self) -> bool {
        self.waiting.iter().any(|notice| notice.severity == Severity::Critical)
    }

    /// Takes a change. One that waits already of the same alert is replaced in its place: what counts is how the alert is
    /// now. The notice that is dropped where there is one too many.
    pub(super) fn push(&mut self, change: Change, alert: Arc<Alert>, at: Time) -> Option<Notice> {
        let severity = alert.severity;
        let mut notice = Notice { number: self.next, change, earlier: Vec::new(), alert, at, severity };
        self.next += 1;
        if let Some(waiting) = self.waiting.iter_mut().find(|waiting| waiting.alert.id == notice.alert.id) {
            notice.supersede(waiting);
            *waiting = notice;
            return None;
        }
        self.waiting.push_back(notice);
        self.bound()
    }

    /// The next delivery: the oldest of the most severe notices, with those that are like it where these are many. It is
    /// put back where it was not delivered. `losses`: what is too old to be sent.
    pub(super) fn take(&mut self, now: Time, mut losses: impl FnMut(Loss)) -> Option<Batch> {
        let before = self.waiting.len();
        self.waiting.retain(|notice| !notice.is_stale(now));
        (self.waiting.len()..before).for_each(|_| losses(Loss::Stale));
        let failed = std::mem::take(&mut self.failed);
        let rank = |&(index, notice): &(usize, &Notice)| {
            (failed.contains(&notice.alert.id), std::cmp::Reverse(notice.severity), index)
        };
        let (index, _) = self.waiting.iter().enumerate().min_by_key(rank)?;
        let notice = self.waiting.remove(index)?;
        let mut alike = Vec::new();
        if self.waiting.iter().filter(|other| other.is_like(&notice)).count() >= self.alike {
            let (taken, others): (VecDeque<Notice>, _) =
                std::mem::take(&mut self.waiting).into_iter().partition(|other| other.is_like(&notice));
            (alike, self.waiting) = (taken.into(), others);
        }
        let batch = Batch::new(notice, alike);
        self.taken = batch.notices().map(|notice| notice.alert.id).collect();
        self.outdated.clear();
        Some(batch)
    }

    /// It was not delivered. It waits behind the others of its severity, and others have the next turn, so that one which is
    /// never taken does not keep them; where its alert has changed meanwhile, that notice stands for both. The notices that
    /// are dropped where there are too many.
    pub(super) fn put_back(&mut self, batch: Batch) -> Vec<Notice> {
        self.failed = std::mem::take(&mut self.taken);
        let mut dropped = Vec::new();
        for notice in batch.into_notices() {
            if self.outdated.contains(&notice.alert.id) {
                dropped.push(notice);
                continue;
            }
            if let Some(newer) = self.waiting.iter_mut().find(|waiting| waiting.alert.id == notice.alert.id) {
                newer.supersede(&notice);
                continue;
            }
            self.waiting.push_back(notice);
            dropped.extend(self.bound());
        }
        dropped
    }

    /// Drops the least severe where there is one too many: of these one that is over and of which the receiver was never told,
    /// else the oldest.
    fn bound(&mut self) -> Option<Notice> {
        if self.waiting.len() <= self.bound {
            return None;
        }
        let rank = |&(_, notice): &(usize, &Notice)| {
            (notice.severity, notice.effect() != Some(Effect::Passed), notice.number)
        };
        let (least, _) = self.waiting.iter().enumerate().min_by_key(rank)?;
        let dropped = self.waiting.remove(least)?;
        if self.taken.contains(&dropped.alert.id) {
            self.outdated.push(dropped.alert.id);
        }
        Some(dropped)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::super::body::tests::alert;
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * SECOND)
    }

    fn told(batch: Option<Batch>) -> Option<(u64, Change, Vec<Change>)> {
        let notice = batch?.single().expect("one notice").clone();
        Some((notice.alert.id, notice.change, notice.earlier))
    }

    fn critical(id: u64) -> Arc<Alert> {
        Arc::new(Alert { severity: Severity::Critical, ..Alert::clone(&alert(id)) })
    }

    fn ids(batch: &Batch) -> Vec<u64> {
        batch.notices().map(|notice| notice.alert.id).collect()
    }

    fn none(loss: Loss) {
        panic!("{loss:?}")
    }

    #[test]
    fn the_newest_state_of_an_alert_takes_the_place_of_what_waits() {
        let mut queue = Queue::new(4, ALIKE);
        for (change, id) in [
            (Change::Began, 1),
            (Change::Began, 2),
            (Change::Changed, 1),
            (Change::Acknowledged, 1),
            (Change::Changed, 1),
        ] {
            assert_eq!(queue.push(change, alert(id), at(0)), None);
        }
        let earlier = vec![Change::Began, Change::Acknowledged];
        assert_eq!(told(queue.take(at(0), none)), Some((1, Change::Changed, earlier)));
        assert_eq!(told(queue.take(at(0), none)), Some((2, Change::Began, vec![])));
        assert_eq!(queue.take(at(0), none), None);
    }

    #[test]
    fn what_is_not_delivered_waits_behind_the_others_or_in_what_came_meanwhile() {
        let mut queue = Queue::new(4, ALIKE);
        queue.push(Change::Began, alert(1), at(0));
        queue.push(Change::Began, alert(2), at(0));
        let first = queue.take(at(0), none).unwrap();
        queue.put_back(first);
        let second = queue.take(at(0), none).unwrap();
        queue.push(Change::Ended, alert(2), at(0));
        queue.put_back(second);
        assert_eq!(told(queue.take(at(0), none)), Some((1, Change::Began, vec![])));
        assert_eq!(told(queue.take(at(0), none)), Some((2, Change::Ended, vec![Change::Began])));
        assert_eq!(queue.len(), 0);
    }

    #[test]
    fn what_is_long_over_is_not_sent_and_what_lasts_is() {
        let mut queue = Queue::new(4, ALIKE);
        let over = Alert { until: Some(at(0)), ..Alert::clone(&alert(1)) };
        queue.push(Change::Ended, over.into(), at(0));
        queue.push(Change::Began, alert(2), at(0));
        let mut lost = Vec::new();
        assert_eq!(ids(&queue.take(at(3_601), |loss| lost.push(loss)).unwrap()), [2]);
        assert_eq!(lost, [Loss::Stale]);
    }

    #[test]
    fn critical_notice_is_taken_before_older_warnings() {
        let mut queue = Queue::new(8, ALIKE);
        queue.push(Change::Began, alert(1), at(0));
        queue.push(Change::Began, alert(2), at(0));
        queue.push(Change::Began, critical(3), at(1));
        assert_eq!(ids(&queue.take(at(1), none).unwrap()), [3]);
        // The alert is no longer critical, but no notice said so.
        queue.push(Change::Changed, critical(2), at(2));
        queue.push(Change::Changed, alert(2), at(3));
        assert_eq!(ids(&queue.take(at(3), none).unwrap()), [2]);
        assert_eq!(ids(&queue.take(at(3), none).unwrap()), [1]);
    }

    #[test]
    fn critical_notice_that_keeps_failing_alternates_with_others() {
        let mut queue = Queue::new(8, ALIKE);
        queue.push(Change::Began, critical(1), at(0));
        queue.push(Change::Began, alert(2), at(0));
        queue.push(Change::Began, alert(3), at(0));
        let mut turns = Vec::new();
        for _ in 0..5 {
            let batch = queue.take(at(0), none).unwrap();
            turns.extend(ids(&batch));
            if ids(&batch) == [1] {
                queue.put_back(batch);
            }
        }
        assert_eq!(turns, [1, 2, 1, 3, 1]);
    }

    #[test]
    fn many_notices_alike_are_one_batch_and_others_stay_single() {
        let mut queue = Queue::new(100, 3);
        (1..=9).for_each(|id| _ = queue.push(Change::Began, alert(id), at(0)));
        queue.push(Change::Acknowledged, alert(9), at(0));
        queue.push(Change::Ended, alert(8), at(0));
        queue.push(Change::Began, critical(20), at(0));
        assert_eq!(ids(&queue.take(at(0), none).unwrap()), [20]);
        let flood = queue.take(at(0), none).unwrap();
        assert_eq!(ids(&flood), [1, 2, 3, 4, 5, 6, 7]);
        // The notice of the alert that changed stands for both; the rest is summarised again, with another id.
        queue.push(Change::Ended, alert(3), at(1));
        let id = flood.id("run");
        queue.put_back(flood);
        assert_eq!(ids(&queue.take(at(1), none).unwrap()), [8]);
        assert_eq!(ids(&queue.take(at(1), none).unwrap()), [9]);
        assert_eq!(ids(&queue.take(at(1), none).unwrap()), [3]);
        let again = queue.take(at(1), none).unwrap();
        assert_eq!(ids(&again), [1, 2, 4, 5, 6, 7]);
        assert_ne!(again.id("run"), id);
        assert_eq!(queue.len(), 0);
    }

    #[test]
    fn full_queue_drops_the_least_severe_and_then_the_oldest() {
        let mut queue = Queue::new(4, ALIKE);
        queue.push(Change::Began, critical(1), at(0));
        (2..=4).for_each(|id| _ = queue.push(Change::Began, alert(id), at(0)));
        queue.push(Change::Ended, alert(4), at(1));
        let mut dropped = |id| queue.push(Change::Began, critical(id), at(2)).map(|notice| notice.alert.id);
        // The receiver misses least in what is over.
        assert_eq!([5, 6, 7, 8].map(&mut dropped), [Some(4), Some(2), Some(3), Some(1)]);
    }

    proptest! {
        /// Whatever comes and however often sending fails: no more than the bound waits, one of an alert at most and the newest
        /// of it, and what was neither lost nor delivered is there with all that became of it.
        #[test]
        fn the_queue_is_bounded_and_holds_the_newest(
            steps in prop::collection::vec((0_u64..9, 0_usize..4), 1..400),
        ) {
            const BOUND: usize = 5;
            let changes = [Change::Began, Change::Changed, Change::Acknowledged, Change::Ended];
            let mut queue = Queue::new(BOUND, 3);
            let mut newest: BTreeMap<u64, (Change, Time)> = BTreeMap::new();
            let (mut sending, mut lost): (Option<Batch>, usize) = (None, 0);
            for (step, &(id, what)) in steps.iter().enumerate() {
                let at = at(step as i64);
                match (id, sending.take()) {
                    (0, None) => sending = queue.take(at, none),
                    // Delivered.
                    (0, Some(batch)) if what == 0 => {
                        for notice in batch.notices() {
                            if newest.get(&notice.alert.id) == Some(&(notice.change, notice.at)) {
                                newest.remove(&notice.alert.id);
                            }
                        }
                    }
                    (0, Some(batch)) => lost += queue.put_back(batch).len(),
                    (id, was) => {
                        sending = was;
                        lost += usize::from(queue.push(changes[what], alert(id), at).is_some());
                        newest.insert(id, (changes[what], at));
                    }
                }
                prop_assert!(queue.len() <= BOUND);
            }
            if let Some(batch) = sending {
                lost += queue.put_back(batch).len();
            }
            prop_assert!(newest.len() <= queue.len() + lost);
            let mut seen = std::collections::BTreeSet::new();
            let mut notices = Vec::new();
            while let Some(batch) = queue.take(at(0), none) {
                notices.extend(batch.into_notices());
            }
            for notice in notices {
                prop_assert!(seen.insert(notice.alert.id), "two of one alert");
                prop_assert_eq!(newest.get(&notice.alert.id), Some(&(notice.change, notice.at)));
                let distinct: std::collections::BTreeSet<_> = notice.earlier.iter().map(|c| format!("{c:?}")).collect();
                prop_assert_eq!(distinct.len(), notice.earlier.len());
            }
        }
    }
}
