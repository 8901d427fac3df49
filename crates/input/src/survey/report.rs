//! The findings of a survey, as plain values that serialise to JSON.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddr};

use serde::{Serialize, Serializer};

use super::Endpoints;
use super::presence::nanos_between;
use crate::capture::Gaps;
use fusion::time::{SECOND, Time};

/// The survey of a capture.
#[derive(Clone, Debug, Serialize)]
pub struct SurveyReport {
    /// Number of UDP datagrams, or of data blocks in a file without reception times.
    pub datagrams: u64,
    /// Octets in them, without link, IP and UDP headers.
    pub octets: u64,
    /// Copies of a datagram received at most 2 s earlier, as from redundant lines; all other figures include them.
    pub copies: u64,
    /// First to last reception, or time of day in a file without reception times.
    pub span: Option<Span>,
    /// Streams by address.
    pub streams: Vec<StreamReport>,
    /// Datagrams of streams beyond [`super::STREAMS`].
    pub datagrams_of_more_streams: u64,
    /// Sources by category, SAC and SIC.
    pub sources: Vec<SourceReport>,
    /// Records of sources beyond [`super::SOURCES`].
    pub records_of_more_sources: u64,
    /// Categories.
    pub categories: Vec<CategoryReport>,
    /// Editions of CAT021 that the sources follow.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub editions: Vec<EditionReport>,
    /// Sources most of whose blocks cannot be read in the usual edition of their category.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub misread: Vec<MisreadReport>,
    /// Remote ID messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote_id: Option<RemoteIdReport>,
    /// Errors by category and kind.
    pub errors: Vec<ErrorReport>,
    /// Octets that remain unread because of errors.
    pub unread: Gaps,
    /// Radars and receivers, as a configuration would list them.
    pub sensors: Vec<SensorHint>,
}

impl SurveyReport {
    /// Number of errors.
    pub fn error_count(&self) -> u64 {
        self.errors.iter().map(|error| error.count).sum()
    }
}

/// Numbers of Remote ID messages, by type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[expect(missing_docs, reason = "the types of the standard")]
pub struct RemoteIdReport {
    /// Number of transmitters.
    pub transmitters: u64,
    /// Datagrams, or lines of a gateway, of transmitters beyond [`super::TRANSMITTERS`].
    pub messages_of_more_transmitters: u64,
    pub basic_id: u64,
    pub location: u64,
    pub authentication: u64,
    pub self_id: u64,
    pub system: u64,
    pub operator_id: u64,
}

/// A period of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Span {
    /// The kind of time: `reception` or `time of day`.
    pub of: &'static str,
    /// First time.
    pub first: Stamp,
    /// Last time.
    pub last: Stamp,
    /// Time from first to last, over midnights.
    #[serde(rename = "duration_s", serialize_with = "as_seconds")]
    pub duration_ns: i64,
    /// Number of times the clock of reception stepped back by more than 1 s.
    pub steps_back: u64,
}

fn as_seconds<S: Serializer>(nanos: &i64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(seconds(*nanos))
}

/// A time with a known day, or only a time of day: `2026-06-20T23:59:30.132Z` or `23:59:30.132`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// The time; counted from an arbitrary midnight unless `dated`.
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

/// The datagrams from one address to another.
#[derive(Clone, Debug, Serialize)]
pub struct StreamReport {
    /// Source address and port.
    pub source: SocketAddr,
    /// Destination address and port.
    pub destination: SocketAddr,
    /// Number of datagrams.
    pub datagrams: u64,
    /// Octets of their payloads.
    pub octets: u64,
    /// Rate between the first and the last datagram.
    pub datagrams_per_s: Option<f64>,
    /// Reception of the first datagram.
    pub first: Option<Stamp>,
    /// Reception of the last datagram.
    pub last: Option<Stamp>,
    /// Categories of the blocks.
    pub categories: Vec<u8>,
}

/// The records of one category from one SAC/SIC.
#[derive(Clone, Debug, Serialize)]
pub struct SourceReport {
    /// Category.
    pub category: u8,
    /// System area code; `None` for records without a source.
    pub sac: Option<u8>,
    /// System identification code.
    pub sic: Option<u8>,
    /// Number of records.
    pub records: u64,
    /// Octets of the records, with FSPEC and without block headers.
    pub octets: u64,
    /// Share of all records read, 0 to 1.
    pub share: f64,
    /// Rate between the first and the last record.
    pub records_per_s: Option<f64>,
    /// First record, without strays among undated times of day.
    pub first: Option<Stamp>,
    /// Last record, without strays among undated times of day.
    pub last: Option<Stamp>,
    /// Identification of targets in the records.
    pub followed: Option<Followed>,
    /// Interval between reports.
    pub interval: Option<Interval>,
    /// Silences.
    pub silences: Option<Silences>,
    /// Time from the time of day in a record to its reception, modulo 24 h.
    pub delay: Option<Delay>,
    /// Number of records without a time of day.
    pub without_time: u64,
    /// Number of times of day of 24 h or more.
    pub out_of_range: u64,
    /// Number of times of day more than a minute from those before and after; only without reception times.
    pub strays: u64,
    /// Number of backward steps: more than 1 s of reception time, or more than a minute of time of day.
    pub steps_back: u64,
    /// Number of records with each item, in the order of the record.
    pub items: Items,
    /// The first eight streams with these records.
    #[serde(skip)]
    pub lines: Vec<Endpoints>,
}

