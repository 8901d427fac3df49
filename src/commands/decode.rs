//! `decode`: captures as JSON, one record a line, or as tables.

mod tables;

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use asterix::all::Definition;
use asterix::{
    Block, Fault, Located, Record, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129,
};

use super::edition::{EditionOf, editions};
use super::{CommandResult, Outcome, Usage, lost_frames};
use crate::app::Failure;
use crate::capture::{Capture, Contents, Datagram, Gaps};
use crate::gateways::remote_id::{Line, is_broadcast, is_lines, lines};
use crate::json::{
    Editions, Named, Place, REMOTE_ID, Reading, SKIPPED, write_block, write_fault, write_messages,
    write_record, write_refused, write_skipped, write_trailer, write_untyped,
};
use crate::pipeline::LineFault;
use tables::Tables;

/// How records are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// One JSON object per line, with nothing lost.
    #[default]
    Json,
    /// Comma-separated values, a table per category.
    Csv,
    /// Apache Parquet, a table per category.
    Parquet,
}

impl Format {
    /// Of the names of its files.
    fn extension(self) -> &'static str {
        match self {
            Self::Json => "ndjson",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

/// Print captures as JSON, one record a line
///
/// A record: {"time":"2026-11-20T10:20:30.250Z", "offset":3, "block":0, "cat":48, "sac":25, "sic":200, "items":{…}}.
/// `offset` and `block` are where the record and its block begin in the file, `time` is null in files without reception
/// times, and the items have the numbers of the specification. No bit is lost: octets without a known meaning are
/// hexadecimal, numbers round back to what was sent.
///
/// What cannot be read: {"error":{"kind":…, "offset":…, "detail":…}, "offset":…, "block":…, "cat":…, "hex":…}, and decoding
/// goes on with the next block. Where octets of a raw file or a FINAL recording were lost, added or changed, the next block is
/// looked for, and what is between is such a line of kind `skipped`, or several. A block of a category that has no public
/// definition: its octets as `hex`, without `items`. Octets that a sender puts behind the blocks of each datagram:
/// {"trailer":8, "offset":…, "block":…, "hex":…}.
/// A line says its `edition` where `encode` would else take it for another one.
/// With several inputs each line names its file, as `input`.
///
/// A message of Remote ID (ASTM F3411), of a Wi-Fi or Bluetooth capture or a gateway's line: {"time":…, "offset":…, "block":…,
/// "transmitter":"90:3a:e6:5b:c8:a8", "message":"location", "version":2, "latitude_deg":…, …}. Frames of a 1090 MHz receiver
/// (Beast) are printed as the CAT021 records that they become, with SAC and SIC 0.
///
/// With --format csv or parquet a table of each category goes into the directory -o: cat048.parquet has a row per record and a
/// column per scalar, I048_040_rho_m for `rho_m` of item 040; unread.parquet has what could not be read or was not looked into.
/// CSV of one category (--cat) or of the errors (--errors-only) may go to standard output.
///
/// The exit code is 4 where octets of a raw file or a FINAL recording could not be read.
#[derive(clap::Args, Debug, Default)]
pub struct Args {
    /// Capture files (raw ASTERIX, pcap, pcapng, FINAL, Beast; also gzip-compressed), or - for standard input; one after the other
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Look at blocks of this category only; where no block can be made out is still told
    #[arg(long, value_name = "N")]
    pub cat: Option<u8>,
    /// The edition that the senders follow: 1.31 of the category of --cat, else of CAT021 (where `info` names the one that
    /// fits), or 48:1.31; may be given several times
    #[arg(long, value_name = "[N:]EDITION")]
    pub edition: Vec<EditionOf>,
    /// Read everything by the definitions alone, also the categories whose keys are made by hand: one rule for all keys
    #[arg(long)]
    pub untyped: bool,
    /// Stop after this many lines
    #[arg(long, value_name = "N")]
    pub limit: Option<u64>,
    /// Print what cannot be read, not the records
    #[arg(long)]
    pub errors_only: bool,
    /// End with exit code 4 if there was anything that cannot be read, also in a pcap or pcapng
    #[arg(long)]
    pub strict: bool,
    /// Add the octets of each record, as `hex`
    #[arg(long)]
    pub hex: bool,
    /// How records are written
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t)]
    pub format: Format,
    /// The directory of the tables of --format csv and parquet; it is made where it is missing
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl Args {
    /// Where records go.
    fn sink<'a>(&'a self, out: &'a mut dyn Write) -> Result<Sink<'a>, Failure> {
        let refuse = |text: &str| Err(Usage(text.to_owned()).into());
        match (self.format, &self.output) {
            (Format::Json, None) => Ok(Sink::Lines { out: BufWriter::new(out), line: Vec::new() }),
            (Format::Json, Some(_)) => refuse("-o is for tables: --format csv or --format parquet"),
            (format, Some(directory)) => {
                let is_within = |input: &&PathBuf| {
                    let is_table = input.extension().is_some_and(|extension| extension == format.extension());
                    let (file, within) = (input.canonicalize().ok(), directory.canonicalize().ok());
                    is_table
                        && within.is_some()
                        && file.as_deref().and_then(Path::parent) == within.as_deref()
                };
                if let Some(input) = self.inputs.iter().find(is_within) {
                    let input = input.display();
                    return refuse(&format!("-o: {input} is in that directory and might be overwritten"));
                }
                Ok(Sink::Tables(Tables::within(format, directory)?))
            }
            (Format::Csv, None) if self.cat.is_some() || self.errors_only => {
                Ok(Sink::Tables(Tables::only(Format::Csv, out)))
            }
            (Format::Csv, None) => {
                refuse("--format csv: a table per category needs -o DIR, or --cat for one of them")
            }
            (Format::Parquet, None) => refuse("--format parquet needs a directory: -o DIR"),
        }
    }
}

/// Reads the inputs and writes a line for each record, unknown block and error to `out`; what went wrong in all is said
/// on standard error.
///
/// # Errors
/// An edition is none, or an input cannot be opened, which is found before anything is printed; or an input cannot be read to
/// its end; or `out` cannot be written to: a closed pipe comes back as its [`io::Error`].
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let chosen = if args.untyped { Editions::untyped() } else { Editions::default() };
    let editions = editions(chosen, &args.edition, args.cat)?;
    let captures = args.inputs.iter().map(|path| Capture::open(path)).collect::<Result<Vec<_>, _>>()?;
    let several = captures.len() > 1;
    let mut printer = Printer {
        args,
        editions,
        sink: args.sink(out)?,
        left: args.limit.unwrap_or(u64::MAX),
        errors: BTreeMap::new(),
        unread: Gaps::default(),
    };
    let mut damage = None;
    let mut damaged = false;
    for mut capture in captures {
        let input = several.then(|| capture.name().to_owned());
        while printer.left > 0 && damage.is_none() {
            match capture.next() {
                Some(Ok(datagram)) => printer.datagram(&datagram, input.as_deref())?,
                Some(Err(error)) => damage = Some(error),
                None => break,
            }
        }
        printer.count_frames(&capture);
        for trailer in capture.trailers() {
            let _ = writeln!(io::stderr(), "{}: {trailer}", capture.name());
        }
        let unread = std::mem::take(&mut printer.unread);
        if !unread.is_empty() {
            damaged |= capture.format().is_asterix_only();
            // Without a standard error there is nobody to tell.
            let _ = writeln!(io::stderr(), "{}: {unread} could not be read", capture.name());
        }
    }
    let Printer { sink, errors, .. } = printer;
    sink.finish()?;
    summarise(&errors);
    match damage {
        Some(error) => Err(error.into()),
        None if damaged || args.strict && !errors.is_empty() => Ok(Outcome::InputErrors),
        None => Ok(Outcome::Done),
    }
}

