//! From the frames of a 1090 MHz receiver (Beast or AVR) to CAT021, edition 2.6: a record for each position that is heard, with
//! what the aircraft has said of itself by then, in a datagram of its own.
//!
//! | I021 | from |
//! |---|---|
//! | 040 | downlink format 17, 18 (ADS-B), 18 (ADS-R, as it was sent first); GBS of positions on the ground |
//! | 073, 075 | reception of the position, of the velocity |
//! | 131 | a pair of frames, even and odd, at most 10 s apart (on the ground 25 s); else one, near a place at most 60 s old |
//! | 145, 140 | altitude as sent, and with the difference that came with the velocity |
//! | 155 or 157, 160 | velocity at most 10 s old |
//! | 090, 210 | type code, operational status, target state |
//! | 020, 170 | identification, while the aircraft is heard |
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

use self::aircraft::{Aircraft, Unplaced};
pub use self::cpr::Place;
pub(crate) use self::frames::BODY_MOST;
pub use self::frames::{Deframer, Frame, Framing, Message, Piece, ReceiverId, STAMP_HZ};
use self::squitter::{NotAdsb, Says, Squitter};
use super::Dropped;

/// Most aircraft that are known at a time; one more takes the place of the one not heard for longest.
pub const AIRCRAFT_MOST: usize = 4096;
/// An aircraft not heard for this long is forgotten.
pub const FORGOTTEN_NS: i64 = 300 * SECOND;
/// Frames back to which a copy of a frame is known by stamp and octets.
const COPIES: usize = 256;

/// Why a frame is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// `cut`: another frame began, or the stream ended, before it did.
    Cut,
    /// `malformed`: of a kind, a length or with characters that do not exist.
    Malformed,
    /// `mode_ac`: a reply in Mode A or C.
    ModeAc,
    /// `receiver_status`: the receiver's own state or position.
    Receiver,
    /// `receiver_id`: the identity of the receiver.
    ReceiverId,
    /// `mode_s_reply`: an answer to an interrogator, or what else is no squitter of an aircraft.
    ModeS,
    /// `copy`: stamp and octets of a frame shortly before, or a position that another receiver has brought.
    Copy,
    /// `damaged`: its parity does not fit.
    Damaged,
    /// `tis_b`: a ground station reports what its radar sees.
    TisB,
    /// `unused_squitter`: of a kind that no item needs.
    Unused,
    /// `no_pair`: a position without a frame of the other parity or a place nearby.
    Alone,
    /// `implausible`: nothing flies there from where it was, or is heard from there.
    Implausible,
    /// `out_of_range`: an item cannot hold a value.
    OutOfRange,
}

/// What became of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// A datagram.
    Translated(Vec<u8>),
    /// It goes with the aircraft's next positions.
    Noted,
    /// Nothing.
    Dropped(Reason),
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

/// What a translator has met. Every frame is translated, noted or dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Frames, whole or not.
    pub frames: u64,
    /// Octets in no frame.
    pub outside: u64,
    /// Positions that became records.
    pub translated: u64,
    /// Squitters whose contents go with the aircraft's next positions.
    pub noted: u64,
    /// Frames dropped, by [`Reason`].
    pub dropped: Dropped<13>,
    /// Aircraft forgotten to make room.
    pub displaced: u64,
}

impl Default for Counts {
    fn default() -> Self {
        Self { frames: 0, outside: 0, translated: 0, noted: 0, dropped: Dropped::new(&REASONS), displaced: 0 }
    }
}

/// Translates the stream of one receiver.
#[derive(Clone, Debug)]
pub struct Translator {
    source: DataSource,
    receiver: Option<Place>,
    deframer: Deframer,
    aircraft: BTreeMap<u32, Aircraft>,
    copies: VecDeque<(u64, Message)>,
    counts: Counts,
}

impl Translator {
    /// Of a receiver at `receiver` (latitude, longitude in degrees, where known: positions on the ground need it), whose records
    /// bear the sensor's SAC and SIC.
    pub fn new(framing: Framing, source: DataSource, receiver: Option<Place>) -> Self {
        Self {
            source,
            receiver,
            deframer: Deframer::new(framing),
            aircraft: BTreeMap::new(),
            copies: VecDeque::with_capacity(COPIES),
            counts: Counts::default(),
        }
    }

