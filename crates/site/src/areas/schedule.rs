//! Schedules of zones.

use std::fmt;

use jiff::civil::{Date, Time as TimeOfDay, Weekday};
use jiff::tz::TimeZone;
use jiff::{Span, Timestamp};

use fusion::time::Time;

/// Days to look ahead for a change: hours repeat weekly, and overlap at most two days.
const AHEAD_DAYS: i64 = 9;

/// When a zone applies: in any of its periods; always if it has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedule(Vec<Period>);

/// A period of time, possibly limited to hours of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Period {
    /// First instant of the period; `None`: no beginning.
    pub(super) from: Option<Time>,
    /// First instant after the period; `None`: no end.
    pub(super) to: Option<Time>,
    /// Hours at which the period applies; if there are none, it applies all day.
    pub(super) hours: Vec<Hours>,
}

/// Hours on days of the week. If the end is not after the start, it is on the next day.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hours {
    pub(super) days: Days,
    pub(super) start: TimeOfDay,
    pub(super) end: TimeOfDay,
    /// Time zone of the hours, and of the day on which they begin.
    pub(super) zone: TimeZone,
}

/// Days of the week.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Days(u8);

impl Days {
    pub(super) const ALL: Self = Self(0b111_1111);
    const NAMES: [&str; 7] = ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"];

    pub(super) fn with(self, day: Weekday) -> Self {
        Self(self.0 | 1 << day.to_monday_zero_offset())
    }

    fn has(self, day: Weekday) -> bool {
        self.0 & 1 << day.to_monday_zero_offset() != 0
    }
}

impl Schedule {
    /// The union of the periods.
    pub(super) fn of(periods: Vec<Period>) -> Self {
        // One unlimited period includes all others.
        let is_always = periods.contains(&Period::default());
        Self(if is_always { Vec::new() } else { periods })
    }

    /// Whether the zone always applies.
    pub fn is_always(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether the zone applies at that time.
    pub fn is_active(&self, at: Time) -> bool {
        self.is_always() || self.0.iter().any(|period| period.holds(at))
    }

    /// The time after `at` at which the zone next begins or ceases to apply; `None`: never.
    pub fn changes_after(&self, at: Time) -> Option<Time> {
        let is_active = self.is_active(at);
        let mut next = at;
        loop {
            next = self.0.iter().filter_map(|period| period.turns_after(next)).min()?;
            if self.is_active(next) != is_active {
                return Some(next);
            }
            // Only hours repeat without end; they cause a change within a week of the last date.
            let last_date = self.0.iter().flat_map(|period| [period.from, period.to]).flatten().max();
            let behind = last_date.map_or(at, |date| date.max(at));
            if next.seconds_since(behind) > (AHEAD_DAYS * 86_400) as f64 {
                return None;
            }
        }
    }
}

impl Period {
    fn holds(&self, at: Time) -> bool {
        self.is_between(at) && (self.hours.is_empty() || self.hours.iter().any(|hours| hours.hold(at)))
    }

    fn is_between(&self, at: Time) -> bool {
        self.from.is_none_or(|from| from <= at) && self.to.is_none_or(|to| at < to)
    }

    /// The next instant at which the period may begin or end.
    fn turns_after(&self, at: Time) -> Option<Time> {
        let dates = [self.from, self.to].into_iter().flatten().filter(|&date| date > at);
        let hours =
            self.hours.iter().filter(|_| self.is_between(at)).filter_map(|hours| hours.turn_after(at));
        dates.chain(hours).min()
    }
}

impl Hours {
    fn hold(&self, at: Time) -> bool {
        let Some(today) = self.date(at) else { return false };
        [today.yesterday().ok(), Some(today)].into_iter().flatten().any(|date| {
            let is_in = |(from, to): (Time, Time)| from <= at && at < to;
            self.days.has(date.weekday()) && self.on(date).is_some_and(is_in)
        })
    }

    fn turn_after(&self, at: Time) -> Option<Time> {
        let today = self.date(at)?;
        let dates = (-1..AHEAD_DAYS).filter_map(|days| today.checked_add(Span::new().days(days)).ok());
        let turns = dates.filter(|date| self.days.has(date.weekday())).filter_map(|date| self.on(date));
        turns.flat_map(|(from, to)| [from, to]).filter(|&turn| turn > at).min()
    }

    /// Start and end of the hours that begin on that day.
    fn on(&self, date: Date) -> Option<(Time, Time)> {
        let end_date = if self.end > self.start { date } else { date.tomorrow().ok()? };
        let instant = |date: Date, time| {
            let zoned = date.to_datetime(time).to_zoned(self.zone.clone()).ok()?;
            Some(time_of(zoned.timestamp()))
        };
        Some((instant(date, self.start)?, instant(end_date, self.end)?))
    }

    fn date(&self, at: Time) -> Option<Date> {
        let timestamp = Timestamp::from_nanosecond(at.nanos().into()).ok()?;
        Some(self.zone.to_datetime(timestamp).date())
    }
}

/// The time, limited to the year 2262, the end of the range of [`Time`].
pub(super) fn time_of(timestamp: Timestamp) -> Time {
    let nanos = timestamp.as_nanosecond().clamp(i64::MIN.into(), i64::MAX.into());
    Time::from_nanos(nanos as i64)
}

/// Displays the schedule: `always`, or `Sat Sun 17:00-23:00 UTC from 2026-06-15`.
impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_always() {
            return f.write_str("always");
        }
        for (index, period) in self.0.iter().enumerate() {
            write!(f, "{}{period}", if index > 0 { "; " } else { "" })?;
        }
        Ok(())
    }
}

impl fmt::Display for Period {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hours: Vec<String> = self.hours.iter().map(Hours::to_string).collect();
        let minute = |time: Time| time.to_string()[..16].replace('T', " ");
        let from = self.from.map(|from| format!("from {} UTC", minute(from)));
        let to = self.to.map(|to| format!("to {} UTC", minute(to)));
        let parts = (!hours.is_empty()).then(|| hours.join(", ")).into_iter().chain(from).chain(to);
        f.write_str(&parts.collect::<Vec<_>>().join(" "))
    }
}

impl fmt::Display for Hours {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.days != Days::ALL {
            write!(f, "{} ", self.days)?;
        }
        let zone = match self.zone.iana_name() {
            Some(name) => name.to_owned(),
            None => self.zone.to_fixed_offset().map_or_else(|_| String::new(), |offset| offset.to_string()),
        };
        let (start, end) = (self.start.strftime("%H:%M"), self.end.strftime("%H:%M"));
        write!(f, "{start}-{end} {zone}")
    }
}

impl fmt::Display for Days {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = Self::NAMES.iter().enumerate().filter(|(day, _)| self.0 & 1 << day != 0);
        f.write_str(&names.map(|(_, name)| *name).collect::<Vec<_>>().join(" "))
    }
}
