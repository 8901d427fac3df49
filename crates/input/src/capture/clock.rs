//! Reception times for files without times or dates.

use std::collections::VecDeque;

use asterix::TimeOfDay;
use jiff::civil::Date;

use crate::normalise::{nearest_day, on_day};
use fusion::time::{DAY, SECOND, Time};

/// Reception times for a file with times of day. The first is on the given day, each later one at most [`BACKWARDS_NS`]
/// before its predecessor. A recording may therefore pause for almost a day.
#[derive(Clone, Debug)]
pub(super) struct DayClock {
    /// Start of the day of the first record.
    midnight: Option<Time>,
    last: Option<Time>,
}

/// Largest backward step, in nanoseconds (records written late, or a clock that was set); beyond it a day has passed.
const BACKWARDS_NS: i64 = 3600 * SECOND;

impl DayClock {
    pub(super) fn starting_on(date: Date) -> Self {
        Self { midnight: Time::midnight(date), last: None }
    }

    /// Reception time of the next record, `since_midnight` nanoseconds into its day.
    pub(super) fn tell(&mut self, since_midnight: i64) -> Option<Time> {
        let nanos = match self.last {
            None => self.midnight?.nanos().checked_add(since_midnight)?,
            Some(last) => {
                let earliest = Time::from_nanos(last.nanos().checked_sub(BACKWARDS_NS)?);
                let ahead = (since_midnight - earliest.since_midnight()).rem_euclid(DAY);
                earliest.nanos().checked_add(ahead)?
            }
        };
        self.last = Some(Time::from_nanos(nanos));
        self.last
    }
}

/// Reception times for a file without any: the running maximum of its times of day.
///
/// A report more than a minute away moves the time only if three in a row agree within a minute. (The pipeline drops such
/// outliers as late or in the future.)
#[derive(Clone, Debug)]
pub(super) struct RawClock {
    /// Start of the day of the first record.
    midnight: Option<Time>,
    running: Option<Time>,
    /// Consecutive outliers, all more than a minute ahead or all more than a minute behind; at most two.
    astray: VecDeque<Time>,
}

/// Largest distance of a report from the running time, and of outliers from each other, in nanoseconds.
const ASTRAY_NS: i64 = 60 * SECOND;

impl RawClock {
    pub(super) fn starting_on(date: Date) -> Self {
        Self { midnight: Time::midnight(date), running: None, astray: VecDeque::new() }
    }

    /// Present time; `None` before the first report.
    pub(super) fn running(&self) -> Option<Time> {
        self.running
    }

    /// Sets the time from a record with a reception time.
    pub(super) fn set(&mut self, time: Time) {
        self.running = Some(time);
    }

    /// Advances to the next record's time of day, if it has one.
    pub(super) fn tell(&mut self, time_of_day: Option<TimeOfDay>) {
        let Some(count) = time_of_day.map(TimeOfDay::count) else { return };
        let Some(running) = self.running else {
            self.running = self.midnight.and_then(|midnight| on_day(count, midnight));
            return;
        };
        let Some(time) = nearest_day(count, running) else { return };
        let apart = |a: Time, b: Time| (a.nanos() - b.nanos()).abs();
        if apart(time, running) <= ASTRAY_NS {
            self.astray.clear();
            self.running = Some(running.max(time));
            return;
        }
        let same_side = |stray: &Time| (*stray > running) == (time > running);
        if !self.astray.iter().all(same_side) {
            self.astray.clear();
        }
        self.astray.push_back(time);
        if self.astray.len() == 3 {
            let agree = self.astray.iter().all(|&a| self.astray.iter().all(|&b| apart(a, b) <= ASTRAY_NS));
            if agree {
                self.running = Some(time);
                self.astray.clear();
            } else {
                self.astray.pop_front();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock_after(seconds: &[f64]) -> Vec<f64> {
        let mut clock = RawClock::starting_on(jiff::civil::date(1970, 1, 1));
        let tell = |&second: &f64| {
            clock.tell(TimeOfDay::from_count((second * 128.0) as u32));
            clock.running.unwrap().as_seconds()
        };
        seconds.iter().map(tell).collect()
    }

    #[test]
    fn first_record_is_on_the_given_day_and_others_nearest() {
        assert_eq!(clock_after(&[0.0, 1.0]), [0.0, 1.0]);
        assert_eq!(clock_after(&[86_400.0, 1.0]), [86_400.0, 86_401.0]);
        assert_eq!(clock_after(&[86_390.0, 5.0, 86_399.0, 6.0]), [86_390.0, 86_405.0, 86_405.0, 86_406.0]);
    }

    #[test]
    fn time_moves_after_three_agreeing_records_not_one() {
        assert_eq!(clock_after(&[100.0, 500.0, 101.0, 500.0, 501.0]), [100.0, 100.0, 101.0, 101.0, 101.0]);
        assert_eq!(clock_after(&[100.0, 500.0, 510.0, 520.0, 101.0]), [100.0, 100.0, 100.0, 520.0, 520.0]);
        assert_eq!(clock_after(&[900.0, 500.0, 510.0, 520.0, 521.0]), [900.0, 900.0, 900.0, 520.0, 521.0]);
        // Three that do not agree, and three of which one is on the other side.
        assert_eq!(clock_after(&[100.0, 500.0, 900.0, 510.0, 520.0, 530.0]).last(), Some(&530.0));
        assert_eq!(clock_after(&[500.0, 900.0, 100.0, 901.0, 902.0]).last(), Some(&500.0));
    }

    #[test]
    fn times_continue_over_midnight_and_slightly_backwards() {
        let received = |seconds: &[i64]| -> Vec<i64> {
            let mut clock = DayClock::starting_on(jiff::civil::date(1970, 1, 1));
            seconds.iter().map(|second| clock.tell(second * SECOND).unwrap().nanos() / SECOND).collect()
        };
        assert_eq!(received(&[86_399, 0, 86_399, 1]), [86_399, 86_400, 86_399, 86_401]);
        assert_eq!(received(&[0, 86_399]), [0, -1]);
        assert_eq!(received(&[7200, 3600, 0, 82_799]), [7200, 3600, 0, 82_799]);
        // A pause of 23 hours less a second, twice.
        assert_eq!(received(&[5000, 1401, 84_200]), [5000, 1401, 84_200]);
        assert_eq!(received(&[5000, 1399, 84_198]), [5000, 87_799, 170_598]);
    }

    #[test]
    fn time_of_day_beyond_a_day_is_rejected() {
        assert_eq!(clock_after(&[100.0, 86_401.0]), [100.0, 100.0]);
    }
}
