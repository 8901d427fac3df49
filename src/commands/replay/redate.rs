//! Moves the times inside recorded messages to the present, in place.

use asterix::{
    Block, DataSource, Profile, Record, TimeOfDay, blocks, cat015, cat021, cat034, cat048, cat129, items,
};
use serde_json::Value;

use fusion::time::{SECOND, Time};
use input::gateways::remote_id::{is_broadcast, is_lines, lines};
use input::hex;
use input::normalise::{nearest_day, time_of_day_count};

/// Mapping from the times of a recording to the present.
#[derive(Clone, Copy, Debug)]
pub struct Redating {
    /// First time of the recording.
    first: Time,
    /// Present time to which `first` is mapped.
    begins: Time,
    /// Seconds of the recording per second.
    speed: f64,
}

/// Length of a Remote ID message, and of the header of a pack, in octets.
const MESSAGE: usize = remote_id::LENGTH;
const PACK_HEADER: usize = 3;
/// Epoch of the seconds in a system message: 2019-01-01, in seconds since 1970.
const SYSTEM_EPOCH_S: i64 = 1_546_300_800;
/// Tenths of a second in an hour.
const TENTHS_PER_HOUR: i64 = 36_000;
const TENTH: i64 = SECOND / 10;

impl Redating {
    /// Maps `first` to `now`. At speed 1 all times move by the same whole number of seconds, which every item can represent
    /// without rounding.
    pub fn new(first: Time, now: Time, speed: f64) -> Self {
        let seconds = (now.nanos() - first.nanos()).div_euclid(SECOND) + 1;
        Self { first, begins: Time::from_nanos(first.nanos() + seconds * SECOND), speed }
    }

    /// Present time of the recorded time.
    pub fn now(&self, recorded: Time) -> Time {
        let after = recorded.nanos() - self.first.nanos();
        // No rounding at speed 1.
        let after = if self.speed == 1.0 { after } else { (after as f64 / self.speed).round() as i64 };
        Time::from_nanos(self.begins.nanos() + after)
    }

    /// Moves the times in a datagram received at `received`. Data that cannot be decoded stay unchanged.
    ///
    /// `edition` is the edition of a source's CAT021.
    pub fn move_times(
        &self,
        payload: &mut Vec<u8>,
        received: Time,
        edition: impl Fn(DataSource) -> cat021::Edition,
    ) {
        if is_broadcast(payload) {
            self.move_messages(payload, received);
        } else if is_lines(payload) {
            let moved: Vec<Vec<u8>> = lines(payload).map(|line| self.move_line(line, received)).collect();
            *payload = moved.join(&b'\n');
        } else {
            self.move_blocks(payload, received, edition);
        }
    }

    fn move_blocks(
        &self,
        payload: &mut [u8],
        received: Time,
        edition: impl Fn(DataSource) -> cat021::Edition,
    ) {
        let mut moved: Vec<(usize, Vec<u8>)> = Vec::new();
        for block in blocks(payload).flatten() {
            let found = match block.category {
                cat015::Record::CATEGORY => self.times_in::<cat015::Record>(block, (), &["145"], received),
                cat021::Record::CATEGORY => {
                    let edition = block.first_source().map(&edition).unwrap_or_default();
                    let times = ["071", "072", "073", "075", "077"];
                    self.times_in::<cat021::Record>(block, edition, &times, received)
                }
                cat034::Record::CATEGORY => self.times_in::<cat034::Record>(block, (), &["030"], received),
                cat048::Record::CATEGORY => self.times_in::<cat048::Record>(block, (), &["140"], received),
                cat129::Record::CATEGORY => self.times_in::<cat129::Record>(block, (), &["070"], received),
                _ => Vec::new(),
            };
            moved.extend(found);
        }
        for (offset, octets) in moved {
            payload[offset..offset + octets.len()].copy_from_slice(&octets);
        }
    }

