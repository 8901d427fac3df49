//! MAVLink, frames of version 1 and 2:
//!
//! | message | becomes |
//! |---|---|
//! | GLOBAL_POSITION_INT | CAT129: own drones, identified by their system numbers, each with the serial number from a table |
//! | ADSB_VEHICLE | CAT021, edition 2.6 (`vehicle.rs`) |
//! | OPEN_DRONE_ID_BASIC_ID, LOCATION, SYSTEM, OPERATOR_ID, MESSAGE_PACK | a line of Remote ID (`remote_id.rs`) |
//!
//! A frame's checksum is verified. Signatures are not verified, because the service has no key: the network has to keep
//! strangers out.

mod remote_id;
#[cfg(test)]
mod tests;
mod vehicle;

use std::collections::BTreeMap;

use asterix::cat129::{Altitude, HorizontalVelocity, Position, Record, VerticalVelocity};
use asterix::{BuildError, DataSource, encode_block};
use fusion::time::Time;

use super::{DropCounts, time_of_day};
use site::config::{Connection, ConnectionFormat, KnownSystem, Sensor, SensorKind};

/// Entries for all system numbers, with the serial numbers `SYSTEM-1` to `SYSTEM-255`.
pub fn every_system() -> BTreeMap<u8, KnownSystem> {
    (1..=u8::MAX)
        .filter_map(|number| Some((number, KnownSystem::new(&format!("SYSTEM-{number}"))?)))
        .collect()
}

/// Sensors for the translated messages; a message of a kind without a sensor is dropped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MavlinkSensors {
    /// SAC and SIC for positions of own drones, with the drones.
    pub drones: Option<(DataSource, BTreeMap<u8, KnownSystem>)>,
    /// SAC and SIC for ADSB_VEHICLE.
    pub aircraft: Option<DataSource>,
    /// Receiver of OPEN_DRONE_ID messages.
    pub remote_id: Option<RemoteIdReceiver>,
}

impl MavlinkSensors {
    /// For each kind, the first sensor with a `"mavlink"` connection that is wanted.
    pub fn of<'a>(
        sensors: impl Iterator<Item = &'a Sensor>,
        is_wanted: impl Fn(&Connection) -> bool,
    ) -> Self {
        let mut found = Self::default();
        for sensor in sensors {
            let is_heard = |of: &&Connection| of.format == ConnectionFormat::Mavlink && is_wanted(of);
            let Some(connection) = sensor.connections.iter().find(is_heard) else { continue };
            let source = DataSource { sac: sensor.sac, sic: sensor.sic };
            match sensor.kind {
                SensorKind::Transponder(_) => {
                    found.drones.get_or_insert_with(|| (source, connection.systems()));
                }
                SensorKind::AdsB(_) => {
                    found.aircraft.get_or_insert(source);
                }
                SensorKind::RemoteId(_) => {
                    let id = Some(sensor.id.clone());
                    found.remote_id.get_or_insert(RemoteIdReceiver { id });
                }
                SensorKind::Radar(_) | SensorKind::Camera(_) => {}
            }
        }
        found
    }
}

/// Receiver of Remote ID.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RemoteIdReceiver {
    /// Id of the sensor, for the lines.
    pub id: Option<String>,
}

/// Length of the frame that begins with these three octets; `None` if no frame does.
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

/// Whether the checksum of this frame is correct; `None` if it cannot be verified.
pub fn is_sound(frame: &[u8]) -> Option<bool> {
    MavlinkFrame::new(frame).ok()?.is_sound()
}

/// Reason for dropping a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MavlinkDropReason {
    /// `cut`: the datagram ends before the frame does.
    Cut,
    /// `checksum`: damaged, or of another dialect.
    Checksum,
    /// `incompatible`: it requires an unpublished feature of its receiver.
    Incompatible,
    /// `other_message`: of a kind that is not translated, or that the connection has no sensor for.
    OtherMessage,
    /// `unknown_system`: not in the table.
    UnknownSystem,
    /// `no_position`: at 0, 0, as without a fix, or marked as invalid.
    NoPosition,
    /// `out_of_range`: not a place on the Earth, or a value that an item cannot represent.
    OutOfRange,
}

