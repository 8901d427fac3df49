//! One source: the records of one category with one SAC/SIC.

use std::collections::BTreeSet;

use asterix::all::Untyped;
use asterix::{DataSource, Record, TimeOfDay, UapItem};

use super::STEP_NS;
use super::bounded::Bounded;
use super::histogram::Histogram;
use super::presence::{DOUBT_NS, Days, Presence, nanos_between};
use super::report::{Delay, Followed, Interval, Items, Silences, SourceReport, Stamp, rate, seconds};
use crate::capture::{CapturedDatagram, Endpoints};
use crate::normalise::nearest_day;
use fusion::Identity;
use fusion::time::{SECOND, Time};

/// The part of a record of any category that a survey uses.
pub(super) struct Glimpse {
    /// Items present: one bit per item of the category, the first item in the lowest bit.
    pub(super) items: u64,
    pub(super) source: Option<DataSource>,
    pub(super) time: Option<TimeOfDay>,
    /// The target, if the record identifies it.
    pub(super) target: Option<Target>,
}

impl Glimpse {
    pub(super) fn of<R: Record>(record: &R, target: Option<Target>) -> Self {
        let fspec = record.fspec();
        let has = |item: &UapItem| fspec.has(item.frn);
        let items = present(R::UAP, has);
        Self { items, source: record.data_source(), time: record.time_of_day(), target }
    }

    /// The part of a record without a type; its target is unknown.
    pub(super) fn of_untyped(record: &Untyped<'_>) -> Self {
        let has = |item: &UapItem| record.items().any(|(other, _)| other.item == item.item);
        let items = present(record.definition().items(), has);
        Self { items, source: record.data_source(), time: record.time_of_day(), target: None }
    }
}

/// The items that are present, the first one in the lowest bit.
fn present(items: &[UapItem], has: impl Fn(&UapItem) -> bool) -> u64 {
    items.iter().enumerate().fold(0, |bits, (place, item)| bits | u64::from(has(item)) << place)
}

/// Identification of a target across records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Target {
    /// Track number, I048/161.
    Track(u16),
    /// Target address, I021/080.
    Address(u32),
    /// Serial number, I129/040, trimmed.
    Serial(Identity),
}

impl Target {
    /// The target with this serial number; `None` if it is blank.
    pub(super) fn serial(octets: &[u8; 12]) -> Option<Self> {
        Identity::new(octets, None).map(Self::Serial)
    }
}

/// Maximum number of targets distinguished per source: CAT048 has 4,096 track numbers.
const TARGETS: usize = 4096;

/// Maximum number of streams named per source; more than a few redundant lines are unusual.
const LINES: usize = 8;

/// Minimum length of a gap, in usual intervals; [`GAP_NS`] applies, too.
const GAP_INTERVALS: i64 = 5;

/// Minimum length of a gap, in nanoseconds: between bursts of records every source is silent.
const GAP_NS: i64 = SECOND;

/// Counts of one source. Its size is bounded: see [`TARGETS`] and [`Histogram`].
#[derive(Clone, Debug, Default)]
pub(super) struct Source {
    records: u64,
    octets: u64,
    /// Number of records with each item of the category.
    items: Vec<u64>,
    /// Presence by times of reception; by times of day in files without these.
    presence: Presence,
    days: Days,
    delay: Histogram,
    without_time: u64,
    out_of_range: u64,
    /// Time of the latest report of each target.
    targets: Bounded<Target, Option<Time>, TARGETS>,
    /// Intervals between reports of the same target.
    intervals: Histogram,
    lines: BTreeSet<Endpoints>,
}

impl Source {
    /// Counts a record of `octets` octets in `datagram`. Returns the times that are now credible. `around`: a time of the same
    /// file for dating the first time of day.
    pub(super) fn record(
        &mut self,
        glimpse: &Glimpse,
        octets: usize,
        datagram: &CapturedDatagram,
        around: Option<Time>,
    ) -> [Option<Time>; 2] {
        self.records += 1;
        self.octets += octets as u64;
        self.items.resize(u64::BITS as usize, 0);
        for (place, count) in self.items.iter_mut().enumerate() {
            *count += glimpse.items >> place & 1;
        }
        if let Some(endpoints) = datagram.endpoints
            && self.lines.len() < LINES
        {
            self.lines.insert(endpoints);
        }
        if glimpse.time.is_none() {
            self.without_time += 1;
        }
        let received = datagram.received;
        let count = glimpse.time.map(TimeOfDay::count);
        let (time, seen) = match received {
            Some(received) => {
                let time = count.and_then(|count| nearest_day(count, received));
                if let Some(time) = time {
                    self.delay.add(nanos_between(time, received));
                }
                (time, [Some(received), None])
            }
            None => match count.and_then(|count| self.days.tell(count, around)) {
                Some((time, believed)) => (Some(time), believed),
                None => (None, [None; 2]),
            },
        };
        self.out_of_range += u64::from(count.is_some() && time.is_none());
        let tolerance_ns = if received.is_some() { STEP_NS } else { DOUBT_NS };
        for time in seen.into_iter().flatten() {
            self.presence.see(time, tolerance_ns);
        }
        self.follow(glimpse.target, time.or(received));
        seen
    }

