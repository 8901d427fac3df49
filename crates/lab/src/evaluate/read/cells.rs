//! Parses times and numbers.

use jiff::Timestamp;

use fusion::integrity::{Reason, Reasons, State};
use fusion::time::{SECOND, Time};

/// Parses a time: decimal seconds UTC since 1970-01-01, to the nanosecond, or RFC 3339. `None`: neither, or outside the
/// years 1678 to 2261.
pub fn time(text: &str) -> Option<Time> {
    decimal_seconds(text).or_else(|| {
        let stamp: Timestamp = text.parse().ok()?;
        i64::try_from(stamp.as_nanosecond()).ok().map(Time::from_nanos)
    })
}

/// Digits beyond the ninth decimal are cut off.
fn decimal_seconds(text: &str) -> Option<Time> {
    let (is_negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let are_digits = |text: &str| text.bytes().all(|octet| octet.is_ascii_digit());
    if whole.is_empty() || !are_digits(whole) || !are_digits(fraction) {
        return None;
    }
    let nanos = fraction.bytes().chain(std::iter::repeat(b'0')).take(9);
    let nanos = nanos.fold(0, |nanos, digit| nanos * 10 + i64::from(digit - b'0'));
    let nanos = whole.parse::<i64>().ok()?.checked_mul(SECOND)?.checked_add(nanos)?;
    Some(Time::from_nanos(if is_negative { -nanos } else { nanos }))
}

/// Parses the integrity of a transponder: the names of its state and reasons.
pub(super) fn integrity<'a>(
    state: &str,
    reasons: impl Iterator<Item = &'a str>,
) -> Result<(State, Reasons), String> {
    let known = State::ALL.into_iter().find(|known| known.name() == state);
    let known = known.ok_or_else(|| {
        format!("integrity: {state:?} is none of {}", State::ALL.map(State::name).join(", "))
    })?;
    let reason = |name: &str| {
        let reason = Reason::ALL.into_iter().find(|reason| reason.name() == name);
        reason.ok_or_else(|| {
            format!("reasons: {name:?} is none of {}", Reason::ALL.map(Reason::name).join(", "))
        })
    };
    Ok((known, reasons.map(reason).collect::<Result<_, _>>()?))
}

/// Parses a finite number from `low` to `high`.
pub(super) fn number(text: &str, low: f64, high: f64) -> Option<f64> {
    text.parse().ok().filter(|number| (low..=high).contains(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_exact_to_the_nanosecond() {
        let nanos = |text| time(text).map(Time::nanos);
        assert_eq!(nanos("1773478800.0078125"), Some(1_773_478_800_007_812_500));
        assert_eq!(nanos("1773478800.123456789123"), Some(1_773_478_800_123_456_789));
        assert_eq!(nanos("1773478800"), Some(1_773_478_800 * SECOND));
        assert_eq!(nanos("-0.5"), Some(-SECOND / 2));
        assert_eq!(nanos("2026-03-14T09:00:00.25Z"), Some(1_773_478_800 * SECOND + SECOND / 4));
        assert_eq!(nanos("2026-03-14T10:00:00.25+01:00"), nanos("2026-03-14T09:00:00.25Z"));
        for wrong in
            ["", ".5", "1e9", "-", "1.2.3", "nan", "12 s", "2026-03-14", "99999999999999999999", "1,5"]
        {
            assert_eq!(time(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn numbers_are_finite_and_in_range() {
        assert_eq!(number("-90", -90.0, 90.0), Some(-90.0));
        for wrong in ["90.1", "nan", "inf", "", "5 m", "0x10"] {
            assert_eq!(number(wrong, -90.0, 90.0), None, "{wrong}");
        }
    }
}
