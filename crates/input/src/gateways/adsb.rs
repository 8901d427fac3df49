//! Translates the frames of a 1090 MHz receiver (Beast or AVR) to CAT021, edition 2.6. Each received position becomes a
//! record in its own datagram, with the data that the aircraft has sent by then.
//!
//! | I021 | from |
//! |---|---|
//! | 040 | downlink format 17, 18 (ADS-B), 18 (ADS-R, as it was sent first); GBS of positions on the ground |
//! | 073, 075 | reception of the position, of the velocity |
//! | 131 | a pair of frames, even and odd, at most 10 s apart (on the ground 25 s); or one frame near a place at most 60 s old |
//! | 145, 140 | altitude as sent, and with the difference sent with the velocity |
//! | 155 or 157, 160 | velocity at most 10 s old |
//! | 090, 210 | type code, operational status, target state |
//! | 020, 170 | identification, while the aircraft is received |
//! | 070, 200 | status at most 60 s old |

mod aircraft;
mod cpr;
mod frames;
mod squitter;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, VecDeque};

use asterix::{DataSource, encode_block};
use fusion::time::{SECOND, Time};

use self::aircraft::{AdsbAircraft, Unplaced};
pub use self::cpr::LatLonDeg;
pub(crate) use self::frames::BODY_MOST;
pub use self::frames::{
    AdsbFrame, Deframer, ModeSMessage, ReceiverFraming, ReceiverId, STAMP_HZ, StreamPart,
};
use self::squitter::{NotAdsb, Squitter, SquitterContents};
use super::DropCounts;

/// Maximum number of aircraft; a further one replaces the one not received for longest.
pub const AIRCRAFT_MOST: usize = 4096;
/// Time without reception after which an aircraft is dropped, in nanoseconds.
pub const FORGOTTEN_NS: i64 = 300 * SECOND;
/// Number of frames among which a copy is recognised by stamp and octets.
const COPIES: usize = 256;

/// Reason for dropping a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdsbDropReason {
    /// `cut`: another frame began, or the stream ended, before this one did.
    Cut,
    /// `malformed`: of an unknown kind, with a wrong length or invalid characters.
    Malformed,
    /// `mode_ac`: a reply in Mode A or C.
    ModeAc,
    /// `receiver_status`: state or position of the receiver.
    Receiver,
    /// `receiver_id`: the identity of the receiver.
    ReceiverId,
    /// `mode_s_reply`: a reply to an interrogator, or another message that is not an aircraft's squitter.
    ModeS,
    /// `copy`: equal stamp and octets as a frame shortly before, or a position already received from another receiver.
    Copy,
    /// `damaged`: wrong parity.
    Damaged,
    /// `tis_b`: a report of a ground station from its radar.
    TisB,
    /// `unused_squitter`: of a kind that is not needed for any item.
    Unused,
    /// `no_pair`: a position without a frame of the other parity or a place nearby.
    Alone,
    /// `implausible`: impossible speed from the last place, or out of the receiver's range.
    Implausible,
    /// `out_of_range`: an item cannot represent a value.
    OutOfRange,
}

/// Result of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FrameResult {
    /// Translated to a datagram.
    Translated(Vec<u8>),
    /// Stored for the aircraft's next positions.
    Noted,
    /// Dropped.
    Dropped(AdsbDropReason),
}

pub(super) const REASONS: [&str; 13] = [
    "cut",
    "malformed",
    "mode_ac",
    "receiver_status",
    "receiver_id",
    "mode_s_reply",
    "copy",
    "damaged",
    "tis_b",
    "unused_squitter",
    "no_pair",
    "implausible",
    "out_of_range",
];

/// Counts of a translator. Every frame is translated, noted or dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdsbCounts {
    /// Frames, complete or not.
    pub frames: u64,
    /// Octets outside of frames.
    pub outside: u64,
    /// Positions translated to records.
    pub translated: u64,
    /// Squitters stored for the aircraft's next positions.
    pub noted: u64,
    /// Frames dropped, by [`AdsbDropReason`].
    pub dropped: DropCounts<13>,
    /// Aircraft dropped because the maximum number was reached.
    pub displaced: u64,
}

impl Default for AdsbCounts {
    fn default() -> Self {
        Self {
            frames: 0,
            outside: 0,
            translated: 0,
            noted: 0,
            dropped: DropCounts::new(&REASONS),
            displaced: 0,
        }
    }
}

/// Translates the stream of one receiver.
#[derive(Clone, Debug)]
pub struct AdsbTranslator {
    source: DataSource,
    receiver: Option<LatLonDeg>,
    deframer: Deframer,
    aircraft: BTreeMap<u32, AdsbAircraft>,
    copies: VecDeque<(u64, ModeSMessage)>,
    counts: AdsbCounts,
}

impl AdsbTranslator {
    /// Translator for a receiver at `receiver` (latitude and longitude in degrees, if known; needed for positions on the
    /// ground). The records have the sensor's SAC and SIC.
    pub fn new(framing: ReceiverFraming, source: DataSource, receiver: Option<LatLonDeg>) -> Self {
        Self {
            source,
            receiver,
            deframer: Deframer::new(framing),
            aircraft: BTreeMap::new(),
            copies: VecDeque::with_capacity(COPIES),
            counts: AdsbCounts::default(),
        }
    }

    /// Counts so far.
    pub fn counts(&self) -> AdsbCounts {
        AdsbCounts { outside: self.deframer.outside(), ..self.counts.clone() }
    }