    fn follow(&mut self, target: Option<Target>, time: Option<Time>) {
        let (Some(target), Some(time)) = (target, time) else { return };
        let Some(last) = self.targets.get(target) else { return };
        if let Some(passed_ns) = last.map(|last| nanos_between(last, time)) {
            if passed_ns > 0 {
                self.intervals.add(passed_ns);
            } else if passed_ns > -DOUBT_NS {
                return; // a copy, or out of order
            }
        }
        *last = Some(time);
    }

    /// The last time of day if it is not yet confirmed or refuted.
    pub(super) fn doubted(&self) -> Option<Time> {
        self.days.doubted
    }

    pub(super) fn report(
        &self,
        category: u8,
        source: Option<DataSource>,
        uap: &'static [UapItem],
        dated: bool,
        all_records: u64,
    ) -> SourceReport {
        let mut presence = self.presence.clone();
        if let Some(doubted) = self.days.doubted {
            presence.see(doubted, DOUBT_NS);
        }
        let stamp = |time| Stamp { time, dated };
        let followed = self.followed();
        let between_records_ns = presence.silences.quantile(0.5);
        let of_target_ns = self.intervals.quantile(0.5);
        let interval = match followed {
            Some(followed) => of_target_ns.map(|median_ns| (followed.of, median_ns)),
            None => between_records_ns.map(|median_ns| ("record", median_ns)),
        };
        let usual_ns = of_target_ns.max(between_records_ns);
        let counted = |(item, count): (&'static UapItem, &u64)| (item.item, *count);
        let items = uap.iter().zip(&self.items).map(counted).filter(|(_, count)| *count > 0);
        SourceReport {
            category,
            sac: source.map(|source| source.sac),
            sic: source.map(|source| source.sic),
            records: self.records,
            octets: self.octets,
            share: self.records as f64 / all_records.max(1) as f64,
            records_per_s: rate(self.records, presence.span()),
            first: presence.span().map(|(first, _)| stamp(first)),
            last: presence.span().map(|(_, last)| stamp(last)),
            followed,
            interval: interval.map(|(of, median_ns)| Interval { of, median_s: seconds(median_ns) }),
            silences: presence.longest.zip(usual_ns).map(|((longest_ns, from), usual_ns)| {
                let limit_ns = usual_ns.saturating_mul(GAP_INTERVALS).max(GAP_NS);
                let counted = presence.silences.longer_than(limit_ns);
                Silences {
                    gap_above_s: seconds(limit_ns),
                    gaps: counted.max(u64::from(longest_ns > limit_ns)),
                    longest_s: seconds(longest_ns),
                    longest_from: stamp(from),
                }
            }),
            delay: self.delay.range().map(|(min_ns, max_ns)| Delay {
                min_s: seconds(min_ns),
                median_s: seconds(self.delay.quantile(0.5).unwrap_or(min_ns)),
                p99_s: seconds(self.delay.quantile(0.99).unwrap_or(max_ns)),
                max_s: seconds(max_ns),
            }),
            without_time: self.without_time,
            out_of_range: self.out_of_range,
            strays: self.days.strays,
            steps_back: presence.steps_back,
            items: Items(items.collect()),
            lines: self.lines.iter().copied().collect(),
        }
    }

    fn followed(&self) -> Option<Followed> {
        let count = self.targets.len();
        let (first, _) = self.targets.iter().next()?;
        // There are no more track numbers than this limit.
        let or_more = count == TARGETS && !matches!(first, Target::Track(_));
        let of = match first {
            Target::Track(_) => "track",
            Target::Address(_) => "address",
            Target::Serial(_) => "serial",
        };
        Some(Followed { of, count, or_more })
    }
}
