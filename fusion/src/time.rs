//! Time: UTC as whole nanoseconds since the Unix epoch.
//!
//! 1/128 s, the unit of every ASTERIX time of day, is exactly 7,812,500 ns (7,812.5 µs is not a whole number of
//! microseconds). Capture files have time stamps in nanoseconds.

use std::fmt;
use std::ops::{Add, Sub};

use jiff::{SignedDuration, Timestamp, civil::Date, tz::TimeZone};
use serde::{Deserialize, Serialize};

/// An instant: UTC, whole nanoseconds since 1970-01-01T00:00:00Z, leap seconds not counted. Years 1678 to 2262.
///
/// ```
/// use jiff::SignedDuration;
/// use utm_fusion_engine::Time;
///
/// let noon = Time::midnight(jiff::civil::date(2026, 11, 22)).unwrap() + SignedDuration::from_hours(12);
/// assert_eq!(noon.to_string(), "2026-11-22T12:00:00.000Z");
/// assert_eq!(noon - (noon - SignedDuration::from_secs(3)), SignedDuration::from_secs(3));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Time(i64);

/// Nanoseconds in a second.
pub const SECOND: i64 = 1_000_000_000;
/// Nanoseconds in a UTC day.
pub const DAY: i64 = 86_400 * SECOND;

impl Time {
    /// The instant `nanos` nanoseconds after the epoch.
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// Whole nanoseconds since the epoch.
    pub const fn nanos(self) -> i64 {
        self.0
    }

    /// Midnight at the start of `date`, or `None` outside the years 1678 to 2262.
    pub fn midnight(date: Date) -> Option<Self> {
        let zoned = date.to_zoned(TimeZone::UTC).ok()?;
        i64::try_from(zoned.timestamp().as_nanosecond()).ok().map(Self)
    }

    /// Seconds since the epoch; exact to about 0.2 µs, so for display and tables only.
    pub fn as_seconds(self) -> f64 {
        self.0.div_euclid(SECOND) as f64 + self.0.rem_euclid(SECOND) as f64 / SECOND as f64
    }

    /// Nanoseconds since the last UTC midnight, 0 to [`DAY`] - 1.
    pub const fn since_midnight(self) -> i64 {
        self.0.rem_euclid(DAY)
    }

    /// `self - earlier`, in seconds; exact enough for interpolation (differences here are below a minute).
    pub fn seconds_since(self, earlier: Self) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 / SECOND as f64
    }
}

impl Add<SignedDuration> for Time {
    type Output = Self;

    fn add(self, span: SignedDuration) -> Self {
        Self(self.0.saturating_add(span.as_nanos().clamp(i64::MIN.into(), i64::MAX.into()) as i64))
    }
}

impl Sub<SignedDuration> for Time {
    type Output = Self;

    fn sub(self, span: SignedDuration) -> Self {
        Self(self.0.saturating_sub(span.as_nanos().clamp(i64::MIN.into(), i64::MAX.into()) as i64))
    }
}

impl Sub for Time {
    type Output = SignedDuration;

    fn sub(self, earlier: Self) -> SignedDuration {
        SignedDuration::from_nanos(self.0.saturating_sub(earlier.0))
    }
}

/// RFC 3339 UTC with milliseconds, as on every interface.
impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match Timestamp::from_nanosecond(self.0.into()) {
            Ok(stamp) => write!(f, "{stamp:.3}"),
            Err(_) => write!(f, "{} ns", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_of_a_128th_second_is_exact_and_display_is_rfc_3339() {
        let noon = Time::midnight(jiff::civil::date(2026, 11, 20)).unwrap() + SignedDuration::from_hours(12);
        let time = Time::from_nanos(noon.nanos() + 16 * 7_812_500);
        assert_eq!(time.to_string(), "2026-11-20T12:00:00.125Z");
        assert_eq!(time.since_midnight(), 43_200 * SECOND + SECOND / 8);
        assert_eq!(time.seconds_since(noon), 0.125);
    }
}
