//! Arguments of `replay`.

use std::collections::BTreeSet;
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use jiff::civil::Date;
use tracing::warn;

use crate::commands::Usage;
use crate::commands::address::listen_address;
use crate::commands::moment::{ReplaySpeed, TimeArgument, day};
use fusion::numbering::Given;
use input::capture::{Capture, OpenError, SiteReceivers, StampKind, TrailerRules};
use picture::formats::OutputFormat;
use service::state::{SavedState, read_beside, read_kept, read_numbers_beside};
use site::config::PictureKind;

/// Default day of files without a date: the first of the epoch.
const UNDATED: Date = Date::constant(1970, 1, 1);

/// Replays captured files through the same engine as the live service.
///
/// The same input gives the same bytes, at any speed. Without -o a summary is printed.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Capture files: raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR or a MAVLink log, also gzip-compressed. The format is
    /// recognised by content; `-` is standard input. Several are merged by reception time.
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Site configuration.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// Output file; `-` is standard output. The extension sets the format: .ast .pcap .ndjson .geojson .csv .parquet .mcap.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Output format, if the extension does not set it.
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub output_format: Option<OutputFormat>,
    /// Picture to write and count: `lagged`, the slots as published, or `now`, the predicted positions at the time of each
    /// publication. --udp sends each destination its configured picture.
    #[arg(long, value_name = "PICTURE", default_value = "lagged", value_parser = PictureKind::from_str, conflicts_with = "serve")]
    pub at: PictureKind,
    /// Profile of the engine, instead of the configured one.
    #[arg(long, value_name = "PROFILE")]
    pub profile: Option<String>,
    /// Replay speed as a multiple of real time, or `max` for as fast as possible. Default: max; with --udp, --to-inputs or
    /// --serve, 1.
    #[arg(long, value_name = "N|max")]
    pub speed: Option<ReplaySpeed>,
    /// Time of the flight at which the output starts: 2026-11-20T10:00:00Z, 10:00:00 or +90s.
    #[arg(long, value_name = "T")]
    pub start: Option<TimeArgument>,
    /// Time of the flight at which the output ends.
    #[arg(long, value_name = "T")]
    pub end: Option<TimeArgument>,
    /// UTC day of the first record of files without a date (raw ASTERIX, FINAL, ORADIS; Beast and AVR without a time in the
    /// name). By default 1970-01-01, with a warning.
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Option<Date>,
    /// Time stamps in Beast and AVR files: a 12 MHz counter, or seconds of the UTC day and nanoseconds (Radarcape). `auto`
    /// determines the kind from the first frames.
    #[arg(long, value_enum, value_name = "KIND", default_value = "auto")]
    pub stamps: StampKind,
    /// Directory or recording from which to restore state. A directory (`[state] dir`) has the transponder numbers and the
    /// registration of radars kept by the service. `input-<start>` names the files beside a recording: `.numbers.json`,
    /// `.registration.json` and, for each input, the operator decisions (`.decisions.jsonl`), which are applied again. The files
    /// are only read.
    #[arg(long, value_name = "DIR")]
    pub state: Option<PathBuf>,
    /// Sends the output as the service would, tracks and status to `[output] asterix`, in real time until Ctrl-C. Its times are
    /// those of the recording.
    #[arg(long)]
    pub udp: bool,
    /// Sends the recorded datagrams to the UDP inputs of the site, for `utm-fusion run` on this machine. The timing is kept, and
    /// times in the messages are moved to the present. Nothing leaves this machine. Datagrams without an input are counted.
    #[arg(long, conflicts_with_all = ["output", "output_format", "udp", "serve", "alerts", "conflicts", "stats", "state", "profile"])]
    pub to_inputs: bool,
    /// Repeats the recording until Ctrl-C, with --udp, --to-inputs or --serve. Times jump back at each repetition, except with
    /// --to-inputs.
    #[arg(long = "loop")]
    pub again: bool,
    /// Serves the API and the map of the replay until Ctrl-C. The replay can be paused, sped up, and moved to another time.
    #[arg(long, conflicts_with_all = ["output", "start", "end", "stats", "udp"])]
    pub serve: bool,
    /// Address for --serve, instead of the configured http.listen: 127.0.0.1:8080, or a port of this machine.
    #[arg(long, value_name = "ADDR", requires = "serve", value_parser = listen_address)]
    pub http: Option<SocketAddr>,
    /// File for alerts that follow from the picture (area, integrity, jamming, silent, uncooperative, conflict). One JSON object
    /// per line, when an alert is raised, changes or ends, as in the API's stream.
    #[arg(long, value_name = "FILE", conflicts_with = "serve")]
    pub alerts: Option<PathBuf>,
    /// File for conflicts, even if the configuration does not enable them. One JSON object for every pair, volume and second with
    /// a level, or with a probability of at least 0.01.
    #[arg(long, value_name = "FILE", conflicts_with = "serve")]
    pub conflicts: Option<PathBuf>,
    /// Adds the processing time to the summary, and prints it to standard error if standard output holds data.
    #[arg(long)]
    pub stats: bool,
}

