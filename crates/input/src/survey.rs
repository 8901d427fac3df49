//! A survey of a capture: sources, their amount of data, timing and errors. No I/O, no clock: datagrams in, [`SurveyReport`] out.
//!
//! Memory does not grow with the capture: streams, sources and targets are kept in bounded maps whose overflow is counted, and
//! medians are taken from histograms with bins of 3 %.
//!
//! Times are times of reception. Without these they are the times of day in the records, followed over midnight, without single
//! strays.

mod bounded;
mod categories;
mod editions;
mod hints;
mod histogram;
mod misread;
mod presence;
mod report;
mod source;
mod truncated;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use asterix::all::Untyped;
use asterix::{
    Block, DataSource, Fault, Located, Record, TimeOfDay, UapItem, blocks, cat015, cat021, cat034, cat048,
    cat062, cat063, cat065, cat129,
};

use crate::capture::{CapturedDatagram, Endpoints, Gaps, PayloadKind};
use crate::gateways::remote_id::{BroadcastLine, is_broadcast, is_lines, lines};
use crate::json::{REMOTE_ID, SKIPPED};
use crate::pipeline::{Duplicates, LineFault};
use bounded::Bounded;
use editions::Editions;
use fusion::time::{SECOND, Time};
use misread::Misread;
use presence::{DOUBT_NS, Presence, nanos_between};
use report::rate;
use source::{Glimpse, Source, Target};

pub use report::{
    CategoryReport, Delay, EditionReport, ErrorReport, Followed, Interval, Items, LineHint, MisreadReport,
    RemoteIdReport, SensorHint, Silences, SourceReport, Span, Stamp, StreamReport, SurveyReport,
};

/// Maximum number of streams that are distinguished.
pub const STREAMS: usize = 1024;

/// Maximum number of Remote ID transmitters that are distinguished.
pub const TRANSMITTERS: usize = 4096;

/// Maximum number of sources that are distinguished; one may take half a megabyte.
pub const SOURCES: usize = 256;

/// CAT001, target reports of old radars, and CAT002, their service messages. Only the latter have a complete time of day.
const OLD_REPORTS: u8 = 1;
const OLD_SERVICE: u8 = 2;

/// Maximum backward step of the reception time that is not reported, in nanoseconds.
const STEP_NS: i64 = SECOND;

/// Surveys datagrams.
#[derive(Debug, Default)]
pub struct Survey {
    datagrams: u64,
    octets: u64,
    recent: Duplicates,
    copies: u64,
    /// Presence by times of reception, or by credible times of day.
    span: Presence,
    dated: bool,
    streams: Bounded<Endpoints, Stream, STREAMS>,
    datagrams_of_more_streams: u64,
    sources: Bounded<(u8, Option<DataSource>), Source, SOURCES>,
    records_of_more_sources: u64,
    categories: BTreeMap<u8, Category>,
    editions: Editions,
    misread: Misread,
    /// Latest time of each source of CAT002.
    north_times: Bounded<Option<DataSource>, Option<TimeOfDay>, SOURCES>,
    transmitters: Bounded<String, (), TRANSMITTERS>,
    remote_id: RemoteIdReport,
    errors: BTreeMap<(Option<u8>, &'static str), ErrorReport>,
    unread: Gaps,
}

#[derive(Clone, Debug, Default)]
struct Stream {
    datagrams: u64,
    octets: u64,
    span: Option<(Time, Time)>,
    categories: BTreeSet<u8>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Category {
    blocks: u64,
    octets: u64,
    records: Option<u64>,
    items: &'static [UapItem],
}

impl Survey {
    /// Counts a datagram, a data block of a raw file, or octets outside of any block.
    pub fn datagram(&mut self, datagram: &CapturedDatagram) {
        if datagram.contents == PayloadKind::Unframed {
            self.unread.add(datagram.origin, datagram.payload.len());
            let detail = "octets belong to no block";
            return self.error(SKIPPED, None, None, datagram.origin, || detail.to_owned());
        }
        self.datagrams += 1;
        self.octets += (datagram.payload.len() + datagram.trailer.len()) as u64;
        if let Some(received) = datagram.received {
            self.dated = true;
            self.span.see(received, STEP_NS);
            let now = self.span.span().map_or(received, |(_, last)| last);
            self.copies += u64::from(self.recent.is_repeated(&datagram.payload, now));
        }
        if let Some(endpoints) = datagram.endpoints {
            match self.streams.get(endpoints) {
                Some(stream) => stream.datagram(datagram),
                None => self.datagrams_of_more_streams += 1,
            }
        }
        if datagram.may_be_remote_id() && (is_lines(&datagram.payload) || is_broadcast(&datagram.payload)) {
            return self.remote_id(datagram);
        }
        for block in blocks(&datagram.payload) {
            match block {
                Ok(block) => self.block(block, datagram),
                Err(fault) => self.fault(fault, datagram, fault.offset..datagram.payload.len()),
            }
        }
    }

