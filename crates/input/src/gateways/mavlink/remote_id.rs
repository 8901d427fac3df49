//! OPEN_DRONE_ID messages: Remote ID of the sender, or of other drones that it receives, as a gateway's line. The messages
//! have the fields of ASTM F3411 in other units, with the same codes.

use std::fmt::Write;

use fusion::time::Time;
use jiff::Timestamp;
use remote_id::{
    BasicId, HeightAbove, IdType, LENGTH, Location, LocationContent, Message, Status, System, SystemContent,
    UaType,
};

use super::{MavlinkDropReason, MavlinkPayload, RemoteIdReceiver};
use crate::hex;

/// Number and checksum seed of each message.
pub(super) const BASIC_ID: (u32, u8) = (12_900, 114);
pub(super) const LOCATION: (u32, u8) = (12_901, 254);
pub(super) const SYSTEM: (u32, u8) = (12_904, 77);
pub(super) const OPERATOR_ID: (u32, u8) = (12_905, 49);
pub(super) const MESSAGE_PACK: (u32, u8) = (12_915, 94);
/// Numbers of all messages.
pub(super) const NUMBERS: [u32; 5] = [BASIC_ID.0, LOCATION.0, SYSTEM.0, OPERATOR_ID.0, MESSAGE_PACK.0];

/// Maximum number of messages in a pack.
const PACK_MOST: u8 = 9;
/// Octets of a MAC address.
const MAC: usize = 6;

/// Line for a message from a system and component.
pub(super) fn line(
    receiver: &RemoteIdReceiver,
    sender: (u8, u8),
    number: u32,
    contents: &MavlinkPayload,
    received: Time,
) -> Result<Vec<u8>, MavlinkDropReason> {
    // Offset of the transmitter's address, if it is not the sender itself.
    let heard_from_at = match number {
        n if n == LOCATION.0 => 32,
        n if n == SYSTEM.0 => 30,
        _ => 2,
    };
    let message = match number {
        n if n == BASIC_ID.0 => basic_id(contents).octets().to_vec(),
        n if n == LOCATION.0 => location(contents)?.to_vec(),
        n if n == SYSTEM.0 => system(contents).octets().to_vec(),
        n if n == OPERATOR_ID.0 => operator_id(contents).to_vec(),
        _ => pack(contents)?,
    };
    let stamp =
        Timestamp::from_nanosecond(received.nanos().into()).map_err(|_| MavlinkDropReason::OutOfRange)?;
    let transmitter = transmitter(sender, contents.at(heard_from_at));
    let mut line = format!("{{\"time\":\"{stamp}\",\"transmitter\":\"{transmitter}\",");
    if let Some(id) = &receiver.id {
        // Ids of sensors consist of letters, digits, _ and -, which need no escaping.
        let _ = write!(line, "\"receiver\":\"{id}\",");
    }
    let _ = write!(line, "\"message\":\"{}\"}}", hex::text(&message));
    Ok(line.into_bytes())
}

/// Name of the drone: the address or identity with which it was received, otherwise the name of the sender.
fn transmitter((system, component): (u8, u8), heard_from: [u8; 20]) -> String {
    let length = heard_from.iter().rposition(|octet| *octet != 0).map_or(0, |last| last + 1);
    match length {
        0 => format!("mavlink-{system}-{component}"),
        1..=MAC => {
            let octets = heard_from[..MAC].iter().map(|octet| format!("{octet:02x}"));
            octets.collect::<Vec<_>>().join(":")
        }
        _ => hex::text(&heard_from[..length]),
    }
}

fn basic_id(contents: &MavlinkPayload) -> Message {
    let [id_type, ua_type] = contents.at(22);
    // The number is encoded unchanged.
    let id: [u8; 20] = contents.at(24);
    Message::BasicId(BasicId::new(IdType::Reserved(id_type), UaType::Other(ua_type), &id))
}

/// Metres; -1000 means unknown.
fn metres(contents: &MavlinkPayload, at: usize) -> Option<f64> {
    let metres = f32::from_le_bytes(contents.at(at));
    (metres.is_finite() && metres > -1000.0).then_some(f64::from(metres))
}

fn location(contents: &MavlinkPayload) -> Result<[u8; LENGTH], MavlinkDropReason> {
    let place = [0, 4].map(|at| contents.i32(at));
    if place == [0, 0] {
        return Err(MavlinkDropReason::NoPosition);
    }
    let place_deg = place.map(|count| f64::from(count) * 1e-7);
    if place_deg[0].abs() > 90.0 || place_deg[1].abs() > 180.0 {
        return Err(MavlinkDropReason::OutOfRange);
    }
    let (course, speed, climb) = (contents.u16(24), contents.u16(26), contents.i16(28));
    let [status, height_reference, horizontal, vertical, pressure, speed_accuracy, time_accuracy] =
        contents.at(52);
    let above = if height_reference == 1 { HeightAbove::Ground } else { HeightAbove::TakeOff };
    let seconds = f64::from(f32::from_le_bytes(contents.at(20)));
    let sent = Location::new(&LocationContent {
        status: Status::Reserved(status),
        course_deg: (course <= 36_000).then_some(f64::from(course) / 100.0),
        speed_m_s: (speed < 25_500).then_some(f64::from(speed) / 100.0),
        climb_m_s: (climb.abs() < 6_300).then_some(f64::from(climb) / 100.0),
        place_deg: Some(place_deg),
        pressure_altitude_m: metres(contents, 8),
        geodetic_altitude_m: metres(contents, 12),
        height_m: metres(contents, 16).map(|metres| (metres, above)),
        accuracy_h_m: None,
        accuracy_v_m: None,
        accuracy_pressure_m: None,
        accuracy_speed_m_s: None,
        seconds_of_hour: (0.0..=3600.0).contains(&seconds).then_some(seconds),
        accuracy_time_s: None,
    });
    let mut octets = *Message::Location(sent).octets();
    // The codes are the same as in F3411.
    octets[19] = vertical << 4 | horizontal & 0xf;
    octets[20] = pressure << 4 | speed_accuracy & 0xf;
    octets[23] = time_accuracy & 0xf;
    Ok(octets)
}

fn system(contents: &MavlinkPayload) -> Message {
    let [location_type, classification, category, class] = contents.at(50);
    let place = [0, 4].map(|at| contents.i32(at));
    Message::System(System::new(&SystemContent {
        location_type,
        classification,
        operator_deg: Some(place.map(|count| f64::from(count) * 1e-7)),
        area_count: contents.u16(24),
        area_radius_m: f64::from(contents.u16(26)),
        area_ceiling_m: metres(contents, 8),
        area_floor_m: metres(contents, 12),
        category_and_class: [category, class],
        operator_altitude_m: metres(contents, 16),
        time_s: u32::from_le_bytes(contents.at(20)),
    }))
}

fn operator_id(contents: &MavlinkPayload) -> [u8; LENGTH] {
    let mut octets = [0; LENGTH];
    octets[0] = 0x52;
    octets[1..22].copy_from_slice(&contents.at::<21>(22));
    octets
}

fn pack(contents: &MavlinkPayload) -> Result<Vec<u8>, MavlinkDropReason> {
    let [size, count] = contents.at(22);
    if usize::from(size) != LENGTH || !(1..=PACK_MOST).contains(&count) {
        return Err(MavlinkDropReason::OutOfRange);
    }
    let messages = contents.at::<{ LENGTH * PACK_MOST as usize }>(24);
    Ok([&[0xf2, size, count][..], &messages[..LENGTH * usize::from(count)]].concat())
}
