//! Wi-Fi: beacons, probe responses and NAN service discovery frames.

use std::borrow::Cow;

use super::{Advertisement, NotHeard, Transport, at_least_one};
use crate::message::{is_pack_header, missing};

/// Vendor (ASD-STAN) and type of the element.
const VENDOR: [u8; 4] = [0xfa, 0x0b, 0xbc, 0x0d];
/// Vendor and type of the element with the French electronic identification (decree of 27 December 2019).
const FRENCH: [u8; 4] = [0x6a, 0x5c, 0x35, 0x01];
/// Service of Wi-Fi Aware: the first octets of the hash of its name.
const NAN_SERVICE: [u8; 6] = [0x88, 0x69, 0x19, 0x9d, 0x92, 0x09];
/// Action frames of Wi-Fi Aware: public, vendor specific, Wi-Fi Alliance, type 0x13.
const NAN_ACTION: [u8; 6] = [0x04, 0x09, 0x50, 0x6f, 0x9a, 0x13];
/// Number of the attribute that describes a service.
const SERVICE_DESCRIPTOR: u8 = 0x03;

/// Radiotap flag: the checksum after the frame is wrong.
const BAD_CHECKSUM: u8 = 0x40;
/// Radiotap flag: a checksum follows the frame.
const HAS_CHECKSUM: u8 = 0x10;

/// Frame control, first octet: management frames of protocol version 0.
const PROBE_RESPONSE: u8 = 0x50;
const BEACON: u8 = 0x80;
const ACTION: u8 = 0xd0;
/// Frame control, second octet: the body is encrypted.
const PROTECTED: u8 = 0x40;
/// Frame control, second octet: an HT control field of 4 octets follows the header (802.11 section 9.2.4.6).
const ORDER: u8 = 0x80;
const HEADER: usize = 24;
const HT_CONTROL: usize = 4;

/// Element numbers: vendor specific, and fragment of a long element.
const VENDOR_SPECIFIC: u8 = 221;
const FRAGMENT: u8 = 242;

/// The 802.11 frame after a radiotap header (radiotap.org), without its checksum.
pub(super) fn behind_radiotap(frame: &[u8]) -> Result<&[u8], NotHeard> {
    let [_, _, low, high, header @ ..] = frame else { return Err(NotHeard::Cut) };
    let length = usize::from(u16::from_le_bytes([*low, *high]));
    let present = u32::from_le_bytes(*header.first_chunk().ok_or(NotHeard::Cut)?);
    let body = frame.get(length..).ok_or(NotHeard::Cut)?;
    // Bit 31 of each word of present fields states whether another word follows.
    let mut words = 1;
    while present_word(frame, words).is_some_and(|word| word >> 31 == 1) {
        words += 1;
    }
    if present & 0b10 == 0 {
        return Ok(body);
    }
    // The time stamp, 8 octets aligned to 8, precedes the flags.
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

/// The advertisements of a frame that begins with its frame control.
pub(super) fn frame(frame: &[u8]) -> Result<Vec<Advertisement<'_>>, NotHeard> {
    let [kind, flags, ..] = *frame else { return Err(NotHeard::Cut) };
    if !matches!(kind, PROBE_RESPONSE | BEACON | ACTION) || flags & PROTECTED != 0 {
        return Err(NotHeard::Other);
    }
    let (header, body) = frame.split_at_checked(HEADER).ok_or(NotHeard::Cut)?;
    let transmitter = *header[10..].first_chunk().expect("24 octets");
    let read = |body| if kind == ACTION { services(transmitter, body) } else { elements(transmitter, body) };
    if flags & ORDER != 0
        && let Some(behind) = body.get(HT_CONTROL..)
        && let Ok(found) = read(behind)
    {
        return Ok(found);
    }
    // Senders without high throughput use the bit for another purpose.
    read(body)
}

