//! The clock of a recording of 1090 MHz frames, which has no time of its own but the receiver's stamps.
//!
//! Stamps of 48 bits are of two kinds. Most receivers count at 12 MHz from any start. A Radarcape, and what imitates one, sends
//! the seconds of the UTC day in the upper 18 bits and nanoseconds in the lower 30.

use std::collections::BTreeMap;

use fusion::time::{DAY, SECOND, Time};

use crate::gateways::adsb::{Deframer, Frame, Framing, Message, Piece, STAMP_HZ};

/// Kind of the stamps in a recording of 1090 MHz frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Stamps {
    /// Found out from the first frames of the recording.
    #[default]
    Auto,
    /// A counter of 12 MHz.
    #[value(name = "12mhz")]
    Counter,
    /// Seconds of the UTC day and nanoseconds, as a Radarcape sends them.
    #[value(name = "gps")]
    Gps,
}

/// Octets at the front of a recording from which the kind of stamps is found out.
pub(super) const HEAD: usize = 64 * 1024;

/// Bits of a stamp, and of its nanoseconds.
const STAMP_BITS: u32 = 48;
const NANOS_BITS: u32 = 30;
/// A time that moves by more than this, in either direction, is believed once the next one is as far, seconds.
const JUMP_S: i64 = 60;
/// An aircraft sends its position every 0.4 s at most, and is rarely missed for long: as a counter of 12 MHz, longer gaps than
/// this are implausible, and as nanoseconds shorter ones are.
const GAP: u64 = 20 * STAMP_HZ.unsigned_abs();
/// A position that follows sooner, in counts of either kind, is a copy from another receiver.
const COPY: u64 = 1_000_000;
/// Number of gaps by which stamps are judged.
const GAPS_LEAST: u64 = 8;
/// Bits of a Radarcape's status: stamps are GPS time; and they are not a second ahead.
const STATUS_GPS: u8 = 0x10;
const STATUS_UTC: u8 = 0x80;

/// The unit of stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Counter,
    /// `ahead_ns` is what older firmware is ahead of UTC.
    Gps {
        ahead_ns: i64,
    },
}

impl Unit {
    /// The unit by the first octets of a recording. A status frame says it. Otherwise stamps are GPS time if all can be, and
    /// successive positions of each aircraft would be too far apart as a counter.
    fn judged(framing: Framing, head: &[u8]) -> Self {
        let mut deframer = Deframer::new(framing);
        let mut last = BTreeMap::new();
        let (mut can_be_gps, mut gaps, mut short) = (true, 0_u64, 0_u64);
        for octet in head {
            let Some(Piece::Frame(frame)) = deframer.take(*octet) else { continue };
            if let Message::Status(status) = &frame.message {
                let ahead_ns = if status[2] & STATUS_UTC == 0 { SECOND } else { 0 };
                return if status[0] & STATUS_GPS == 0 { Self::Counter } else { Self::Gps { ahead_ns } };
            }
            let Some(stamp) = frame.stamp else { continue };
            can_be_gps &= gps_ns(stamp).is_some();
            let Some(address) = sender_of_position(&frame.message) else { continue };
            let gap = last.insert(address, stamp).map_or(0, |before| stamp.abs_diff(before));
            if gap > COPY {
                gaps += 1;
                short += u64::from(gap < GAP);
            }
        }
        let is_gps = can_be_gps && gaps >= GAPS_LEAST && short * 10 <= gaps;
        if is_gps { Self::Gps { ahead_ns: 0 } } else { Self::Counter }
    }

    /// Ticks of a stamp from any start; `None` where it is none of this unit.
    fn ticks(self, stamp: u64) -> Option<i64> {
        match self {
            Self::Counter => Some(stamp as i64),
            Self::Gps { ahead_ns } => gps_ns(stamp).map(|ns| (ns - ahead_ns).rem_euclid(DAY)),
        }
    }

    /// Ticks in a second, and those after which stamps begin again.
    const fn scale(self) -> (i64, i64) {
        match self {
            Self::Counter => (STAMP_HZ, 1 << STAMP_BITS),
            Self::Gps { .. } => (SECOND, DAY),
        }
    }
}

