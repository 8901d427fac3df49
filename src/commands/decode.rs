//! `decode`: captures as JSON, one record a line, or as tables.

mod files;

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use asterix::Fault;

use super::edition::{EditionOf, editions};
use super::{CommandResult, Outcome, Usage};
use crate::app::Failure;
use crate::capture::{Capture, OpenError, Receivers, Stamps};
use crate::decode::{Decoder, Faults, Sink, Tables};
use crate::gateways::remote_id::Line;
use crate::json::{
    Editions, Entry, Place, REMOTE_ID, SKIPPED, write_block, write_fault, write_messages, write_record,
    write_refused, write_skipped, write_trailer,
};
use crate::pipeline::LineFault;
use fusion::time::Time;

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

/// Prints captures as JSON, one record a line
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
/// (Beast, AVR) are printed as the CAT021 records that they become, positions of a MAVLink log as CAT129, with SAC and SIC 0.
///
/// With --format csv or parquet a table of each category goes into the directory -o: cat048.parquet has a row per record and a
/// column per scalar, I048_040_rho_m for `rho_m` of item 040; unread.parquet has what could not be read or was not looked into.
/// CSV of one category (--cat) or of the errors (--errors-only) may go to standard output.
///
/// The exit code is 4 where octets of a raw file or of a FINAL, ORADIS or GPS recording could not be read.
#[derive(clap::Args, Debug, Default)]
pub struct Args {
    /// Capture files (raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR, MAVLink log; also gzip-compressed), or - for standard
    /// input; one after the other
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Looks at blocks of this category only; where no block can be made out is still told
    #[arg(long, value_name = "N")]
    pub cat: Option<u8>,
    /// The edition that the senders follow: 1.31 of the category of --cat, else of CAT021 (where `info` names the one that
    /// fits), or 48:1.31; may be given several times
    #[arg(long, value_name = "[N:]EDITION")]
    pub edition: Vec<EditionOf>,
    /// Kind of the stamps in Beast and AVR files: a counter of 12 MHz, or seconds of the UTC day and nanoseconds (Radarcape);
    /// auto: found out from the first frames
    #[arg(long, value_enum, value_name = "KIND", default_value = "auto")]
    pub stamps: Stamps,
    /// Reads everything by the definitions alone, also the categories whose keys are made by hand: one rule for all keys
    #[arg(long)]
    pub untyped: bool,
    /// Stops after this many lines
    #[arg(long, value_name = "N")]
    pub limit: Option<u64>,
    /// Prints what cannot be read, not the records
    #[arg(long)]
    pub errors_only: bool,
    /// Ends with exit code 4 if there was anything that cannot be read, also in a pcap or pcapng
    #[arg(long)]
    pub strict: bool,
    /// Adds the octets of each record, as `hex`
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
    fn destination<'a>(&'a self, out: &'a mut dyn Write) -> Result<Destination<'a>, Failure> {
        let refuse = |text: &str| Err(Usage(text.to_owned()).into());
        match (self.format, &self.output) {
            (Format::Json, None) => Ok(Destination::Lines { out: BufWriter::new(out), line: Vec::new() }),
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
                Ok(Destination::Tables(files::within(format, directory, self.hex)?))
            }
            (Format::Csv, None) if self.cat.is_some() || self.errors_only => {
                Ok(Destination::Tables(files::only(out, self.hex)))
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
    let captures = args
        .inputs
        .iter()
        .map(|path| Ok(Capture::open(path)?.with_receivers(&Receivers::default().with_stamps(args.stamps))))
        .collect::<Result<Vec<_>, OpenError>>()?;
    let several = captures.len() > 1;
    let decoder = Decoder { editions, category: args.cat };
    let mut printer = Printer {
        args,
        destination: args.destination(out)?,
        left: args.limit.unwrap_or(u64::MAX),
        faults: Faults::default(),
        is_empty: true,
    };
    let mut damage = None;
    let mut damaged = false;
    for mut capture in captures {
        let input = several.then(|| capture.name().to_owned());
        while printer.left > 0 && damage.is_none() {
            match capture.next() {
                Some(Ok(datagram)) => decoder.datagram(&datagram, input.as_deref(), &mut printer)?,
                Some(Err(error)) => damage = Some(error),
                None => break,
            }
        }
        for trailer in capture.trailers() {
            let _ = writeln!(io::stderr(), "{}: {trailer}", capture.name());
        }
        let unread = printer.faults.end(&capture);
        if !unread.is_empty() {
            damaged |= capture.format().is_asterix_only();
            // Without a standard error there is nobody to tell.
            let _ = writeln!(io::stderr(), "{}: {unread} could not be read", capture.name());
        }
    }
    let Printer { destination, faults, is_empty, .. } = printer;
    destination.finish()?;
    if let Some(category) = args.cat.filter(|_| is_empty && args.limit != Some(0)) {
        let first = args.inputs[0].display();
        let _ = writeln!(
            io::stderr(),
            "no record of category {category}; `utm-fusion info {first}` shows the categories that are there"
        );
    }
    if !faults.is_empty() {
        // Without a standard error there is nobody to tell.
        let _ = writeln!(io::stderr(), "{faults}");
    }
    match damage {
        Some(error) => Err(error.into()),
        None if damaged || args.strict && !faults.is_empty() => Ok(Outcome::InputErrors),
        None => Ok(Outcome::Done),
    }
}

struct Printer<'a> {
    args: &'a Args,
    destination: Destination<'a>,
    /// Lines still wanted.
    left: u64,
    /// What could not be read.
    faults: Faults,
    /// Whether there was no record and no whole block.
    is_empty: bool,
}

/// Where records, and what could not be read, go.
enum Destination<'a> {
    Lines {
        out: BufWriter<&'a mut dyn Write>,
        /// The line being made.
        line: Vec<u8>,
    },
    Tables(Tables<'a>),
}

impl Destination<'_> {
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

impl Sink for Printer<'_> {
    type Error = io::Error;

