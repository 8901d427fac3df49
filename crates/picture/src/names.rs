//! Short names of aircraft, as the map writes them beside a symbol: callsign or address, the end of the serial number, or the
//! track number.

use std::collections::{BTreeMap, BTreeSet};

use super::texts::text;
use super::{Picture, PictureTrack, serial_text};
use fusion::report::Space;
use fusion::time::{SECOND, Time};
use fusion::{Identity, Source};

/// Minimum number of characters of a serial number, from its end.
const END: usize = 5;
/// Time after which a transponder that is no longer in the picture loses its name, in nanoseconds.
const FORGET_NS: i64 = 60 * SECOND;

/// Names of the aircraft in successive pictures. A name is unique among the aircraft shown, and stays while one is shown.
#[derive(Clone, Debug, Default)]
pub struct TrackNames {
    /// Time of the last picture.
    last: Option<Time>,
    /// Each known transponder.
    known: BTreeMap<Identity, NamedTransponder>,
    /// Transponders that several tracks of the last picture have.
    doubled: BTreeSet<Identity>,
}

#[derive(Clone, Debug)]
struct NamedTransponder {
    serial: String,
    /// End of the serial number that no other one had when it appeared.
    end: String,
    seen: Time,
}

impl TrackNames {
    /// Names the tracks of the next picture. An earlier picture than the last one discards all names.
    pub fn name(&mut self, picture: &mut Picture) {
        if self.last.replace(picture.time).is_some_and(|last| picture.time < last) {
            self.known.clear();
        }
        self.note(picture);
        self.label(picture);
    }

    /// Names the tracks of a picture that belongs to the last one.
    pub fn label(&self, picture: &mut Picture) {
        for track in &mut picture.tracks {
            track.name = self.track(track);
        }
    }

    /// Learns the transponders of a picture.
    fn note(&mut self, picture: &Picture) {
        let now = picture.time;
        self.known.retain(|_, known| now.nanos().abs_diff(known.seen.nanos()) <= FORGET_NS.unsigned_abs());
        self.doubled.clear();
        let mut seen = BTreeSet::new();
        let mut fresh = Vec::new();
        for identity in picture.tracks.iter().filter_map(identity) {
            if !seen.insert(identity) {
                self.doubled.insert(identity);
                continue;
            }
            match self.known.get_mut(&identity) {
                Some(known) => known.seen = now,
                None => fresh.push((identity, serial_text(identity))),
            }
        }
        for (identity, serial) in &fresh {
            let named = NamedTransponder { serial: serial.clone(), end: String::new(), seen: now };
            self.known.insert(*identity, named);
        }
        for (identity, serial) in fresh {
            let end = self.unique_end(&serial);
            if let Some(known) = self.known.get_mut(&identity) {
                known.end = end;
            }
        }
    }

    /// Name of a track.
    fn track(&self, track: &PictureTrack) -> String {
        let number = track.point.number;
        let Some(part) = track.point.source.transponder() else {
            return match track.point.source {
                Source::Radar(_) => format!("R {number}"),
                Source::Cameras => format!("C {number}"),
                Source::Fused(..) | Source::Transponder(_) => number.to_string(),
            };
        };
        if part.identity.space() == Space::Address {
            return text(&part.aircraft.callsign)
                .map_or_else(|| serial_text(part.identity), std::borrow::Cow::into_owned);
        }
        let name = self.transponder(part.identity);
        let is_doubled = self.doubled.contains(&part.identity);
        if is_doubled { format!("{name} #{number}") } else { name }
    }

    /// Name of a transponder: the end of its serial number.
    fn transponder(&self, identity: Identity) -> String {
        self.known.get(&identity).map_or_else(|| short_serial(identity), |known| known.end.clone())
    }

    /// Shortest end of a serial number, of at least five characters, that no other one has.
    fn unique_end(&self, serial: &str) -> String {
        let length = serial.chars().count();
        let is_free = |name: &String| {
            let mut others = self.known.values().filter(|other| other.serial != serial);
            !others.any(|other| other.serial.ends_with(name.as_str()))
        };
        let ends = (END..length).map(|count| end(serial, count));
        ends.into_iter().find(is_free).unwrap_or_else(|| serial.to_owned())
    }
}

fn identity(track: &PictureTrack) -> Option<Identity> {
    track.point.source.transponder().map(|part| part.identity)
}

/// End of a serial number, for a transponder that no picture has shown.
pub fn short_serial(identity: Identity) -> String {
    end(&serial_text(identity), END)
}

/// Last characters of a text.
fn end(text: &str, count: usize) -> String {
    let skipped = text.chars().count().saturating_sub(count);
    text.chars().skip(skipped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(serials: &[&str]) -> TrackNames {
        let mut names = TrackNames::default();
        let known = |serial: &&str| {
            let identity = Identity::new(serial.as_bytes(), None).unwrap();
            (
                identity,
                NamedTransponder { serial: (*serial).to_owned(), end: String::new(), seen: Time::default() },
            )
        };
        names.known = serials.iter().map(known).collect();
        names
    }

    #[test]
    fn end_is_lengthened_until_it_is_unique() {
        let names = names(&["SMTR70000002", "1596F00002", "ALPHA", "XALPHA"]);
        let end = |serial: &str| names.unique_end(serial);
        assert_eq!([end("SMTR70000002"), end("1596F00002")], ["000002", "F00002"]);
        assert_eq!([end("ALPHA"), end("XALPHA")], ["ALPHA", "XALPHA"]);
    }

    #[test]
    fn unknown_transponder_is_named_by_its_last_five_characters() {
        let identity = Identity::new(b"SMTR70000002", None).unwrap();
        assert_eq!(TrackNames::default().transponder(identity), "00002");
    }
}
