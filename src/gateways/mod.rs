//! What other receivers speak, translated at the door: octets and a time of reception in, datagrams of the pipeline's own
//! languages (ASTERIX, lines of Remote ID) out.
//!
//! | room | takes | gives |
//! |---|---|---|
//! | [`adsb`] | frames of a 1090 MHz receiver, Beast or AVR | CAT021, edition 2.6 |
//! | [`blocks`] | ASTERIX over TCP | its data blocks, unchanged |
//! | [`mavlink`] | MAVLink position reports | CAT129 |
//! | [`remote_id`] | frames of Wi-Fi and Bluetooth; text from a broker | lines of Remote ID |
//!
//! A translator reads no clock and no socket; it keeps what it has heard, within bounds, and counts what it drops by reason.
//! What is recorded is what it gives, so that a replay needs no translator.

pub mod adsb;
pub mod blocks;
pub mod mavlink;
pub mod remote_id;

use std::fmt;

use asterix::TimeOfDay;
use fusion::time::{SECOND, Time};

/// What a translator did not translate, by reason. `Display`: `3 cut, 1 damaged`, or `none`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dropped<const N: usize> {
    names: &'static [&'static str; N],
    counts: [u64; N],
}

impl<const N: usize> Dropped<N> {
    /// None so far; the names are those of the reasons, in their order.
    const fn new(names: &'static [&'static str; N]) -> Self {
        Self { names, counts: [0; N] }
    }

    /// All of them.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Every reason with its count, 0 included.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, u64)> {
        self.names.iter().copied().zip(self.counts)
    }

    /// Count of a reason, by its index.
    pub fn of(&self, reason: usize) -> u64 {
        self.counts[reason]
    }

    fn add(&mut self, reason: usize) {
        self.counts[reason] += 1;
    }

    /// Adds what another one has counted.
    fn join(&mut self, other: &Self) {
        self.counts.iter_mut().zip(other.counts).for_each(|(count, more)| *count += more);
    }
}

impl<const N: usize> fmt::Display for Dropped<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut comma = "";
        for (name, count) in self.iter().filter(|(_, count)| *count > 0) {
            write!(f, "{comma}{count} {name}")?;
            comma = ", ";
        }
        if comma.is_empty() { f.write_str("none") } else { Ok(()) }
    }
}

/// The nearest 1/128 s of the day of a time.
fn time_of_day(time: Time) -> Option<TimeOfDay> {
    let per_second = i64::from(TimeOfDay::PER_SECOND);
    let count = (time.since_midnight() * per_second + SECOND / 2) / SECOND;
    TimeOfDay::from_count(count as u32 % TimeOfDay::PER_DAY)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_names_each_reason() {
        let page = include_str!("../../docs/INPUTS.md");
        let all =
            super::adsb::REASONS.iter().chain(&super::mavlink::REASONS).chain(&super::remote_id::REFUSALS);
        all.for_each(|reason| assert!(page.contains(&format!("`{reason}`")), "{reason}"));
    }
}
