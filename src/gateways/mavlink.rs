//! From MAVLink position reports (GLOBAL_POSITION_INT, frames of version 1 and 2) to CAT129: own drones, known by their system
//! number, each with the serial number that a table gives it.
//!
//! A frame's checksum is verified. A signed frame is taken as an unsigned one: the service has no key, so it is the network that
//! must keep strangers out.

use std::collections::BTreeMap;

use asterix::cat129::{Altitude, HorizontalVelocity, Position, Record, VerticalVelocity};
use asterix::{BuildError, DataSource, encode_block};
use fusion::time::Time;
use mavlink_core::calculate_crc;

use super::{Dropped, time_of_day};

/// What the table says of a system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct System {
    /// I129/040: filled up with blanks.
    pub serial_number: [u8; 12],
    /// I129/020.
    pub manufacturer: Option<[u8; 3]>,
    /// I129/030.
    pub model: Option<[u8; 3]>,
    /// I129/050.
    pub country: [u8; 2],
}

/// A country for those that state none: of the codes that ISO 3166-1 leaves to users the one that is used for "unknown".
pub const NO_COUNTRY: [u8; 2] = *b"ZZ";

impl System {
    /// A system with this serial number; `None` where that is blank, longer than 12 octets or not printable ASCII.
    pub fn new(serial_number: &str) -> Option<Self> {
        let is_sound = serial_number.bytes().all(|octet| (b' '..=b'~').contains(&octet));
        if serial_number.trim().is_empty() || serial_number.len() > 12 || !is_sound {
            return None;
        }
        let mut filled = [b' '; 12];
        filled[..serial_number.len()].copy_from_slice(serial_number.as_bytes());
        Some(Self { serial_number: filled, manufacturer: None, model: None, country: NO_COUNTRY })
    }
}

/// Every system number, each drone called after it: `SYSTEM-1` to `SYSTEM-255`.
pub fn every_system() -> BTreeMap<u8, System> {
    (1..=u8::MAX).filter_map(|number| Some((number, System::new(&format!("SYSTEM-{number}"))?))).collect()
}

/// Octets of the frame that begins with these three; `None` if none does.
pub(crate) fn frame_length(start: [u8; 3]) -> Option<usize> {
    let [magic, contents, flags] = start;
    let around = match magic {
        VERSION_1 => HEADERS[0] + CHECKSUM,
        VERSION_2 if flags & SIGNED != 0 => HEADERS[1] + CHECKSUM + SIGNATURE,
        VERSION_2 => HEADERS[1] + CHECKSUM,
        _ => return None,
    };
    Some(around + usize::from(contents))
}

/// Whether the checksum of this frame fits; `None` where it cannot be verified.
pub(crate) fn is_sound(frame: &[u8]) -> Option<bool> {
    Frame::new(frame).ok()?.is_sound()
}

/// Why a frame is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// `cut`: the datagram ends before the frame does.
    Cut,
    /// `checksum`: it is damaged, or of another dialect.
    Checksum,
    /// `incompatible`: it needs something of its reader that nobody has published.
    Incompatible,
    /// `other_message`: neither a position nor a sign of life.
    OtherMessage,
    /// `unknown_system`: the table does not have it.
    UnknownSystem,
    /// `no_position`: at 0, 0, as without a fix.
    NoPosition,
    /// `out_of_range`: no place on the Earth, or more than an item can hold.
    OutOfRange,
}

pub(super) const REASONS: [&str; 7] =
    ["cut", "checksum", "incompatible", "other_message", "unknown_system", "no_position", "out_of_range"];

/// What a translator has met. Every frame is translated, a sign of life, or dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Frames, whole or not.
    pub frames: u64,
    /// Octets in no frame.
    pub outside: u64,
    /// Positions that became records.
    pub translated: u64,
    /// HEARTBEAT of systems of the table.
    pub heartbeats: u64,
    /// Of all frames, those with a signature, which is not verified.
    pub signed: u64,
    /// Frames dropped, by [`Reason`].
    pub dropped: Dropped<7>,
}

