//! Output as CAT129: raw, or in a capture.

use std::collections::BTreeMap;
use std::io::Cursor;

use asterix::cat129::fusion_report::Source;
use asterix::cat129::{Altitude, FusionReport, Record, WholeSerial};
use asterix::{Record as _, blocks};
use jiff::SignedDuration;
use jiff::civil::Date;

use super::error::InputFileError;
use super::parsed::OutputFile;
use crate::evaluate::place::GeodeticPlace;
use crate::evaluate::types::{OutputPoint, PointFlags, PointSource};
use fusion::Identity;
use fusion::integrity::{Reasons, State};
use fusion::time::Time;
use input::capture::{Capture, CapturedDatagram, OpenError, PayloadKind};
use input::normalise::nearest_day;
use picture::serial_text;

/// Day of the first time of day in a file without dates; each later time takes the day nearest to the previous one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DayReference {
    /// This UTC day.
    From(Date),
    /// The day that puts it nearest to this time, which comes from the truth.
    Near(Time),
}

impl DayReference {
    /// Time to which the first time of day is nearest.
    fn reference(self) -> Option<Time> {
        match self {
            Self::Near(time) => Some(time),
            // From noon, that day is always the nearest.
            Self::From(date) => Some(Time::midnight(date)? + SignedDuration::from_hours(12)),
        }
    }
}

/// Reads the CAT129 records of a raw file or a capture; other categories are skipped.
pub(super) fn output(name: &str, octets: Vec<u8>, days: DayReference) -> Result<OutputFile, InputFileError> {
    let size = octets.len() as u64;
    let capture = Capture::from_reader(name.to_owned(), Box::new(Cursor::new(octets)), Some(size));
    let capture = capture.map_err(|error| match error {
        OpenError::Foreign { found, .. } => InputFileError::whole(
            name,
            format!(
                "looks like {found}, which cannot be scored; give what `replay -o` writes (.ast .pcap .ndjson .geojson .csv)"
            ),
        ),
        other => other.into(),
    })?;
    let mut reader =
        RecordReader { name, last: days.reference(), serials: BTreeMap::new(), points: Vec::new() };
    for datagram in capture {
        reader.datagram(&datagram?)?;
    }
    reader.finish()
}

/// Converts the flags of a record. CAT129 has no reasons, and no flag for a transponder that is not suspect.
fn flags(flags: asterix::cat129::fusion_report::Flags) -> PointFlags {
    use asterix::cat129::fusion_report::Flags as Bits;
    let state = match flags {
        _ if flags.contains(Bits::INTEGRITY_FAILED) => Some(State::Failed),
        _ if flags.contains(Bits::INTEGRITY_SUSPECT) => Some(State::Suspect),
        _ => None,
    };
    PointFlags {
        integrity: state.map(|state| (state, Reasons::default())),
        is_uncooperative: flags.contains(Bits::UNCOOPERATIVE),
    }
}

/// Name of the transponder from the record's serial number (I129/040). `None` if it is the track number (a choice of
/// `[output] serial`), or blank, as for an aircraft without a serial number.
fn identity(record: &Record, report: &FusionReport) -> Option<String> {
    report.transponder?;
    let serial_number = record.serial_number?;
    let whole = record.special_purpose.as_ref().and_then(WholeSerial::read);
    let serial = whole.as_ref().map_or(&serial_number[..], |whole| whole.octets());
    let name = serial_text(Identity::new(serial, None)?);
    (name.parse() != Ok(report.track_number)).then_some(name)
}

struct RecordReader<'a> {
    name: &'a str,
    /// Reference for the next time of day, in a file without times of reception.
    last: Option<Time>,
    /// Numbers for records that have none, by order of appearance.
    serials: BTreeMap<[u8; 12], u32>,
    /// Points, and whether each states its source.
    points: Vec<(OutputPoint, bool)>,
}

impl RecordReader<'_> {
    fn datagram(&mut self, datagram: &CapturedDatagram) -> Result<(), InputFileError> {
        if datagram.contents == PayloadKind::Unframed {
            let (octets, offset) = (datagram.payload.len(), datagram.origin);
            let what =
                format!("at offset {offset}: {octets} octets belong to no block; is the file damaged?");
            return Err(InputFileError::whole(self.name, what));
        }
        let fault = |mut fault: asterix::Fault| {
            fault.offset += datagram.origin as usize;
            InputFileError::whole(self.name, format!("{fault}; is the file damaged?"))
        };
        let mut records = Vec::new();
        for block in blocks(&datagram.payload) {
            let block = block.map_err(fault)?;
            if block.category == Record::CATEGORY {
                for located in block.records::<Record>() {
                    let located = located.map_err(fault)?;
                    records.push((datagram.origin + located.offset as u64, located.record));
                }
            }
        }
        records.iter().try_for_each(|(offset, record)| self.record(datagram.received, *offset, record))
    }

    fn record(&mut self, received: Option<Time>, offset: u64, record: &Record) -> Result<(), InputFileError> {
        let error = |what: &str| {
            InputFileError::whole(
                self.name,
                format!("the record at offset {offset} has no {what}; it cannot be scored"),
            )
        };
        let count = record.time_of_day.ok_or_else(|| error("time of day (I129/070)"))?.count();
        let reference = received.or(self.last).ok_or_else(|| error("day; give another --date"))?;
        let time = nearest_day(count, reference).ok_or_else(|| error("time of day below 24 h (I129/070)"))?;
        let position = record.position.filter(|position| position.in_range());
        let position = position.ok_or_else(|| error("position on Earth (I129/080)"))?;
        self.last = Some(time);
        let report = record.special_purpose.as_ref().and_then(FusionReport::read);
        let number = match &report {
            Some(report) => report.track_number,
            None => {
                let next = self.serials.len() as u32 + 1;
                *self.serials.entry(record.serial_number.unwrap_or_default()).or_insert(next)
            }
        };
        let point = OutputPoint {
            time,
            place: GeodeticPlace {
                latitude_deg: position.latitude_deg(),
                longitude_deg: position.longitude_deg(),
                altitude_amsl_m: record.altitude_amsl.map(Altitude::metres),
            },
            source: match report.as_ref().map(|report| report.source) {
                Some(Source::Fused) | None => PointSource::Fused,
                Some(Source::Radar) => PointSource::Radar,
                Some(Source::Transponder) => PointSource::Transponder,
                Some(Source::Camera) => PointSource::Camera,
            },
            number,
            radar_track: report.as_ref().and_then(|report| report.radar_track),
            sensor: None,
            transponder: report.as_ref().and_then(|report| report.transponder),
            identity: report.as_ref().and_then(|report| identity(record, report)),
            covariance: None,
            flags: report.as_ref().map_or_else(PointFlags::default, |report| flags(report.flags)),
        };
        self.points.push((point, report.is_some()));
        Ok(())
    }

    fn finish(self) -> Result<OutputFile, InputFileError> {
        if self.points.is_empty() {
            return Err(InputFileError::whole(
                self.name,
                "holds no CAT129 record; is it the output of a tracker?",
            ));
        }
        let all = self.points.len() as u64;
        let says_so = self.points.iter().filter(|(_, says_so)| *says_so).count() as u64;
        // If some records state a source, records without one are the tracker's input.
        let unknown_sources = if says_so == 0 { all } else { 0 };
        let points = self.points.into_iter().filter(|(_, is_ours)| *is_ours || says_so == 0);
        Ok(OutputFile {
            points: points.map(|(point, _)| point).collect(),
            unknown_sources,
            inputs: all - says_so - unknown_sources,
        })
    }
}
