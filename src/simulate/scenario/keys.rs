//! Values of the keys of a scenario, and how they are shown.

use std::ops::RangeInclusive;

use crate::config::kinds::{Kind, Text, is_plain};
use crate::config::names::names;
use crate::config::reader::Item;
use crate::config::table::Table;

/// Evenly distributed between two ends, the lower first; in a file `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Span {
    /// From `low` to `high`.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }
}

names! {
    /// How drones choose their way.
    pub Pattern, "pattern" {
        /// Anywhere in the airspace.
        Free = "free",
        /// There and back through its middle.
        Crossing = "crossing",
    }
}

fn rule(limits: &RangeInclusive<f64>) -> String {
    format!("this is between {} and {}", limits.start(), limits.end())
}

impl Kind<f64> for RangeInclusive<f64> {
    fn read(&self, item: &Item<'_>) -> Option<f64> {
        item.number(&rule(self), |value| self.contains(&value))
    }

    fn show(&self, value: &f64) -> Option<String> {
        Some(format!("{value:?}"))
    }

    fn values(&self) -> String {
        rule(self)
    }
}

impl Kind<u32> for RangeInclusive<f64> {
    fn read(&self, item: &Item<'_>) -> Option<u32> {
        let range = *self.start() as u32..=*self.end() as u32;
        item.whole(range, &Kind::<u32>::values(self))
    }

    fn show(&self, value: &u32) -> Option<String> {
        Some(value.to_string())
    }

    fn values(&self) -> String {
        format!("{}, a whole number", rule(self))
    }
}

impl Kind<Span> for RangeInclusive<f64> {
    fn read(&self, item: &Item<'_>) -> Option<Span> {
        let ends: Option<Vec<f64>> = item.list()?.iter().map(|end| Kind::<f64>::read(self, end)).collect();
        match ends?[..] {
            [low, high] if low <= high => Some(Span { low, high }),
            _ => {
                item.refuse("two numbers are expected, the lower first: [low, high]");
                None
            }
        }
    }

    fn show(&self, value: &Span) -> Option<String> {
        Some(format!("[{:?}, {:?}]", value.low, value.high))
    }

    fn values(&self) -> String {
        format!("{}, [low, high]", rule(self))
    }
}

/// A name.
pub(super) const NAME: Text = Text("use only letters A-Z a-z, digits, _ and -", is_plain);
/// A share or probability.
pub(super) const SHARE: RangeInclusive<f64> = 0.0..=1.0;
/// A number of things.
pub(super) const COUNT: RangeInclusive<f64> = 0.0..=2000.0;
/// Seconds within a simulation.
pub(super) const SECONDS: RangeInclusive<f64> = 0.0..=1e6;
/// Metres.
pub(super) const METRES: RangeInclusive<f64> = 0.0..=100_000.0;

/// Each key as TOML with its meaning, a line each.
pub(super) fn lines<T: Table>(section: &T) -> impl Iterator<Item = String> {
    let keys = section.entries().into_iter().zip(T::rows());
    // Behind the values, in the same column for all.
    keys.map(|(entry, row)| {
        let value = format!("{} = {}", entry.key, entry.value.unwrap_or_default());
        format!("{value:COLUMN$} # {}\n", row.about.trim())
    })
}

/// The section as TOML under this header.
pub(super) fn show<T: Table>(section: &T, header: &str) -> String {
    format!("\n#{}\n{header}\n{}", T::ABOUT, lines(section).collect::<String>())
}

/// As wide as the longest key with its value.
const COLUMN: usize = 36;
