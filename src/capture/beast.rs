//! Frames of a 1090 MHz receiver, Beast or AVR, written to a file as they came. A frame bears the receiver's stamp and no date
//! (`stamps.rs`); the date is taken from the file's name, where that has one (`20180403T190228Z`), and is otherwise the day that
//! the user says. [`crate::gateways::adsb`] translates the frames to CAT021.

use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::error::Damage;
use super::receivers::Receivers;
use super::skipped::{SkipReason, Skipped};
use super::stamps::{AHEAD, StampClock};
use super::window::Window;
use super::{Contents, Datagram};
use crate::gateways::adsb::{BODY_MOST, Deframer, Framing, Piece, Reason, Step, Translator};
use fusion::time::Time;

/// First octet of every Beast frame.
pub(super) const ESCAPE: u8 = 0x1a;
/// First characters of lines of AVR.
pub(super) const MARKS: [u8; 3] = [b'*', b'@', b'<'];
/// Frames in a row by which a file is recognised, unless it ends before.
const RECOGNISED: usize = 4;
/// Octets in which they are, each of them doubled.
pub(super) const SAMPLE: usize = RECOGNISED * 2 * (1 + BODY_MOST);
/// Octets looked at in one go, and those between two frames that are told of in one piece.
const STEP: usize = 4096;

/// Whether these octets, the first of a file, are frames one behind another; `Some(false)` if none of them has a stamp.
pub(super) fn begins(framing: Framing, octets: &[u8]) -> Option<bool> {
    let mut deframer = Deframer::new(framing);
    let (mut found, mut has_stamp) = (0, false);
    for octet in octets {
        match deframer.take(*octet) {
            Some(Piece::Frame(frame)) => {
                found += 1;
                has_stamp |= frame.stamp.is_some();
            }
            Some(Piece::Cut | Piece::Malformed) => return None,
            None => {}
        }
        if deframer.outside() > 0 {
            return None;
        }
        if found == RECOGNISED {
            break;
        }
    }
    (found == RECOGNISED || found > 0 && !deframer.is_within()).then_some(has_stamp)
}

/// Reads such a file.
pub(super) struct Beast {
    framing: Framing,
    translator: Translator,
    clock: StampClock,
    /// Offset of the frame that is being read.
    frame_at: u64,
    was_within: bool,
    /// Octets of no frame, up to here, and where they begin: they are one piece in however many parts they were read.
    unframed: Vec<u8>,
    unframed_at: u64,
    has_ended: bool,
}

impl Beast {
    /// The reader of a file of this name.
    pub(super) fn open(name: &str, framing: Framing) -> Self {
        Self {
            framing,
            translator: Self::translator(framing, &Receivers::default()),
            clock: StampClock::new(framing, start(name)),
            frame_at: 0,
            was_within: false,
            unframed: Vec::new(),
            unframed_at: 0,
            has_ended: false,
        }
    }

    fn translator(framing: Framing, receivers: &Receivers) -> Translator {
        Translator::new(framing, receivers.adsb, receivers.place)
    }

    /// Whether its name says when it begins.
    pub(super) fn is_dated(&self) -> bool {
        self.clock.is_dated()
    }

    /// States where the receiver is, what its stamps count, and whose its records are. Before the first one is read.
    pub(super) fn set_receivers(&mut self, receivers: &Receivers) {
        self.translator = Self::translator(self.framing, receivers);
        self.clock.set_stamps(receivers.stamps);
    }

