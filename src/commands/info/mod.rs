//! `info`: what is in a capture, on one screen.

mod site;
mod text;

use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;

use serde::{Serialize, Serializer};
use tracing::{error, warn};

use super::{CommandResult, Outcome, progress};
use crate::capture::{Capture, Format, OpenError, ReadError, Receivers, Skipped, Stamps, Trailer};
use crate::decode::lost_frames;
use crate::survey::{Survey, SurveyReport};

/// Says what is in captures: who sends what, how much, when, and is it healthy
///
/// For each input: streams (who sends where), sources (SAC/SIC), how steadily and how late they report, which items they
/// send, categories, errors, and the sensors that a configuration for it would have. Gaps are silences of a source longer
/// than five times its usual interval and than a second; a delay is from the time of day in a record to its reception.
/// Medians are good to 3 %. The exit code is 4 where octets of a raw file or of a FINAL, ORADIS or GPS recording
/// could not be read.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Args {
    /// Capture files (raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR, MAVLink log; also gzip-compressed), or - for standard
    /// input; each by itself
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Prints one JSON object per input, a line each
    #[arg(long)]
    pub json: bool,
    /// Kind of the stamps in Beast and AVR files: a counter of 12 MHz, or seconds of the UTC day and nanoseconds (Radarcape);
    /// auto: found out from the first frames
    #[arg(long, value_enum, value_name = "KIND", default_value = "auto")]
    pub stamps: Stamps,
    /// Writes a configuration with the sensors that were seen into this file; it says which values are to be filled in
    #[arg(long, value_name = "FILE")]
    pub config_out: Option<PathBuf>,
    /// Ends with exit code 4 if there was anything that cannot be read, also in a pcap or pcapng
    #[arg(long)]
    pub strict: bool,
}

/// The report on an input.
#[derive(Serialize)]
struct Info {
    input: String,
    #[serde(serialize_with = "as_text")]
    format: Format,
    /// Octets of the file, or those read of a pipe.
    size: u64,
    /// Frames of the capture that hold no whole UDP datagram, by reason.
    #[serde(serialize_with = "by_reason")]
    skipped: Skipped,
    /// Those of them that may have cost records.
    lost_frames: u64,
    /// Streams whose datagrams have octets behind their blocks that are none.
    trailers: Vec<Trailer>,
    #[serde(flatten)]
    report: SurveyReport,
    /// Why it could not be read to its end.
    damage: Option<String>,
}

impl Info {
    /// Whether octets of an ASTERIX-only file stay unread; if `strict`, whether any input had errors.
    fn is_bad(&self, strict: bool) -> bool {
        let unread = !self.report.unread.is_empty();
        unread && self.format.is_asterix_only() || strict && self.lost_frames + self.report.error_count() > 0
    }
}

fn as_text<S: Serializer>(format: &Format, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(format)
}

fn by_reason<S: Serializer>(skipped: &Skipped, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(skipped.iter().map(|(reason, count)| (reason.to_string(), count)))
}

/// Reads each input to its end, or to where it is damaged, and writes what is in it to `out`.
///
/// # Errors
/// An input cannot be opened, or the file of `--config-out` is there already, which is found before anything is printed;
/// or `out` or that file cannot be written to: a closed pipe comes back as its [`io::Error`]. Damage is reported and logged,
/// and the next input is read.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    args.config_out.as_deref().map_or(Ok(()), site::check)?;
    let captures = args
        .inputs
        .iter()
        .map(|path| Ok(Capture::open(path)?.with_receivers(&Receivers::default().with_stamps(args.stamps))))
        .collect::<Result<Vec<_>, OpenError>>()?;
    let mut out = BufWriter::new(out);
    let mut outcome = Outcome::Done;
    let mut sensors = Vec::new();
    for (place, capture) in captures.into_iter().enumerate() {
        let info = survey(capture);
        if info.damage.is_some() {
            outcome = Outcome::InputUnreadable;
        } else if outcome == Outcome::Done && info.is_bad(args.strict) {
            outcome = Outcome::InputErrors;
        }
        if args.json {
            serde_json::to_writer(&mut out, &info)?;
            writeln!(out)?;
        } else {
            let blank = if place == 0 { "" } else { "\n" };
            write!(out, "{blank}{}", text::text(&info)?)?;
        }
        // Whoever waits for the next input can read this one.
        out.flush()?;
        sensors.extend(info.report.sensors);
    }
    if let Some(file) = &args.config_out {
        let inputs: Vec<String> = args.inputs.iter().map(|input| input.display().to_string()).collect();
        site::write(file, &inputs, sensors)?;
        tracing::info!("{0}: written; `utm-fusion check {0}` names what is to be filled in", file.display());
    }
    Ok(outcome)
}

fn survey(mut capture: Capture) -> Info {
    let bar = io::stderr().is_terminal().then(|| progress::bar(capture.size()));
    let mut survey = Survey::default();
    let mut damage: Option<ReadError> = None;
    let mut count: u64 = 0;
    while let Some(next) = capture.next() {
        match next {
            Ok(datagram) => survey.datagram(&datagram),
            Err(error) => damage = Some(error),
        }
        count += 1;
        if let Some(bar) = &bar
            && count.is_multiple_of(4096)
        {
            bar.set_position(capture.consumed());
        }
    }
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    if let Some(error) = &damage {
        error!("{error}");
    }
    let report = survey.report();
    if !report.unread.is_empty() {
        warn!("{}: {} could not be read", capture.name(), report.unread);
    }
    Info {
        input: capture.name().to_owned(),
        format: *capture.format(),
        size: capture.size().unwrap_or(capture.consumed()),
        lost_frames: lost_frames(&capture).map(|(_, times)| times).sum(),
        skipped: capture.skipped().clone(),
        trailers: capture.trailers().collect(),
        report,
        damage: damage.map(|error| format!("at offset {}: {}", error.offset, error.damage)),
    }
}