pub(super) const REASONS: [&str; 7] =
    ["cut", "checksum", "incompatible", "other_message", "unknown_system", "no_position", "out_of_range"];

/// Counts of a translator. Every frame is translated, a heartbeat, or dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MavlinkCounts {
    /// Frames, complete or not.
    pub frames: u64,
    /// Octets outside of frames.
    pub outside: u64,
    /// Messages translated to records or lines.
    pub translated: u64,
    /// HEARTBEAT messages of systems in the table.
    pub heartbeats: u64,
    /// Frames with a signature, which is not verified.
    pub signed: u64,
    /// Frames dropped, by [`MavlinkDropReason`].
    pub dropped: DropCounts<7>,
}

impl Default for MavlinkCounts {
    fn default() -> Self {
        Self {
            frames: 0,
            outside: 0,
            translated: 0,
            heartbeats: 0,
            signed: 0,
            dropped: DropCounts::new(&REASONS),
        }
    }
}

/// Translates datagrams.
#[derive(Clone, Debug)]
pub struct MavlinkTranslator {
    sensors: MavlinkSensors,
    counts: MavlinkCounts,
}

/// First octets of frames of version 1 and 2.
const VERSION_1: u8 = 0xfe;
const VERSION_2: u8 = 0xfd;
/// Octets before the contents, including the first one.
const HEADERS: [usize; 2] = [6, 10];
const CHECKSUM: usize = 2;
const SIGNATURE: usize = 13;
/// Flag of a signed frame.
const SIGNED: u8 = 1;
/// Number and checksum seed of the messages that are translated (MAVLink `minimal.xml`, `standard.xml` and `common.xml`).
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
/// Maximum number of octets of a message.
const CONTENTS_MOST: usize = 255;

/// Checksum of these octets and of the seed of their message (CRC-16/MCRF4XX; MAVLink guide, "Packet serialization").
fn calculate_crc(octets: &[u8], seed: u8) -> u16 {
    octets.iter().chain([&seed]).fold(u16::MAX, |crc, &octet| {
        (0..8).fold(crc ^ u16::from(octet), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0x8408 } else { crc >> 1 })
    })
}

/// Contents of a message. Version 2 omits zeros at the end; additional octets are extensions of the message.
struct MavlinkPayload([u8; CONTENTS_MOST]);

impl MavlinkPayload {
    fn new(sent: &[u8]) -> Self {
        let mut contents = [0; CONTENTS_MOST];
        contents.iter_mut().zip(sent).for_each(|(octet, sent)| *octet = *sent);
        Self(contents)
    }

    /// Octets at an offset within every message that is translated.
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

/// A frame whose checksum is not verified yet.
struct MavlinkFrame<'a> {
    is_signed: bool,
    is_incompatible: bool,
    system: u8,
    component: u8,
    message: u32,
    /// Octets covered by the checksum, and the checksum.
    summed: &'a [u8],
    checksum: u16,
    contents: &'a [u8],
    length: usize,
}

impl<'a> MavlinkFrame<'a> {
    /// The frame at the start of these octets. `Err(true)`: it is cut; `Err(false)`: there is none.
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

    /// Whether the checksum is correct; `None` for a message with an unknown seed.
    fn is_sound(&self) -> Option<bool> {
        let known = READ.into_iter().find(|(number, _)| *number == self.message);
        known.map(|(_, seed)| calculate_crc(self.summed, seed) == self.checksum)
    }

    /// Whether a correct frame begins within this one, the first of `octets`, and extends beyond its contents: then this
    /// one's length is damaged. A frame completely within the contents was forwarded by a system, and is not counted.
    fn is_reached_into(&self, octets: &[u8]) -> bool {
        let contents_end = 1 + self.summed.len();
        (1..self.length).any(|place| {
            MavlinkFrame::new(&octets[place..])
                .is_ok_and(|inner| place + inner.length > contents_end && inner.is_sound() == Some(true))
        })
    }
}

impl MavlinkTranslator {
    /// A translator for these sensors.
    pub fn new(sensors: MavlinkSensors) -> Self {
        Self { sensors, counts: MavlinkCounts::default() }
    }