    /// Takes octets of the stream, with their time of reception. Datagrams are passed to `out`.
    pub fn take(&mut self, octets: &[u8], received: Time, mut out: impl FnMut(Vec<u8>)) {
        for octet in octets {
            if let Some(FrameResult::Translated(datagram)) = self.take_octet(*octet, |_| received) {
                out(datagram);
            }
        }
    }

    /// Takes an octet; `received` returns the time of reception of a frame that it ends.
    pub fn take_octet(
        &mut self,
        octet: u8,
        received: impl FnOnce(&AdsbFrame) -> Time,
    ) -> Option<FrameResult> {
        let piece = self.deframer.take(octet)?;
        self.counts.frames += 1;
        let step = match piece {
            StreamPart::Cut => FrameResult::Dropped(AdsbDropReason::Cut),
            StreamPart::Malformed => FrameResult::Dropped(AdsbDropReason::Malformed),
            StreamPart::Frame(frame) => {
                let received = received(&frame);
                self.frame(&frame, received).unwrap_or_else(FrameResult::Dropped)
            }
        };
        match &step {
            FrameResult::Translated(_) => self.counts.translated += 1,
            FrameResult::Noted => self.counts.noted += 1,
            FrameResult::Dropped(reason) => self.counts.dropped.add(*reason as usize),
        }
        Some(step)
    }

    /// Number of octets so far that belong to no frame.
    pub fn outside(&self) -> u64 {
        self.deframer.outside()
    }

    /// Whether a frame has begun and not ended.
    pub fn is_within(&self) -> bool {
        self.deframer.is_within()
    }

    /// Ends the stream, so that the next one starts again. Returns whether that cut a frame, which is counted.
    pub fn end(&mut self) -> bool {
        let cuts = self.deframer.is_within();
        if cuts {
            self.counts.frames += 1;
            self.counts.dropped.add(AdsbDropReason::Cut as usize);
        }
        self.deframer.restart();
        cuts
    }

    fn frame(&mut self, frame: &AdsbFrame, received: Time) -> Result<FrameResult, AdsbDropReason> {
        if self.is_copy(frame) {
            return Err(AdsbDropReason::Copy);
        }
        let message = match &frame.message {
            ModeSMessage::ModeAc => return Err(AdsbDropReason::ModeAc),
            ModeSMessage::Status(_) | ModeSMessage::ReceiverPlace => return Err(AdsbDropReason::Receiver),
            ModeSMessage::ReceiverId(_) => return Err(AdsbDropReason::ReceiverId),
            ModeSMessage::Short(_) => return Err(AdsbDropReason::ModeS),
            ModeSMessage::Long(message) => message,
        };
        let squitter = Squitter::new(message).map_err(|reason| match reason {
            NotAdsb::Damaged => AdsbDropReason::Damaged,
            NotAdsb::TisB => AdsbDropReason::TisB,
            NotAdsb::Other => AdsbDropReason::ModeS,
        })?;
        if squitter.contents == SquitterContents::Other {
            return Err(AdsbDropReason::Unused);
        }
        let (source, receiver) = (self.source, self.receiver);
        let aircraft = self.aircraft(squitter.address, received);
        let SquitterContents::Position(position) = &squitter.contents else {
            aircraft.note(&squitter.contents, received);
            return Ok(FrameResult::Noted);
        };
        let place = aircraft.place(position, received, receiver).map_err(|reason| match reason {
            Unplaced::Copy => AdsbDropReason::Copy,
            Unplaced::Alone => AdsbDropReason::Alone,
            Unplaced::Implausible => AdsbDropReason::Implausible,
        })?;
        let record = aircraft
            .record(source, &squitter, position, place, received)
            .map_err(|_| AdsbDropReason::OutOfRange)?;
        let mut datagram = Vec::new();
        encode_block(&[record], &mut datagram).map_err(|_| AdsbDropReason::OutOfRange)?;
        Ok(FrameResult::Translated(datagram))
    }

    /// Whether a frame with the same stamp and octets was received already, as it happens if two outputs of a receiver are
    /// merged.
    fn is_copy(&mut self, frame: &AdsbFrame) -> bool {
        let Some(stamp) = frame.stamp else { return false };
        let seen = (stamp, frame.message);
        if self.copies.contains(&seen) {
            return true;
        }
        if self.copies.len() == COPIES {
            self.copies.pop_front();
        }
        self.copies.push_back(seen);
        false
    }

    /// The aircraft with an address, received now.
    fn aircraft(&mut self, address: u32, now: Time) -> &mut AdsbAircraft {
        if !self.aircraft.contains_key(&address) && self.aircraft.len() == AIRCRAFT_MOST {
            let before = self.aircraft.len();
            self.aircraft
                .retain(|_, aircraft| now.nanos().saturating_sub(aircraft.heard.nanos()) <= FORGOTTEN_NS);
            if self.aircraft.len() == before {
                let longest = self.aircraft.iter().min_by_key(|(_, aircraft)| aircraft.heard);
                if let Some(address) = longest.map(|(address, _)| *address) {
                    self.aircraft.remove(&address);
                    self.counts.displaced += 1;
                }
            }
        }
        let aircraft = self.aircraft.entry(address).or_insert_with(|| AdsbAircraft::new(now));
        if now.nanos().saturating_sub(aircraft.heard.nanos()) > FORGOTTEN_NS {
            *aircraft = AdsbAircraft::new(now);
        }
        aircraft.heard = aircraft.heard.max(now);
        aircraft
    }
}