    fn record(&mut self, entry: &Entry<'_>) -> io::Result<()> {
        self.is_empty = false;
        if self.args.errors_only {
            return Ok(());
        }
        let hex = self.args.hex;
        self.write(|line| write_record(line, entry, hex), |tables| tables.record(entry))
    }

    fn block(&mut self, category: u8, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.is_empty = false;
        if self.args.errors_only {
            return Ok(());
        }
        self.write(
            |line| write_block(line, category, octets, place),
            |tables| tables.block(category, octets, place),
        )
    }

    fn fault(&mut self, fault: Fault, octets: &[u8], origin: u64, place: Place<'_>) -> io::Result<()> {
        self.note(fault.kind.name(), place, octets);
        self.write(
            |line| write_fault(line, fault, octets, origin, place),
            |tables| tables.fault(fault, octets, origin, place),
        )
    }

    fn skipped(&mut self, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.note(SKIPPED, place, octets);
        self.write(|line| write_skipped(line, octets, place), |tables| tables.skipped(octets, place))
    }

    fn trailer(&mut self, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        if self.args.errors_only {
            return Ok(());
        }
        self.write(|line| write_trailer(line, octets, place), |tables| tables.trailer(octets, place))
    }

    fn remote_id(
        &mut self,
        line: Result<&Line, LineFault>,
        octets: &[u8],
        received: Option<Time>,
        place: Place<'_>,
    ) -> io::Result<()> {
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
        let note =
            |out: &mut Vec<u8>, sound: Result<(), String>| made.push((std::mem::take(out), sound.is_ok()));
        write_messages(&mut out, line, received, place, self.args.errors_only, note);
        for (text, is_sound) in made {
            if !is_sound {
                self.note(REMOTE_ID, place, &line.octets);
            }
            self.write(|out| out.extend_from_slice(&text), |tables| tables.skipped(&line.octets, place))?;
        }
        Ok(())
    }
}

impl Printer<'_> {
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
        self.destination.write(make, add)
    }

    /// Counts unreadable octets, if their line is still wanted.
    fn note(&mut self, reason: &str, place: Place<'_>, octets: &[u8]) {
        if self.left > 0 {
            self.faults.note(reason, place, octets);
        }
    }
}
