//! From a frame off the air to the advertisements in it: Wi-Fi beacon and NAN (IEEE 802.11, Wi-Fi Aware), Bluetooth legacy and
//! extended advertising (Core 5.4, volume 6 part B), and the events in which a Bluetooth controller reports advertising.

mod bluetooth;
mod chain;
mod wifi;

use std::borrow::Cow;

pub use self::chain::Listener;
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
    /// Bluetooth Low Energy from the access address to the checksum (link type 251).
    LeLinkLayer,
    /// The same behind a header of 10 octets about the radio (link type 256).
    LeRadio,
    /// Bluetooth HCI packets with their indicator (link type 187).
    Hci,
    /// The same behind a direction of 4 octets (link type 201).
    HciDirection,
    /// Packets of the Linux Bluetooth monitor (link type 254).
    HciMonitor,
}

impl Link {
    /// All of them.
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

/// What a drone was heard by.
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

/// One time that a drone was heard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Advertisement<'a> {
    /// What by.
    pub transport: Transport,
    /// The transmitter's address.
    pub transmitter: [u8; 6],
    /// Counts what it sends; goes round. 0 in a French beacon, which has no counter.
    pub counter: u8,
    /// A message or a pack, for [`messages`](crate::messages); more may stand behind it. Owned where it was sent in parts.
    pub octets: Cow<'a, [u8]>,
}

/// The advertisements of a frame alone, at least one: a frame may carry several elements or reports. [`Listener`] puts together
/// what comes in several frames.
///
/// # Errors
/// The frame carries none, or the radio garbled it.
pub fn advertisements(link: Link, frame: &[u8]) -> Result<Vec<Advertisement<'_>>, NotHeard> {
    match link {
        Link::Radiotap => wifi::frame(wifi::behind_radiotap(frame)?),
        Link::Ieee80211 => wifi::frame(frame),
        _ => bluetooth::advertisements(link, frame),
    }
}

/// The advertisements found; without one the frame is cut or carries none.
fn at_least_one<'a>(found: Vec<Advertisement<'a>>, is_cut: bool) -> Result<Vec<Advertisement<'a>>, NotHeard> {
    match (found.is_empty(), is_cut) {
        (false, _) => Ok(found),
        (true, true) => Err(NotHeard::Cut),
        (true, false) => Err(NotHeard::Other),
    }
}
