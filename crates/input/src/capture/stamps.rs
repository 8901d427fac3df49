//! Clock of a recording of 1090 MHz frames, whose only times are the receivers' stamps.
//!
//! Stamps of 48 bits are of two kinds. Most receivers count at 12 MHz from any start. A Radarcape, or a compatible
//! receiver, sends the seconds of the UTC day in the upper 18 bits and nanoseconds in the lower 30.

mod time_base;

use std::collections::BTreeMap;

use fusion::time::{DAY, SECOND, Time};

use self::time_base::{ReceiverClock, gps_first_ns};
use crate::gateways::adsb::{
    AdsbFrame, Deframer, ModeSMessage, ReceiverFraming, ReceiverId, STAMP_HZ, StreamPart,
};

/// Kind of the stamps in a recording of 1090 MHz frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum StampKind {
    /// Determined from the first frames of the recording.
    #[default]
    Auto,
    /// A counter at 12 MHz.
    #[value(name = "12mhz")]
    Counter,
    /// Seconds of the UTC day and nanoseconds, as sent by a Radarcape.
    #[value(name = "gps")]
    Gps,
}

/// Number of octets after the first frame of a receiver from which the kind of its stamps is determined. Also the number of
/// octets after a stamp that fits no counter, from which a pause of the recording is distinguished from a new receiver.
pub(super) const AHEAD: usize = 64 * 1024;
/// Maximum number of receivers with clocks; one more restarts all of them.
const RECEIVERS_MOST: usize = 4096;
/// Maximum time difference of receivers that share a counter, such as the outputs of one receiver, in nanoseconds.
const SHARED_NS: i64 = 2 * SECOND;

/// Bits of a stamp, and of its nanoseconds.
const STAMP_BITS: u32 = 48;
const NANOS_BITS: u32 = 30;
/// Gap between positions of one aircraft that separates the kinds of stamps: 20 s at 12 MHz, 0.24 s in nanoseconds. Aircraft send
/// their positions at least 0.4 s apart, and are rarely missed for as long as 20 s.
const GAP: u64 = 20 * STAMP_HZ.unsigned_abs();
/// Maximum gap of a copy from another receiver, in counts of either kind.
const COPY: u64 = 1_000_000;
/// Minimum number of gaps for a decision on the kind of stamps.
const GAPS_LEAST: u64 = 8;
/// Bits of a Radarcape's status: stamps are GPS time; stamps are not a second ahead.
const STATUS_GPS: u8 = 0x10;
const STATUS_UTC: u8 = 0x80;

/// The unit of stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Counter,
    /// `ahead_ns`: time by which older firmware is ahead of UTC, in nanoseconds.
    Gps {
        ahead_ns: i64,
    },
}

