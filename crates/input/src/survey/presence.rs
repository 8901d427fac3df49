//! Times of presence and of silence.

use super::histogram::Histogram;
use crate::normalise::{nearest_day, on_day};
use fusion::time::{SECOND, Time};

/// First and last time, and the silences between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Presence {
    span: Option<(Time, Time)>,
    /// The latest time since the last backward step; the beginning of the next silence.
    latest: Option<Time>,
    /// Intervals from each time to the next later one.
    pub(super) silences: Histogram,
    /// Length, in nanoseconds, and beginning of the longest silence, the first of several equal ones.
    pub(super) longest: Option<(i64, Time)>,
    /// Number of backward steps that exceed the tolerance.
    pub(super) steps_back: u64,
}

impl Presence {
    /// Notes presence at a time. A backward step within `tolerance_ns` counts as reordering.
    pub(super) fn see(&mut self, time: Time, tolerance_ns: i64) {
        let (first, last) = self.span.unwrap_or((time, time));
        self.span = Some((first.min(time), last.max(time)));
        let passed_ns = self.latest.map_or(0, |latest| nanos_between(latest, time));
        if let Some(latest) = self.latest.filter(|_| passed_ns > 0) {
            self.silences.add(passed_ns);
            if self.longest.is_none_or(|(longest_ns, _)| passed_ns > longest_ns) {
                self.longest = Some((passed_ns, latest));
            }
        }
        if passed_ns < -tolerance_ns {
            self.steps_back += 1;
        } else if passed_ns < 0 {
            return;
        }
        self.latest = Some(time);
    }

    /// First and last time.
    pub(super) fn span(&self) -> Option<(Time, Time)> {
        self.span
    }
}

/// Time from `earlier` to `later`, in nanoseconds; negative if `later` is the earlier one.
pub(super) fn nanos_between(earlier: Time, later: Time) -> i64 {
    later.nanos().saturating_sub(earlier.nanos())
}

/// Maximum step of a credible time of day, in nanoseconds.
pub(super) const DOUBT_NS: i64 = 60 * SECOND;

/// Dates the times of day of one source without times of reception; the first day is 1970-01-01.
///
/// A time more than a minute away from the previous one is confirmed if the next time is nearer to it than to the previous one.
/// Otherwise it is a stray.
#[derive(Clone, Debug, Default)]
pub(super) struct Days {
    believed: Option<Time>,
    /// Time that is not confirmed yet; credible if no other follows.
    pub(super) doubted: Option<Time>,
    /// Number of strays.
    pub(super) strays: u64,
}

impl Days {
    /// Dates the next time of day (in 1/128 s). Returns its time and the times that are now credible; `None` for 24 h or more.
    /// `around`: a time of the same file for dating the first.
    pub(super) fn tell(&mut self, count: u32, around: Option<Time>) -> Option<(Time, [Option<Time>; 2])> {
        let before = match (self.believed, around) {
            (Some(before), _) => before,
            (None, around) => {
                let first = match around {
                    Some(around) => nearest_day(count, around),
                    None => on_day(count, Time::from_nanos(0)),
                }?;
                self.believed = Some(first);
                return Some((first, [Some(first), None]));
            }
        };
        let distance = |time: Time, from: Time| nanos_between(from, time).abs();
        let time = nearest_day(count, before)?;
        let mut confirmed = None;
        let mut nearest = (time, before);
        if let Some(doubted) = self.doubted.take() {
            let beside_it = nearest_day(count, doubted)?;
            if distance(beside_it, doubted) < distance(time, before) {
                confirmed = Some(doubted);
                nearest = (beside_it, doubted);
                self.believed = confirmed;
            } else {
                self.strays += 1;
            }
        }
        let (time, before) = nearest;
        if distance(time, before) > DOUBT_NS {
            self.doubted = Some(time);
            return Some((time, [confirmed, None]));
        }
        self.believed = Some(time);
        Some((time, [confirmed, Some(time)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The times that are credible in the end, in seconds, and the number of strays.
    fn believed(seconds: &[f64]) -> (Vec<f64>, u64) {
        let mut days = Days::default();
        let mut all = Vec::new();
        for second in seconds {
            let (_, times) = days.tell((second * 128.0) as u32, None).unwrap();
            all.extend(times.into_iter().flatten());
        }
        all.extend(days.doubted);
        (all.into_iter().map(Time::as_seconds).collect(), days.strays)
    }

    #[test]
    fn midnight_is_crossed_in_both_directions() {
        assert_eq!(believed(&[86_399.0, 1.0, 86_398.0]), (vec![86_399.0, 86_401.0, 86_398.0], 0));
        assert_eq!(believed(&[86_000.0, 400.0, 800.0]), (vec![86_000.0, 86_800.0, 87_200.0], 0));
    }

    #[test]
    fn stray_time_is_ignored_and_slow_reports_are_not() {
        assert_eq!(believed(&[100.0, 5_000.0, 101.0]), (vec![100.0, 101.0], 1));
        assert_eq!(believed(&[100.0, 5_000.0, 5_001.0]), (vec![100.0, 5_000.0, 5_001.0], 0));
        assert_eq!(believed(&[100.0, 300.0, 500.0, 700.0]), (vec![100.0, 300.0, 500.0, 700.0], 0));
        assert_eq!(believed(&[100.0, 5_000.0]), (vec![100.0, 5_000.0], 0));
        assert_eq!(Days::default().tell(86_401 * 128, None), None);
    }

    #[test]
    fn silences_are_measured_from_the_latest_time() {
        let mut presence = Presence::default();
        for second in [10, 11, 10, 12, 30, 5, 6] {
            presence.see(Time::from_nanos(second * SECOND), 10 * SECOND);
        }
        let at = |second| Time::from_nanos(second * SECOND);
        assert_eq!(presence.span(), Some((at(5), at(30))));
        assert_eq!(presence.longest, Some((18 * SECOND, at(12))));
        assert_eq!((presence.steps_back, presence.silences.longer_than(0)), (1, 4));
    }
}
