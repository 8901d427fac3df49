//! Queue of notices for one receiver: bounded, the most severe first, and at most one notice per alert. Sans-IO.

use std::collections::VecDeque;
use std::sync::Arc;

use super::batch::NoticeBatch;
use super::counts::NoticeLoss;
use crate::live::{Alert, AlertChange, Severity};
use fusion::time::{SECOND, Time};

/// Maximum number of waiting notices. Chosen by judgement: one alert for each drone of a city.
pub(super) const WAITING: usize = 512;
/// Number of similar notices above which they are delivered as one summary. Chosen by judgement: about as many as a person
/// reads.
pub(super) const ALIKE: usize = 16;
/// Time after the end of an alert from which its notice is no longer useful, in nanoseconds. Chosen by judgement.
const STALE_NS: i64 = 3_600 * SECOND;

/// A notice of a change of an alert.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notice {
    /// Number of the notice for its receiver; different content has a different number.
    pub(super) number: u64,
    /// Latest change.
    pub(super) change: AlertChange,
    /// Earlier changes that the receiver has not been sent, each once.
    pub(super) earlier: Vec<AlertChange>,
    /// The alert after the latest change.
    pub(super) alert: Arc<Alert>,
    /// Time of the latest change.
    pub(super) at: Time,
    /// Greatest severity of the alert since the last notice that was sent.
    pub(super) severity: Severity,
}

/// Effect of a notice, as distinguished by summaries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoticeEffect {
    /// The alert is new to the receiver, and active.
    Began,
    /// The alert is active, and has changed.
    Changed,
    /// The alert has ended.
    Ended,
    /// The alert has ended before its beginning was sent.
    Passed,
}

impl NoticeEffect {
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
    /// Merges an earlier notice of the same alert into this one.
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

    /// Whether the receiver has not been sent the alert yet.
    pub(super) fn is_first(&self) -> bool {
        self.change == AlertChange::Began || self.earlier.contains(&AlertChange::Began)
    }

    /// Effect of the notice; `None` for an operator's decision, which comes one at a time and is never summarised.
    pub(super) fn effect(&self) -> Option<NoticeEffect> {
        match (self.change, self.is_first()) {
            (AlertChange::Acknowledged | AlertChange::Shelved | AlertChange::Unshelved, _) => None,
            (AlertChange::Ended, false) => Some(NoticeEffect::Ended),
            (AlertChange::Ended, true) => Some(NoticeEffect::Passed),
            (AlertChange::Began | AlertChange::Changed | AlertChange::Amended, true) => {
                Some(NoticeEffect::Began)
            }
            (AlertChange::Began | AlertChange::Changed | AlertChange::Amended, false) => {
                Some(NoticeEffect::Changed)
            }
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        let key = |notice: &Self| Some((notice.effect()?, notice.severity, notice.alert.kind));
        key(self).is_some_and(|own| key(other) == Some(own))
    }
}

/// Queue of one receiver.
#[derive(Debug)]
pub(super) struct PendingNotices {
    bound: usize,
    alike: usize,
    /// Number of the next notice.
    next: u64,
    /// Waiting notices; within each severity the oldest comes first.
    waiting: VecDeque<Notice>,
    /// Alerts of the delivery taken last, and those of them of which a newer notice has been dropped since. The older
    /// notice is then not sent again.
    taken: Vec<u64>,
    outdated: Vec<u64>,
    /// Alerts of the delivery that failed last; others are sent first.
    failed: Vec<u64>,
}

impl PendingNotices {
    /// Queue of at most `bound` notices; more than `alike` of the same kind, severity and effect are summarised.
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