/// Number of different targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Followed {
    /// The identification that is counted: `track` (I048/161), `address` (I021/080) or `serial` (I129/040).
    pub of: &'static str,
    /// Number of different values.
    pub count: usize,
    /// Whether counting stopped at this number.
    pub or_more: bool,
}

/// Median interval between reports, by their times of day.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Reports that are compared: those of the same `track`, `address` or `serial`, or any `record` without these.
    pub of: &'static str,
    /// Median, in seconds; exact for a steady source, otherwise to 3 %.
    pub median_s: f64,
}

/// Silences between consecutive records of a source.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Silences {
    /// Silence above which there is a gap, in seconds: five times the usual interval, and at least 1 s.
    pub gap_above_s: f64,
    /// Number of gaps; the limit is accurate to 3 %.
    pub gaps: u64,
    /// Longest silence, in seconds.
    pub longest_s: f64,
    /// Beginning of the longest silence.
    pub longest_from: Stamp,
}

/// Time from the time of day in a record to its reception, in seconds; negative if the record is ahead.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Delay {
    /// Minimum.
    pub min_s: f64,
    /// Median, to 3 %.
    pub median_s: f64,
    /// 99th percentile, to 3 %.
    pub p99_s: f64,
    /// Maximum.
    pub max_s: f64,
}

/// Number of records with each item, by item number; an object in JSON.
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

/// The blocks of one category.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CategoryReport {
    /// Category number.
    pub category: u8,
    /// EUROCONTROL's name, if known here.
    pub name: Option<&'static str>,
    /// Number of complete blocks.
    pub blocks: u64,
    /// Octets of the blocks, with CAT and LEN.
    pub octets: u64,
    /// Number of records read; `None` if the category is not decoded.
    pub records: Option<u64>,
}

/// The edition of CAT021 that a source follows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EditionReport {
    /// System area code, if the records have one.
    pub sac: Option<u8>,
    /// System identification code, if the records have one.
    pub sic: Option<u8>,
    /// The edition that fits best; `None` if all known editions fit.
    pub edition: Option<&'static str>,
    /// Whether later editions fit as well.
    pub or_later: bool,
    /// Number of blocks.
    pub blocks: u64,
    /// Number of errors in that edition.
    pub unreadable: u64,
    /// Number of errors in the editions with another layout.
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
    /// Number of blocks.
    pub blocks: u64,
    /// Number of blocks that cannot be read or have invalid times of day.
    pub misread: u64,
    /// Editions in which the blocks can be read; if there are none, the blocks have another edition or format.
    pub read_in: Vec<&'static str>,
    /// Known editions, oldest first.
    pub known: Vec<&'static str>,
}

/// Errors of one kind.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ErrorReport {
    /// [`asterix::FaultKind::name`], or `skipped` for octets outside of any block.
    pub kind: &'static str,
    /// Category, if known.
    pub category: Option<u8>,
    /// Number of errors.
    pub count: u64,
    /// Offset of the first error in the file.
    pub first_offset: u64,
    /// Item of the first error, if it is in an item.
    pub first_item: Option<&'static str>,
    /// Description of the first error.
    pub detail: String,
}

/// A sensor for a configuration; the fields have the names of its keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SensorHint {
    /// `radar`, `transponder`, `adsb` or `remote-id`.
    pub kind: &'static str,
    /// System area code.
    pub sac: u8,
    /// System identification code.
    pub sic: u8,
    /// Interval between two reports of one target, in seconds.
    pub period_s: Option<f64>,
    /// Item with which the radar states the UAV probability, as far as the records show.
    pub classification: Option<&'static str>,
    /// The edition of CAT021 that fits best; `None` if several fit.
    pub edition: Option<&'static str>,
    /// Inputs to listen on.
    pub inputs: Vec<LineHint>,
}

/// An input of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct LineHint {
    /// Whether `address` is a multicast group.
    pub multicast: bool,
    /// Destination address of the datagrams.
    pub address: Ipv4Addr,
    /// UDP port.
    pub port: u16,
}

/// Nanoseconds in seconds.
pub(super) fn seconds(nanos: i64) -> f64 {
    nanos as f64 / SECOND as f64
}

/// Rate of `count` events over a span, per second; `None` if all have the same time.
pub(super) fn rate(count: u64, span: Option<(Time, Time)>) -> Option<f64> {
    let span_ns = span.map_or(0, |(first, last)| nanos_between(first, last));
    (span_ns > 0 && count > 1).then(|| (count - 1) as f64 / seconds(span_ns))
}
