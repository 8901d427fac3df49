//! The findings of a survey, as plain values that serialise to JSON.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddr};

use serde::{Serialize, Serializer};

use super::Endpoints;
use super::presence::nanos_between;
use crate::capture::Gaps;
use fusion::time::{SECOND, Time};

/// A whole capture.
#[derive(Clone, Debug, Serialize)]
pub struct SurveyReport {
    /// UDP datagrams, or data blocks of a file without reception times.
    pub datagrams: u64,
    /// Their octets, without link, IP and UDP headers.
    pub octets: u64,
    /// Copies of a datagram received at most 2 s before, as from redundant lines; counted like others everywhere else.
    pub copies: u64,
    /// First to last reception, or time of day in a file without reception times.
    pub span: Option<Span>,
    /// Streams, by address.
    pub streams: Vec<StreamReport>,
    /// Datagrams of streams beyond [`super::STREAMS`].
    pub datagrams_of_more_streams: u64,
    /// Sources, by category, SAC and SIC.
    pub sources: Vec<SourceReport>,
    /// Records of sources beyond [`super::SOURCES`].
    pub records_of_more_sources: u64,
    /// Categories.
    pub categories: Vec<CategoryReport>,
    /// The editions of CAT021 that its sources follow.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub editions: Vec<EditionReport>,
    /// Sources most of whose blocks cannot be read in the usual edition of their category.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub misread: Vec<MisreadReport>,
    /// What there is of Remote ID.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote_id: Option<RemoteIdReport>,
    /// Errors, by category and kind.
    pub errors: Vec<ErrorReport>,
    /// The octets that stay unread because of them.
    pub unread: Gaps,
    /// Radars and transponder receivers, as a configuration would list them.
    pub sensors: Vec<SensorHint>,
}

impl SurveyReport {
    /// Number of errors.
    pub fn error_count(&self) -> u64 {
        self.errors.iter().map(|error| error.count).sum()
    }
}

/// Messages of Remote ID, by type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[expect(missing_docs, reason = "the types of the standard")]
pub struct RemoteIdReport {
    /// Transmitters.
    pub transmitters: u64,
    /// Datagrams of transmitters beyond [`super::TRANSMITTERS`].
    pub messages_of_more_transmitters: u64,
    pub basic_id: u64,
    pub location: u64,
    pub authentication: u64,
    pub self_id: u64,
    pub system: u64,
    pub operator_id: u64,
}

/// A stretch of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Span {
    /// `reception`, or `time of day`.
    pub of: &'static str,
    /// The first time.
    pub first: Stamp,
    /// The last time.
    pub last: Stamp,
    /// From first to last, over midnights.
    #[serde(rename = "duration_s", serialize_with = "as_seconds")]
    pub duration_ns: i64,
    /// How often the clock of reception went back by more than 1 s.
    pub steps_back: u64,
}

fn as_seconds<S: Serializer>(nanos: &i64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(seconds(*nanos))
}

/// A time whose day is known, or only a time of day: `2026-06-20T23:59:30.132Z` or `23:59:30.132`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// When; counted from an arbitrary midnight where `dated` is not set.
    pub time: Time,
    /// Whether the day is known.
    pub dated: bool,
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.dated {
            return self.time.fmt(f);
        }
        let millis = self.time.since_midnight() / (SECOND / 1000);
        let (seconds, millis) = (millis / 1000, millis % 1000);
        write!(f, "{:02}:{:02}:{:02}.{millis:03}", seconds / 3600, seconds / 60 % 60, seconds % 60)
    }
}

impl Serialize for Stamp {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Datagrams from one address to another.
#[derive(Clone, Debug, Serialize)]
pub struct StreamReport {
    /// Address and port that sends.
    pub source: SocketAddr,
    /// Address and port that it goes to.
    pub destination: SocketAddr,
    /// How many.
    pub datagrams: u64,
    /// What they carry, octets.
    pub octets: u64,
    /// Rate between its first and last.
    pub datagrams_per_s: Option<f64>,
    /// When the first was received.
    pub first: Option<Stamp>,
    /// When the last was received.
    pub last: Option<Stamp>,
    /// Categories of its blocks.
    pub categories: Vec<u8>,
}

/// Records of one category from one SAC/SIC.
#[derive(Clone, Debug, Serialize)]
pub struct SourceReport {
    /// Their category.
    pub category: u8,
    /// System area code; `None` of records that do not say who reports.
    pub sac: Option<u8>,
    /// System identification code.
    pub sic: Option<u8>,
    /// How many.
    pub records: u64,
    /// Their octets, FSPEC included and block headers not.
    pub octets: u64,
    /// Share of all records that were read, 0 to 1.
    pub share: f64,
    /// Between the first and the last.
    pub records_per_s: Option<f64>,
    /// The first; strays among undated times of day do not count.
    pub first: Option<Stamp>,
    /// The last.
    pub last: Option<Stamp>,
    /// What identifies targets in them.
    pub followed: Option<Followed>,
    /// From one report to the next.
    pub interval: Option<Interval>,
    /// Silences.
    pub silences: Option<Silences>,
    /// From the time of day in a record to its reception, modulo 24 h.
    pub delay: Option<Delay>,
    /// Records without a time of day.
    pub without_time: u64,
    /// Times of day of 24 h or more.
    pub out_of_range: u64,
    /// Times of day more than a minute from those before and after; only without reception times.
    pub strays: u64,
    /// Backward steps: by more than 1 s of reception time, or by more than a minute of time of day.
    pub steps_back: u64,
    /// Number of records with each item, in the order of the record.
    pub items: Items,
    /// The first eight streams that carry them.
    #[serde(skip)]
    pub lines: Vec<Endpoints>,
}

/// Number of different tracks or serial numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Followed {
    /// `track` (I048/161) or `serial` (I129/040).
    pub of: &'static str,
    /// How many.
    pub count: usize,
    /// Whether the count stopped there.
    pub or_more: bool,
}