/// Nanoseconds of the day of a stamp that is GPS time.
fn gps_ns(stamp: u64) -> Option<i64> {
    let (seconds, ns) = ((stamp >> NANOS_BITS) as i64, (stamp & ((1 << NANOS_BITS) - 1)) as i64);
    (seconds < DAY / SECOND && ns < SECOND).then_some(seconds * SECOND + ns)
}

/// The address of the aircraft, if this is a squitter with a position.
fn sender_of_position(message: &Message) -> Option<[u8; 3]> {
    match message {
        Message::Long([first, a, b, c, code, ..]) => {
            let is_squitter = matches!(first >> 3, 17 | 18);
            (is_squitter && matches!(code >> 3, 5..=18 | 20..=22)).then_some([*a, *b, *c])
        }
        _ => None,
    }
}

/// Time by the receiver's stamps.
#[derive(Debug)]
pub(super) struct StampClock {
    /// When the recording begins, by its name.
    start: Option<Time>,
    stamps: Stamps,
    /// `None` before it is known.
    unit: Option<Unit>,
    last: Option<i64>,
    /// A stamp that was far from the one before.
    astray: Option<i64>,
    /// From `start`, or midnight, to the first stamp.
    first_ns: i64,
    /// From the first stamp to the last, ticks.
    elapsed: i64,
}

impl StampClock {
    /// The clock of a recording that begins at `start`, where that is known.
    pub(super) fn new(start: Option<Time>) -> Self {
        Self { start, stamps: Stamps::Auto, unit: None, last: None, astray: None, first_ns: 0, elapsed: 0 }
    }

    /// States the kind of stamps, before the first one.
    pub(super) fn set_stamps(&mut self, stamps: Stamps) {
        self.stamps = stamps;
    }

    /// Whether the kind of stamps is to be found out.
    pub(super) fn is_undecided(&self) -> bool {
        self.unit.is_none()
    }

    /// Decides the kind of stamps, where that is not stated by the first octets of the recording.
    pub(super) fn decide(&mut self, framing: Framing, head: &[u8]) {
        self.unit = Some(match (self.stamps, Unit::judged(framing, head)) {
            (Stamps::Counter, _) => Unit::Counter,
            (Stamps::Auto, unit) | (Stamps::Gps, unit @ Unit::Gps { .. }) => unit,
            (Stamps::Gps, Unit::Counter) => Unit::Gps { ahead_ns: 0 },
        });
    }

    /// Whether the day of its times is known.
    pub(super) fn is_dated(&self) -> bool {
        self.start.is_some()
    }

    /// Time of the last frame; `None` where the day is not known.
    pub(super) fn now(&self) -> Option<Time> {
        self.start.map(|start| Time::from_nanos(start.nanos().saturating_add(self.since_start_ns())))
    }

    /// Time of day of the last frame, nanoseconds.
    pub(super) fn since_midnight_ns(&self) -> i64 {
        self.since_start_ns().rem_euclid(DAY)
    }

    fn since_start_ns(&self) -> i64 {
        let (hz, _) = self.unit().scale();
        let elapsed_ns = i128::from(self.elapsed) * i128::from(SECOND) / i128::from(hz);
        self.first_ns.saturating_add(elapsed_ns as i64)
    }

    fn unit(&self) -> Unit {
        self.unit.unwrap_or(Unit::Counter)
    }

    /// Time of a frame: of its stamp, or else of the stamp before.
    pub(super) fn time(&mut self, frame: &Frame) -> Time {
        if let Some(ticks) = frame.stamp.and_then(|stamp| self.unit().ticks(stamp)) {
            self.advance(ticks);
        }
        self.now().unwrap_or(Time::from_nanos(self.since_start_ns()))
    }