    /// Counts the Remote ID messages of a datagram.
    fn remote_id(&mut self, datagram: &CapturedDatagram) {
        let payload = &datagram.payload;
        if is_broadcast(payload) {
            let transmitter = datagram.endpoints.map_or("unknown".to_owned(), |of| of.source.to_string());
            return self.messages(transmitter, payload, datagram);
        }
        for line in lines(payload) {
            match BroadcastLine::parse(line) {
                Ok(line) => self.messages(line.transmitter, &line.octets, datagram),
                Err(refusal) => self
                    .error(REMOTE_ID, None, None, datagram.origin, || LineFault::from(refusal).to_string()),
            }
        }
    }

    fn messages(&mut self, transmitter: String, octets: &[u8], datagram: &CapturedDatagram) {
        if self.transmitters.get(transmitter).is_none() {
            self.remote_id.messages_of_more_transmitters += 1;
        }
        for message in remote_id::messages(octets) {
            let of = &mut self.remote_id;
            match message {
                Ok(message) => {
                    *match message {
                        remote_id::Message::BasicId(_) => &mut of.basic_id,
                        remote_id::Message::Location(_) => &mut of.location,
                        remote_id::Message::Authentication(_) => &mut of.authentication,
                        remote_id::Message::SelfId(_) => &mut of.self_id,
                        remote_id::Message::System(_) => &mut of.system,
                        remote_id::Message::OperatorId(_) => &mut of.operator_id,
                    } += 1;
                }
                Err(fault) => self.error(REMOTE_ID, None, None, datagram.origin, || fault.to_string()),
            }
        }
    }

    /// Counts a block; each category with typed records has a line here.
    fn block(&mut self, block: Block<'_>, datagram: &CapturedDatagram) {
        let category = self.categories.entry(block.category).or_default();
        category.blocks += 1;
        category.octets += block.octets.len() as u64;
        let is_misread = self.contents(block, datagram);
        self.misread.block(block, is_misread);
    }

    /// Counts the records of a block. Returns whether one of them cannot be read or has an invalid time of day.
    fn contents(&mut self, block: Block<'_>, datagram: &CapturedDatagram) -> bool {
        match block.category {
            15 => self.read(block, (), datagram, |record: &cat015::Record| {
                record.number.map(|number| Target::Track(number.number()))
            }),
            21 => {
                let edition = self.editions.block(block);
                self.read(block, edition, datagram, |record: &cat021::Record| {
                    record.target_address.map(|address| Target::Address(address.address()))
                })
            }
            34 => self.read(block, (), datagram, |_: &cat034::Record| None),
            48 => self.read(block, (), datagram, |record: &cat048::Record| {
                record.track_number.map(|number| Target::Track(number.number()))
            }),
            62 => self.read(block, (), datagram, |record: &cat062::Record| {
                record.track_number.map(|number| Target::Track(number.number()))
            }),
            63 => self.read(block, (), datagram, |_: &cat063::Record| None),
            65 => self.read(block, (), datagram, |_: &cat065::Record| None),
            129 => self.read(block, (), datagram, |record: &cat129::Record| {
                record.serial_number.as_ref().and_then(Target::serial)
            }),
            // Other categories are read in their newest edition.
            other => {
                let Some(category) = asterix::all::category(other) else { return false };
                let definition = category.newest();
                let around = self.north_time(block.first_source(), datagram);
                let glimpse = |record: &Untyped<'_>| {
                    let glimpse = Glimpse::of_untyped(record);
                    let is_old = other == OLD_REPORTS;
                    let time = around.filter(|_| is_old).and_then(|around| truncated::time(record, around));
                    Glimpse { time: glimpse.time.or(time), ..glimpse }
                };
                let records = definition.records(block);
                self.records(block, definition.items(), records, datagram, glimpse)
            }
        }
    }

