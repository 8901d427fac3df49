//! From a frame off the air to the advertisement in it: Wi-Fi beacon and NAN (IEEE 802.11, Wi-Fi Aware), Bluetooth extended
//! advertising (Core 5.4, volume 6 part B).

use super::NotHeard;

/// What stands in front of a frame in a capture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// 802.11 behind a radiotap header (link type 127).
    Radiotap,
    /// 802.11 (link type 105).
    Ieee80211,
    /// Bluetooth Low Energy behind the header of the nRF sniffer (link type 272).
    NordicBle,
}

/// What a drone was heard by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// A Wi-Fi beacon.
    WifiBeacon,
    /// A Wi-Fi Aware service discovery frame.
    WifiNan,
    /// Bluetooth extended advertising.
    Bluetooth,
}

/// One time that a drone was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Advertisement<'a> {
    /// What by.
    pub transport: Transport,
    /// The transmitter's address.
    pub transmitter: [u8; 6],
    /// Counts what it sends; goes round.
    pub counter: u8,
    /// A message or a pack, for [`messages`](crate::messages); more may stand behind it.
    pub octets: &'a [u8],
}

/// The advertisement of a frame.
///
/// # Errors
/// The frame carries none, or the radio garbled it.
pub fn advertisement(link: Link, frame: &[u8]) -> Result<Advertisement<'_>, NotHeard> {
    match link {
        Link::Radiotap => wifi(behind_radiotap(frame)?),
        Link::Ieee80211 => wifi(frame),
        Link::NordicBle => bluetooth(frame),
    }
}

/// Vendor of the element (ASD-STAN) and its type.
const VENDOR: [u8; 4] = [0xfa, 0x0b, 0xbc, 0x0d];
/// Service of Wi-Fi Aware: the first octets of the hash of its name.
const NAN_SERVICE: [u8; 6] = [0x88, 0x69, 0x19, 0x9d, 0x92, 0x09];
/// Wi-Fi Aware's own action frames: public, vendor specific, of the Wi-Fi Alliance, type 0x13.
const NAN_ACTION: [u8; 6] = [0x04, 0x09, 0x50, 0x6f, 0x9a, 0x13];
/// Attribute of those in which a service is described.
const SERVICE_DESCRIPTOR: u8 = 0x03;
/// Service data of UUID 0xFFFA (ASTM), application code of Remote ID.
const BLUETOOTH_SERVICE: [u8; 3] = [0xfa, 0xff, 0x0d];

/// A bit set in the flags of radiotap: the checksum behind the frame failed.
const BAD_CHECKSUM: u8 = 0x40;
/// The same: there is a checksum behind the frame.
const HAS_CHECKSUM: u8 = 0x10;

/// The 802.11 frame behind a radiotap header (radiotap.org), without the checksum behind it.
fn behind_radiotap(frame: &[u8]) -> Result<&[u8], NotHeard> {
    let [_, _, low, high, header @ ..] = frame else { return Err(NotHeard::Cut) };
    let length = usize::from(u16::from_le_bytes([*low, *high]));
    let present = u32::from_le_bytes(*header.first_chunk().ok_or(NotHeard::Cut)?);
    let body = frame.get(length..).ok_or(NotHeard::Cut)?;
    // Further words of what is present follow while bit 31 says so.
    let mut words = 1;
    while present_word(frame, words).is_some_and(|word| word >> 31 == 1) {
        words += 1;
    }
    if present & 0b10 == 0 {
        return Ok(body);
    }
    // The time stamp, 8 octets aligned to 8, stands in front of the flags.
    let start = 4 + 4 * words;
    let flags_at = if present & 1 == 1 { start.next_multiple_of(8) + 8 } else { start };
    let flags = *frame.get(flags_at).filter(|_| flags_at < length).ok_or(NotHeard::Cut)?;
    if flags & BAD_CHECKSUM != 0 {
        return Err(NotHeard::Damaged);
    }
    let checksum = if flags & HAS_CHECKSUM == 0 { 0 } else { 4 };
    body.len().checked_sub(checksum).map(|length| &body[..length]).ok_or(NotHeard::Cut)
}

fn present_word(frame: &[u8], number: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*frame.get(4 * number..)?.first_chunk()?))
}

