//! Bluetooth Low Energy: advertising as captured by a sniffer, and as reported by a controller to its host.

use std::borrow::Cow;

use super::{Advertisement, Link, NotHeard, Transport, at_least_one};

/// Service data with UUID 0xFFFA (ASTM) and the application code of Remote ID.
const SERVICE: [u8; 3] = [0xfa, 0xff, 0x0d];
/// Type of an advertising structure: service data with a 16-bit UUID.
const SERVICE_DATA: u8 = 0x16;
/// Access address of advertising channels.
const ADVERTISING: [u8; 4] = [0xd6, 0xbe, 0x89, 0x8e];
const ADDRESS: usize = 6;
const CHECKSUM: usize = 3;
/// Lengths of further fields of an extended header, in octets.
const CTE_INFO: usize = 1;
const ADI: usize = 2;
const AUX_POINTER: usize = 3;

/// Length of the headers of the capture program and the radio before the access address; the flags are in the latter.
const NORDIC_HEADER: usize = 17;
const NORDIC_FLAGS: usize = 8;
/// Bits of the nRF flags.
const NORDIC_CHECKSUM_GOOD: u8 = 1;
const NORDIC_PHY: u8 = 0b0111_0000;
const NORDIC_CODED: u8 = 2 << 4;

/// Length of the header of link type 256: channel, signal, noise, offenses, reference access address, flags.
const RADIO_HEADER: usize = 10;
const RADIO_FLAGS: usize = 8;
/// Bits of the flags of link type 256.
const RADIO_CHECKSUM_CHECKED: u16 = 0x0400;
const RADIO_CHECKSUM_VALID: u16 = 0x0800;
const RADIO_PHY: u16 = 0xc000;
const RADIO_CODED: u16 = 0x8000;

/// Advertising types ADV_IND, ADV_NONCONN_IND, SCAN_RSP, ADV_SCAN_IND; and the extended type.
const LEGACY: [u8; 4] = [0, 2, 4, 6];
const EXTENDED: u8 = 7;

/// Advertising data, complete or in part.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    /// Address of the advertiser; `None` in a packet that continues others.
    pub(super) address: Option<[u8; ADDRESS]>,
    /// Identifier that distinguishes the advertising data from others.
    pub(super) set: Option<u16>,
    /// Whether a further packet or report continues the data.
    pub(super) has_more: bool,
    /// Whether the data may continue a part with the same address.
    pub(super) may_continue: bool,
    pub(super) data: &'a [u8],
}

/// The parts of a frame, and whether it is cut; `None` if the link is not Bluetooth.
pub(super) fn parts(link: Link, frame: &[u8]) -> Result<Option<(Vec<Part<'_>>, bool)>, NotHeard> {
    let one = |part| (vec![part], false);
    Ok(Some(match link {
        Link::Radiotap | Link::Ieee80211 => return Ok(None),
        Link::NordicBle => one(nordic(frame)?),
        Link::LeLinkLayer => one(link_layer(frame)?),
        Link::LeRadio => one(radio(frame)?),
        Link::Hci => hci(frame)?,
        Link::HciDirection => hci(frame.get(4..).ok_or(NotHeard::Cut)?)?,
        Link::HciMonitor => monitor(frame)?,
    }))
}

/// The advertisements of a single frame.
pub(super) fn advertisements(link: Link, frame: &[u8]) -> Result<Vec<Advertisement<'_>>, NotHeard> {
    let (parts, is_cut) = parts(link, frame)?.ok_or(NotHeard::Other)?;
    let mut found = Vec::new();
    for Part { address, data, .. } in parts {
        if let Some(address) = address {
            service_data(&mut found, address, data);
        }
    }
    at_least_one(found, is_cut)
}

/// Decodes a packet of the nRF sniffer.
fn nordic(frame: &[u8]) -> Result<Part<'_>, NotHeard> {
    let flags = *frame.get(NORDIC_FLAGS).ok_or(NotHeard::Cut)?;
    if flags & NORDIC_CHECKSUM_GOOD == 0 {
        return Err(NotHeard::Damaged);
    }
    let (_, packet) = advertising(frame, NORDIC_HEADER, flags & NORDIC_PHY == NORDIC_CODED)?;
    one(packet)
}

/// Decodes a packet from its access address to its checksum.
fn link_layer(frame: &[u8]) -> Result<Part<'_>, NotHeard> {
    let (whole, packet) = advertising(frame, 0, false)?;
    checked(whole)?;
    one(packet)
}