impl Default for Counts {
    fn default() -> Self {
        Self {
            frames: 0,
            outside: 0,
            translated: 0,
            heartbeats: 0,
            signed: 0,
            dropped: Dropped::new(&REASONS),
        }
    }
}

/// Translates datagrams.
#[derive(Clone, Debug)]
pub struct Translator {
    source: DataSource,
    systems: BTreeMap<u8, System>,
    counts: Counts,
}

/// First octets of frames of version 1 and 2.
const VERSION_1: u8 = 0xfe;
const VERSION_2: u8 = 0xfd;
/// Octets in front of the contents, the first one included.
const HEADERS: [usize; 2] = [6, 10];
const CHECKSUM: usize = 2;
const SIGNATURE: usize = 13;
/// The flag of a signed frame.
const SIGNED: u8 = 1;
/// Number, seed of the checksum and octets of the messages that are read (MAVLink `standard.xml`).
const HEARTBEAT: (u32, u8) = (0, 50);
const GLOBAL_POSITION_INT: (u32, u8) = (33, 104);
const POSITION_OCTETS: usize = 28;

/// A frame, its checksum not verified yet.
struct Frame<'a> {
    is_signed: bool,
    is_incompatible: bool,
    system: u8,
    message: u32,
    /// What the checksum is of, and the checksum.
    summed: &'a [u8],
    checksum: u16,
    contents: &'a [u8],
    length: usize,
}

impl<'a> Frame<'a> {
    /// The frame that these octets begin with. `Err(true)`: it is cut; `Err(false)`: it is none.
    fn new(octets: &'a [u8]) -> Result<Self, bool> {
        let header = match octets.first() {
            Some(&VERSION_1) => HEADERS[0],
            Some(&VERSION_2) => HEADERS[1],
            _ => return Err(false),
        };
        let is_second = header == HEADERS[1];
        let start = octets.get(..header).ok_or(true)?;
        let end = header + usize::from(start[1]);
        let is_signed = is_second && start[2] & SIGNED != 0;
        let length = end + CHECKSUM + if is_signed { SIGNATURE } else { 0 };
        let frame = octets.get(..length).ok_or(true)?;
        let (system, message) = if is_second {
            (start[5], u32::from_le_bytes([start[7], start[8], start[9], 0]))
        } else {
            (start[3], u32::from(start[5]))
        };
        Ok(Self {
            is_signed,
            is_incompatible: is_second && start[2] & !SIGNED != 0,
            system,
            message,
            summed: &frame[1..end],
            checksum: u16::from_le_bytes([frame[end], frame[end + 1]]),
            contents: &frame[header..end],
            length,
        })
    }

    /// Whether the checksum fits; of a message whose seed is not known, `None`.
    fn is_sound(&self) -> Option<bool> {
        let known = [HEARTBEAT, GLOBAL_POSITION_INT].into_iter().find(|(number, _)| *number == self.message);
        known.map(|(_, seed)| calculate_crc(self.summed, seed) == self.checksum)
    }

    /// Whether a sound frame begins within this one, the first of `octets`, and goes on behind its contents: then this one's length
    /// is damaged. A frame that lies within the contents as a whole is what a system has sent on, and no neighbour.
    fn is_reached_into(&self, octets: &[u8]) -> bool {
        let contents_end = 1 + self.summed.len();
        (1..self.length).any(|place| {
            Frame::new(&octets[place..])
                .is_ok_and(|inner| place + inner.length > contents_end && inner.is_sound() == Some(true))
        })
    }
}

impl Translator {
    /// Of the systems of a table, whose records bear the sensor's SAC and SIC.
    pub fn new(source: DataSource, systems: BTreeMap<u8, System>) -> Self {
        Self { source, systems, counts: Counts::default() }
    }

