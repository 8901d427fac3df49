//! What `replay` is asked for.

use std::collections::BTreeSet;
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use jiff::civil::Date;
use tracing::warn;

use crate::capture::{Capture, OpenError, Receivers, Stamps, TrailerRules};
use crate::commands::Usage;
use crate::commands::address::listen_address;
use crate::commands::moment::{Moment, Speed, day};
use crate::config::PictureKind;
use crate::formats::OutputFormat;
use crate::state::{SavedState, read_beside, read_kept, read_numbers_beside};
use fusion::numbering::Given;

/// The day of files that do not say theirs, where none is given: the first of the epoch.
const UNDATED: Date = Date::constant(1970, 1, 1);

/// Replays captured files through the same engine as the live service.
///
/// The same input gives the same bytes, at any speed. Without -o a summary is printed.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Captures: raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR or a MAVLink log, gzip-compressed or not, recognised by
    /// content; `-` is standard input.
    /// Several are merged by reception time.
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// The site's configuration.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// Where the output goes; `-` is standard output. The extension tells the format: .ast .pcap .ndjson .geojson
    /// .csv .parquet .mcap.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The output's format, where the extension does not tell.
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub output_format: Option<OutputFormat>,
    /// Which picture is written and counted: `lagged`, of the slots as they are published, or `now`, where aircraft were
    /// predicted to be at the time of each publication. --udp sends each destination the one that it is configured for.
    #[arg(long, value_name = "PICTURE", default_value = "lagged", value_parser = PictureKind::from_str, conflicts_with = "serve")]
    pub at: PictureKind,
    /// The engine's profile, instead of the configuration's.
    #[arg(long, value_name = "PROFILE")]
    pub profile: Option<String>,
    /// How many times faster than it happened; `max`: as fast as it goes. By default max, with --udp, --to-inputs or --serve 1.
    #[arg(long, value_name = "N|max")]
    pub speed: Option<Speed>,
    /// No output before this time of the flight: 2026-11-20T10:00:00Z, 10:00:00 or +90s.
    #[arg(long, value_name = "T")]
    pub start: Option<Moment>,
    /// No output from this time of the flight on.
    #[arg(long, value_name = "T")]
    pub end: Option<Moment>,
    /// UTC day of the first record of each file that does not say its day (raw ASTERIX, FINAL, ORADIS; Beast and AVR
    /// without a time in the name).
    /// Without it their times are dated from 1970-01-01 on, and a warning says so.
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Option<Date>,
    /// Kind of the stamps in Beast and AVR files: a counter of 12 MHz, or seconds of the UTC day and nanoseconds (Radarcape).
    /// `auto`: found out from the first frames.
    #[arg(long, value_enum, value_name = "KIND", default_value = "auto")]
    pub stamps: Stamps,
    /// Begins with the transponder numbers and the radars' registration that the service has kept in this directory (`[state]
    /// dir`), or that stand beside a recording: `input-<start>`, for its `.numbers.json` and `.registration.json`; then what was
    /// decided by hand (`.decisions.jsonl`, of each input) is decided again. It is only read.
    #[arg(long, value_name = "DIR")]
    pub state: Option<PathBuf>,
    /// Sends the output as the service would, tracks and status to `[output] asterix`, in real time; Ctrl-C ends it. The
    /// times in it are those of the recording.
    #[arg(long)]
    pub udp: bool,
    /// Sends the recording itself to the UDP inputs of the site, for `utm-fusion run` on this machine: with its timing, and with
    /// the times in its messages moved to now. Nothing leaves this machine. What the site has no input for is counted.
    #[arg(long, conflicts_with_all = ["output", "output_format", "udp", "serve", "alerts", "conflicts", "stats", "state", "profile"])]
    pub to_inputs: bool,
    /// Begins again at the end, with --udp, --to-inputs or --serve, until Ctrl-C. The times are those of the recording each time: they
    /// step back where it begins again. With --to-inputs they go on.
    #[arg(long = "loop")]
    pub again: bool,
    /// Serves the API and the map of it, until Ctrl-C; it can be paused, sped up, and taken to another time.
    #[arg(long, conflicts_with_all = ["output", "start", "end", "stats", "udp"])]
    pub serve: bool,
    /// Where --serve listens, instead of the configuration's http.listen: 127.0.0.1:8080, or only a port of this machine.
    #[arg(long, value_name = "ADDR", requires = "serve", value_parser = listen_address)]
    pub http: Option<SocketAddr>,
    /// Where every alert goes that follows from the picture (area, integrity, jamming, silent, uncooperative, conflict): a JSON
    /// object per line as it is raised, changes and ends, as the stream of the API has it.
    #[arg(long, value_name = "FILE", conflicts_with = "serve")]
    pub alerts: Option<PathBuf>,
    /// Where every conflict goes, also where the configuration does not ask for them: a JSON object for every pair, volume and
    /// second with a level, or with a probability of at least 0.01.
    #[arg(long, value_name = "FILE", conflicts_with = "serve")]
    pub conflicts: Option<PathBuf>,
    /// Adds how long it took to the summary, and prints it to standard error where standard output holds data.
    #[arg(long)]
    pub stats: bool,
}

impl Args {
    /// The day on which files begin that do not say theirs; where none is given and one needs it, a warning is logged.
    pub(super) fn day_of(&self, captures: &[Capture]) -> Date {
        self.date.unwrap_or_else(|| {
            for capture in captures.iter().filter(|capture| !capture.is_dated()) {
                let (capture, format) = (capture.name(), capture.format());
                warn!(capture, format = format.to_string(), from = %UNDATED, "the format has no date: give it as --date YYYY-MM-DD");
            }
            UNDATED
        })
    }

    /// What `--state` names; of a recording in several files also the numbers and the decisions of each.
    pub(super) fn saved_state(&self) -> io::Result<SavedState> {
        let Some(path) = &self.state else { return Ok(SavedState::default()) };
        let mut saved = read_kept(path)?;
        if !path.is_dir() {
            for input in &self.inputs {
                saved.correlations.join(read_beside(input)?);
                // A number that was somebody else's before is his who had it first.
                let (numbers, identities): (BTreeSet<_>, BTreeSet<_>) =
                    saved.numbers.iter().map(|given| (given.number, given.identity)).unzip();
                let is_free =
                    |given: &Given| !numbers.contains(&given.number) && !identities.contains(&given.identity);
                saved.numbers.extend(read_numbers_beside(input)?.into_iter().filter(is_free));
            }
        }
        Ok(saved)
    }

    /// The inputs, with the trailers and the receivers of the site.
    pub(super) fn open(
        &self,
        trailers: &TrailerRules,
        receivers: &Receivers,
    ) -> Result<Vec<Capture>, OpenError> {
        let receivers = receivers.clone().with_stamps(self.stamps);
        let open = |path: &PathBuf| {
            Ok(Capture::open(path)?.with_trailers(trailers.clone()).with_receivers(&receivers))
        };
        self.inputs.iter().map(open).collect()
    }

    /// What makes no sense together.
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
            (Some(Moment::After(start)), Some(Moment::After(end))) => end <= start,
            (Some(Moment::At(start)), Some(Moment::At(end))) => end <= start,
            // The day of a time of day is known once the recording is read.
            _ => false,
        };
        if is_empty {
            return refuse("--end is not after --start: nothing would come out");
        }
        Ok(())
    }
}