    /// Offsets of the times of day in a block, each with the octets to write there.
    fn times_in<R: Record>(
        &self,
        block: Block<'_>,
        edition: R::Edition,
        times: &[&str],
        received: Time,
    ) -> Vec<(usize, Vec<u8>)> {
        let profile: &'static Profile = R::profile(edition);
        let mut found = Vec::new();
        // The records after an undecodable one cannot be located.
        for located in block.records_in::<R>(edition).map_while(Result::ok) {
            let begins = located.offset - block.offset;
            let octets = &block.octets[begins..begins + located.length];
            let mut offset = octets.iter().position(|octet| octet & 1 == 0).map_or(0, |last| last + 1);
            let mut latest = None;
            for (item, value) in items(profile, octets) {
                if times.contains(&item.item)
                    && let [a, b, c] = *value
                    && let Some(count) = self.count(u32::from_be_bytes([0, a, b, c]), received)
                {
                    found.push((located.offset + offset, count.to_be_bytes()[1..].to_vec()));
                    latest = Some(count);
                }
                // At other speeds this high-precision item holds the fraction of the rounded time before it.
                if self.speed != 1.0
                    && R::CATEGORY == cat021::Record::CATEGORY
                    && matches!(item.item, "074" | "076")
                    && let Some(count) = latest
                {
                    let fraction = (count % TimeOfDay::PER_SECOND) << 23;
                    found.push((located.offset + offset, fraction.to_be_bytes().to_vec()));
                }
                offset += value.len();
            }
        }
        found
    }

    /// Present time of day, in units of 1/128 s; `None` if `recorded` is not a time of day.
    fn count(&self, recorded: u32, received: Time) -> Option<u32> {
        Some(time_of_day_count(self.now(nearest_day(recorded, received)?)))
    }