    /// What it has met so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Takes a datagram that was received at a time. Each translated one goes to `out`.
    pub fn take(&mut self, mut octets: &[u8], received: Time, mut out: impl FnMut(Vec<u8>)) {
        while !octets.is_empty() {
            let frame = match Frame::new(octets) {
                Ok(frame) => frame,
                Err(is_cut) => {
                    if is_cut {
                        self.drop(Reason::Cut);
                    }
                    octets = self.next(octets);
                    continue;
                }
            };
            let behind = &octets[frame.length..];
            let is_sound = frame.is_sound();
            // What cannot be verified is believed to be a frame where another one, or nothing, follows, and none reaches into it.
            let is_followed = matches!(behind.first(), None | Some(&(VERSION_1 | VERSION_2)));
            match is_sound {
                Some(true) => {}
                None if is_followed && !frame.is_reached_into(octets) => {}
                Some(false) | None => {
                    self.drop(Reason::Checksum);
                    octets = self.next(octets);
                    continue;
                }
            }
            self.counts.signed += u64::from(frame.is_signed);
            match self.frame(&frame, received) {
                Ok(Some(datagram)) => {
                    self.counts.frames += 1;
                    self.counts.translated += 1;
                    out(datagram);
                }
                Ok(None) => {
                    self.counts.frames += 1;
                    self.counts.heartbeats += 1;
                }
                Err(reason) => self.drop(reason),
            }
            octets = behind;
        }
    }

    /// Translates the frame that these octets are, received at a time: a datagram, or `None` for a sign of life. Counts nothing.
    pub(crate) fn frame_at(&self, octets: &[u8], received: Time) -> Result<Option<Vec<u8>>, Reason> {
        let frame = Frame::new(octets).map_err(|_| Reason::Cut)?;
        if frame.is_sound() == Some(false) { Err(Reason::Checksum) } else { self.frame(&frame, received) }
    }

    fn drop(&mut self, reason: Reason) {
        self.counts.frames += 1;
        self.counts.dropped.add(reason as usize);
    }

    /// Behind what is no frame: from the next sound frame on, or the end. What lies between belongs to none.
    fn next<'a>(&mut self, octets: &'a [u8]) -> &'a [u8] {
        let is_sound =
            |place: &usize| Frame::new(&octets[*place..]).is_ok_and(|frame| frame.is_sound() == Some(true));
        let place = (1..octets.len()).find(is_sound).unwrap_or(octets.len());
        self.counts.outside += place as u64;
        &octets[place..]
    }

    fn frame(&self, frame: &Frame<'_>, received: Time) -> Result<Option<Vec<u8>>, Reason> {
        if frame.is_incompatible {
            return Err(Reason::Incompatible);
        }
        if ![HEARTBEAT.0, GLOBAL_POSITION_INT.0].contains(&frame.message) {
            return Err(Reason::OtherMessage);
        }
        let system = self.systems.get(&frame.system).ok_or(Reason::UnknownSystem)?;
        if frame.message == HEARTBEAT.0 {
            return Ok(None);
        }
        // Version 2 leaves out zeros at the end; what is longer has been extended.
        let mut contents = [0; POSITION_OCTETS];
        contents.iter_mut().zip(frame.contents).for_each(|(octet, sent)| *octet = *sent);
        let whole = |at: usize| i32::from_le_bytes(*contents[at..].first_chunk().expect("28 octets"));
        let half =
            |at: usize| f64::from(i16::from_le_bytes(*contents[at..].first_chunk().expect("28 octets")));
        let [latitude, longitude, altitude_mm] = [4, 8, 12].map(whole);
        if latitude == 0 && longitude == 0 {
            return Err(Reason::NoPosition);
        }
        // Centimetres a second to the north, to the east, down.
        let [north, east, down] = [20, 22, 24].map(|at| half(at) / 100.0);
        let position = Position::new(f64::from(latitude) * 1e-7, f64::from(longitude) * 1e-7);
        let (position, time) = position.zip(time_of_day(received)).ok_or(Reason::OutOfRange)?;
        let build = || -> Result<Vec<u8>, BuildError> {
            let mut builder = Record::builder(self.source, system.country, time, position)
                .serial_number(Some(system.serial_number))
                .altitude_amsl(Altitude::from_metres(f64::from(altitude_mm) / 1000.0))
                .horizontal_velocity(HorizontalVelocity::new(east, north))
                .vertical_velocity(VerticalVelocity::new(-down));
            if let Some(manufacturer) = system.manufacturer {
                builder = builder.manufacturer(Some(manufacturer));
            }
            if let Some(model) = system.model {
                builder = builder.model(Some(model));
            }
            let mut datagram = Vec::new();
            // A record is far shorter than a block may be.
            let _ = encode_block(&[builder.build()?], &mut datagram);
            Ok(datagram)
        };
        build().map(Some).map_err(|_| Reason::OutOfRange)
    }
}