impl Args {
    /// Day on which files without a date start. If none is given and a file needs it, a warning is logged.
    pub(super) fn day_of(&self, captures: &[Capture]) -> Date {
        self.date.unwrap_or_else(|| {
            for capture in captures.iter().filter(|capture| !capture.is_dated()) {
                let (capture, format) = (capture.name(), capture.format());
                warn!(capture, format = format.to_string(), from = %UNDATED, "the format has no date: give it as --date YYYY-MM-DD");
            }
            UNDATED
        })
    }

    /// State named by `--state`. For a recording in several files, the numbers and decisions of each file.
    pub(super) fn saved_state(&self) -> io::Result<SavedState> {
        let Some(path) = &self.state else { return Ok(SavedState::default()) };
        let mut saved = read_kept(path)?;
        if !path.is_dir() {
            for input in &self.inputs {
                saved.correlations.join(read_beside(input)?);
                // A number that had another identity before stays with the first identity.
                let (numbers, identities): (BTreeSet<_>, BTreeSet<_>) =
                    saved.numbers.iter().map(|given| (given.number, given.identity)).unzip();
                let is_free =
                    |given: &Given| !numbers.contains(&given.number) && !identities.contains(&given.identity);
                saved.numbers.extend(read_numbers_beside(input)?.into_iter().filter(is_free));
            }
        }
        Ok(saved)
    }

    /// Opens the inputs, with the trailers and receivers of the site.
    pub(super) fn open(
        &self,
        trailers: &TrailerRules,
        receivers: &SiteReceivers,
    ) -> Result<Vec<Capture>, OpenError> {
        let receivers = receivers.clone().with_stamps(self.stamps);
        let open = |path: &PathBuf| {
            Ok(Capture::open(path)?.with_trailers(trailers.clone()).with_receivers(&receivers))
        };
        self.inputs.iter().map(open).collect()
    }

    /// Rejects arguments that contradict each other.
    pub(super) fn check(&self) -> Result<(), Usage> {
        let refuse = |text: &str| Err(Usage(text.to_owned()));
        if self.again && !self.udp && !self.to_inputs && !self.serve {
            return refuse("--loop needs --udp, --to-inputs or --serve: anything else would never end");
        }
        if self.again && self.output.is_some() {
            return refuse("--loop and -o exclude each other: the file would grow without end");
        }
        for (option, path) in [("--alerts", &self.alerts), ("--conflicts", &self.conflicts)] {
            let Some(path) = path else { continue };
            if self.again {
                return refuse(&format!(
                    "--loop and {option} exclude each other: the file would grow without end"
                ));
            }
            if path == Path::new("-") {
                return refuse(&format!("{option} needs a file: standard output is for -o and the summary"));
            }
            if Some(path) == self.output.as_ref() {
                return refuse(&format!("{option} and -o name the same file"));
            }
        }
        if self.alerts.is_some() && self.alerts == self.conflicts {
            return refuse("--alerts and --conflicts name the same file");
        }
        if (self.again || self.serve) && self.inputs.iter().any(|path| path == Path::new("-")) {
            return refuse(
                "--loop and --serve read the input several times, and standard input cannot be; name a file",
            );
        }
        let is_empty = match (self.start, self.end) {
            (Some(TimeArgument::After(start)), Some(TimeArgument::After(end))) => end <= start,
            (Some(TimeArgument::At(start)), Some(TimeArgument::At(end))) => end <= start,
            // A time of day gets its day only when the recording is read.
            _ => false,
        };
        if is_empty {
            return refuse("--end is not after --start: nothing would come out");
        }
        Ok(())
    }
}
