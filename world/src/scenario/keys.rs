//! Values of the keys of a scenario, and how they are shown.

use std::ops::RangeInclusive;

use tables::kinds::{Kind, is_plain, text};
use tables::table::Table;
use tables::{names, written_by_name};

names! {
    /// How drones choose their way.
    #[derive(Copy, Eq)]
    Pattern, "pattern" {
        /// Anywhere in the airspace.
        Free = "free",
        /// There and back through its middle.
        Crossing = "crossing",
    }
}

names! {
    /// What the velocities are that a radar reports, before their noise.
    #[derive(Copy, Eq)]
    VelocityModel, "model" {
        /// Those of its targets.
        True = "true",
        /// One per track, of a course and a speed drawn by lot: they tell nothing.
        Frozen = "frozen",
        /// Those of its targets times a factor.
        Scaled = "scaled",
    }
}

names! {
    /// What a spoofed transponder reports.
    #[derive(Copy, Eq)]
    Attack, "attack" {
        /// Positions that drift away, and velocities to match.
        Drift = "drift",
        /// Positions that are off by the same distance at once.
        Jump = "jump",
        /// The last position and velocity before, for good.
        Frozen = "frozen",
        /// What it reported some time before, again and again.
        Replay = "replay",
        /// Its own, and those of a second transmitter of the same identity elsewhere.
        Duplicate = "duplicate",
        /// Its own under the identity of the next spoofed one, which sends its.
        Swapped = "swapped",
        /// Its own with time stamps that are off.
        Time = "time",
    }
}

written_by_name!(Attack);
written_by_name!(Pattern);
written_by_name!(VelocityModel);

pub(super) fn plain_name() -> Kind<String> {
    text("use only letters A-Z a-z, digits, _ and -", is_plain)
}

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
