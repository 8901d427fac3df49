//! Numbers of CAT048 for tracks that have names, or numbers of their own.

use std::collections::BTreeMap;

use fusion::time::{SECOND, Time};

/// Number of values of I048/161.
const NUMBERS: u16 = 4096;
/// Time after its last plot for which a track keeps its number: longer than the engine's window, nanoseconds.
const KEPT_NS: i64 = 60 * SECOND;

/// The tracks of a radar, by name.
#[derive(Clone, Debug, Default)]
pub(super) struct TrackNumbers {
    numbers: BTreeMap<String, u16>,
    /// Names and times of the last plot, by number.
    tracks: BTreeMap<u16, (String, Time)>,
    next: u16,
}

impl TrackNumbers {
    /// The number of a track with a plot at this time: its name, if that is a free number up to 4095, else the next free one.
    /// `None` if all numbers are in use.
    pub(super) fn number(&mut self, name: &str, now: Time) -> Option<u16> {
        let number = match self.numbers.get(name) {
            Some(&number) => number,
            None => {
                let own =
                    name.parse().ok().filter(|&number: &u16| number < NUMBERS && self.is_free(number, now));
                let number = own.or_else(|| self.free(now))?;
                if let Some((former, _)) = self.tracks.remove(&number) {
                    self.numbers.remove(&former);
                }
                self.numbers.insert(name.to_owned(), number);
                number
            }
        };
        self.tracks.insert(number, (name.to_owned(), now));
        Some(number)
    }

    fn is_free(&self, number: u16, now: Time) -> bool {
        self.tracks.get(&number).is_none_or(|(_, last)| now.nanos() - last.nanos() > KEPT_NS)
    }

    /// The free number whose turn it is. A number is used again as late as possible.
    fn free(&mut self, now: Time) -> Option<u16> {
        let found = (0..NUMBERS)
            .map(|step| (self.next + step) % NUMBERS)
            .find(|&number| self.is_free(number, now))?;
        self.next = (found + 1) % NUMBERS;
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * SECOND)
    }

    #[test]
    fn track_keeps_its_number_while_it_is_seen() {
        let mut tracks = TrackNumbers::default();
        assert_eq!(tracks.number("17", at(0)), Some(17));
        assert_eq!(tracks.number("a", at(0)), Some(0));
        assert_eq!(tracks.number("70000", at(0)), Some(1));
        for seconds in 1..200 {
            assert_eq!(tracks.number("a", at(seconds)), Some(0));
        }
        // The name of one track is the number of another.
        assert_eq!(tracks.number("0", at(200)), Some(2));
        // The track 17 is over.
        assert_eq!(tracks.number("0017", at(200)), Some(17));
        assert_eq!(tracks.number("17", at(201)), Some(3));
    }

    #[test]
    fn number_is_refused_while_all_are_in_use() {
        let mut tracks = TrackNumbers::default();
        let numbers: Vec<Option<u16>> =
            (0..4096).map(|name| tracks.number(&format!("t{name}"), at(0))).collect();
        assert!(numbers.iter().enumerate().all(|(place, number)| *number == Some(place as u16)));
        assert_eq!(tracks.number("another", at(60)), None);
        assert_eq!(tracks.number("t5", at(60)), Some(5));
        assert_eq!(tracks.number("another", at(61)), Some(0));
        assert_eq!(tracks.numbers.len(), 4096);
    }
}
