//! Notices that wait for one receiver: bounded, and one of an alert at most. Sans-IO.

use std::collections::VecDeque;
use std::sync::Arc;

use super::counts::Loss;
use crate::live::{Alert, Change};
use fusion::time::{SECOND, Time};

/// Most notices that wait. By judgement: every drone of a city raising one at once.
pub(super) const WAITING: usize = 512;
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
    }

    fn is_stale(&self, now: Time) -> bool {
        self.alert.until.is_some() && now.nanos() - self.at.nanos() > STALE_NS
    }
}

/// The queue of one receiver.
#[derive(Debug)]
pub(super) struct Queue {
    bound: usize,
    /// Number of the next notice.
    next: u64,
    waiting: VecDeque<Notice>,
}

impl Queue {
    pub(super) fn new(bound: usize) -> Self {
        Self { bound, next: 1, waiting: VecDeque::new() }
    }

    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Takes a change. One that waits already of the same alert is replaced in its place: what counts is how the alert is now.
    pub(super) fn push(&mut self, change: Change, alert: Arc<Alert>, at: Time) -> Option<Loss> {
        let mut notice = Notice { number: self.next, change, earlier: Vec::new(), alert, at };
        self.next += 1;
        if let Some(waiting) = self.waiting.iter_mut().find(|waiting| waiting.alert.id == notice.alert.id) {
            notice.supersede(waiting);
            *waiting = notice;
            return None;
        }
        self.waiting.push_back(notice);
        self.bound()
    }

    /// The next one; whoever takes it puts it back where it was not delivered. `losses`: what is too old to be sent.
    pub(super) fn take(&mut self, now: Time, mut losses: impl FnMut(Loss)) -> Option<Notice> {
        loop {
            let notice = self.waiting.pop_front()?;
            if !notice.is_stale(now) {
                return Some(notice);
            }
            losses(Loss::Stale);
        }
    }

    /// It was not delivered. It waits behind the others, so that one which is never taken does not keep them; where its alert
    /// has changed meanwhile, that notice stands for both.
    pub(super) fn put_back(&mut self, notice: Notice) -> Option<Loss> {
        if let Some(newer) = self.waiting.iter_mut().find(|waiting| waiting.alert.id == notice.alert.id) {
            newer.supersede(&notice);
            return None;
        }
        self.waiting.push_back(notice);
        self.bound()
    }

    /// Drops the oldest where there is one too many.
    fn bound(&mut self) -> Option<Loss> {
        if self.waiting.len() <= self.bound {
            return None;
        }
        let oldest = (0..self.waiting.len()).min_by_key(|&index| self.waiting[index].number)?;
        self.waiting.remove(oldest);
        Some(Loss::Full)
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

    fn told(notice: Option<Notice>) -> Option<(u64, Change, Vec<Change>)> {
        notice.map(|notice| (notice.alert.id, notice.change, notice.earlier))
    }

    fn none(loss: Loss) {
        panic!("{loss:?}")
    }

    #[test]
    fn the_newest_state_of_an_alert_takes_the_place_of_what_waits() {
        let mut queue = Queue::new(4);
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
        let mut queue = Queue::new(4);
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
        let mut queue = Queue::new(4);
        let over = Alert { until: Some(at(0)), ..Alert::clone(&alert(1)) };
        queue.push(Change::Ended, over.into(), at(0));
        queue.push(Change::Began, alert(2), at(0));
        let mut lost = Vec::new();
        assert_eq!(queue.take(at(3_601), |loss| lost.push(loss)).unwrap().alert.id, 2);
        assert_eq!(lost, [Loss::Stale]);
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
            let mut queue = Queue::new(BOUND);
            let mut newest: BTreeMap<u64, (Change, Time)> = BTreeMap::new();
            let (mut sending, mut lost): (Option<Notice>, usize) = (None, 0);
            for (step, &(id, what)) in steps.iter().enumerate() {
                let at = at(step as i64);
                match (id, sending.take()) {
                    (0, None) => sending = queue.take(at, none),
                    // Delivered.
                    (0, Some(notice)) if what == 0 => {
                        if newest.get(&notice.alert.id) == Some(&(notice.change, notice.at)) {
                            newest.remove(&notice.alert.id);
                        }
                    }
                    (0, Some(notice)) => lost += usize::from(queue.put_back(notice).is_some()),
                    (id, was) => {
                        sending = was;
                        lost += usize::from(queue.push(changes[what], alert(id), at).is_some());
                        newest.insert(id, (changes[what], at));
                    }
                }
                prop_assert!(queue.len() <= BOUND);
            }
            if let Some(notice) = sending {
                lost += usize::from(queue.put_back(notice).is_some());
            }
            prop_assert!(newest.len() <= queue.len() + lost);
            let mut seen = std::collections::BTreeSet::new();
            while let Some(notice) = queue.take(at(0), none) {
                prop_assert!(seen.insert(notice.alert.id), "two of one alert");
                prop_assert_eq!(newest.get(&notice.alert.id), Some(&(notice.change, notice.at)));
                let distinct: std::collections::BTreeSet<_> = notice.earlier.iter().map(|c| format!("{c:?}")).collect();
                prop_assert_eq!(distinct.len(), notice.earlier.len());
            }
        }
    }
}
