//! The time of a CAT001 record, which holds only the lower 16 bits of the time of day (I001/141).

use asterix::TimeOfDay;
use asterix::all::Untyped;

/// Number of counts (1/128 s) after which the truncated time repeats: 512 s.
const ROUND: u32 = 1 << 16;

/// The time of day of a CAT001 record with a truncated time: the one nearest to `around`.
pub(super) fn time(record: &Untyped<'_>, around: TimeOfDay) -> Option<TimeOfDay> {
    let (_, octets) = record.items().find(|(item, _)| item.item == "141")?;
    nearest(u16::from_be_bytes(*octets.first_chunk()?), around)
}

/// The time of day with these lower bits that is nearest to `around`, also across midnight.
fn nearest(truncated: u16, around: TimeOfDay) -> Option<TimeOfDay> {
    let day = TimeOfDay::PER_DAY;
    let apart = |count: u32| {
        let apart = count.abs_diff(around.count() % day);
        apart.min(day - apart)
    };
    let counts = (u32::from(truncated)..day).step_by(ROUND as usize);
    counts.min_by_key(|count| apart(*count)).and_then(TimeOfDay::from_count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truncated_time_is_completed_over_midnight() {
        let count =
            |truncated, around| nearest(truncated, TimeOfDay::from_count(around)?).map(TimeOfDay::count);
        assert_eq!(count(0x800d, 0x59_8117), Some(0x59_800d));
        assert_eq!(count(0xfff0, 0x5a_0010), Some(0x59_fff0));
        assert_eq!(count(0x0010, 0x59_fff0), Some(0x5a_0010));
        let last = TimeOfDay::PER_DAY - 1;
        assert_eq!(count(5, last), Some(5), "after midnight");
        assert_eq!(count(last as u16, 5), Some(last), "before midnight");
    }
}