    /// A time near those of a CAT001 source: of its last CAT002 record, or else of the reception.
    fn north_time(&mut self, source: Option<DataSource>, datagram: &CapturedDatagram) -> Option<TimeOfDay> {
        let received = || {
            let count = datagram.received?.since_midnight() * i64::from(TimeOfDay::PER_SECOND) / SECOND;
            TimeOfDay::from_count(count as u32)
        };
        self.north_times.get(source).and_then(|time| *time).or_else(received)
    }

    /// Counts the records of a block by source.
    fn read<R: Record>(
        &mut self,
        block: Block<'_>,
        edition: R::Edition,
        datagram: &CapturedDatagram,
        target: impl Fn(&R) -> Option<Target>,
    ) -> bool {
        let glimpse = |record: &R| Glimpse::of(record, target(record));
        self.records(block, R::UAP, block.records_in::<R>(edition), datagram, glimpse)
    }

    /// Counts records of a category with these items.
    fn records<T>(
        &mut self,
        block: Block<'_>,
        items: &'static [UapItem],
        located: impl Iterator<Item = Result<Located<T>, Fault>>,
        datagram: &CapturedDatagram,
        glimpse: impl Fn(&T) -> Glimpse,
    ) -> bool {
        let (mut records, mut is_misread) = (0, false);
        let end = block.offset + block.octets.len();
        let mut next = end - block.contents().len();
        for located in located {
            match located {
                Ok(located) => {
                    records += 1;
                    next = located.offset + located.length;
                    let glimpse = glimpse(&located.record);
                    is_misread |= glimpse.time.is_some_and(|time| time.count() > TimeOfDay::PER_DAY);
                    self.record(block.category, &glimpse, located.length, datagram);
                }
                Err(fault) => {
                    is_misread = true;
                    self.fault(fault, datagram, next..end);
                }
            }
        }
        let category = self.categories.entry(block.category).or_default();
        category.items = items;
        *category.records.get_or_insert(0) += records;
        is_misread
    }

    fn record(&mut self, category: u8, glimpse: &Glimpse, octets: usize, datagram: &CapturedDatagram) {
        if category == OLD_SERVICE
            && let Some(time) = glimpse.time
            && let Some(north) = self.north_times.get(glimpse.source)
        {
            *north = Some(time);
        }
        let around = self.span.span().map(|(_, last)| last);
        let Some(source) = self.sources.get((category, glimpse.source)) else {
            self.records_of_more_sources += 1;
            return;
        };
        let seen = source.record(glimpse, octets, datagram, around);
        if datagram.received.is_none() {
            seen.into_iter().flatten().for_each(|time| self.span.see(time, DOUBT_NS));
        }
    }

    /// Counts an error and the octets that remain unread because of it.
    fn fault(&mut self, fault: Fault, datagram: &CapturedDatagram, unread: Range<usize>) {
        self.unread.add(datagram.origin + unread.start as u64, unread.len());
        let first_offset = datagram.origin + fault.offset as u64;
        let detail = || fault.kind.to_string();
        self.error(fault.kind.name(), fault.category, fault.item, first_offset, detail);
    }