    fn advance(&mut self, ticks: i64) {
        let (hz, round) = self.unit().scale();
        let Some(last) = self.last else {
            self.last = Some(ticks);
            if self.unit() != Unit::Counter {
                // The time of day is exact; the name of the file says the day.
                let start_ns = self.start.map(Time::since_midnight);
                self.first_ns = start_ns.map_or(ticks, |start_ns| difference(ticks, start_ns, round));
            }
            return;
        };
        let moved = difference(ticks, last, round);
        let is_near = |ticks_apart: i64| ticks_apart.abs() <= JUMP_S * hz;
        let before = self.astray.replace(ticks);
        let agrees = before.is_some_and(|before| is_near(difference(ticks, before, round)));
        if is_near(moved) || agrees {
            self.elapsed = self.elapsed.saturating_add(moved);
            self.last = Some(ticks);
            self.astray = None;
        }
    }
}

/// From `before` to `ticks`, the nearer way round.
fn difference(ticks: i64, before: i64, round: i64) -> i64 {
    let ahead = (ticks - before).rem_euclid(round);
    if ahead > round / 2 { ahead - round } else { ahead }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(stamp: Option<u64>) -> Frame {
        Frame { stamp, message: Message::ModeAc }
    }

    fn gps(seconds: u64, ns: u64) -> u64 {
        seconds << NANOS_BITS | ns
    }

    /// A recording of positions of one aircraft with these stamps, as AVR.
    fn recording(stamps: impl IntoIterator<Item = u64>) -> Vec<u8> {
        let line = |stamp| format!("@{stamp:012x}8d40058b58c901375147efd09357;\n");
        stamps.into_iter().map(line).collect::<String>().into_bytes()
    }

    #[test]
    fn counter_wraps_and_single_stray_is_ignored() {
        let mut clock = StampClock::new(None);
        let mut at = |stamp| clock.time(&frame(stamp)).nanos();
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

    #[test]
    fn gps_stamps_keep_their_time_of_day_over_midnight() {
        let start = "2022-06-22T23:59:58Z".parse::<jiff::Timestamp>().unwrap();
        let start = Time::from_nanos(i64::try_from(start.as_nanosecond()).unwrap());
        let mut clock = StampClock::new(Some(start));
        clock.set_stamps(Stamps::Gps);
        clock.decide(Framing::Avr, &[]);
        let mut at = |stamp| clock.time(&frame(Some(stamp))).to_string();
        assert_eq!(at(gps(86_395, 500_000_000)), "2022-06-22T23:59:55.500Z");
        assert_eq!(at(gps(86_399, 999_000_000)), "2022-06-22T23:59:59.999Z");
        assert_eq!(at(gps(1, 0)), "2022-06-23T00:00:01.000Z");
        // No nanosecond: the stamp before counts.
        assert_eq!(at(gps(1, 1_000_000_000)), "2022-06-23T00:00:01.000Z");
    }

    #[test]
    fn unit_is_judged_by_gaps_between_positions() {
        let judged = |octets: &[u8]| Unit::judged(Framing::Avr, octets);
        let half = 500_000_000;
        let as_gps: Vec<u64> = (0..20).map(|count| gps(70_000 + count / 2, count % 2 * half)).collect();
        assert_eq!(judged(&recording(as_gps.clone())), Unit::Gps { ahead_ns: 0 });
        assert_eq!(judged(&recording(as_gps[..8].iter().copied())), Unit::Counter, "too few");
        let counted = (0..20).map(|count| gps(70_000, 0) + count * 6_000_000);
        assert_eq!(judged(&recording(counted)), Unit::Counter);
        let no_nanos = as_gps.iter().copied().chain([gps(70_011, SECOND as u64)]);
        assert_eq!(judged(&recording(no_nanos)), Unit::Counter, "a stamp that cannot be GPS time");
    }

    #[test]
    fn unit_is_what_a_status_frame_says() {
        let status = |first: u8, third: u8| {
            let head = [&[0x1a, b'4'][..], &[0; 7], &[first, 0, third], &[0; 11]].concat();
            Unit::judged(Framing::Beast, &head)
        };
        assert_eq!(status(0, 0), Unit::Counter);
        assert_eq!(status(STATUS_GPS, STATUS_UTC), Unit::Gps { ahead_ns: 0 });
        assert_eq!(status(STATUS_GPS, 0), Unit::Gps { ahead_ns: SECOND });
        assert_eq!(Unit::Gps { ahead_ns: SECOND }.ticks(gps(0, 5)), Some(DAY - SECOND + 5));
    }
}
