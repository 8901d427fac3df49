//! Time of day to UTC: the message states the time within a day, the reception determines the day.

use asterix::TimeOfDay;

use fusion::time::{DAY, Time};

/// Nanoseconds in one count of an ASTERIX time of day, 1/128 s.
pub(super) const NANOS_PER_COUNT: i64 = 7_812_500;

/// The instant with this time of day (counts of 1/128 s) on the day that begins at `midnight`.
///
/// 86400 s exactly is the next midnight. `None` for more, which is not a valid time of day.
pub fn on_day(count: u32, midnight: Time) -> Option<Time> {
    let time_of_day = (count <= TimeOfDay::PER_DAY).then_some(i64::from(count) * NANOS_PER_COUNT)?;
    midnight.nanos().checked_add(time_of_day).map(Time::from_nanos)
}

/// The instant with this time of day (counts of 1/128 s) that is nearest to `reference`; `None` as for [`on_day`].
pub fn nearest_day(count: u32, reference: Time) -> Option<Time> {
    let time_of_day = (count <= TimeOfDay::PER_DAY).then_some(i64::from(count) * NANOS_PER_COUNT)?;
    let offset = (time_of_day - reference.since_midnight() + DAY / 2).rem_euclid(DAY) - DAY / 2;
    reference.nanos().checked_add(offset).map(Time::from_nanos)
}

/// The time of day of an instant in counts of 1/128 s, to the nearest (the engine's times are whole counts).
pub fn time_of_day_count(time: Time) -> u32 {
    let count = (time.since_midnight() + NANOS_PER_COUNT / 2) / NANOS_PER_COUNT;
    (count as u32) % TimeOfDay::PER_DAY
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::time::SECOND;

    const MIDNIGHT: i64 = 20_000 * DAY;

    #[test]
    fn midnight_between_report_and_reception() {
        let just_after = Time::from_nanos(MIDNIGHT + SECOND);
        let just_before = Time::from_nanos(MIDNIGHT - SECOND);
        let last_count = TimeOfDay::PER_DAY - 1;
        assert_eq!(nearest_day(last_count, just_after).unwrap().nanos(), MIDNIGHT - NANOS_PER_COUNT);
        assert_eq!(nearest_day(0, just_before).unwrap().nanos(), MIDNIGHT);
        assert_eq!(nearest_day(TimeOfDay::PER_DAY, just_before).unwrap().nanos(), MIDNIGHT);
        assert_eq!(nearest_day(TimeOfDay::PER_DAY + 1, just_before), None);
    }

    proptest::proptest! {
        #[test]
        fn time_of_day_is_resolved_within_half_a_day(
            count in 0..TimeOfDay::PER_DAY, days in -20_000..40_000_i64, offset in -DAY / 2 + 1..DAY / 2,
        ) {
            let time = Time::from_nanos(days * DAY + i64::from(count) * NANOS_PER_COUNT);
            let reference = Time::from_nanos(time.nanos() + offset);
            proptest::prop_assert_eq!(nearest_day(count, reference), Some(time));
            proptest::prop_assert_eq!(time_of_day_count(time), count);
        }
    }
}