    /// Adds a change. It replaces a waiting notice of the same alert, in place, because only the present state counts.
    /// Returns a notice that is dropped because the queue is full.
    pub(super) fn push(&mut self, change: AlertChange, alert: Arc<Alert>, at: Time) -> Option<Notice> {
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

    /// The next delivery: the oldest of the most severe notices, together with similar ones if there are many. After a
    /// failure it is returned with [`PendingNotices::put_back`]. `losses` receives the notices that are too old to be sent.
    pub(super) fn take(&mut self, now: Time, mut losses: impl FnMut(NoticeLoss)) -> Option<NoticeBatch> {
        let before = self.waiting.len();
        self.waiting.retain(|notice| !notice.is_stale(now));
        (self.waiting.len()..before).for_each(|_| losses(NoticeLoss::Stale));
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
        let batch = NoticeBatch::new(notice, alike);
        self.taken = batch.notices().map(|notice| notice.alert.id).collect();
        self.outdated.clear();
        Some(batch)
    }

    /// Returns a failed delivery to the queue, behind the others of its severity. Others are sent first, so that a notice
    /// which always fails does not block them. A notice of the same alert that has arrived meanwhile is merged with it.
    /// Returns the notices that are dropped because the queue is full.
    pub(super) fn put_back(&mut self, batch: NoticeBatch) -> Vec<Notice> {
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

    /// If the queue is too long, drops a notice of the lowest severity: one of an alert that ended before the receiver was
    /// sent it, otherwise the oldest.
    fn bound(&mut self) -> Option<Notice> {
        if self.waiting.len() <= self.bound {
            return None;
        }
        let rank = |&(_, notice): &(usize, &Notice)| {
            (notice.severity, notice.effect() != Some(NoticeEffect::Passed), notice.number)
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

    fn told(batch: Option<NoticeBatch>) -> Option<(u64, AlertChange, Vec<AlertChange>)> {
        let notice = batch?.single().expect("one notice").clone();
        Some((notice.alert.id, notice.change, notice.earlier))
    }

    fn critical(id: u64) -> Arc<Alert> {
        Arc::new(Alert { severity: Severity::Critical, ..Alert::clone(&alert(id)) })
    }

    fn ids(batch: &NoticeBatch) -> Vec<u64> {
        batch.notices().map(|notice| notice.alert.id).collect()
    }

    fn none(loss: NoticeLoss) {
        panic!("{loss:?}")
    }

    #[test]
    fn newer_notice_replaces_a_waiting_one_of_its_alert() {
        let mut queue = PendingNotices::new(4, ALIKE);
        for (change, id) in [
            (AlertChange::Began, 1),
            (AlertChange::Began, 2),
            (AlertChange::Changed, 1),
            (AlertChange::Acknowledged, 1),
            (AlertChange::Changed, 1),
        ] {
            assert_eq!(queue.push(change, alert(id), at(0)), None);
        }
        let earlier = vec![AlertChange::Began, AlertChange::Acknowledged];
        assert_eq!(told(queue.take(at(0), none)), Some((1, AlertChange::Changed, earlier)));
        assert_eq!(told(queue.take(at(0), none)), Some((2, AlertChange::Began, vec![])));
        assert_eq!(queue.take(at(0), none), None);
    }

    #[test]
    fn undelivered_notice_requeues_or_merges_into_a_newer() {
        let mut queue = PendingNotices::new(4, ALIKE);
        queue.push(AlertChange::Began, alert(1), at(0));
        queue.push(AlertChange::Began, alert(2), at(0));
        let first = queue.take(at(0), none).unwrap();
        queue.put_back(first);
        let second = queue.take(at(0), none).unwrap();
        queue.push(AlertChange::Ended, alert(2), at(0));
        queue.put_back(second);
        assert_eq!(told(queue.take(at(0), none)), Some((1, AlertChange::Began, vec![])));
        assert_eq!(told(queue.take(at(0), none)), Some((2, AlertChange::Ended, vec![AlertChange::Began])));
        assert_eq!(queue.len(), 0);
    }

    #[test]
    fn stale_ended_alerts_are_dropped_and_lasting_ones_sent() {
        let mut queue = PendingNotices::new(4, ALIKE);
        let over = Alert { until: Some(at(0)), ..Alert::clone(&alert(1)) };
        queue.push(AlertChange::Ended, over.into(), at(0));
        queue.push(AlertChange::Began, alert(2), at(0));
        let mut lost = Vec::new();
        assert_eq!(ids(&queue.take(at(3_601), |loss| lost.push(loss)).unwrap()), [2]);
        assert_eq!(lost, [NoticeLoss::Stale]);
    }

    #[test]
    fn critical_notice_is_taken_before_older_warnings() {
        let mut queue = PendingNotices::new(8, ALIKE);
        queue.push(AlertChange::Began, alert(1), at(0));
        queue.push(AlertChange::Began, alert(2), at(0));
        queue.push(AlertChange::Began, critical(3), at(1));
        assert_eq!(ids(&queue.take(at(1), none).unwrap()), [3]);
        // The alert is no longer critical, but no notice of this was sent.
        queue.push(AlertChange::Changed, critical(2), at(2));
        queue.push(AlertChange::Changed, alert(2), at(3));
        assert_eq!(ids(&queue.take(at(3), none).unwrap()), [2]);
        assert_eq!(ids(&queue.take(at(3), none).unwrap()), [1]);
    }

    #[test]
    fn critical_notice_that_keeps_failing_alternates_with_others() {
        let mut queue = PendingNotices::new(8, ALIKE);
        queue.push(AlertChange::Began, critical(1), at(0));
        queue.push(AlertChange::Began, alert(2), at(0));
        queue.push(AlertChange::Began, alert(3), at(0));
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
    fn similar_notices_are_batched_and_others_single() {
        let mut queue = PendingNotices::new(100, 3);
        (1..=9).for_each(|id| _ = queue.push(AlertChange::Began, alert(id), at(0)));
        queue.push(AlertChange::Acknowledged, alert(9), at(0));
        queue.push(AlertChange::Ended, alert(8), at(0));
        queue.push(AlertChange::Began, critical(20), at(0));
        assert_eq!(ids(&queue.take(at(0), none).unwrap()), [20]);
        let flood = queue.take(at(0), none).unwrap();
        assert_eq!(ids(&flood), [1, 2, 3, 4, 5, 6, 7]);
        // The notice of the changed alert covers both changes; the rest is summarised again, with another id.
        queue.push(AlertChange::Ended, alert(3), at(1));
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
        let mut queue = PendingNotices::new(4, ALIKE);
        queue.push(AlertChange::Began, critical(1), at(0));
        (2..=4).for_each(|id| _ = queue.push(AlertChange::Began, alert(id), at(0)));
        queue.push(AlertChange::Ended, alert(4), at(1));
        let mut dropped =
            |id| queue.push(AlertChange::Began, critical(id), at(2)).map(|notice| notice.alert.id);
        // Notices of ended alerts are the least loss.
        assert_eq!([5, 6, 7, 8].map(&mut dropped), [Some(4), Some(2), Some(3), Some(1)]);
    }

    proptest! {
        /// For any sequence of changes and failures: the queue is bounded, holds at most the newest notice of each alert,
        /// and keeps all changes that were neither lost nor delivered.
        #[test]
        fn queue_is_bounded_and_holds_the_newest(
            steps in prop::collection::vec((0_u64..9, 0_usize..4), 1..400),
        ) {
            const BOUND: usize = 5;
            let changes = [AlertChange::Began, AlertChange::Changed, AlertChange::Acknowledged, AlertChange::Ended];
            let mut queue = PendingNotices::new(BOUND, 3);
            let mut newest: BTreeMap<u64, (AlertChange, Time)> = BTreeMap::new();
            let (mut sending, mut lost): (Option<NoticeBatch>, usize) = (None, 0);
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