/// Median interval between reports, by the times of day in them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Between reports of the same `track` or `serial`, or of any `record` where the source has neither.
    pub of: &'static str,
    /// Seconds; exact for a steady source, else to 3 %.
    pub median_s: f64,
}

/// The times between a record of a source and the next one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Silences {
    /// A silence above this is a gap: five times what is usual, and at least a second. Seconds.
    pub gap_above_s: f64,
    /// How many gaps, to 3 % of that limit.
    pub gaps: u64,
    /// Seconds.
    pub longest_s: f64,
    /// When the longest began.
    pub longest_from: Stamp,
}

/// From the time of day in a record to its reception, seconds; negative where the record is ahead.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Delay {
    /// The least.
    pub min_s: f64,
    /// To 3 %.
    pub median_s: f64,
    /// 99 of 100 are not longer; to 3 %.
    pub p99_s: f64,
    /// The greatest.
    pub max_s: f64,
}

/// Number of records with each item, by item number. An object in JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Items(pub Vec<(&'static str, u64)>);

impl Items {
    /// Number of records with this item.
    pub fn count(&self, number: &str) -> u64 {
        self.0.iter().find(|(item, _)| *item == number).map_or(0, |(_, count)| *count)
    }
}

impl Serialize for Items {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().copied())
    }
}

/// Blocks of one category.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CategoryReport {
    /// Its number.
    pub category: u8,
    /// What EUROCONTROL calls it, where that is known here.
    pub name: Option<&'static str>,
    /// Whole blocks.
    pub blocks: u64,
    /// Octets of the blocks, CAT and LEN included.
    pub octets: u64,
    /// Records that were read; `None` if the category is not decoded.
    pub records: Option<u64>,
}

/// The edition of CAT021 that a source follows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EditionReport {
    /// System area code, if the records have one.
    pub sac: Option<u8>,
    /// System identification code, if the records have one.
    pub sic: Option<u8>,
    /// The edition that fits best; `None` where all that are known do.
    pub edition: Option<&'static str>,
    /// Whether later editions fit as well.
    pub or_later: bool,
    /// Blocks.
    pub blocks: u64,
    /// Those that cannot be read in that edition.
    pub unreadable: u64,
    /// Those that cannot be read in the editions that lay octets out differently.
    pub unreadable_otherwise: u64,
}

/// A source most of whose blocks cannot be read in the usual edition of their category.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MisreadReport {
    /// Category.
    pub category: u8,
    /// System area code, if the blocks seem to have one.
    pub sac: Option<u8>,
    /// System identification code, if the blocks seem to have one.
    pub sic: Option<u8>,
    /// Blocks.
    pub blocks: u64,
    /// Blocks that cannot be read, or hold times of day that do not exist.
    pub misread: u64,
    /// The editions that can read them; none: another edition, or another format.
    pub read_in: Vec<&'static str>,
    /// The editions that are known, the oldest first.
    pub known: Vec<&'static str>,
}

/// Errors of one kind.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ErrorReport {
    /// [`asterix::FaultKind::name`], or `skipped`: octets that belong to no block.
    pub kind: &'static str,
    /// Category, where there was one.
    pub category: Option<u8>,
    /// How many.
    pub count: u64,
    /// Offset in the file of the first one.
    pub first_offset: u64,
    /// Item of the first one, where the error is in an item.
    pub first_item: Option<&'static str>,
    /// What is wrong.
    pub detail: String,
}

/// A sensor as a configuration would have it, with the names of its keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SensorHint {
    /// `radar`, `transponder`, `adsb` or `remote-id`.
    pub kind: &'static str,
    /// System area code.
    pub sac: u8,
    /// System identification code.
    pub sic: u8,
    /// Between two reports of one target, seconds.
    pub period_s: Option<f64>,
    /// Where a radar says how likely a target is a UAV, as its items suggest.
    pub classification: Option<&'static str>,
    /// The edition of CAT021 that fits best; `None` where several do.
    pub edition: Option<&'static str>,
    /// What to listen on.
    pub inputs: Vec<LineHint>,
}

/// An input of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct LineHint {
    /// Whether `address` is a group.
    pub multicast: bool,
    /// Where the datagrams go to.
    pub address: Ipv4Addr,
    /// UDP port.
    pub port: u16,
}

/// Nanoseconds as seconds.
pub(super) fn seconds(nanos: i64) -> f64 {
    nanos as f64 / SECOND as f64
}

/// Rate per second of `count` events over a span; `None` if they all have the same time.
pub(super) fn rate(count: u64, span: Option<(Time, Time)>) -> Option<f64> {
    let span_ns = span.map_or(0, |(first, last)| nanos_between(first, last));
    (span_ns > 0 && count > 1).then(|| (count - 1) as f64 / seconds(span_ns))
}
