//! MAVLink, frames of version 1 and 2:
//!
//! | message | becomes |
//! |---|---|
//! | GLOBAL_POSITION_INT | CAT129: own drones, known by their system number, each with the serial number that a table gives it |
//! | ADSB_VEHICLE | CAT021, edition 2.6 (`vehicle.rs`) |
//! | OPEN_DRONE_ID_BASIC_ID, LOCATION, SYSTEM, OPERATOR_ID, MESSAGE_PACK | a line of Remote ID (`remote_id.rs`) |
//!
//! A frame's checksum is verified. A signed frame is taken as an unsigned one: the service has no key, so it is the network that
//! must keep strangers out.

mod remote_id;
#[cfg(test)]
mod tests;
mod vehicle;

use std::collections::BTreeMap;

use asterix::cat129::{Altitude, HorizontalVelocity, Position, Record, VerticalVelocity, WholeSerial};
use asterix::{BuildError, DataSource, encode_block};
use fusion::time::Time;
use mavlink_core::calculate_crc;

use super::{Dropped, time_of_day};

/// What the table says of a system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct System {
    /// I129/040 holds its last 12 characters; a longer one is in SP, too.
    pub serial_number: WholeSerial,
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
    /// A system with this serial number; `None` where that is blank, longer than 20 octets or not printable ASCII.
    pub fn new(serial_number: &str) -> Option<Self> {
        let is_sound = serial_number.bytes().all(|octet| (b' '..=b'~').contains(&octet));
        if serial_number.trim().is_empty() || !is_sound {
            return None;
        }
        let serial_number = WholeSerial::new(serial_number.as_bytes())?;
        Some(Self { serial_number, manufacturer: None, model: None, country: NO_COUNTRY })
    }
}

/// Every system number, each drone called after it: `SYSTEM-1` to `SYSTEM-255`.
pub fn every_system() -> BTreeMap<u8, System> {
    (1..=u8::MAX).filter_map(|number| Some((number, System::new(&format!("SYSTEM-{number}"))?))).collect()
}

/// The sensors whose records messages become; a message of a kind without a sensor is dropped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sensors {
    /// SAC and SIC of positions of own drones, and the drones.
    pub drones: Option<(DataSource, BTreeMap<u8, System>)>,
    /// SAC and SIC of ADSB_VEHICLE.
    pub aircraft: Option<DataSource>,
    /// Receiver of OPEN_DRONE_ID messages.
    pub remote_id: Option<RemoteIdReceiver>,
}

/// Receiver of Remote ID.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RemoteIdReceiver {
    /// Id of the sensor, which lines name.
    pub id: Option<String>,
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
    /// `other_message`: not read, or of a kind that the connection has no sensor for.
    OtherMessage,
    /// `unknown_system`: the table does not have it.
    UnknownSystem,
    /// `no_position`: at 0, 0, as without a fix, or stated to be invalid.
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
    /// Messages that became records or lines.
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
    sensors: Sensors,
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
/// Number and seed of the checksum of the messages that are read (MAVLink `minimal.xml`, `standard.xml` and `common.xml`).
const HEARTBEAT: (u32, u8) = (0, 50);
const GLOBAL_POSITION_INT: (u32, u8) = (33, 104);
const READ: [(u32, u8); 8] = [
    HEARTBEAT,
    GLOBAL_POSITION_INT,
    vehicle::ADSB_VEHICLE,
    remote_id::BASIC_ID,
    remote_id::LOCATION,
    remote_id::SYSTEM,
    remote_id::OPERATOR_ID,
    remote_id::MESSAGE_PACK,
];
/// Largest number of octets of a message.
const CONTENTS_MOST: usize = 255;

/// The contents of a message. Version 2 leaves out zeros at the end; what is longer than known has been extended.
struct Contents([u8; CONTENTS_MOST]);

impl Contents {
    fn new(sent: &[u8]) -> Self {
        let mut contents = [0; CONTENTS_MOST];
        contents.iter_mut().zip(sent).for_each(|(octet, sent)| *octet = *sent);
        Self(contents)
    }

