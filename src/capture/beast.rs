//! Beast: what a 1090 MHz receiver sends, written to a file as it came. Its frames bear a counter of 12 MHz and no time; the
//! time of the first one is taken from the file's name, where that has one (`20180403T190228Z`), and is otherwise midnight of
//! the day that the user says. [`crate::gateways::adsb`] translates the frames to CAT021.

use asterix::DataSource;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::error::Damage;
use super::skipped::{SkipReason, Skipped};
use super::window::Window;
use super::{Contents, Datagram};
use crate::gateways::adsb::{Frame, Framing, Reason, STAMP_HZ, Step, Translator};
use fusion::time::{DAY, SECOND, Time};

/// What begins every frame.
pub(super) const ESCAPE: u8 = 0x1a;
/// Frames in a row by which a file is recognised, unless it ends before.
const RECOGNISED: usize = 4;
/// Octets in which they are, each of them doubled.
pub(super) const SAMPLE: usize = RECOGNISED * 2 * (2 + 7 + 14);
/// Octets looked at in one go, and those between two frames that are told of in one piece.
const STEP: usize = 4096;
/// Bits of the counter.
const STAMP_BITS: u32 = 48;
/// A counter that moves by more than this, in either direction, is believed once the next one is as far.
const JUMP: i64 = 60 * STAMP_HZ;

/// Whether these octets, the first of a file, are frames one behind another.
pub(super) fn begins(mut octets: &[u8]) -> bool {
    for found in 0..RECOGNISED {
        let [ESCAPE, kind, rest @ ..] = octets else { return found > 0 && octets.is_empty() };
        let mut left = match kind {
            b'1' => 9,
            b'2' => 14,
            b'3' | b'4' => 21,
            _ => return false,
        };
        octets = rest;
        while left > 0 {
            octets = match octets {
                [ESCAPE, ESCAPE, rest @ ..] => rest,
                [ESCAPE, ..] | [] => return false,
                [_, rest @ ..] => rest,
            };
            left -= 1;
        }
    }
    true
}

/// Reads such a file.
pub(super) struct Beast {
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
    pub(super) fn open(name: &str) -> Self {
        Self {
            translator: Self::translator(DataSource { sac: 0, sic: 0 }),
            clock: StampClock { start: start(name), last: None, astray: None, elapsed: 0 },
            frame_at: 0,
            was_within: false,
            unframed: Vec::new(),
            unframed_at: 0,
            has_ended: false,
        }
    }

    fn translator(source: DataSource) -> Translator {
        Translator::new(Framing::Beast, source, None)
    }

    /// Whether its name says when it begins.
    pub(super) fn is_dated(&self) -> bool {
        self.clock.start.is_some()
    }

    /// Whose records they shall be. Before the first one is read.
    pub(super) fn set_source(&mut self, source: DataSource) {
        self.translator = Self::translator(source);
    }

    /// The next position, or octets that belong to no frame; all else is counted in `skipped`.
    pub(super) fn next(
        &mut self,
        window: &mut Window,
        skipped: &mut Skipped,
    ) -> Result<Option<Datagram>, Damage> {
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
            let octets = &octets[..octets.len().min(STEP)];
            let (mut found, mut taken, mut is_whole) = (None, 0, false);
            for octet in octets {
                let at = position + taken as u64;
                if !self.was_within {
                    self.frame_at = at;
                }
                let before = self.translator.outside();
                let clock = &mut self.clock;
                let step = self.translator.take_octet(*octet, |frame| clock.time(frame));
                self.was_within = self.translator.is_within();
                taken += 1;
                if self.was_within && matches!(step, Some(Step::Dropped(Reason::Cut))) {
                    // It is cut by the next one, which began with the escape before this octet.
                    self.frame_at = at - 1;
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
                let since_start = self.clock.elapsed_ns();
                let received = self.clock.start.map(|start| Time::from_nanos(start.nanos() + since_start));
                return Ok(Some(Datagram {
                    received,
                    since_midnight: received.is_none().then(|| since_start.rem_euclid(DAY)),
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

/// Time by the receiver's counter.
struct StampClock {
    /// Time of the first stamp.
    start: Option<Time>,
    last: Option<u64>,
    /// One that was far from the one before.
    astray: Option<u64>,
    /// From the first stamp to the last one, counts.
    elapsed: i64,
}

impl StampClock {
    fn time(&mut self, frame: &Frame) -> Time {
        if let Some(stamp) = frame.stamp {
            let moved = self.last.map_or(0, |last| difference(stamp, last));
            let agrees =
                self.astray.replace(stamp).is_some_and(|astray| difference(stamp, astray).abs() <= JUMP);
            if moved.abs() <= JUMP || agrees {
                self.elapsed = self.elapsed.saturating_add(moved);
                self.last = Some(stamp);
                self.astray = None;
            }
        }
        let start = self.start.map_or(0, Time::nanos);
        Time::from_nanos(start.saturating_add(self.elapsed_ns()))
    }

    fn elapsed_ns(&self) -> i64 {
        (i128::from(self.elapsed) * i128::from(SECOND) / i128::from(STAMP_HZ)) as i64
    }
}

/// From `before` to `stamp`, the nearer way round.
fn difference(stamp: u64, before: u64) -> i64 {
    let spare = 64 - STAMP_BITS;
    (stamp.wrapping_sub(before) << spare).cast_signed() >> spare
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

    #[test]
    fn a_counter_goes_round_and_one_stray_moves_nothing() {
        let mut clock = StampClock { start: None, last: None, astray: None, elapsed: 0 };
        let message = crate::gateways::adsb::Message::ModeAc;
        let mut at = |stamp| clock.time(&Frame { stamp, message }).nanos();
        let second = STAMP_HZ as u64;
        assert_eq!(at(Some((1 << 48) - second)), 0);
        assert_eq!(at(Some(second)), 2 * SECOND);
        assert_eq!(at(Some(second / 2)), 3 * SECOND / 2);
        assert_eq!(at(None), 3 * SECOND / 2);
        assert_eq!(at(Some(7_000 * second)), 3 * SECOND / 2);
        assert_eq!(at(Some(3 * second)), 4 * SECOND);
        // A pause: two that agree.
        assert_eq!(at(Some(7_000 * second)), 4 * SECOND);
        assert_eq!(at(Some(7_001 * second)), 7_002 * SECOND);
    }
}