/// Decodes a packet with a radio header.
fn radio(frame: &[u8]) -> Result<Part<'_>, NotHeard> {
    let flags = frame.get(RADIO_FLAGS..RADIO_HEADER).ok_or(NotHeard::Cut)?;
    let flags = u16::from_le_bytes([flags[0], flags[1]]);
    let (whole, packet) = advertising(frame, RADIO_HEADER, flags & RADIO_PHY == RADIO_CODED)?;
    match (flags & RADIO_CHECKSUM_CHECKED != 0, flags & RADIO_CHECKSUM_VALID != 0) {
        (true, true) => {}
        (true, false) => return Err(NotHeard::Damaged),
        (false, _) => checked(whole)?,
    }
    one(packet)
}

/// The advertising packet whose access address begins at `start`, with and without its checksum.
fn advertising(frame: &[u8], start: usize, is_coded: bool) -> Result<(&[u8], &[u8]), NotHeard> {
    let access = frame.get(start..).ok_or(NotHeard::Cut)?;
    let (address, behind) = access.split_first_chunk::<4>().ok_or(NotHeard::Cut)?;
    if *address != ADVERTISING {
        return Err(NotHeard::Other);
    }
    // On the coded PHY an octet with the coding indicator follows.
    let packet = behind.get(usize::from(is_coded)..).ok_or(NotHeard::Cut)?;
    let [_, length, body @ ..] = packet else { return Err(NotHeard::Cut) };
    let length = usize::from(*length);
    if body.len() < length {
        return Err(NotHeard::Cut);
    }
    Ok((&packet[..(2 + length + CHECKSUM).min(packet.len())], &packet[..2 + length]))
}

/// Verifies the checksum of an advertising packet (Core 5.4, volume 6 part B, section 3.1.1).
fn checked(packet: &[u8]) -> Result<(), NotHeard> {
    let (octets, sent) = packet.split_last_chunk::<CHECKSUM>().ok_or(NotHeard::Cut)?;
    let length = octets.get(1).ok_or(NotHeard::Cut)?;
    if octets.len() != 2 + usize::from(*length) {
        return Err(NotHeard::Cut);
    }
    // Shift register of 24 bits, the oldest bit lowest, with the initial value 0x555555.
    let mut register: u32 = 0xaa_aaaa;
    for octet in octets {
        for bit in 0..8 {
            let feedback = (register ^ u32::from(octet >> bit)) & 1;
            register >>= 1;
            if feedback == 1 {
                register ^= 0xda_6000;
            }
        }
    }
    let sent = u32::from_le_bytes([sent[0], sent[1], sent[2], 0]);
    if register == sent { Ok(()) } else { Err(NotHeard::Damaged) }
}

/// The advertising data of a packet, which begins with its header and has no checksum.
fn one(packet: &[u8]) -> Result<Part<'_>, NotHeard> {
    let [kind, _, body @ ..] = packet else { return Err(NotHeard::Cut) };
    let kind = kind & 0xf;
    if LEGACY.contains(&kind) {
        let (address, data) = body.split_first_chunk().ok_or(NotHeard::Cut)?;
        let address = Some(backwards(*address));
        return Ok(Part { address, set: None, has_more: false, may_continue: false, data });
    }
    if kind != EXTENDED {
        return Err(NotHeard::Other);
    }
    let [header_length, rest @ ..] = body else { return Err(NotHeard::Cut) };
    let length = usize::from(header_length & 0x3f);
    let (header, data) = rest.split_at_checked(length).ok_or(NotHeard::Cut)?;
    let [fields, header @ ..] = header else { return Err(NotHeard::Other) };
    // The flags state which fields are present, in this order.
    let mut rest = header;
    let mut field = |flag: u8, octets: usize| {
        if fields & flag == 0 {
            return Ok(None);
        }
        let (field, behind) = rest.split_at_checked(octets).ok_or(NotHeard::Cut)?;
        rest = behind;
        Ok(Some(field))
    };
    let address = field(1, ADDRESS)?.and_then(|address| address.try_into().ok()).map(backwards);
    field(1 << 1, ADDRESS)?;
    field(1 << 2, CTE_INFO)?;
    let set = field(1 << 3, ADI)?.and_then(|adi| adi.try_into().ok()).map(u16::from_le_bytes);
    let has_more = field(1 << 4, AUX_POINTER)?.is_some();
    // Without address and set the advertiser is unknown.
    if address.is_none() && set.is_none() {
        return Err(NotHeard::Other);
    }
    Ok(Part { address, set, has_more, may_continue: false, data })
}

