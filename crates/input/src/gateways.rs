//! Translators of other receivers' formats: from octets and a time of reception to the datagrams of the pipeline (ASTERIX,
//! lines of Remote ID).
//!
//! | module | input | output |
//! |---|---|---|
//! | [`adsb`] | frames of a 1090 MHz receiver, Beast or AVR | CAT021, edition 2.6 |
//! | [`blocks`] | ASTERIX over TCP | its data blocks, unchanged |
//! | [`lines`] | lines of JSON or CSV, whose fields the configuration names | CAT048, CAT129 |
//! | [`mavlink`] | MAVLink messages | CAT129, CAT021, lines of Remote ID |
//! | [`remote_id`] | frames of Wi-Fi and Bluetooth; text from a broker | lines of Remote ID |
//!
//! A translator uses neither clock nor socket. It keeps state within bounds, and counts dropped data by reason. Its output
//! is recorded, so a replay needs no translator.

pub mod adsb;
pub mod blocks;
pub mod lines;
pub mod mavlink;
pub mod remote_id;

use std::fmt;

use asterix::TimeOfDay;
use fusion::time::{SECOND, Time};

/// Number of untranslated items, by reason. `Display`: `3 cut, 1 damaged`, or `none`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DropCounts<const N: usize> {
    names: &'static [&'static str; N],
    counts: [u64; N],
}

impl<const N: usize> DropCounts<N> {
    /// Starts at 0; the names are those of the reasons, in their order.
    const fn new(names: &'static [&'static str; N]) -> Self {
        Self { names, counts: [0; N] }
    }

    /// Total of all reasons.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Every reason with its count, 0 included.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, u64)> {
        self.names.iter().copied().zip(self.counts)
    }

    /// Count of the reason with this index.
    pub fn of(&self, reason: usize) -> u64 {
        self.counts[reason]
    }

    fn add(&mut self, reason: usize) {
        self.counts[reason] += 1;
    }

    /// Adds the counts of another one.
    fn join(&mut self, other: &Self) {
        self.counts.iter_mut().zip(other.counts).for_each(|(count, more)| *count += more);
    }
}

impl<const N: usize> fmt::Display for DropCounts<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut comma = "";
        for (name, count) in self.iter().filter(|(_, count)| *count > 0) {
            write!(f, "{comma}{count} {name}")?;
            comma = ", ";
        }
        if comma.is_empty() { f.write_str("none") } else { Ok(()) }
    }
}

/// Time of day, rounded to 1/128 s.
fn time_of_day(time: Time) -> Option<TimeOfDay> {
    let per_second = i64::from(TimeOfDay::PER_SECOND);
    let count = (time.since_midnight() * per_second + SECOND / 2) / SECOND;
    TimeOfDay::from_count(count as u32 % TimeOfDay::PER_DAY)
}

#[cfg(test)]
mod tests {
    #[test]
    fn inputs_page_names_each_drop_reason() {
        let page = include_str!("../../../docs/INPUTS.md");
        let all =
            super::adsb::REASONS.iter().chain(&super::mavlink::REASONS).chain(&super::remote_id::REFUSALS);
        let all = all.chain(&super::lines::REASONS);
        all.for_each(|reason| assert!(page.contains(&format!("`{reason}`")), "{reason}"));
    }
}