    /// The next position, or octets that belong to no frame; all else is counted in `skipped`.
    pub(super) fn next(
        &mut self,
        window: &mut Window,
        skipped: &mut Skipped,
    ) -> Result<Option<Datagram>, Damage> {
        let mut step = [0; STEP];
        loop {
            let position = window.position();
            let octets = window.glimpse(1);
            if octets.is_empty() {
                if !self.unframed.is_empty() {
                    return Ok(Some(self.take_unframed()));
                }
                // Why it breaks off, where it does.
                window.peek(1)?;
                if !std::mem::replace(&mut self.has_ended, true) && self.translator.end() {
                    skipped.add(SkipReason::Truncated);
                }
                return Ok(None);
            }
            // A copy: a frame may need to look farther ahead.
            let length = octets.len().min(STEP);
            step[..length].copy_from_slice(&octets[..length]);
            let (mut found, mut taken, mut is_whole) = (None, 0, false);
            for octet in &step[..length] {
                let at = position + taken as u64;
                if !self.was_within {
                    self.frame_at = at;
                }
                let before = self.translator.outside();
                let clock = &mut self.clock;
                taken += 1;
                let mut ahead = || {
                    let octets = window.glimpse(taken + AHEAD);
                    octets[taken..].iter().take(AHEAD).copied().collect()
                };
                let step = self.translator.take_octet(*octet, |frame| clock.time(frame, &mut ahead));
                self.was_within = self.translator.is_within();
                if self.was_within && matches!(step, Some(Step::Dropped(Reason::Cut))) {
                    // The next frame cuts it: a line begins with this octet, a Beast frame with the escape before it.
                    self.frame_at = if self.framing == Framing::Beast { at - 1 } else { at };
                }
                if self.translator.outside() > before {
                    // Of two escapes the first is of no frame, and the second begins one.
                    let outside_at =
                        if self.was_within { std::mem::replace(&mut self.frame_at, at) } else { at };
                    if self.unframed.is_empty() {
                        self.unframed_at = outside_at;
                    }
                    self.unframed.push(*octet);
                    is_whole = self.unframed.len() == STEP;
                } else {
                    // A frame begins, and none ends.
                    is_whole = !self.unframed.is_empty();
                }
                match step {
                    None | Some(Step::Noted) => {}
                    Some(Step::Dropped(reason)) => skipped.add(reason_of(reason)),
                    Some(Step::Translated(payload)) => found = Some(payload),
                }
                if is_whole || found.is_some() {
                    break;
                }
            }
            window.consume(taken);
            if let Some(payload) = found {
                let received = self.clock.now();
                return Ok(Some(Datagram {
                    received,
                    since_midnight: received.is_none().then(|| self.clock.since_midnight_ns()),
                    origin: self.frame_at,
                    payload,
                    contents: Contents::Translated,
                    ..Datagram::default()
                }));
            }
            if is_whole {
                return Ok(Some(self.take_unframed()));
            }
        }
    }

    fn take_unframed(&mut self) -> Datagram {
        let payload = std::mem::take(&mut self.unframed);
        Datagram { origin: self.unframed_at, payload, contents: Contents::Unframed, ..Datagram::default() }
    }
}

fn reason_of(reason: Reason) -> SkipReason {
    match reason {
        Reason::Cut => SkipReason::Truncated,
        Reason::Malformed => SkipReason::Malformed,
        Reason::Copy => SkipReason::Copy,
        Reason::Damaged => SkipReason::Checksum,
        Reason::ReceiverId => SkipReason::ReceiverId,
        Reason::ModeAc | Reason::Receiver | Reason::ModeS | Reason::TisB | Reason::Unused => {
            SkipReason::NotAdsb
        }
        Reason::Alone => SkipReason::Unplaced,
        Reason::Implausible | Reason::OutOfRange => SkipReason::Implausible,
    }
}

/// The time of the first frame in a file's name: year, month and day, `T`, hour, minute and second, `Z`.
fn start(name: &str) -> Option<Time> {
    let stamps = name.as_bytes().windows(16).filter_map(|window| str::from_utf8(window).ok());
    let mut times = stamps.filter(|stamp| stamp.as_bytes()[8] == b'T' && stamp.ends_with('Z'));
    times.find_map(|stamp| {
        let time = DateTime::strptime("%Y%m%dT%H%M%S", &stamp[..15]).ok()?;
        let nanos = time.to_zoned(TimeZone::UTC).ok()?.timestamp().as_nanosecond();
        i64::try_from(nanos).ok().map(Time::from_nanos)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_a_time() {
        let time = |name| start(name).map(|time| time.to_string());
        assert_eq!(time("a/ulss7-20180403T190228Z.beast").as_deref(), Some("2018-04-03T19:02:28.000Z"));
        assert_eq!(time("20181303T190228Z 20180403T190229Z").as_deref(), Some("2018-04-03T19:02:29.000Z"));
        assert_eq!([time("capture.beast"), time("20180403T190228"), time("")], [None, None, None]);
    }
}
