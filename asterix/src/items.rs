//! Items and arithmetic that the categories share.

use deku::{DekuRead, DekuWrite};

use crate::Layout;
use crate::item::{Describe, octets};
use crate::layout::{count, quantity};

/// The whole number nearest to `value`, halves away from zero; `None` outside `min` to `max` and for what is no number.
pub(crate) fn nearest(value: f64, min: i32, max: i32) -> Option<i32> {
    let rounded = value.round();
    (rounded >= f64::from(min) && rounded <= f64::from(max)).then_some(rounded as i32)
}

/// The low `bits` (1 to 32) of `word` as two's complement.
pub(crate) const fn sign_extend(word: u32, bits: u32) -> i32 {
    (word << (32 - bits)) as i32 >> (32 - bits)
}

/// A 24-bit big-endian word.
pub(crate) const fn word24(octets: [u8; 3]) -> u32 {
    u32::from_be_bytes([0, octets[0], octets[1], octets[2]])
}

/// The low 24 bits of `word`, big-endian.
pub(crate) const fn octets24(word: u32) -> [u8; 3] {
    let [_, high, middle, low] = word.to_be_bytes();
    [high, middle, low]
}

/// Data source identifier: I048/010, I129/010.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, DekuRead, DekuWrite)]
pub struct DataSource {
    /// System area code.
    pub sac: u8,
    /// System identification code.
    pub sic: u8,
}

impl Describe for DataSource {
    const LAYOUT: Layout = Layout::Fields(&[count("sac", 8), count("sic", 8)]);
}

/// Time of day: I048/140, I129/070. UTC since midnight, 24 bits, LSB 1/128 s, range of the item 0 to below 86400 s.
///
/// A time past the end of the day decodes; whether to trust it is the reader's decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TimeOfDay([u8; 3]);

octets!(TimeOfDay, 3);

impl TimeOfDay {
    /// Counts in a second.
    pub const PER_SECOND: u32 = 128;
    /// Counts in a day: the first that is no time of day.
    pub const PER_DAY: u32 = 86_400 * Self::PER_SECOND;

    /// The time of this many 1/128 s, or `None` above 24 bits.
    pub const fn from_count(count: u32) -> Option<Self> {
        if count >> 24 == 0 { Some(Self(octets24(count))) } else { None }
    }

    /// The nearest time of day, or `None` when that is not in 0 to below 86400 s.
    pub fn from_seconds(seconds: f64) -> Option<Self> {
        let count = nearest(seconds * f64::from(Self::PER_SECOND), 0, Self::PER_DAY as i32 - 1)?;
        Self::from_count(count as u32)
    }

    /// Units of 1/128 s since midnight.
    pub const fn count(self) -> u32 {
        word24(self.0)
    }

    /// Seconds since midnight, exact.
    pub fn seconds(self) -> f64 {
        f64::from(self.count()) / f64::from(Self::PER_SECOND)
    }

    /// Whether it is below 86400 s, as the item demands.
    pub const fn in_range(self) -> bool {
        self.count() < Self::PER_DAY
    }
}

impl Describe for TimeOfDay {
    const LAYOUT: Layout = Layout::Fields(&[quantity("", 24, false, 1.0 / 128.0, 7)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_halves_away_from_zero() {
        for (value, expected) in
            [(0.5, Some(1)), (-0.5, Some(-1)), (0.49, Some(0)), (2.4999, Some(2)), (-2.5, Some(-3))]
        {
            assert_eq!(nearest(value, -3, 3), expected);
        }
        for value in [3.5, -3.5, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(nearest(value, -3, 3), None);
        }
    }

    #[test]
    fn extends_the_sign_of_any_width() {
        assert_eq!(sign_extend(0x3fff, 14), -1);
        assert_eq!(sign_extend(0x1fff, 14), 8191);
        assert_eq!(sign_extend(0xff_ffff, 24), -1);
        assert_eq!(sign_extend(0x8_0000, 20), -524_288);
        assert_eq!(sign_extend(0xabc7_ffff, 20), 524_287);
    }

    #[test]
    fn time_of_day() {
        let noon = TimeOfDay::from_seconds(43_200.5).unwrap();
        assert_eq!(noon.count(), 0x54_6040);
        assert_eq!(noon.seconds(), 43_200.5);
        assert_eq!(TimeOfDay::from_seconds(0.5 / 128.0).map(TimeOfDay::count), Some(1));
        assert_eq!(TimeOfDay::from_seconds(86_399.997), None);
        assert_eq!(TimeOfDay::from_seconds(-0.1), None);
        let past_midnight = TimeOfDay::from_count(TimeOfDay::PER_DAY).unwrap();
        assert!(!past_midnight.in_range());
        assert_eq!(past_midnight.seconds(), 86_400.0);
        assert_eq!(TimeOfDay::from_count(1 << 24), None);
    }
}