    /// What it has met so far.
    pub fn counts(&self) -> Counts {
        Counts { outside: self.deframer.outside(), ..self.counts.clone() }
    }

    /// Takes octets of the stream that were received at a time. Each datagram goes to `out`.
    pub fn take(&mut self, octets: &[u8], received: Time, mut out: impl FnMut(Vec<u8>)) {
        for octet in octets {
            if let Some(Step::Translated(datagram)) = self.take_octet(*octet, |_| received) {
                out(datagram);
            }
        }
    }

    /// Takes an octet; a frame that it ends was received at the time that `received` says of it.
    pub fn take_octet(&mut self, octet: u8, received: impl FnOnce(&Frame) -> Time) -> Option<Step> {
        let piece = self.deframer.take(octet)?;
        self.counts.frames += 1;
        let step = match piece {
            Piece::Cut => Step::Dropped(Reason::Cut),
            Piece::Malformed => Step::Dropped(Reason::Malformed),
            Piece::Frame(frame) => {
                let received = received(&frame);
                self.frame(&frame, received).unwrap_or_else(Step::Dropped)
            }
        };
        match &step {
            Step::Translated(_) => self.counts.translated += 1,
            Step::Noted => self.counts.noted += 1,
            Step::Dropped(reason) => self.counts.dropped.add(*reason as usize),
        }
        Some(step)
    }

    /// Octets so far that belong to no frame.
    pub fn outside(&self) -> u64 {
        self.deframer.outside()
    }

    /// Whether a frame has begun and not ended.
    pub fn is_within(&self) -> bool {
        self.deframer.is_within()
    }

    /// Ends the stream, so that the next one begins anew; whether that cut a frame, which is counted.
    pub fn end(&mut self) -> bool {
        let cuts = self.deframer.is_within();
        if cuts {
            self.counts.frames += 1;
            self.counts.dropped.add(Reason::Cut as usize);
        }
        self.deframer.restart();
        cuts
    }

    fn frame(&mut self, frame: &Frame, received: Time) -> Result<Step, Reason> {
        if self.is_copy(frame) {
            return Err(Reason::Copy);
        }
        let message = match &frame.message {
            Message::ModeAc => return Err(Reason::ModeAc),
            Message::Status(_) | Message::ReceiverPlace => return Err(Reason::Receiver),
            Message::ReceiverId(_) => return Err(Reason::ReceiverId),
            Message::Short(_) => return Err(Reason::ModeS),
            Message::Long(message) => message,
        };
        let squitter = Squitter::new(message).map_err(|reason| match reason {
            NotAdsb::Damaged => Reason::Damaged,
            NotAdsb::TisB => Reason::TisB,
            NotAdsb::Other => Reason::ModeS,
        })?;
        if squitter.says == Says::Other {
            return Err(Reason::Unused);
        }
        let (source, receiver) = (self.source, self.receiver);
        let aircraft = self.aircraft(squitter.address, received);
        let Says::Position(position) = &squitter.says else {
            aircraft.note(&squitter.says, received);
            return Ok(Step::Noted);
        };
        let place = aircraft.place(position, received, receiver).map_err(|reason| match reason {
            Unplaced::Copy => Reason::Copy,
            Unplaced::Alone => Reason::Alone,
            Unplaced::Implausible => Reason::Implausible,
        })?;
        let record =
            aircraft.record(source, &squitter, position, place, received).map_err(|_| Reason::OutOfRange)?;
        let mut datagram = Vec::new();
        encode_block(&[record], &mut datagram).map_err(|_| Reason::OutOfRange)?;
        Ok(Step::Translated(datagram))
    }

    /// Whether the receiver's clock says that this very frame has come already, as it does where two of its outputs are merged.
    fn is_copy(&mut self, frame: &Frame) -> bool {
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

    /// The aircraft of an address, heard now.
    fn aircraft(&mut self, address: u32, now: Time) -> &mut Aircraft {
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
        let aircraft = self.aircraft.entry(address).or_insert_with(|| Aircraft::new(now));
        if now.nanos().saturating_sub(aircraft.heard.nanos()) > FORGOTTEN_NS {
            *aircraft = Aircraft::new(now);
        }
        aircraft.heard = aircraft.heard.max(now);
        aircraft
    }
}
