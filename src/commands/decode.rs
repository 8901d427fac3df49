//! `decode`: prints captures as JSON, one record per line, or writes tables.

mod files;

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use asterix::Fault;

use super::edition::{EditionOf, editions};
use super::{CommandResult, Outcome, Usage};
use crate::app::AppError;
use fusion::time::Time;
use input::capture::{Capture, OpenError, SiteReceivers, StampKind};
use input::gateways::remote_id::BroadcastLine;
use input::json::{
    Editions, Entry, Place, REMOTE_ID, SKIPPED, write_block, write_fault, write_messages, write_record,
    write_refused, write_skipped, write_trailer,
};
use input::pipeline::LineFault;
use picture::decode::{Decoder, Faults, Sink, Tables};

/// Output format of records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum DecodeFormat {
    /// One JSON object per line, lossless.
    #[default]
    Json,
    /// Comma-separated values, one table per category.
    Csv,
    /// Apache Parquet, one table per category.
    Parquet,
}

impl DecodeFormat {
    /// File name extension.
    fn extension(self) -> &'static str {
        match self {
            Self::Json => "ndjson",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

/// Prints captures as JSON, one record per line
///
/// A record: {"time":"2026-11-20T10:20:30.250Z", "offset":3, "block":0, "cat":48, "sac":25, "sic":200, "items":{…}}. `offset` and
/// `block` are the positions of the record and of its block in the file. `time` is null in files without reception times. Items
/// have the numbers of the specification. The output is lossless: octets without a known meaning are hexadecimal, and numbers
/// round back to the values sent.
///
/// Data that cannot be read: {"error":{"kind":…, "offset":…, "detail":…}, "offset":…, "block":…, "cat":…, "hex":…}. Decoding
/// continues with the next block. In a raw file or a FINAL recording, octets may be lost, added or changed. Then decoding
/// continues at the next block that is found, and the octets in between become lines of kind `skipped`. A block of a category
/// without a public definition has its octets as `hex` and no `items`. Octets that a sender appends to the blocks of each
/// datagram: {"trailer":8, "offset":…, "block":…, "hex":…}. A line names its `edition` if `encode` would otherwise assume another
/// one. With several inputs each line names its file as `input`.
///
/// A Remote ID message (ASTM F3411) from a Wi-Fi or Bluetooth capture or a gateway's line: {"time":…, "offset":…, "block":…,
/// "transmitter":"90:3a:e6:5b:c8:a8", "message":"location", "version":2, "latitude_deg":…, …}. Frames of a 1090 MHz receiver
/// (Beast, AVR) are printed as CAT021 records, positions of a MAVLink log as CAT129, both with SAC and SIC 0.
///
/// With --format csv or parquet, one table per category is written to the directory -o. cat048.parquet has one row per record and
/// one column per scalar: I048_040_rho_m for `rho_m` of item 040. unread.parquet has the data that could not be read or was not
/// decoded. CSV of one category (--cat) or of the errors (--errors-only) may go to standard output.
///
/// The exit code is 4 if octets of a raw file or of a FINAL, ORADIS or GPS recording could not be read.
#[derive(clap::Args, Debug, Default)]
pub struct Args {
    /// Capture files (raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR, MAVLink log; also gzip-compressed), or - for standard
    /// input, in the order given
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Decodes blocks of this category only. Data that is not a block is still reported
    #[arg(long, value_name = "N")]
    pub cat: Option<u8>,
    /// Edition that the senders use: 1.31 for the category of --cat, else for CAT021 (`info` names the one that fits), or
    /// 48:1.31. May be given several times
    #[arg(long, value_name = "[N:]EDITION")]
    pub edition: Vec<EditionOf>,
    /// Time stamps in Beast and AVR files: a 12 MHz counter, or seconds of the UTC day and nanoseconds (Radarcape). auto
    /// determines the kind from the first frames
    #[arg(long, value_enum, value_name = "KIND", default_value = "auto")]
    pub stamps: StampKind,
    /// Decodes every category by its definition alone, including those with hand-written keys, so that all keys follow one rule
    #[arg(long)]
    pub untyped: bool,
    /// Stops after this number of lines
    #[arg(long, value_name = "N")]
    pub limit: Option<u64>,
    /// Prints only data that cannot be read, no records
    #[arg(long)]
    pub errors_only: bool,
    /// Ends with exit code 4 if any data could not be read, in pcap and pcapng files too
    #[arg(long)]
    pub strict: bool,
    /// Adds the octets of each record, as `hex`
    #[arg(long)]
    pub hex: bool,
    /// Output format of records
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t)]
    pub format: DecodeFormat,
    /// Directory of the tables of --format csv and parquet; created if missing
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl Args {
    /// Destination of records.
    fn destination<'a>(&'a self, out: &'a mut dyn Write) -> Result<Destination<'a>, AppError> {
        let refuse = |text: &str| Err(Usage(text.to_owned()).into());
        if self.format == DecodeFormat::Parquet {
            super::check_parquet()?;
        }
        match (self.format, &self.output) {
            (DecodeFormat::Json, None) => {
                Ok(Destination::Lines { out: BufWriter::new(out), line: Vec::new() })
            }
            (DecodeFormat::Json, Some(_)) => refuse("-o is for tables: --format csv or --format parquet"),
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
            (DecodeFormat::Csv, None) if self.cat.is_some() || self.errors_only => {
                Ok(Destination::Tables(files::only(out, self.hex)))
            }
            (DecodeFormat::Csv, None) => {
                refuse("--format csv: a table per category needs -o DIR, or --cat for one of them")
            }
            (DecodeFormat::Parquet, None) => refuse("--format parquet needs a directory: -o DIR"),
        }
    }
}

/// Reads the inputs and writes a line for each record, unknown block and error to `out`. A summary of the errors is written to
/// standard error.
///
/// # Errors
/// An edition is unknown or an input cannot be opened; both are found before anything is printed. An input cannot be read to its
/// end. `out` cannot be written: a closed pipe is returned as its [`io::Error`].
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let chosen = if args.untyped { Editions::untyped() } else { Editions::default() };
    let editions = editions(chosen, &args.edition, args.cat)?;
    let captures = args
        .inputs
        .iter()
        .map(|path| {
            Ok(Capture::open(path)?.with_receivers(&SiteReceivers::default().with_stamps(args.stamps)))
        })
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
            // A failure to write to standard error cannot be reported.
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
        // A failure to write to standard error cannot be reported.
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
    /// Number of lines left to write.
    left: u64,
    /// Data that could not be read.
    faults: Faults,
    /// Whether no record and no whole block was found.
    is_empty: bool,
}

/// Destination of records and unreadable data.
enum Destination<'a> {
    Lines {
        out: BufWriter<&'a mut dyn Write>,
        /// Buffer of the current line.
        line: Vec<u8>,
    },
    Tables(Tables<'a>),
}

impl Destination<'_> {
    /// Writes a line, or adds a row.
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
        line: Result<&BroadcastLine, LineFault>,
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
    /// Writes a line or adds a row, if the limit of lines allows it.
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

    /// Counts unreadable octets, if the limit of lines allows it.
    fn note(&mut self, reason: &str, place: Place<'_>, octets: &[u8]) {
        if self.left > 0 {
            self.faults.note(reason, place, octets);
        }
    }
}
