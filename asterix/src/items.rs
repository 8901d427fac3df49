//! Items shared by the categories.

use crate::bits;
use crate::item::items;

items! {
    /// Item 010, data source identifier.
    words pub struct DataSource {
        /// System area code.
        sac: u8 { count 8 "sac"; }
        /// System identification code.
        sic: u8 { count 8 "sic"; }
    }

    /// Time of day in UTC: 0 to below 86400 s.
    ///
    /// Later times are decoded, too; the caller decides whether to use them.
    #[derive(PartialOrd, Ord)]
    pub struct TimeOfDay(3) {
        /// Seconds since midnight, exact: LSB 1/128 s.
        unsigned 24 "" seconds = 1.0 / 128.0, 7;
    }
}

impl TimeOfDay {
    /// Counts per second.
    pub const PER_SECOND: u32 = 128;
    /// Counts per day: the first count that is no time of day.
    pub const PER_DAY: u32 = 86_400 * Self::PER_SECOND;

    /// The time with this count of 1/128 s; `None` above 24 bits.
    pub const fn from_count(count: u32) -> Option<Self> {
        if count >> 24 == 0 { Some(Self(bits::set([0; 3], 0, 24, count as u64))) } else { None }
    }

    /// The nearest time of day; `None` if it is not in 0 to below 86400 s.
    pub fn from_seconds(seconds: f64) -> Option<Self> {
        let count = bits::nearest_count(seconds * f64::from(Self::PER_SECOND), 24, false)?;
        Self::from_count(count as u32).filter(|time| time.in_range())
    }

    /// Count of 1/128 s since midnight.
    pub const fn count(self) -> u32 {
        bits::get(&self.0, 0, 24) as u32
    }

    /// Whether the time is below 86400 s, as the item requires.
    pub const fn in_range(self) -> bool {
        self.count() < Self::PER_DAY
    }
}

/// Encoded as SAC and SIC.
#[cfg(feature = "serde")]
impl serde::Serialize for DataSource {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.sac, self.sic).serialize(serializer)
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for DataSource {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        <(u8, u8)>::deserialize(deserializer).map(|(sac, sic)| Self { sac, sic })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