    /// Moves the times in a Remote ID message or pack.
    fn move_messages(&self, octets: &mut [u8], received: Time) {
        let header = if octets.first().is_some_and(|first| first >> 4 == 0xf) { PACK_HEADER } else { 0 };
        let Some(messages) = octets.get_mut(header..) else { return };
        for message in messages.chunks_exact_mut(MESSAGE) {
            match message[0] >> 4 {
                1 => {
                    let tenths = i64::from(u16::from_le_bytes([message[21], message[22]]));
                    if tenths <= TENTHS_PER_HOUR {
                        // The nearest time with these tenths of the hour.
                        let now = received.nanos().div_euclid(TENTH);
                        let half = TENTHS_PER_HOUR / 2;
                        let offset = (tenths - now + half).rem_euclid(TENTHS_PER_HOUR) - half;
                        let moved = self.now(Time::from_nanos((now + offset) * TENTH)).nanos();
                        let tenths = ((moved + TENTH / 2).div_euclid(TENTH)).rem_euclid(TENTHS_PER_HOUR);
                        message[21..23].copy_from_slice(&(tenths as u16).to_le_bytes());
                    }
                }
                4 => {
                    let stamp = u32::from_le_bytes([message[20], message[21], message[22], message[23]]);
                    if stamp > 0 {
                        let recorded = Time::from_nanos((SYSTEM_EPOCH_S + i64::from(stamp)) * SECOND);
                        let moved = self.now(recorded).nanos().div_euclid(SECOND) - SYSTEM_EPOCH_S;
                        if let Ok(stamp) = u32::try_from(moved) {
                            message[20..24].copy_from_slice(&stamp.to_le_bytes());
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// A gateway's line with its times moved; an invalid line stays unchanged.
    fn move_line(&self, line: &[u8], received: Time) -> Vec<u8> {
        let Ok(Value::Object(mut members)) = serde_json::from_slice(line) else { return line.to_vec() };
        let mut heard = received;
        if let Some(time) = members.get_mut("time") {
            let nanos = match &*time {
                Value::String(text) => text.parse().ok().map(|stamp: jiff::Timestamp| stamp.as_nanosecond()),
                Value::Number(seconds) => seconds.as_f64().map(|seconds| (seconds * SECOND as f64) as i128),
                _ => None,
            };
            if let Some(recorded) = nanos.and_then(|nanos| i64::try_from(nanos).ok()).map(Time::from_nanos) {
                heard = recorded;
                *time = self.now(recorded).to_string().into();
            }
        }
        let octets = members.get("message").and_then(Value::as_str).and_then(hex::octets);
        if let Some(mut octets) = octets {
            self.move_messages(&mut octets, heard);
            members.insert("message".to_owned(), hex::text(&octets).into());
        }
        Value::Object(members).to_string().into_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::time::DAY;
    use remote_id::{Message, messages};

    const FIRST: Time = Time::from_nanos(20_000 * DAY + 36_000 * SECOND);
    /// Some years later, close to midnight, not on a whole second.
    const NOW: Time = Time::from_nanos(20_900 * DAY + DAY - 2 * SECOND + 300_000_000);

    fn redated(octets: &[u8], received: Time, speed: f64) -> Vec<u8> {
        let mut payload = octets.to_vec();
        Redating::new(FIRST, NOW, speed).move_times(&mut payload, received, |_| cat021::Edition::default());
        payload
    }

    /// A block of CAT048 and one of CAT034, each with this time of day.
    fn datagram(count: u32) -> Vec<u8> {
        let [_, a, b, c] = count.to_be_bytes();
        [[48, 0, 10, 0b1110_0000, 25, 10, a, b, c, 0x20], [34, 0, 10, 0b1110_0000, 25, 10, 2, a, b, c]]
            .concat()
    }

    #[test]
    fn times_move_by_whole_seconds_and_the_rest_stays() {
        let count = 36_005 * 128 + 77;
        let recorded = datagram(count);
        let moved = redated(&recorded, FIRST + jiff::SignedDuration::from_secs(5), 1.0);
        let begins = Redating::new(FIRST, NOW, 1.0).now(FIRST);
        assert!(begins > NOW && begins.nanos() - NOW.nanos() <= SECOND);
        assert_eq!((begins.nanos() - FIRST.nanos()) % SECOND, 0);
        // Across midnight.
        let expected = (time_of_day_count(begins) + 5 * 128 + 77) % TimeOfDay::PER_DAY;
        let differing: Vec<usize> = (0..recorded.len()).filter(|&at| recorded[at] != moved[at]).collect();
        let at = |range: std::ops::Range<usize>| {
            u32::from_be_bytes([0, moved[range.start], moved[range.start + 1], moved[range.start + 2]])
        };
        assert_eq!(at(6..9), expected);
        assert_eq!(at(17..20), expected);
        assert!(differing.iter().all(|at| (6..9).contains(at) || (17..20).contains(at)), "{differing:?}");
    }

    #[test]
    fn a_faster_recording_has_its_times_closer_together() {
        let redating = Redating::new(FIRST, NOW, 4.0);
        let (early, late) = (FIRST, FIRST + jiff::SignedDuration::from_secs(8));
        assert_eq!((redating.now(late) - redating.now(early)).as_secs(), 2);
    }

    #[test]
    fn damaged_octets_stay_as_they_are() {
        for octets in [&b""[..], b"\x30\x00\x05\xff\xff", b"\x30\xff\xff\x01", b"{\"message\":", b"\x00"] {
            assert_eq!(redated(octets, FIRST, 1.0), octets);
        }
    }

    #[test]
    fn remote_id_messages_and_lines_move() {
        let received = FIRST + jiff::SignedDuration::from_millis(3_599_900);
        let mut octets = [0; MESSAGE];
        octets[0] = 0x12;
        // Half a second before the reception.
        octets[21..23].copy_from_slice(&35_994_u16.to_le_bytes());
        let seconds = |octets: &[u8]| {
            let Some(Ok(Message::Location(location))) = messages(octets).next() else { panic!() };
            location.seconds_of_hour().unwrap()
        };
        let moved = Redating::new(FIRST, NOW, 1.0).now(received).nanos() - SECOND / 2;
        let expected = (moved.rem_euclid(3_600 * SECOND)) as f64 / SECOND as f64;
        assert!((seconds(&redated(&octets, received, 1.0)) - expected).abs() < 1e-9);
        let line = format!(
            "{{\"time\":\"{received}\",\"transmitter\":\"a\",\"message\":\"{}\"}}",
            hex::text(&octets)
        );
        let moved = redated(line.as_bytes(), FIRST, 1.0);
        let line = input::gateways::remote_id::BroadcastLine::parse(&moved).unwrap();
        assert_eq!(line.time, Some(Redating::new(FIRST, NOW, 1.0).now(received)));
        assert!((seconds(&line.octets) - expected).abs() < 1e-9);
    }
}