    /// Counts so far.
    pub fn counts(&self) -> &MavlinkCounts {
        &self.counts
    }

    /// Takes a datagram with its time of reception. Translated datagrams are passed to `out`.
    pub fn take(&mut self, mut octets: &[u8], received: Time, mut out: impl FnMut(Vec<u8>)) {
        while !octets.is_empty() {
            let frame = match MavlinkFrame::new(octets) {
                Ok(frame) => frame,
                Err(is_cut) => {
                    if is_cut {
                        self.drop(MavlinkDropReason::Cut);
                    }
                    octets = self.next(octets);
                    continue;
                }
            };
            let behind = &octets[frame.length..];
            let is_sound = frame.is_sound();
            // A frame that cannot be verified is accepted if it is followed by another one or the end, and no frame
            // overlaps it.
            let is_followed = matches!(behind.first(), None | Some(&(VERSION_1 | VERSION_2)));
            match is_sound {
                Some(true) => {}
                None if is_followed && !frame.is_reached_into(octets) => {}
                Some(false) | None => {
                    self.drop(MavlinkDropReason::Checksum);
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

    /// Translates a frame received at this time: a datagram, or `None` for a heartbeat. Does not count.
    pub(crate) fn frame_at(
        &self,
        octets: &[u8],
        received: Time,
    ) -> Result<Option<Vec<u8>>, MavlinkDropReason> {
        let frame = MavlinkFrame::new(octets).map_err(|_| MavlinkDropReason::Cut)?;
        if frame.is_sound() == Some(false) {
            Err(MavlinkDropReason::Checksum)
        } else {
            self.frame(&frame, received)
        }
    }

    fn drop(&mut self, reason: MavlinkDropReason) {
        self.counts.frames += 1;
        self.counts.dropped.add(reason as usize);
    }

    /// Skips octets that are not a frame, up to the next correct frame or the end.
    fn next<'a>(&mut self, octets: &'a [u8]) -> &'a [u8] {
        let is_sound = |place: &usize| {
            MavlinkFrame::new(&octets[*place..]).is_ok_and(|frame| frame.is_sound() == Some(true))
        };
        let place = (1..octets.len()).find(is_sound).unwrap_or(octets.len());
        self.counts.outside += place as u64;
        &octets[place..]
    }

    fn frame(&self, frame: &MavlinkFrame<'_>, received: Time) -> Result<Option<Vec<u8>>, MavlinkDropReason> {
        if frame.is_incompatible {
            return Err(MavlinkDropReason::Incompatible);
        }
        let contents = MavlinkPayload::new(frame.contents);
        let MavlinkSensors { drones, aircraft, remote_id: receiver } = &self.sensors;
        match (frame.message, drones, aircraft, receiver) {
            (number, Some((source, systems)), ..)
                if [HEARTBEAT.0, GLOBAL_POSITION_INT.0].contains(&number) =>
            {
                let system = systems.get(&frame.system).ok_or(MavlinkDropReason::UnknownSystem)?;
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
            _ => Err(MavlinkDropReason::OtherMessage),
        }
    }
}

/// The record of a GLOBAL_POSITION_INT.
fn position(
    source: DataSource,
    system: &KnownSystem,
    contents: &MavlinkPayload,
    received: Time,
) -> Result<Vec<u8>, MavlinkDropReason> {
    let [latitude, longitude, altitude_mm] = [4, 8, 12].map(|at| contents.i32(at));
    if latitude == 0 && longitude == 0 {
        return Err(MavlinkDropReason::NoPosition);
    }
    // Centimetres per second to the north, to the east, and down.
    let [north, east, down] = [20, 22, 24].map(|at| f64::from(contents.i16(at)) / 100.0);
    let position = Position::new(f64::from(latitude) * 1e-7, f64::from(longitude) * 1e-7);
    let (position, time) = position.zip(time_of_day(received)).ok_or(MavlinkDropReason::OutOfRange)?;
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
        // A record is always shorter than the maximum of a block.
        let _ = encode_block(&[builder.build()?], &mut datagram);
        Ok(datagram)
    };
    build().map_err(|_| MavlinkDropReason::OutOfRange)
}
