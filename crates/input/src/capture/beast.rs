//! Recordings of a 1090 MHz receiver's frames, Beast or AVR. A frame has the receiver's stamp but no date (`stamps.rs`).
//! The date is taken from the file's name, if it contains one (`20180403T190228Z`), and otherwise stated by the user.
//! [`crate::gateways::adsb`] translates the frames to CAT021.

use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::error::Damage;
use super::receivers::SiteReceivers;
use super::skipped::{SkipReason, SkippedFrames};
use super::stamps::{AHEAD, StampClock};
use super::window::ReadWindow;
use super::{CapturedDatagram, PayloadKind};
use crate::gateways::adsb::{
    AdsbDropReason, AdsbTranslator, BODY_MOST, Deframer, FrameResult, ReceiverFraming, StreamPart,
};
use fusion::time::Time;

/// First octet of every Beast frame.
pub(super) const ESCAPE: u8 = 0x1a;
/// First characters of AVR lines.
pub(super) const MARKS: [u8; 3] = [b'*', b'@', b'<'];
/// Number of consecutive frames by which a file is recognised, unless it ends earlier.
const RECOGNISED: usize = 4;
/// Maximum size of these frames in octets, with each octet doubled.
pub(super) const SAMPLE: usize = RECOGNISED * 2 * (1 + BODY_MOST);
/// Number of octets examined at a time, and maximum length of a reported stretch between two frames.
const STEP: usize = 4096;

/// Whether these octets, the first of a file, are consecutive frames: `Some(false)` if none of them has a stamp, `None` if
/// they are not frames.
pub(super) fn begins(framing: ReceiverFraming, octets: &[u8]) -> Option<bool> {
    let mut deframer = Deframer::new(framing);
    let (mut found, mut has_stamp) = (0, false);
    for octet in octets {
        match deframer.take(*octet) {
            Some(StreamPart::Frame(frame)) => {
                found += 1;
                has_stamp |= frame.stamp.is_some();
            }
            Some(StreamPart::Cut | StreamPart::Malformed) => return None,
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

/// Reader of such a file.
pub(super) struct Beast {
    framing: ReceiverFraming,
    translator: AdsbTranslator,
    clock: StampClock,
    /// Offset of the frame that is being read.
    frame_at: u64,
    was_within: bool,
    /// Octets that belong to no frame, and their offset: one stretch, in however many parts it was read.
    unframed: Vec<u8>,
    unframed_at: u64,
    has_ended: bool,
}

impl Beast {
    /// Reader of a file with this name.
    pub(super) fn open(name: &str, framing: ReceiverFraming) -> Self {
        Self {
            framing,
            translator: Self::translator(framing, &SiteReceivers::default()),
            clock: StampClock::new(framing, start(name)),
            frame_at: 0,
            was_within: false,
            unframed: Vec::new(),
            unframed_at: 0,
            has_ended: false,
        }
    }

    fn translator(framing: ReceiverFraming, receivers: &SiteReceivers) -> AdsbTranslator {
        AdsbTranslator::new(framing, receivers.adsb, receivers.place)
    }

    /// Whether the file's name states its start.
    pub(super) fn is_dated(&self) -> bool {
        self.clock.is_dated()
    }

    /// Sets the receiver's position, the kind of its stamps, and the SAC/SIC of its records. To be called before the first
    /// read.
    pub(super) fn set_receivers(&mut self, receivers: &SiteReceivers) {
        self.translator = Self::translator(self.framing, receivers);
        self.clock.set_stamps(receivers.stamps);
    }

    /// The next position, or octets that belong to no frame; all other frames are counted in `skipped`.
    pub(super) fn next(
        &mut self,
        window: &mut ReadWindow,
        skipped: &mut SkippedFrames,
    ) -> Result<Option<CapturedDatagram>, Damage> {
        let mut step = [0; STEP];
        loop {
            let position = window.position();
            let octets = window.glimpse(1);
            if octets.is_empty() {
                if !self.unframed.is_empty() {
                    return Ok(Some(self.take_unframed()));
                }
                // Reports a read error, if there is one.
                window.peek(1)?;
                if !std::mem::replace(&mut self.has_ended, true) && self.translator.end() {
                    skipped.add(SkipReason::Truncated);
                }
                return Ok(None);
            }
            // Copied, because a frame may need to look further ahead.
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
                if self.was_within && matches!(step, Some(FrameResult::Dropped(AdsbDropReason::Cut))) {
                    // The next frame cuts this one: an AVR line begins with this octet, a Beast frame with the escape
                    // before it.
                    self.frame_at = if self.framing == ReceiverFraming::Beast { at - 1 } else { at };
                }
                if self.translator.outside() > before {
                    // The first of two escapes belongs to no frame, and the second begins one.
                    let outside_at =
                        if self.was_within { std::mem::replace(&mut self.frame_at, at) } else { at };
                    if self.unframed.is_empty() {
                        self.unframed_at = outside_at;
                    }
                    self.unframed.push(*octet);
                    is_whole = self.unframed.len() == STEP;
                } else {
                    // A frame begins here, and ends the stretch outside of frames.
                    is_whole = !self.unframed.is_empty();
                }
                match step {
                    None | Some(FrameResult::Noted) => {}
                    Some(FrameResult::Dropped(reason)) => skipped.add(reason_of(reason)),
                    Some(FrameResult::Translated(payload)) => found = Some(payload),
                }
                if is_whole || found.is_some() {
                    break;
                }
            }
            window.consume(taken);
            if let Some(payload) = found {
                let received = self.clock.now();
                return Ok(Some(CapturedDatagram {
                    received,
                    since_midnight: received.is_none().then(|| self.clock.since_midnight_ns()),
                    origin: self.frame_at,
                    payload,
                    contents: PayloadKind::Translated,
                    ..CapturedDatagram::default()
                }));
            }
            if is_whole {
                return Ok(Some(self.take_unframed()));
            }
        }
    }

    fn take_unframed(&mut self) -> CapturedDatagram {
        let payload = std::mem::take(&mut self.unframed);
        CapturedDatagram {
            origin: self.unframed_at,
            payload,
            contents: PayloadKind::Unframed,
            ..CapturedDatagram::default()
        }
    }
}

fn reason_of(reason: AdsbDropReason) -> SkipReason {
    match reason {
        AdsbDropReason::Cut => SkipReason::Truncated,
        AdsbDropReason::Malformed => SkipReason::Malformed,
        AdsbDropReason::Copy => SkipReason::Copy,
        AdsbDropReason::Damaged => SkipReason::Checksum,
        AdsbDropReason::ReceiverId => SkipReason::ReceiverId,
        AdsbDropReason::ModeAc
        | AdsbDropReason::Receiver
        | AdsbDropReason::ModeS
        | AdsbDropReason::TisB
        | AdsbDropReason::Unused => SkipReason::NotAdsb,
        AdsbDropReason::Alone => SkipReason::Unplaced,
        AdsbDropReason::Implausible | AdsbDropReason::OutOfRange => SkipReason::Implausible,
    }
}

/// Start of the recording from the file's name: year, month and day, `T`, hour, minute and second, `Z`.
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
    fn capture_name_states_its_time() {
        let time = |name| start(name).map(|time| time.to_string());
        assert_eq!(time("a/ulss7-20180403T190228Z.beast").as_deref(), Some("2018-04-03T19:02:28.000Z"));
        assert_eq!(time("20181303T190228Z 20180403T190229Z").as_deref(), Some("2018-04-03T19:02:29.000Z"));
        assert_eq!([time("capture.beast"), time("20180403T190228"), time("")], [None, None, None]);
    }
}
