//! Values of the keys of a scenario, and their text form.

use std::ops::RangeInclusive;

use tables::kinds::{Kind, is_plain, text};
use tables::table::Table;
use tables::{names, written_by_name};

names! {
    /// Choice of waypoints.
    #[derive(Copy, Eq)]
    Pattern, "pattern" {
        /// Random waypoints in the airspace.
        Free = "free",
        /// To and fro through the middle of the airspace.
        Crossing = "crossing",
        /// All drones together, on a grid.
        Formation = "formation",
    }
}

names! {
    /// Velocities that a radar reports, before noise.
    #[derive(Copy, Eq)]
    VelocityModel, "model" {
        /// Velocities of the targets.
        True = "true",
        /// One random velocity per track, unrelated to the target.
        Frozen = "frozen",
        /// Velocities of the targets times a factor.
        Scaled = "scaled",
    }
}

names! {
    /// Attack on a spoofed transponder.
    #[derive(Copy, Eq)]
    Attack, "attack" {
        /// Positions drift away, with matching velocities.
        Drift = "drift",
        /// Positions jump away by a constant offset.
        Jump = "jump",
        /// The last position and velocity before the attack, repeated.
        Frozen = "frozen",
        /// A recording of earlier reports, repeated.
        Replay = "replay",
        /// Correct reports, and those of a second transmitter of the same identity elsewhere.
        Duplicate = "duplicate",
        /// Correct reports under the identity of another spoofed transponder; the two exchange identities.
        Swapped = "swapped",
        /// Correct reports with shifted time stamps.
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
/// A number of objects.
pub(super) const COUNT: RangeInclusive<f64> = 0.0..=2000.0;
/// Seconds within a simulation.
pub(super) const SECONDS: RangeInclusive<f64> = 0.0..=1e6;
/// Distances, metres.
pub(super) const METRES: RangeInclusive<f64> = 0.0..=100_000.0;

/// Returns the keys of a section as TOML, each on a line with its meaning.
pub(super) fn lines<T: Table>(section: &T) -> impl Iterator<Item = String> {
    let keys = section.entries().into_iter().zip(T::rows());
    // Align the comments in one column.
    keys.map(|(entry, row)| {
        let value = format!("{} = {}", entry.key, entry.value.unwrap_or_default());
        format!("{value:COLUMN$} # {}\n", row.about.trim())
    })
}

/// Returns the section as TOML, under `header`.
pub(super) fn show<T: Table>(section: &T, header: &str) -> String {
    format!("\n#{}\n{header}\n{}", T::ABOUT, lines(section).collect::<String>())
}

/// Width of the longest key with its value.
const COLUMN: usize = 36;