impl Unit {
    /// Determines the unit from the first frames of a receiver; `None` if they do not suffice. A status frame states it.
    /// Otherwise stamps are GPS time if all have valid values, and successive positions of each aircraft would be too far
    /// apart as a counter.
    fn judged(frames: impl Iterator<Item = AdsbFrame>) -> Option<Self> {
        let mut last = BTreeMap::new();
        let (mut can_be_gps, mut gaps, mut short) = (true, 0_u64, 0_u64);
        for frame in frames {
            if let ModeSMessage::Status(status) = &frame.message {
                let ahead_ns = if status[2] & STATUS_UTC == 0 { SECOND } else { 0 };
                let is_gps = status[0] & STATUS_GPS != 0;
                return Some(if is_gps { Self::Gps { ahead_ns } } else { Self::Counter });
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
        if !can_be_gps || short * 10 > gaps {
            return Some(Self::Counter);
        }
        (gaps >= GAPS_LEAST).then_some(Self::Gps { ahead_ns: 0 })
    }

    /// Ticks of a stamp from any start; `None` if it is not valid in this unit.
    fn ticks(self, stamp: u64) -> Option<i64> {
        match self {
            Self::Counter => Some(stamp as i64),
            Self::Gps { ahead_ns } => gps_ns(stamp).map(|ns| (ns - ahead_ns).rem_euclid(DAY)),
        }
    }

    /// Ticks per second, and number of ticks after which stamps wrap.
    const fn scale(self) -> (i64, i64) {
        match self {
            Self::Counter => (STAMP_HZ, 1 << STAMP_BITS),
            Self::Gps { .. } => (SECOND, DAY),
        }
    }
}

/// Nanoseconds of the day of a GPS stamp.
fn gps_ns(stamp: u64) -> Option<i64> {
    let (seconds, ns) = ((stamp >> NANOS_BITS) as i64, (stamp & ((1 << NANOS_BITS) - 1)) as i64);
    (seconds < DAY / SECOND && ns < SECOND).then_some(seconds * SECOND + ns)
}

/// Address of the aircraft, if this is a squitter with a position.
fn sender_of_position(message: &ModeSMessage) -> Option<[u8; 3]> {
    match message {
        ModeSMessage::Long([first, a, b, c, code, ..]) => {
            let is_squitter = matches!(first >> 3, 17 | 18);
            (is_squitter && matches!(code >> 3, 5..=18 | 20..=22)).then_some([*a, *b, *c])
        }
        _ => None,
    }
}

/// Time from the stamps of a recording's receivers. Receivers count from different starts: each receiver named in the
/// stream has its own clock, and a stream that merges receivers without their identities has several counters.
#[derive(Debug)]
pub(super) struct StampClock {
    framing: ReceiverFraming,
    /// Start of the recording, from its name.
    start: Option<Time>,
    stamps: StampKind,
    /// Receiver named by the last frame with an identity.
    receiver: Option<ReceiverId>,
    clocks: BTreeMap<Option<ReceiverId>, ReceiverClock>,
    /// Time from `start`, or midnight, to the last frame, in nanoseconds.
    now_ns: i64,
}

impl StampClock {
    /// Clock of a recording that begins at `start`, if known.
    pub(super) fn new(framing: ReceiverFraming, start: Option<Time>) -> Self {
        let (stamps, clocks) = (StampKind::Auto, BTreeMap::new());
        Self { framing, start, stamps, receiver: None, clocks, now_ns: 0 }
    }

    /// Sets the kind of stamps; to be called before the first frame.
    pub(super) fn set_stamps(&mut self, stamps: StampKind) {
        self.stamps = stamps;
    }

    /// Whether the day of its times is known.
    pub(super) fn is_dated(&self) -> bool {
        self.start.is_some()
    }

    /// Time of the last frame; `None` if the day is not known.
    pub(super) fn now(&self) -> Option<Time> {
        self.start.map(|start| Time::from_nanos(start.nanos().saturating_add(self.now_ns)))
    }

    /// Time of day of the last frame, in nanoseconds.
    pub(super) fn since_midnight_ns(&self) -> i64 {
        self.now_ns.rem_euclid(DAY)
    }

    /// Time of a frame: of its stamp, or otherwise of the frame before. `ahead` reads the next [`AHEAD`] octets of the
    /// recording.
    pub(super) fn time(&mut self, frame: &AdsbFrame, ahead: impl FnOnce() -> Vec<u8>) -> Time {
        self.note(frame, ahead);
        self.now().unwrap_or(Time::from_nanos(self.now_ns))
    }

    fn note(&mut self, frame: &AdsbFrame, ahead: impl FnOnce() -> Vec<u8>) {
        if let ModeSMessage::ReceiverId(receiver) = frame.message {
            self.receiver = Some(receiver);
            return;
        }
        let (framing, receiver, now_ns) = (self.framing, self.receiver, self.now_ns);
        let is_status = matches!(frame.message, ModeSMessage::Status(_));
        let Some(clock) = self.clocks.get_mut(&receiver) else {
            if frame.stamp.is_some() || is_status {
                self.begin(frame, &ahead());
            }
            return;
        };
        let Some(ticks) = frame.stamp.and_then(|stamp| clock.unit.ticks(stamp)) else { return };
        if clock.is_new() {
            self.begin_counter(ticks);
            return;
        }
        let recurs = |clock: &ReceiverClock| {
            let ahead = ahead();
            let mut frames = frames_of(framing, receiver, &ahead);
            frames.any(|frame| {
                frame.stamp.and_then(|stamp| clock.unit.ticks(stamp)).is_some_and(|ticks| clock.has(ticks))
            })
        };
        if let Some(time_ns) = clock.time_ns(ticks, now_ns, recurs) {
            self.now_ns = time_ns;
        }
    }

    /// Starts the clock of a receiver with its first frame.
    fn begin(&mut self, frame: &AdsbFrame, ahead: &[u8]) {
        let judged = || {
            let ahead = frames_of(self.framing, self.receiver, ahead);
            // If undetermined, the unit of another receiver is used.
            let another = || self.clocks.values().next_back().map(|clock| clock.unit);
            Unit::judged(std::iter::once(*frame).chain(ahead)).or_else(another)
        };
        let unit = match (self.stamps, judged) {
            (StampKind::Counter, _) => Unit::Counter,
            (StampKind::Auto, judged) => judged().unwrap_or(Unit::Counter),
            (StampKind::Gps, judged) => {
                let unit = judged().filter(|unit| matches!(unit, Unit::Gps { .. }));
                unit.unwrap_or(Unit::Gps { ahead_ns: 0 })
            }
        };
        if self.clocks.len() == RECEIVERS_MOST {
            self.clocks.clear();
        }
        self.clocks.insert(self.receiver, ReceiverClock::new(unit));
        if let Some(ticks) = frame.stamp.and_then(|stamp| unit.ticks(stamp)) {
            self.begin_counter(ticks);
        }
    }

    /// Takes the first stamp of a receiver.
    fn begin_counter(&mut self, ticks: i64) {
        let is_first = self.clocks.values().all(ReceiverClock::is_new);
        let others = self.clocks.values();
        let shared = others.filter(|clock| clock.unit == Unit::Counter).find_map(|clock| {
            let time_ns = clock.time_near(ticks, SHARED_NS)?;
            (time_ns.abs_diff(self.now_ns) <= SHARED_NS.unsigned_abs()).then_some(time_ns)
        });
        let start_ns = self.start.map(Time::since_midnight);
        let Some(clock) = self.clocks.get_mut(&self.receiver) else { return };
        let first_ns = match (clock.unit, start_ns) {
            (Unit::Counter, _) => shared.unwrap_or(self.now_ns),
            // The time of day is exact; the file's name states the day.
            (Unit::Gps { .. }, None) if is_first => ticks,
            (Unit::Gps { .. }, start_ns) => gps_first_ns(ticks, start_ns.unwrap_or(0), self.now_ns),
        };
        clock.begin(ticks, first_ns);
        self.now_ns = first_ns;
    }
}

/// Frames of one receiver in these octets, which begin with one of its frames.
fn frames_of(
    framing: ReceiverFraming,
    receiver: Option<ReceiverId>,
    octets: &[u8],
) -> impl Iterator<Item = AdsbFrame> + '_ {
    let mut deframer = Deframer::new(framing);
    let mut current = receiver;
    octets.iter().filter_map(move |octet| {
        let Some(StreamPart::Frame(frame)) = deframer.take(*octet) else { return None };
        if let ModeSMessage::ReceiverId(named) = frame.message {
            current = Some(named);
            return None;
        }
        (current == receiver).then_some(frame)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(stamp: Option<u64>) -> AdsbFrame {
        AdsbFrame { stamp, message: ModeSMessage::ModeAc }
    }

    fn gps(seconds: u64, ns: u64) -> u64 {
        seconds << NANOS_BITS | ns
    }

    /// A recording in AVR of positions of one aircraft with these stamps.
    fn recording(stamps: impl IntoIterator<Item = u64>) -> Vec<u8> {
        let line = |stamp| format!("@{stamp:012x}8d40058b58c901375147efd09357;\n");
        stamps.into_iter().map(line).collect::<String>().into_bytes()
    }

    #[test]
    fn counter_wraps_and_single_stray_is_ignored() {
        let mut clock = StampClock::new(ReceiverFraming::Avr, None);
        let mut at = |stamp| clock.time(&frame(stamp), Vec::new).nanos();
        let second = STAMP_HZ as u64;
        assert_eq!(at(Some((1 << 48) - second)), 0);
        assert_eq!(at(Some(second)), 2 * SECOND);
        assert_eq!(at(Some(second / 2)), 3 * SECOND / 2);
        assert_eq!(at(None), 3 * SECOND / 2);
        assert_eq!(at(Some(7_000 * second)), 3 * SECOND / 2);
        assert_eq!(at(Some(3 * second)), 4 * SECOND);
        // A pause: two stamps that agree.
        assert_eq!(at(Some(7_000 * second)), 4 * SECOND);
        assert_eq!(at(Some(7_001 * second)), 7_002 * SECOND);
    }

    /// Times of frames, in seconds. Each frame has a receiver (0: not named), and a stamp in seconds of its counter.
    fn times(frames: &[(u128, f64)]) -> Vec<f64> {
        let octets = |(receiver, seconds): &(u128, f64)| {
            let stamp = (seconds * STAMP_HZ as f64) as u64;
            let id = [&[0x1a, 0xe3][..], &receiver.to_be_bytes()[8..]].concat();
            let frame = [&[0x1a, b'1'][..], &stamp.to_be_bytes()[2..], &[0x80, 1, 2]].concat();
            if *receiver == 0 { frame } else { [id, frame].concat() }
        };
        let octets: Vec<u8> = frames.iter().flat_map(octets).collect();
        let (mut clock, mut deframer) =
            (StampClock::new(ReceiverFraming::Beast, None), Deframer::new(ReceiverFraming::Beast));
        let taken = octets.iter().enumerate().filter_map(|(at, octet)| {
            let Some(StreamPart::Frame(frame)) = deframer.take(*octet) else { return None };
            let time = clock.time(&frame, || octets[at + 1..].to_vec());
            frame.stamp.map(|_| time.nanos() as f64 / SECOND as f64)
        });
        taken.collect()
    }

    #[test]
    fn named_receivers_have_a_time_base_each() {
        let frames = [(1, 5000.0), (2, 80.0), (1, 5001.0), (2, 81.0), (2, 82.0), (1, 5002.0)];
        assert_eq!(times(&frames), [0.0, 0.0, 1.0, 1.0, 2.0, 2.0]);
        // Two outputs that share a counter keep it.
        assert_eq!(times(&[(1, 5000.0), (2, 5000.5), (1, 5001.0)]), [0.0, 0.5, 1.0]);
    }

    #[test]
    fn merged_receivers_without_ids_keep_the_time() {
        let pairs = [5000.0, 5000.5, 80.0, 80.5, 5001.0, 5001.5, 81.0, 81.5, 5002.0];
        let found = times(&pairs.map(|seconds| (0, seconds)));
        // The first stamp of another counter is not accepted yet.
        assert_eq!(found, [0.0, 0.5, 0.5, 0.5, 1.0, 1.5, 1.0, 1.5, 2.0]);
        let (ahead, found) = ([80.0, 80.5, 5000.0, 5000.5, 81.0, 5001.0], [0.0, 0.5, 0.5, 0.5, 1.0, 1.0]);
        assert_eq!(times(&ahead.map(|seconds| (0, seconds))), found, "no pause");
        let turns = [5000.0, 80.0, 5000.5, 80.5, 5001.0, 81.0];
        assert_eq!(times(&turns.map(|seconds| (0, seconds))), [0.0, 0.0, 0.5, 0.5, 1.0, 1.0]);
    }

    #[test]
    fn counter_that_begins_again_does_not_go_back() {
        let restarted = [5000.0, 5001.0, 2.0, 3.0, 4.0];
        assert_eq!(times(&restarted.map(|seconds| (0, seconds))), [0.0, 1.0, 1.0, 1.0, 2.0]);
        let paused = [5000.0, 5001.0, 9000.0, 9001.0];
        assert_eq!(times(&paused.map(|seconds| (0, seconds))), [0.0, 1.0, 1.0, 4001.0]);
    }

    #[test]
    fn gps_stamps_keep_their_time_of_day_over_midnight() {
        let start = "2022-06-22T23:59:58Z".parse::<jiff::Timestamp>().unwrap();
        let start = Time::from_nanos(i64::try_from(start.as_nanosecond()).unwrap());
        let mut clock = StampClock::new(ReceiverFraming::Avr, Some(start));
        clock.set_stamps(StampKind::Gps);
        let mut at = |stamp| clock.time(&frame(Some(stamp)), Vec::new).to_string();
        assert_eq!(at(gps(86_395, 500_000_000)), "2022-06-22T23:59:55.500Z");
        assert_eq!(at(gps(86_399, 999_000_000)), "2022-06-22T23:59:59.999Z");
        assert_eq!(at(gps(1, 0)), "2022-06-23T00:00:01.000Z");
        // Not a valid nanosecond: the stamp before is used.
        assert_eq!(at(gps(1, 1_000_000_000)), "2022-06-23T00:00:01.000Z");
    }

    #[test]
    fn unit_is_judged_by_gaps_between_positions() {
        let judged = |octets: &[u8]| Unit::judged(frames_of(ReceiverFraming::Avr, None, octets));
        let half = 500_000_000;
        let as_gps: Vec<u64> = (0..20).map(|count| gps(70_000 + count / 2, count % 2 * half)).collect();
        assert_eq!(judged(&recording(as_gps.clone())), Some(Unit::Gps { ahead_ns: 0 }));
        assert_eq!(judged(&recording(as_gps[..8].iter().copied())), None, "too few");
        let counted = (0..20).map(|count| gps(70_000, 0) + count * 6_000_000);
        assert_eq!(judged(&recording(counted)), Some(Unit::Counter));
        let no_nanos = as_gps.iter().copied().chain([gps(70_011, SECOND as u64)]);
        assert_eq!(judged(&recording(no_nanos)), Some(Unit::Counter), "a stamp that cannot be GPS time");
    }

    #[test]
    fn unit_follows_the_status_frame() {
        let status = |first: u8, third: u8| {
            let head = [&[0x1a, b'4'][..], &[0; 7], &[first, 0, third], &[0; 11]].concat();
            Unit::judged(frames_of(ReceiverFraming::Beast, None, &head)).unwrap()
        };
        assert_eq!(status(0, 0), Unit::Counter);
        assert_eq!(status(STATUS_GPS, STATUS_UTC), Unit::Gps { ahead_ns: 0 });
        assert_eq!(status(STATUS_GPS, 0), Unit::Gps { ahead_ns: SECOND });
        assert_eq!(Unit::Gps { ahead_ns: SECOND }.ticks(gps(0, 5)), Some(DAY - SECOND + 5));
    }
}
