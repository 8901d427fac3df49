//! Times as JSON.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use fusion::time::{DAY, Time};

/// A UTC time, RFC 3339.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema)]
#[schemars(inline, extend("format" = "date-time"))]
pub struct Rfc3339(#[schemars(with = "String")] pub Time);

impl From<Time> for Rfc3339 {
    fn from(time: Time) -> Self {
        Self(time)
    }
}

/// Written without a general formatter, because a picture has several times per track.
impl Serialize for Rfc3339 {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let text = text(self.0);
        serializer.serialize_str(str::from_utf8(&text).expect("digits and signs"))
    }
}

/// Text with milliseconds; smaller units are cut off.
fn text(time: Time) -> [u8; 24] {
    let (year, month, day) = date(time.nanos().div_euclid(DAY));
    let milliseconds = time.since_midnight() / 1_000_000;
    let seconds = milliseconds / 1000;
    let mut text = *b"0000-00-00T00:00:00.000Z";
    for (place, number) in [
        (0..4, year),
        (5..7, month),
        (8..10, day),
        (11..13, seconds / 3600),
        (14..16, seconds / 60 % 60),
        (17..19, seconds % 60),
        (20..23, milliseconds % 1000),
    ] {
        let mut left = number;
        for digit in text[place].iter_mut().rev() {
            *digit = b'0' + (left % 10) as u8;
            left /= 10;
        }
    }
    text
}

/// Year, month and day of the Gregorian calendar, `days` after 1970-01-01; from the year 0 on.
///
/// Years start in March, so that the leap day is the last: 400 of them have [`ERA`] days, and five months from March or August on
/// have 153 days.
fn date(days: i64) -> (i64, i64, i64) {
    /// Number of days in 400 years.
    const ERA: i64 = 146_097;
    /// Number of days from 0000-03-01 to 1970-01-01.
    const EPOCH: i64 = 719_468;
    let days = days + EPOCH;
    let (era, day) = (days.div_euclid(ERA), days.rem_euclid(ERA));
    // Without the leap days before them (one in four years, except for whole centuries), the days are years of 365.
    let year = (day - day / 1_460 + day / 36_524 - day / (ERA - 1)) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (year, month) = if month < 10 { (year, month + 3) } else { (year + 1, month - 9) };
    (400 * era + year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(time: Time) -> String {
        String::from_utf8(text(time).to_vec()).unwrap()
    }

    #[test]
    fn dates_match_the_calendar_on_every_day() {
        for day in i64::MIN / DAY + 1..i64::MAX / DAY {
            let time = Time::from_nanos(day * DAY);
            assert_eq!(shown(time), time.to_string());
        }
    }

    proptest::proptest! {
        #[test]
        fn serialised_time_equals_its_display(nanos: i64) {
            let time = Time::from_nanos(nanos);
            proptest::prop_assert_eq!(shown(time), time.to_string());
        }
    }
}