    /// The octets at a place within every message that is read.
    fn at<const N: usize>(&self, at: usize) -> [u8; N] {
        *self.0[at..].first_chunk().expect("within the contents")
    }

    fn i32(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.at(at))
    }

    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes(self.at(at))
    }

    fn i16(&self, at: usize) -> i16 {
        i16::from_le_bytes(self.at(at))
    }
}

/// A frame, its checksum not verified yet.
struct Frame<'a> {
    is_signed: bool,
    is_incompatible: bool,
    system: u8,
    component: u8,
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
        let (system, component, message) = if is_second {
            (start[5], start[6], u32::from_le_bytes([start[7], start[8], start[9], 0]))
        } else {
            (start[3], start[4], u32::from(start[5]))
        };
        Ok(Self {
            is_signed,
            is_incompatible: is_second && start[2] & !SIGNED != 0,
            system,
            component,
            message,
            summed: &frame[1..end],
            checksum: u16::from_le_bytes([frame[end], frame[end + 1]]),
            contents: &frame[header..end],
            length,
        })
    }

    /// Whether the checksum fits; of a message whose seed is not known, `None`.
    fn is_sound(&self) -> Option<bool> {
        let known = READ.into_iter().find(|(number, _)| *number == self.message);
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
    /// A translator for these sensors.
    pub fn new(sensors: Sensors) -> Self {
        Self { sensors, counts: Counts::default() }
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
        let contents = Contents::new(frame.contents);
        let Sensors { drones, aircraft, remote_id: receiver } = &self.sensors;
        match (frame.message, drones, aircraft, receiver) {
            (number, Some((source, systems)), ..)
                if [HEARTBEAT.0, GLOBAL_POSITION_INT.0].contains(&number) =>
            {
                let system = systems.get(&frame.system).ok_or(Reason::UnknownSystem)?;
                if number == HEARTBEAT.0 {
                    return Ok(None);
                }
                position(*source, system, &contents, received).map(Some)
            }
            (number, _, Some(source), _) if number == vehicle::ADSB_VEHICLE.0 => {
                vehicle::record(*source, &contents, received).map(Some)
            }
            (number, .., Some(receiver)) if remote_id::NUMBERS.contains(&number) => {
                let sender = (frame.system, frame.component);
                remote_id::line(receiver, sender, number, &contents, received).map(Some)
            }
            _ => Err(Reason::OtherMessage),
        }
    }
}

/// The record of a GLOBAL_POSITION_INT.
fn position(
    source: DataSource,
    system: &System,
    contents: &Contents,
    received: Time,
) -> Result<Vec<u8>, Reason> {
    let [latitude, longitude, altitude_mm] = [4, 8, 12].map(|at| contents.i32(at));
    if latitude == 0 && longitude == 0 {
        return Err(Reason::NoPosition);
    }
    // Centimetres a second to the north, to the east, down.
    let [north, east, down] = [20, 22, 24].map(|at| f64::from(contents.i16(at)) / 100.0);
    let position = Position::new(f64::from(latitude) * 1e-7, f64::from(longitude) * 1e-7);
    let (position, time) = position.zip(time_of_day(received)).ok_or(Reason::OutOfRange)?;
    let build = || -> Result<Vec<u8>, BuildError> {
        let serial = &system.serial_number;
        let mut builder = Record::builder(source, system.country, time, position)
            .serial_number(Some(serial.last()))
            .altitude_amsl(Altitude::from_metres(f64::from(altitude_mm) / 1000.0))
            .horizontal_velocity(HorizontalVelocity::new(east, north))
            .vertical_velocity(VerticalVelocity::new(-down));
        if let Some(manufacturer) = system.manufacturer {
            builder = builder.manufacturer(Some(manufacturer));
        }
        if let Some(model) = system.model {
            builder = builder.model(Some(model));
        }
        if !serial.octets().ends_with(b"        ") {
            builder = builder.special_purpose(Some(serial.to_field()));
        }
        let mut datagram = Vec::new();
        // A record is far shorter than a block may be.
        let _ = encode_block(&[builder.build()?], &mut datagram);
        Ok(datagram)
    };
    build().map_err(|_| Reason::OutOfRange)
}