fn wifi(frame: &[u8]) -> Result<Advertisement<'_>, NotHeard> {
    let (header, body) = frame.split_at_checked(24).ok_or(NotHeard::Cut)?;
    let transmitter = *header[10..].first_chunk().expect("24 octets");
    // Type management, subtype beacon or action; the second octet holds flags.
    let (transport, (counter, octets)) = match header[0] {
        0x80 => {
            // Time stamp, interval, capabilities.
            let elements = body.get(12..).ok_or(NotHeard::Cut)?;
            (Transport::WifiBeacon, vendor_element(elements)?)
        }
        0xd0 => {
            let attributes = body.strip_prefix(&NAN_ACTION).ok_or(NotHeard::Other)?;
            (Transport::WifiNan, service_descriptor(attributes)?)
        }
        _ => return Err(NotHeard::Other),
    };
    Ok(Advertisement { transport, transmitter, counter, octets })
}

/// Counter and message of the vendor's element: number, length, contents each.
fn vendor_element(mut elements: &[u8]) -> Result<(u8, &[u8]), NotHeard> {
    while let [number, length, rest @ ..] = elements {
        let (contents, behind) = rest.split_at_checked(usize::from(*length)).ok_or(NotHeard::Cut)?;
        if let (221, Some([counter, octets @ ..])) = (number, contents.strip_prefix(&VENDOR)) {
            return Ok((*counter, octets));
        }
        elements = behind;
    }
    Err(NotHeard::Other)
}

/// The same of the attribute that describes the service: number, length (two octets), contents each.
fn service_descriptor(mut attributes: &[u8]) -> Result<(u8, &[u8]), NotHeard> {
    while let [number, low, high, rest @ ..] = attributes {
        let length = usize::from(u16::from_le_bytes([*low, *high]));
        let (contents, behind) = rest.split_at_checked(length).ok_or(NotHeard::Cut)?;
        if let (&SERVICE_DESCRIPTOR, Some(described)) = (number, contents.strip_prefix(&NAN_SERVICE)) {
            // Instance, requestor, control, length of what follows.
            let [_, _, _, length, info @ ..] = described else { return Err(NotHeard::Cut) };
            let [counter, octets @ ..] = info.get(..usize::from(*length)).ok_or(NotHeard::Cut)? else {
                return Err(NotHeard::Cut);
            };
            return Ok((*counter, octets));
        }
        attributes = behind;
    }
    Err(NotHeard::Other)
}

/// In front of the access address: of the capture program, then of the radio (its flags second).
const NORDIC_HEADER: usize = 17;
const NORDIC_FLAGS: usize = 8;
/// Bits of those flags.
const CHECKSUM_GOOD: u8 = 1;
const PHY: u8 = 0b0111_0000;
const CODED: u8 = 2 << 4;

/// Advertising of the extended kind: ADV_EXT_IND and what follows it.
const EXTENDED: u8 = 7;

fn bluetooth(frame: &[u8]) -> Result<Advertisement<'_>, NotHeard> {
    let flags = *frame.get(NORDIC_FLAGS).ok_or(NotHeard::Cut)?;
    if flags & CHECKSUM_GOOD == 0 {
        return Err(NotHeard::Damaged);
    }
    // Access address; on the coded radio an octet of its coding.
    let coding = usize::from(flags & PHY == CODED);
    let packet = frame.get(NORDIC_HEADER + 4 + coding..).ok_or(NotHeard::Cut)?;
    let [kind, length, rest @ ..] = packet else { return Err(NotHeard::Cut) };
    if kind & 0xf != EXTENDED {
        return Err(NotHeard::Other);
    }
    let body = rest.get(..usize::from(*length)).ok_or(NotHeard::Cut)?;
    let [header_length, rest @ ..] = body else { return Err(NotHeard::Cut) };
    let (header, data) = rest.split_at_checked(usize::from(header_length & 0x3f)).ok_or(NotHeard::Cut)?;
    let [fields, header @ ..] = header else { return Err(NotHeard::Other) };
    // The advertiser's address, where there is one, stands first, backwards.
    if fields & 1 == 0 {
        return Err(NotHeard::Other);
    }
    let mut transmitter: [u8; 6] = *header.first_chunk().ok_or(NotHeard::Cut)?;
    transmitter.reverse();
    let (counter, octets) = service_data(data)?;
    Ok(Advertisement { transport: Transport::Bluetooth, transmitter, counter, octets })
}

/// The same of the service data: length, kind, contents each.
fn service_data(mut structures: &[u8]) -> Result<(u8, &[u8]), NotHeard> {
    while let &[length, ref rest @ ..] = structures
        && length > 0
    {
        let (contents, behind) = rest.split_at_checked(usize::from(length)).ok_or(NotHeard::Cut)?;
        if let [0x16, data @ ..] = contents
            && let Some([counter, octets @ ..]) = data.strip_prefix(&BLUETOOTH_SERVICE)
        {
            return Ok((*counter, octets));
        }
        structures = behind;
    }
    Err(NotHeard::Other)
}