fn backwards(mut address: [u8; ADDRESS]) -> [u8; ADDRESS] {
    address.reverse();
    address
}

/// Adds the advertisements in advertising data. A structure continued in a further packet is used as far as it is present.
pub(super) fn service_data<'a>(
    found: &mut Vec<Advertisement<'a>>,
    transmitter: [u8; ADDRESS],
    data: &'a [u8],
) {
    found.extend(remote_ids(data).map(|(counter, octets)| {
        let (transport, octets) = (Transport::Bluetooth, Cow::Borrowed(octets));
        Advertisement { transport, transmitter, counter, octets }
    }));
}

/// Counter and octets of the first Remote ID structure in advertising data.
pub(super) fn remote_id_of(data: &[u8]) -> Option<(u8, &[u8])> {
    remote_ids(data).next()
}

/// Counter and octets of each Remote ID structure in advertising data. A structure has length, type and contents.
fn remote_ids(mut structures: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    std::iter::from_fn(move || {
        while let &[length, ref rest @ ..] = structures
            && length > 0
        {
            let (contents, behind) = rest.split_at(usize::from(length).min(rest.len()));
            structures = behind;
            if let [SERVICE_DATA, data @ ..] = contents
                && let Some([counter, octets @ ..]) = data.strip_prefix(&SERVICE)
            {
                return Some((*counter, octets));
            }
        }
        None
    })
}

/// Packet indicator of an HCI event.
const EVENT: u8 = 4;
/// Opcode of an event in the Linux monitor.
const MONITOR_EVENT: u16 = 3;
/// Event code of Low Energy events, and the subevents that report advertising.
const LE_META: u8 = 0x3e;
const REPORT: u8 = 0x02;
const EXTENDED_REPORT: u8 = 0x0d;

/// Extended reports: bits of the event type for complete and for continued data, and the position of the set.
const DATA_STATUS: u8 = 0b110_0000;
const GOES_ON: u8 = 0b010_0000;
const SET: usize = 11;

/// Decodes a packet of the Linux monitor: adapter, opcode, then the contents for that opcode.
fn monitor(frame: &[u8]) -> Result<(Vec<Part<'_>>, bool), NotHeard> {
    let [_, _, high, low, packet @ ..] = frame else { return Err(NotHeard::Cut) };
    if u16::from_be_bytes([*high, *low]) == MONITOR_EVENT { event(packet) } else { Err(NotHeard::Other) }
}

/// Decodes an HCI packet with its packet indicator.
fn hci(packet: &[u8]) -> Result<(Vec<Part<'_>>, bool), NotHeard> {
    match packet {
        [EVENT, event_packet @ ..] => event(event_packet),
        [] => Err(NotHeard::Cut),
        _ => Err(NotHeard::Other),
    }
}

/// The parts of an event, and whether it is cut. An event has a code and a length; an LE event then has a subevent code and the
/// number of reports.
fn event(packet: &[u8]) -> Result<(Vec<Part<'_>>, bool), NotHeard> {
    let [code, length, parameters @ ..] = packet else { return Err(NotHeard::Cut) };
    if *code != LE_META {
        return Err(NotHeard::Other);
    }
    let parameters = parameters.get(..usize::from(*length)).ok_or(NotHeard::Cut)?;
    let [about, count, reports @ ..] = parameters else { return Err(NotHeard::Other) };
    let mut reports = reports;
    // Number of octets before the address, before the length of the data, and after the data.
    let (before, to_length, after) = match *about {
        REPORT => (2, 8, 1),
        EXTENDED_REPORT => (3, 23, 0),
        _ => return Err(NotHeard::Other),
    };
    let mut found = Vec::new();
    let mut is_cut = false;
    for _ in 0..*count {
        let data = reports.get(to_length).and_then(|&length| {
            let end = to_length + 1 + usize::from(length);
            Some((reports.get(to_length + 1..end)?, reports.get(end + after..)?))
        });
        let Some((data, behind)) = data else {
            is_cut = true;
            break;
        };
        let address = reports[before..].first_chunk().map(|address| backwards(*address));
        let is_extended = *about == EXTENDED_REPORT;
        found.push(Part {
            address,
            set: is_extended.then(|| reports[SET].into()),
            has_more: is_extended && reports[0] & DATA_STATUS == GOES_ON,
            may_continue: is_extended,
            data,
        });
        reports = behind;
    }
    Ok((found, is_cut))
}
