//! `info`: summary of a capture on one screen.

pub(super) mod site;
mod text;

use std::collections::BTreeMap;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;

use serde::{Serialize, Serializer};
use tracing::{error, warn};

use super::{CommandResult, Outcome, progress};
use input::capture::{
    Capture, CaptureFormat, OpenError, ReadError, SiteReceivers, SkippedFrames, StampKind, Trailer,
};
use input::survey::{Survey, SurveyReport};
use picture::decode::lost_frames;

/// Summarises captures: senders, counts, times, and signs of faults
///
/// For each input the report lists streams (sender and destination), sources (SAC/SIC) with the regularity and delay of their
/// reports, items, categories, errors, and the sensors for a configuration. A gap is a silence of a source longer than five times
/// its usual interval and longer than a second. A delay is the time from the time of day in a record to its reception. Medians
/// are accurate to 3 %. The exit code is 4 if octets of a raw file or of a FINAL, ORADIS or GPS recording could not be read.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Args {
    /// Capture files (raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR, MAVLink log; also gzip-compressed), or - for standard
    /// input. Each is reported separately
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Prints one JSON object per input, one per line
    #[arg(long)]
    pub json: bool,
    /// Time stamps in Beast and AVR files: a 12 MHz counter, or seconds of the UTC day and nanoseconds (Radarcape). auto
    /// determines the kind from the first frames
    #[arg(long, value_enum, value_name = "KIND", default_value = "auto")]
    pub stamps: StampKind,
    /// Writes a configuration with the detected sensors to this file, and marks the values to be filled in
    #[arg(long, value_name = "FILE")]
    pub config_out: Option<PathBuf>,
    /// Ends with exit code 4 if any data could not be read, in pcap and pcapng files too
    #[arg(long)]
    pub strict: bool,
}

/// Report on an input.
#[derive(Serialize)]
struct InputSummary {
    input: String,
    #[serde(serialize_with = "as_text")]
    format: CaptureFormat,
    /// Size of the file, or octets read from a pipe.
    size: u64,
    /// Number of frames without a whole UDP datagram, by reason.
    #[serde(serialize_with = "by_reason")]
    skipped: SkippedFrames,
    /// Number of these frames that may have contained records.
    lost_frames: u64,
    /// Streams whose datagrams have further octets after their blocks.
    trailers: Vec<Trailer>,
    #[serde(flatten)]
    report: SurveyReport,
    /// Reason why the input could not be read to its end.
    damage: Option<String>,
}

impl InputSummary {
    /// Whether octets of an ASTERIX-only file could not be read; if `strict`, whether any input had errors.
    fn is_bad(&self, strict: bool) -> bool {
        let unread = !self.report.unread.is_empty();
        unread && self.format.is_asterix_only() || strict && self.lost_frames + self.report.error_count() > 0
    }
}

fn as_text<S: Serializer>(format: &CaptureFormat, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(format)
}

fn by_reason<S: Serializer>(skipped: &SkippedFrames, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(skipped.iter().map(|(reason, count)| (reason.to_string(), count)))
}

/// Reads each input to its end, or to where it is damaged, and writes the report to `out`.
///
/// # Errors
/// An input cannot be opened, or the file of `--config-out` exists already; both are found before anything is printed. `out` or
/// that file cannot be written; a closed pipe is returned as its [`io::Error`]. Damage is reported and logged, and the next input
/// is read.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    args.config_out.as_deref().map_or(Ok(()), |file| site::check(file, "--config-out"))?;
    let captures = args
        .inputs
        .iter()
        .map(|path| {
            Ok(Capture::open(path)?.with_receivers(&SiteReceivers::default().with_stamps(args.stamps)))
        })
        .collect::<Result<Vec<_>, OpenError>>()?;
    let mut out = BufWriter::new(out);
    let mut outcome = Outcome::Done;
    let mut sensors = Vec::new();
    let mut is_offered = false;
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
        // The report can be read while the next input is processed.
        out.flush()?;
        is_offered |= text::can_locate(&info.report.sensors);
        sensors.extend(info.report.sensors);
    }
    let inputs: Vec<String> = args.inputs.iter().map(|input| input.display().to_string()).collect();
    // A radar and the transponders may be in different files.
    if !args.json && !is_offered && text::can_locate(&sensors) {
        let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
        write!(out, "\n{}", text::locate_hint(&sensors, &inputs))?;
        out.flush()?;
    }
    if let Some(file) = &args.config_out {
        site::write(file, "--config-out", &inputs, sensors, &BTreeMap::new())?;
        tracing::info!("{0}: written; `utm-fusion check {0}` names what is to be filled in", file.display());
    }
    Ok(outcome)
}

fn survey(mut capture: Capture) -> InputSummary {
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
    InputSummary {
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