struct Printer<'a> {
    args: &'a Args,
    editions: Editions,
    sink: Sink<'a>,
    /// Lines still wanted.
    left: u64,
    /// What could not be read, by reason.
    errors: BTreeMap<String, u64>,
    /// Octets of the input that could not be read.
    unread: Gaps,
}

/// Where records, and what could not be read, go.
enum Sink<'a> {
    Lines {
        out: BufWriter<&'a mut dyn Write>,
        /// The line being made.
        line: Vec<u8>,
    },
    Tables(Tables<'a>),
}

impl Sink<'_> {
    /// Makes a line, or adds a row.
    fn write(
        &mut self,
        make: impl FnOnce(&mut Vec<u8>),
        add: impl FnOnce(&mut Tables<'_>) -> io::Result<()>,
    ) -> io::Result<()> {
        match self {
            Self::Tables(tables) => add(tables),
            Self::Lines { out, line } => {
                line.clear();
                make(line);
                out.write_all(line)
            }
        }
    }

    fn finish(self) -> io::Result<()> {
        match self {
            Self::Lines { mut out, .. } => out.flush(),
            Self::Tables(tables) => tables.finish(),
        }
    }
}

/// A datagram and the file it is from, where there are several.
#[derive(Clone, Copy)]
struct Source<'a> {
    input: Option<&'a str>,
    datagram: &'a Datagram,
}