/// The advertisements in the elements of a beacon or probe response.
fn elements(transmitter: [u8; 6], body: &[u8]) -> Result<Vec<Advertisement<'_>>, NotHeard> {
    // Time stamp, interval and capabilities precede the elements.
    let mut rest = body.get(12..).ok_or(NotHeard::Cut)?;
    let mut found: Vec<Advertisement<'_>> = Vec::new();
    let mut is_cut = false;
    while let [number, length, behind @ ..] = rest {
        let Some((contents, behind)) = behind.split_at_checked(usize::from(*length)) else {
            is_cut = true;
            break;
        };
        let (contents, behind) = with_fragments(contents, behind);
        rest = behind;
        if *number != VENDOR_SPECIFIC {
            continue;
        }
        if contents.starts_with(&FRENCH) {
            let octets = without_first(contents, FRENCH.len());
            let transport = Transport::WifiFrench;
            found.push(Advertisement { transport, transmitter, counter: 0, octets });
        } else if contents.starts_with(&VENDOR) && contents.len() > VENDOR.len() {
            take_element(&mut found, transmitter, without_first(contents, VENDOR.len()));
        }
    }
    at_least_one(found, is_cut)
}

/// Adds an element with counter and octets: a new advertisement, or the end of the pack that the previous element began.
fn take_element<'a>(found: &mut Vec<Advertisement<'a>>, transmitter: [u8; 6], element: Cow<'a, [u8]>) {
    let begun = found.last_mut().filter(|last| last.transport == Transport::WifiBeacon);
    if let Some(begun) = begun
        && let Some(missing) = missing(&begun.octets)
        && !is_pack_header(&element[1..])
    {
        // Some senders repeat the counter, others do not.
        let end = if element.len() == missing { &element[..] } else { &element[1..] };
        if end.len() >= missing {
            begun.octets.to_mut().extend_from_slice(end);
            return;
        }
    }
    let counter = element[0];
    let transport = Transport::WifiBeacon;
    found.push(Advertisement { transport, transmitter, counter, octets: without_first(element, 1) });
}

/// An element joined with its fragment elements, and the rest after these.
fn with_fragments<'a>(contents: &'a [u8], mut rest: &'a [u8]) -> (Cow<'a, [u8]>, &'a [u8]) {
    let mut whole = Cow::Borrowed(contents);
    let mut last = contents.len();
    while let [FRAGMENT, length, behind @ ..] = rest
        && last == usize::from(u8::MAX)
        && let Some((part, behind)) = behind.split_at_checked(usize::from(*length))
    {
        whole.to_mut().extend_from_slice(part);
        (last, rest) = (part.len(), behind);
    }
    (whole, rest)
}

fn without_first(octets: Cow<'_, [u8]>, count: usize) -> Cow<'_, [u8]> {
    match octets {
        Cow::Borrowed(octets) => Cow::Borrowed(&octets[count..]),
        Cow::Owned(mut octets) => {
            octets.drain(..count);
            Cow::Owned(octets)
        }
    }
}

/// The advertisements in the service descriptors of an action frame. Each has number, length (two octets) and contents.
fn services(transmitter: [u8; 6], body: &[u8]) -> Result<Vec<Advertisement<'_>>, NotHeard> {
    let mut attributes = body.strip_prefix(&NAN_ACTION).ok_or(NotHeard::Other)?;
    let mut found = Vec::new();
    let mut is_cut = false;
    while let [number, low, high, rest @ ..] = attributes {
        let length = usize::from(u16::from_le_bytes([*low, *high]));
        let Some((contents, behind)) = rest.split_at_checked(length) else {
            is_cut = true;
            break;
        };
        if let (&SERVICE_DESCRIPTOR, Some(described)) = (number, contents.strip_prefix(&NAN_SERVICE)) {
            // Instance, requestor, control, and length of the rest.
            let info = match described {
                [_, _, _, length, info @ ..] => info.get(..usize::from(*length)),
                _ => None,
            };
            match info {
                Some([counter, octets @ ..]) => found.push(Advertisement {
                    transport: Transport::WifiNan,
                    transmitter,
                    counter: *counter,
                    octets: Cow::Borrowed(octets),
                }),
                _ => is_cut = true,
            }
        }
        attributes = behind;
    }
    at_least_one(found, is_cut)
}
