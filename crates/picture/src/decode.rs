//! Decodes captures record by record: [`Decoder`] splits datagrams and passes everything it finds to a [`Sink`], in order and
//! without omissions. Sans-IO.

mod faults;
mod tables;

use asterix::all::Definition;
use asterix::{
    Block, Fault, Located, Record, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129,
};

use fusion::time::Time;
use input::capture::{CapturedDatagram, PayloadKind};
use input::gateways::remote_id::{BroadcastLine, is_broadcast, is_lines, lines};
use input::json::{Editions, Entry, Named, Place, Reading, needs_untyped};
use input::pipeline::LineFault;

pub use faults::Faults;
pub use faults::lost_frames;
pub use tables::Tables;

/// Receives what the decoder finds.
pub trait Sink {
    /// Error that stops decoding.
    type Error;

    /// A record.
    fn record(&mut self, entry: &Entry<'_>) -> Result<(), Self::Error>;

    /// A block that is not decoded, because its category has no public definition or it holds no record. `octets` begin with
    /// CAT and LEN.
    fn block(&mut self, category: u8, octets: &[u8], place: Place<'_>) -> Result<(), Self::Error>;

    /// Octets that cannot be read: the rest of a block from the faulty record on, or of a datagram from the faulty block on. The
    /// offset in the fault is relative to `origin` in the file.
    fn fault(
        &mut self,
        fault: Fault,
        octets: &[u8],
        origin: u64,
        place: Place<'_>,
    ) -> Result<(), Self::Error>;

    /// Octets outside of any block.
    fn skipped(&mut self, octets: &[u8], place: Place<'_>) -> Result<(), Self::Error>;

    /// Octets that a sender appends to the blocks of each datagram.
    fn trailer(&mut self, octets: &[u8], place: Place<'_>) -> Result<(), Self::Error>;

    /// A message of Remote ID with these octets, or its error.
    fn remote_id(
        &mut self,
        line: Result<&BroadcastLine, LineFault>,
        octets: &[u8],
        received: Option<Time>,
        place: Place<'_>,
    ) -> Result<(), Self::Error>;
}

/// Options of decoding.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    /// Edition of each category.
    pub editions: Editions,
    /// Decode this category only; anything without a category is then left out.
    pub category: Option<u8>,
}

/// A datagram, and the file it is from if there are several.
#[derive(Clone, Copy)]
struct Source<'a> {
    input: Option<&'a str>,
    datagram: &'a CapturedDatagram,
}

impl<'a> Source<'a> {
    /// Place in the file of an offset in the datagram and of its block.
    fn place(&self, offset: usize, block: usize) -> Place<'a> {
        let origin = self.datagram.origin;
        Place { input: self.input, offset: origin + offset as u64, block: origin + block as u64 }
    }
}

impl Decoder {
    /// Passes everything in a datagram to the sink.
    ///
    /// # Errors
    /// The sink returns an error.
    pub fn datagram<S: Sink>(
        &self,
        datagram: &CapturedDatagram,
        input: Option<&str>,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let source = Source { input, datagram };
        let (payload, place) = (&datagram.payload, source.place(0, 0));
        if datagram.contents == PayloadKind::Unframed {
            return sink.skipped(payload, place);
        }
        if datagram.may_be_remote_id() && (is_lines(payload) || is_broadcast(payload)) {
            // Remote ID has no category.
            return if self.category.is_some() { Ok(()) } else { remote_id(source, sink) };
        }
        for block in blocks(payload) {
            match block {
                Ok(block) if self.category.is_some_and(|wanted| wanted != block.category) => {}
                Ok(block) => self.block(block, source, sink)?,
                Err(fault) => {
                    let place = source.place(fault.offset, fault.offset);
                    sink.fault(fault, &payload[fault.offset..], datagram.origin, place)?;
                }
            }
        }
        if !datagram.trailer.is_empty() && self.category.is_none() {
            let at = payload.len();
            sink.trailer(&datagram.trailer, source.place(at, at))?;
        }
        Ok(())
    }

