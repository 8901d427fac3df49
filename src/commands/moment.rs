//! Times and durations in a user's notation.

use std::str::FromStr;

use jiff::civil::Date;
use jiff::{SignedDuration, Timestamp};

use fusion::time::{SECOND, Time};
use input::normalise::nearest_day;

/// A time: `2026-11-20T10:00:00Z`, `10:00:00` or `+90s`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeArgument {
    /// An absolute time.
    At(Time),
    /// UTC time of day, on the day nearest to the first reception, in units of 1/128 s.
    TimeOfDay(u32),
    /// Time since the first reception.
    After(SignedDuration),
}

impl TimeArgument {
    /// Absolute time, given the time of the first reception.
    pub fn resolve(self, first: Time) -> Time {
        match self {
            Self::At(time) => time,
            Self::TimeOfDay(count) => nearest_day(count, first).unwrap_or(first),
            Self::After(span) => first + span,
        }
    }
}

impl FromStr for TimeArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(span) = text.strip_prefix('+') {
            return duration(span).map(Self::After);
        }
        if let Ok(stamp) = text.parse::<Timestamp>() {
            let nanos =
                i64::try_from(stamp.as_nanosecond()).map_err(|_| "years 1678 to 2261 only".to_owned())?;
            return Ok(Self::At(Time::from_nanos(nanos)));
        }
        if text.contains(':')
            && let Ok(time) = text.parse::<jiff::civil::Time>()
        {
            let midnight = SignedDuration::from_secs(
                i64::from(time.hour()) * 3600 + i64::from(time.minute()) * 60 + i64::from(time.second()),
            );
            let nanos = midnight.as_nanos() as i64 + i64::from(time.subsec_nanosecond());
            return Ok(Self::TimeOfDay((nanos / (SECOND / 128)) as u32));
        }
        Err("write it as 2026-11-20T10:00:00Z, as 10:00:00 (UTC), or as +90s after the first reception"
            .to_owned())
    }
}

/// Parses `6.25s`, `250ms`, `2m`, `1h30m`: from 0 to a year.
pub fn duration(text: &str) -> Result<SignedDuration, String> {
    let duration: SignedDuration = text
        .parse()
        .map_err(|_| "write a duration with its unit, as 6.25s, 250ms, 2m or 1h30m".to_owned())?;
    if (SignedDuration::ZERO..=SignedDuration::from_secs(31_557_600)).contains(&duration) {
        Ok(duration)
    } else {
        Err("a duration is at least 0 and at most a year".to_owned())
    }
}

/// Parses `2026-11-20`: a UTC day of the years 1970 to 2200, so that differences of times stay in range.
pub fn day(text: &str) -> Result<Date, String> {
    let day: Date = text.parse().map_err(|_| "write a day as 2026-11-20".to_owned())?;
    if (1970..=2200).contains(&day.year()) {
        Ok(day)
    } else {
        Err("a day of the years 1970 to 2200".to_owned())
    }
}

/// Replay speed: `max`, or a multiple of real time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReplaySpeed {
    /// Maximum speed, without pacing.
    Max,
    /// Seconds of the recording per second.
    Times(f64),
}

impl FromStr for ReplaySpeed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(times) if (0.001..=1e6).contains(&times) => Ok(Self::Times(times)),
            _ if text == "max" => Ok(Self::Max),
            _ => Err("write `max`, or how many times faster than it happened: 1, 10, 0.5".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_durations_are_parsed() {
        let first = Time::from_nanos(20_000 * fusion::time::DAY + 86_390 * SECOND);
        let after = |text: &str| text.parse::<TimeArgument>().unwrap().resolve(first).seconds_since(first);
        assert_eq!(after("+90s"), 90.0);
        assert_eq!((after("+1.5m"), after("+1m30s"), after("+6.25s")), (90.0, 90.0, 6.25));
        assert_eq!(after("23:59:55"), 5.0);
        assert_eq!(after("00:00:05"), 15.0);
        assert_eq!(after("2024-10-05T00:00:00Z"), 10.0);
        for wrong in ["", "10", "+", "+5", "25:00:00", "+-5s", "yesterday", "+1e9h", "+nans"] {
            assert!(wrong.parse::<TimeArgument>().is_err(), "{wrong}");
        }
        assert_eq!(day("2026-11-20"), Ok(jiff::civil::date(2026, 11, 20)));
        assert!(
            ["2026-02-30", "1969-12-31", "2201-01-01", "today"].into_iter().all(|text| day(text).is_err())
        );
        assert_eq!("max".parse(), Ok(ReplaySpeed::Max));
        assert_eq!("10".parse(), Ok(ReplaySpeed::Times(10.0)));
        assert!(
            "0".parse::<ReplaySpeed>().is_err()
                && "fast".parse::<ReplaySpeed>().is_err()
                && "NaN".parse::<ReplaySpeed>().is_err()
        );
    }
}