#[cfg(test)]
mod tests {
    use asterix::blocks;
    use proptest::prelude::*;

    use super::*;

    const SOURCE: DataSource = DataSource { sac: 25, sic: 31 };
    const NOON: Time = Time::from_nanos(1_800_014_400_000_000_000);

    fn translator() -> Translator {
        let system = System { manufacturer: Some(*b"ACM"), ..System::new("DRONE-7").unwrap() };
        Translator::new(SOURCE, BTreeMap::from([(7, system)]))
    }

    /// A frame as a sender makes it.
    fn frame(version: u8, flags: u8, system: u8, message: u32, contents: &[u8]) -> Vec<u8> {
        let [low, middle, high, _] = message.to_le_bytes();
        let length = contents.len() as u8;
        let mut frame = match version {
            1 => vec![VERSION_1, length, 9, system, 1, low],
            _ => vec![VERSION_2, length, flags, 0, 9, system, 1, low, middle, high],
        };
        frame.extend(contents);
        let seed = if message == HEARTBEAT.0 { HEARTBEAT.1 } else { GLOBAL_POSITION_INT.1 };
        let checksum = calculate_crc(&frame[1..], seed);
        frame.extend(checksum.to_le_bytes());
        if version == 2 && flags & SIGNED != 0 {
            frame.extend([0xfd; SIGNATURE]);
        }
        frame
    }

    fn position(latitude: i32, longitude: i32) -> Vec<u8> {
        let mut contents = 5000_u32.to_le_bytes().to_vec();
        [latitude, longitude, 123_400, 50_000].iter().for_each(|value| contents.extend(value.to_le_bytes()));
        [1250_i16, -300, -150].iter().for_each(|value| contents.extend(value.to_le_bytes()));
        contents.extend(35_000_u16.to_le_bytes());
        contents
    }

    fn records(translator: &mut Translator, octets: &[u8]) -> Vec<Record> {
        let mut records = Vec::new();
        translator.take(octets, NOON, |datagram| {
            let block = blocks(&datagram).next().unwrap().unwrap();
            records.extend(block.records::<Record>().map(|located| located.unwrap().record));
        });
        let counts = translator.counts();
        assert_eq!(counts.frames, counts.translated + counts.heartbeats + counts.dropped.total());
        records
    }

    /// A HEARTBEAT of an ArduPilot simulation, octet by octet, and its checksum as pymavlink computes it.
    #[test]
    fn a_checksum_is_that_of_others() {
        // mavutil: type 2, autopilot 3, base_mode 81, custom_mode 0, status 3, version 3.
        let octets = [0, 0, 0, 0, 2, 3, 81, 3, 3];
        // CRC-16/MCRF4XX of "123456789" is 0x6f91; a seed of 0 behind it takes another step.
        assert_eq!(calculate_crc(b"12345678", b'9'), 0x6f91);
        let mut translator = translator();
        records(&mut translator, &frame(1, 0, 7, 0, &octets));
        assert_eq!(translator.counts().heartbeats, 1);
    }