    fn block<S: Sink>(&self, block: Block<'_>, source: Source<'_>, sink: &mut S) -> Result<(), S::Error> {
        match self.editions.of(block.category) {
            _ if block.contents().is_empty() => unread(block, source, sink),
            Reading::Typed => of_type(block, source, sink),
            Reading::Cat021(edition) => typed::<cat021::Record, S>(block, edition, source, sink),
            Reading::Untyped(definition) => untyped(block, definition, source, sink),
            Reading::Unknown => unread(block, source, sink),
        }
    }
}

/// Decodes a payload of Remote ID.
fn remote_id<S: Sink>(source: Source<'_>, sink: &mut S) -> Result<(), S::Error> {
    let Source { datagram, .. } = source;
    let (payload, place) = (&datagram.payload, source.place(0, 0));
    if is_lines(payload) {
        return lines(payload).try_for_each(|octets| {
            let line = BroadcastLine::parse(octets).map_err(LineFault::from);
            sink.remote_id(line.as_ref().map_err(|fault| *fault), octets, datagram.received, place)
        });
    }
    let transmitter = datagram.endpoints.map_or("unknown".to_owned(), |of| of.source.to_string());
    let line =
        BroadcastLine { time: None, transmitter, rssi_dbm: None, receiver: None, octets: payload.clone() };
    sink.remote_id(Ok(&line), payload, datagram.received, place)
}

/// Decodes a block whose category has a typed record; each such category has a line here.
fn of_type<S: Sink>(block: Block<'_>, source: Source<'_>, sink: &mut S) -> Result<(), S::Error> {
    match block.category {
        cat015::Record::CATEGORY => typed::<cat015::Record, S>(block, (), source, sink),
        cat034::Record::CATEGORY => typed::<cat034::Record, S>(block, (), source, sink),
        cat048::Record::CATEGORY => typed::<cat048::Record, S>(block, (), source, sink),
        cat062::Record::CATEGORY => typed::<cat062::Record, S>(block, (), source, sink),
        cat063::Record::CATEGORY => typed::<cat063::Record, S>(block, (), source, sink),
        cat065::Record::CATEGORY => typed::<cat065::Record, S>(block, (), source, sink),
        cat129::Record::CATEGORY => typed::<cat129::Record, S>(block, (), source, sink),
        _ => unread(block, source, sink),
    }
}

fn typed<R: Record<Edition: Named>, S: Sink>(
    block: Block<'_>,
    edition: R::Edition,
    source: Source<'_>,
    sink: &mut S,
) -> Result<(), S::Error> {
    let received = source.datagram.received;
    records(block, source, block.records_in::<R>(edition), sink, |record, octets, place| {
        Entry::typed(&record, edition, octets, place, received)
    })
}

fn untyped<S: Sink>(
    block: Block<'_>,
    definition: &'static Definition,
    source: Source<'_>,
    sink: &mut S,
) -> Result<(), S::Error> {
    let (received, untyped) = (source.datagram.received, needs_untyped(definition));
    records(block, source, definition.records(block), sink, |record, _, place| {
        Entry::untyped(&record, untyped, place, received)
    })
}

/// Passes on the records of a block, each with its octets, and the fault after the last one.
fn records<'a, T, S: Sink>(
    block: Block<'a>,
    source: Source<'a>,
    records: impl Iterator<Item = Result<Located<T>, Fault>>,
    sink: &mut S,
    entry: impl Fn(T, &'a [u8], Place<'a>) -> Entry<'a>,
) -> Result<(), S::Error> {
    let end = block.offset + block.octets.len();
    let mut next = end - block.contents().len();
    for located in records {
        let place = source.place(next, block.offset);
        let octets = &source.datagram.payload[next..end];
        match located {
            Ok(located) => {
                next += located.length;
                sink.record(&entry(located.record, &octets[..located.length], place))?;
            }
            Err(fault) => sink.fault(fault, octets, source.datagram.origin, place)?,
        }
    }
    Ok(())
}

fn unread<S: Sink>(block: Block<'_>, source: Source<'_>, sink: &mut S) -> Result<(), S::Error> {
    sink.block(block.category, block.octets, source.place(block.offset, block.offset))
}