    fn error(
        &mut self,
        kind: &'static str,
        category: Option<u8>,
        first_item: Option<&'static str>,
        first_offset: u64,
        detail: impl Fn() -> String,
    ) {
        let error = self.errors.entry((category, kind)).or_insert_with(|| ErrorReport {
            kind,
            category,
            count: 0,
            first_offset,
            first_item,
            detail: detail(),
        });
        error.count += 1;
    }

    /// The findings so far.
    pub fn report(&self) -> SurveyReport {
        let dated = self.dated;
        let all_records = self.categories.values().filter_map(|category| category.records).sum();
        let source = |(&(category, source), counts): (&(u8, Option<DataSource>), &Source)| {
            let uap = self.categories.get(&category).map_or(&[][..], |category| category.items);
            counts.report(category, source, uap, dated, all_records)
        };
        let sources: Vec<_> = self.sources.iter().map(source).collect();
        let misread = self.misread.report();
        let is_older = |fit: &EditionReport| {
            misread
                .iter()
                .any(|of| (of.category, of.sac, of.sic) == (cat021::Record::CATEGORY, fit.sac, fit.sic))
        };
        let editions: Vec<EditionReport> =
            self.editions.report().into_iter().filter(|fit| !is_older(fit)).collect();
        SurveyReport {
            datagrams: self.datagrams,
            octets: self.octets,
            copies: self.copies,
            span: self.span(),
            streams: self.streams.iter().map(|(endpoints, stream)| stream.report(*endpoints)).collect(),
            datagrams_of_more_streams: self.datagrams_of_more_streams,
            sensors: hints::sensors(&sources, &editions, self.transmitters.len() > 0),
            sources,
            records_of_more_sources: self.records_of_more_sources,
            categories: self
                .categories
                .iter()
                .map(|(&category, counts)| CategoryReport {
                    category,
                    name: categories::name(category),
                    blocks: counts.blocks,
                    octets: counts.octets,
                    records: counts.records,
                })
                .collect(),
            editions,
            misread,
            remote_id: (self.transmitters.len() > 0)
                .then(|| RemoteIdReport { transmitters: self.transmitters.len() as u64, ..self.remote_id }),
            errors: self.errors.values().cloned().collect(),
            unread: self.unread.clone(),
        }
    }

    fn span(&self) -> Option<Span> {
        let mut span = self.span.clone();
        if !self.dated {
            let doubted = self.sources.iter().filter_map(|(_, source)| source.doubted());
            doubted.for_each(|time| span.see(time, DOUBT_NS));
        }
        let (first, last) = span.span()?;
        Some(Span {
            of: if self.dated { "reception" } else { "time of day" },
            first: Stamp { time: first, dated: self.dated },
            last: Stamp { time: last, dated: self.dated },
            duration_ns: nanos_between(first, last),
            steps_back: if self.dated { span.steps_back } else { 0 },
        })
    }
}

impl Stream {
    fn datagram(&mut self, datagram: &CapturedDatagram) {
        self.datagrams += 1;
        self.octets += (datagram.payload.len() + datagram.trailer.len()) as u64;
        if let Some(received) = datagram.received {
            let (first, last) = self.span.unwrap_or((received, received));
            self.span = Some((first.min(received), last.max(received)));
        }
        self.categories.extend(blocks(&datagram.payload).flatten().map(|block| block.category));
    }

    fn report(&self, endpoints: Endpoints) -> StreamReport {
        let stamp = |time| Stamp { time, dated: true };
        StreamReport {
            source: endpoints.source,
            destination: endpoints.destination,
            datagrams: self.datagrams,
            octets: self.octets,
            datagrams_per_s: rate(self.datagrams, self.span),
            first: self.span.map(|(first, _)| stamp(first)),
            last: self.span.map(|(_, last)| stamp(last)),
            categories: self.categories.iter().copied().collect(),
        }
    }
}
