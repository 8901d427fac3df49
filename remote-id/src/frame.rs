//! Advertisements in radio frames: Wi-Fi beacons and NAN (IEEE 802.11, Wi-Fi Aware), Bluetooth legacy and extended advertising
//! (Core 5.4, volume 6 part B), and HCI events in which a Bluetooth controller reports advertising.

mod bluetooth;
mod chain;
mod wifi;

use std::borrow::Cow;

pub use self::chain::Listener;
use super::NotHeard;

/// Link type of a capture file: the header before each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// 802.11 with a radiotap header (link type 127).
    Radiotap,
    /// 802.11 (link type 105).
    Ieee80211,
    /// Bluetooth Low Energy with the header of the nRF sniffer (link type 272).
    NordicBle,
    /// Bluetooth Low Energy from access address to checksum (link type 251).
    LeLinkLayer,
    /// Bluetooth Low Energy from access address to checksum, with a radio header of 10 octets (link type 256).
    LeRadio,
    /// Bluetooth HCI packets with their packet indicator (link type 187).
    Hci,
    /// Bluetooth HCI packets with a direction of 4 octets and their packet indicator (link type 201).
    HciDirection,
    /// Packets of the Linux Bluetooth monitor (link type 254).
    HciMonitor,
}

impl Link {
    /// All link types.
    pub const ALL: [Self; 8] = [
        Self::Radiotap,
        Self::Ieee80211,
        Self::NordicBle,
        Self::LeLinkLayer,
        Self::LeRadio,
        Self::Hci,
        Self::HciDirection,
        Self::HciMonitor,
    ];
}

/// Transport of an advertisement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// A Wi-Fi beacon.
    WifiBeacon,
    /// A Wi-Fi beacon with the French electronic identification, for [`French`](crate::French).
    WifiFrench,
    /// A Wi-Fi Aware service discovery frame.
    WifiNan,
    /// Bluetooth advertising.
    Bluetooth,
}

/// A received advertisement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Advertisement<'a> {
    /// Transport.
    pub transport: Transport,
    /// Address of the transmitter.
    pub transmitter: [u8; 6],
    /// Counter of the sender, modulo 256; 0 in a French beacon, which has no counter.
    pub counter: u8,
    /// A message or a pack, for [`messages`](crate::messages), possibly with trailing octets. Owned if it was sent in parts.
    pub octets: Cow<'a, [u8]>,
}

/// The advertisements of a single frame, at least one: a frame may carry several elements or reports. [`Listener`] reassembles
/// advertisements from several frames.
///
/// # Errors
/// The frame carries no advertisement, or is damaged.
pub fn advertisements(link: Link, frame: &[u8]) -> Result<Vec<Advertisement<'_>>, NotHeard> {
    match link {
        Link::Radiotap => wifi::frame(wifi::behind_radiotap(frame)?),
        Link::Ieee80211 => wifi::frame(frame),
        _ => bluetooth::advertisements(link, frame),
    }
}

/// The advertisements found; if there are none, the error that the frame is cut or carries none.
fn at_least_one<'a>(found: Vec<Advertisement<'a>>, is_cut: bool) -> Result<Vec<Advertisement<'a>>, NotHeard> {
    match (found.is_empty(), is_cut) {
        (false, _) => Ok(found),
        (true, true) => Err(NotHeard::Cut),
        (true, false) => Err(NotHeard::Other),
    }
}