    #[test]
    fn a_position_of_either_version_signed_or_not() {
        let contents = position(500_000_000, 80_000_000);
        // The heading of 0 is left out at the end of a frame of version 2.
        let short = [&contents[..26], &[0, 0]].concat();
        let frames = [
            frame(1, 0, 7, 33, &contents),
            frame(2, 0, 7, 33, &contents),
            frame(2, SIGNED, 7, 33, &contents),
            frame(2, 0, 7, 33, &short[..26]),
        ];
        let mut translator = translator();
        let records = records(&mut translator, &frames.concat());
        assert_eq!((records.len(), translator.counts().signed, translator.counts().outside), (4, 1, 0));
        for record in records {
            assert_eq!(record.data_source, Some(SOURCE));
            assert_eq!(record.serial_number, Some(*b"DRONE-7     "));
            assert_eq!(
                (record.manufacturer, record.model, record.registration_country),
                (Some(*b"ACM"), None, Some(*b"ZZ"))
            );
            let place = record.position.unwrap();
            assert!((place.latitude_deg() - 50.0).abs() < 1e-6 && (place.longitude_deg() - 8.0).abs() < 1e-6);
            assert_eq!(record.altitude_amsl.unwrap().metres(), 123.4);
            let velocity = record.horizontal_velocity.unwrap();
            assert_eq!((velocity.east_m_s(), velocity.north_m_s()), (-3.0, 12.5));
            assert_eq!(record.vertical_velocity.unwrap().up_m_s(), 1.5);
            assert_eq!(record.time_of_day.unwrap().seconds(), 43_200.0);
        }
    }

    #[test]
    fn what_is_dropped_is_counted_by_reason() {
        let good = position(500_000_000, 80_000_000);
        let mut damaged = frame(2, 0, 7, 33, &good);
        damaged[14] ^= 4;
        let mut translator = translator();
        for octets in [
            damaged,
            frame(2, 0, 8, 33, &good),
            frame(2, 0, 7, 33, &position(0, 0)),
            frame(2, 0, 7, 33, &position(910_000_000, 0)),
            frame(2, 2, 7, 33, &good),
            frame(2, 0, 7, 30, &good),
            frame(1, 0, 7, 33, &good)[..20].to_vec(),
        ] {
            assert!(records(&mut translator, &octets).is_empty());
        }
        let expected = "1 cut, 1 checksum, 1 incompatible, 1 other_message, 1 unknown_system, 1 no_position, 1 out_of_range";
        assert_eq!(translator.counts().dropped.to_string(), expected);
    }

    /// What has no known checksum may claim its neighbours as contents, up to the end or to what looks like another frame.
    #[test]
    fn a_damaged_length_swallows_no_neighbour_and_contents_are_no_frames() {
        let good = frame(1, 0, 7, 33, &position(500_000_000, 80_000_000));
        let unknown = frame(1, 0, 7, 30, &[0; 28]);
        for neighbours in 1..=2 {
            let mut damaged = unknown.clone();
            damaged[1] += (neighbours * good.len()) as u8;
            let octets = [damaged, good.repeat(neighbours)].concat();
            let mut translator = translator();
            assert_eq!(records(&mut translator, &octets).len(), neighbours);
            assert_eq!(translator.counts().dropped.to_string(), "1 checksum");
            assert_eq!(translator.counts().outside, unknown.len() as u64);
        }
        let mut translator = translator();
        assert!(records(&mut translator, &frame(1, 0, 7, 30, &good)).is_empty());
        assert_eq!(translator.counts().dropped.to_string(), "1 other_message");
    }

    #[test]
    fn serial_numbers() {
        assert_eq!(System::new("123456789012").unwrap().serial_number, *b"123456789012");
        assert_eq!(["", "   ", "1234567890123", "é"].map(System::new), [None, None, None, None]);
    }

    proptest! {
        #[test]
        fn any_octets_are_counted_and_nothing_else(octets: Vec<u8>, first in prop::sample::select(vec![0xfe_u8, 0xfd, 0])) {
            records(&mut translator(), &[&[first], &octets[..]].concat());
        }

        #[test]
        fn a_damaged_frame_costs_its_neighbours_nothing(damage in prop::collection::btree_map(0..40_usize, any::<u8>(), 1..6), second: bool) {
            let version = if second { 2 } else { 1 };
            let good = frame(version, 0, 7, 33, &position(500_000_000, 80_000_000));
            let mut bad = good.clone();
            for (at, octet) in damage {
                let at = at % bad.len();
                bad[at] = octet;
            }
            let found = records(&mut translator(), &[&good[..], &bad, &good].concat());
            prop_assert!((2..=3).contains(&found.len()));
        }
    }
}