impl<'a> Source<'a> {
    /// Where something stands in the file that begins at these offsets of the datagram.
    fn place(&self, offset: usize, block: usize) -> Place<'a> {
        let origin = self.datagram.origin;
        Place { input: self.input, offset: origin + offset as u64, block: origin + block as u64 }
    }
}

impl Printer<'_> {
    fn datagram(&mut self, datagram: &Datagram, input: Option<&str>) -> io::Result<()> {
        let source = Source { input, datagram };
        if datagram.contents == Contents::Unframed {
            let place = source.place(0, 0);
            self.note(SKIPPED, place, &datagram.payload);
            let octets = &datagram.payload;
            return self
                .write(|line| write_skipped(line, octets, place), |tables| tables.skipped(octets, place));
        }
        let (payload, place) = (&datagram.payload, source.place(0, 0));
        if datagram.may_be_remote_id() && is_lines(payload) {
            for line in lines(payload) {
                self.remote_id(Line::parse(line).map_err(LineFault::from), line, place, datagram)?;
            }
            return Ok(());
        }
        if datagram.may_be_remote_id() && is_broadcast(payload) {
            let transmitter = datagram.endpoints.map_or("unknown".to_owned(), |of| of.source.to_string());
            let octets = payload.clone();
            let line = Line { time: None, transmitter, rssi_dbm: None, receiver: None, octets };
            return self.remote_id(Ok(line), payload, place, datagram);
        }
        for block in blocks(&datagram.payload) {
            match block {
                Ok(block) if self.args.cat.is_some_and(|wanted| wanted != block.category) => {}
                Ok(block) => match self.editions.of(block.category) {
                    _ if block.contents().is_empty() => self.unread_block(block, source)?,
                    Reading::Typed => self.typed(block, source)?,
                    Reading::Cat021(edition) => self.block::<cat021::Record>(block, edition, source)?,
                    Reading::Untyped(definition) => self.untyped(block, definition, source)?,
                    Reading::Unknown => self.unread_block(block, source)?,
                },
                Err(fault) => {
                    let place = source.place(fault.offset, fault.offset);
                    self.fault(fault, place, &datagram.payload[fault.offset..], source)?;
                }
            }
        }
        if !datagram.trailer.is_empty() && !self.args.errors_only && self.args.cat.is_none() {
            let at = datagram.payload.len();
            let (octets, place) = (&datagram.trailer, source.place(at, at));
            self.write(|line| write_trailer(line, octets, place), |tables| tables.trailer(octets, place))?;
        }
        Ok(())
    }

    /// Prints the messages of a line of Remote ID. It has no category.
    fn remote_id(
        &mut self,
        line: Result<Line, LineFault>,
        octets: &[u8],
        place: Place<'_>,
        datagram: &Datagram,
    ) -> io::Result<()> {
        if self.args.cat.is_some() {
            return Ok(());
        }
        let line = match line {
            Ok(line) => line,
            Err(refusal) => {
                self.note(REMOTE_ID, place, octets);
                return self.write(
                    |out| write_refused(out, &refusal.to_string(), octets, place),
                    |tables| tables.skipped(octets, place),
                );
            }
        };
        let mut made = Vec::new();
        let mut out = Vec::new();
        let note = |out: &mut Vec<u8>, sound: Result<(), String>| made.push((std::mem::take(out), sound));
        write_messages(&mut out, &line, datagram.received, place, self.args.errors_only, note);
        for (text, sound) in made {
            if sound.is_err() {
                self.note(REMOTE_ID, place, &line.octets);
            }
            self.write(|out| out.extend_from_slice(&text), |tables| tables.skipped(&line.octets, place))?;
        }
        Ok(())
    }

    /// A block of a category that is read as its typed record; each has a line here.
    fn typed(&mut self, block: Block<'_>, source: Source<'_>) -> io::Result<()> {
        match block.category {
            cat015::Record::CATEGORY => self.block::<cat015::Record>(block, (), source),
            cat034::Record::CATEGORY => self.block::<cat034::Record>(block, (), source),
            cat048::Record::CATEGORY => self.block::<cat048::Record>(block, (), source),
            cat062::Record::CATEGORY => self.block::<cat062::Record>(block, (), source),
            cat063::Record::CATEGORY => self.block::<cat063::Record>(block, (), source),
            cat065::Record::CATEGORY => self.block::<cat065::Record>(block, (), source),
            cat129::Record::CATEGORY => self.block::<cat129::Record>(block, (), source),
            _ => self.unread_block(block, source),
        }
    }

    fn block<R: Record<Edition: Named>>(
        &mut self,
        block: Block<'_>,
        edition: R::Edition,
        source: Source<'_>,
    ) -> io::Result<()> {
        let (received, hex) = (source.datagram.received, self.args.hex);
        self.records(block, source, block.records_in::<R>(edition), |sink, record, octets, place| {
            sink.write(
                |line| write_record(line, record, edition, octets, place, received, hex),
                |tables| tables.record(record, edition, octets, place, received, hex),
            )
        })
    }

    fn untyped(
        &mut self,
        block: Block<'_>,
        definition: &'static Definition,
        source: Source<'_>,
    ) -> io::Result<()> {
        let (received, hex) = (source.datagram.received, self.args.hex);
        self.records(block, source, definition.records(block), |sink, record, _, place| {
            sink.write(
                |line| write_untyped(line, record, place, received, hex),
                |tables| tables.untyped(record, place, received, hex),
            )
        })
    }

    /// Writes the records of a block, each with its octets, as far as they are wanted, and the fault behind the last.
    fn records<T>(
        &mut self,
        block: Block<'_>,
        source: Source<'_>,
        records: impl Iterator<Item = Result<Located<T>, Fault>>,
        write: impl Fn(&mut Sink<'_>, &T, &[u8], Place<'_>) -> io::Result<()>,
    ) -> io::Result<()> {
        let end = block.offset + block.octets.len();
        let mut next = end - block.contents().len();
        for located in records {
            let place = source.place(next, block.offset);
            let octets = &source.datagram.payload[next..end];
            match located {
                Ok(located) => {
                    next += located.length;
                    if !self.args.errors_only && self.left > 0 {
                        self.left -= 1;
                        write(&mut self.sink, &located.record, &octets[..located.length], place)?;
                    }
                }
                Err(fault) => self.fault(fault, place, octets, source)?,
            }
        }
        Ok(())
    }

    fn unread_block(&mut self, block: Block<'_>, source: Source<'_>) -> io::Result<()> {
        if self.args.errors_only {
            return Ok(());
        }
        let place = source.place(block.offset, block.offset);
        let Block { category, octets, .. } = block;
        self.write(
            |line| write_block(line, category, octets, place),
            |tables| tables.block(category, octets, place),
        )
    }

    fn fault(&mut self, fault: Fault, place: Place<'_>, octets: &[u8], source: Source<'_>) -> io::Result<()> {
        self.note(fault.kind.name(), place, octets);
        let origin = source.datagram.origin;
        self.write(
            |line| write_fault(line, fault, octets, origin, place),
            |tables| tables.fault(fault, octets, origin, place),
        )
    }

    /// Makes a line, or adds a row, if one is still wanted.
    fn write(
        &mut self,
        make: impl FnOnce(&mut Vec<u8>),
        add: impl FnOnce(&mut Tables<'_>) -> io::Result<()>,
    ) -> io::Result<()> {
        if self.left == 0 {
            return Ok(());
        }
        self.left -= 1;
        self.sink.write(make, add)
    }

    /// Counts unreadable octets, if their line is still wanted.
    fn note(&mut self, reason: &str, place: Place<'_>, octets: &[u8]) {
        if self.left > 0 {
            self.count(reason.to_owned(), 1);
            self.unread.add(place.offset, octets.len());
        }
    }

    fn count(&mut self, reason: String, times: u64) {
        *self.errors.entry(reason).or_default() += times;
    }

    /// Counts the unreadable frames that may have held records; they have no lines.
    fn count_frames(&mut self, capture: &Capture) {
        for (reason, times) in lost_frames(capture) {
            self.count(format!("{reason} frame"), times);
        }
    }
}

/// Says on standard error what could not be read.
fn summarise(errors: &BTreeMap<String, u64>) {
    let total: u64 = errors.values().sum();
    if total > 0 {
        let counts: Vec<_> = errors.iter().map(|(reason, times)| format!("{times} {reason}")).collect();
        let plural = if total == 1 { "" } else { "s" };
        // Without a standard error there is nobody to tell.
        let _ = writeln!(io::stderr(), "{total} error{plural} in the input: {}", counts.join(", "));
    }
}
