//! Reads comma-separated values with a header: truth, labels, and points.

use std::collections::BTreeMap;
use std::str::FromStr;

use csv::{ErrorKind, Position, ReaderBuilder, StringRecord, Trim};

use super::cells;
use super::error::InputFileError;
use super::parsed::TruthTracks;
use crate::evaluate::integrity::{Attack, AttackKind};
use crate::evaluate::labels::Label;
use crate::evaluate::place::GeodeticPlace;
use crate::evaluate::types::{OutputPoint, PointFlags, PointSource};
use fusion::time::Time;

/// Plausible heights of aircraft, metres.
const HEIGHTS_M: (f64, f64) = (-1_000.0, 100_000.0);

/// Reads `time,id,lat,lon,alt_msl`; further columns are ignored.
pub(super) fn truth(name: &str, text: &str) -> Result<TruthTracks, InputFileError> {
    let columns = CsvColumns::of(name, text, &["time", "id", "lat", "lon", "alt_msl"])?;
    let mut tracks: BTreeMap<String, Vec<(Time, GeodeticPlace)>> = BTreeMap::new();
    for row in columns.rows(text) {
        let row = row?;
        let id = row.text("id");
        if id.is_empty() {
            return Err(row.error("the drone has no id; write one into the column `id`"));
        }
        let sample = (row.time("time")?, row.place()?);
        match tracks.get_mut(id) {
            Some(samples) => samples.push(sample),
            None => {
                tracks.insert(id.to_owned(), vec![sample]);
            }
        }
    }
    Ok(tracks.into_iter().collect())
}

/// Reads the classes of the aircraft: `id` and `class`. The first class of an aircraft counts.
pub(super) fn classes(name: &str, text: &str) -> Result<BTreeMap<String, String>, InputFileError> {
    let columns = CsvColumns::of(name, text, &["id"])?;
    let mut classes = BTreeMap::new();
    for row in columns.rows(text) {
        let row = row?;
        if let (Some(id), Some(class)) = (row.filled("id"), row.filled("class")) {
            classes.entry(id).or_insert(class);
        }
    }
    Ok(classes)
}

/// Reads `time,sensor,number,id,seduced,identity`. An empty id is not a drone; `seduced` (no) and `identity` (not
/// stated) may be empty or missing.
pub(super) fn labels(name: &str, text: &str) -> Result<Vec<Label>, InputFileError> {
    let columns = CsvColumns::of(name, text, &["time", "sensor", "number", "id"])?;
    columns.rows(text).map(|row| label(&row?)).collect()
}

fn label(row: &CsvRow<'_>) -> Result<Label, InputFileError> {
    let seduced = match row.text("seduced") {
        "" | "0" | "false" => false,
        "1" | "true" => true,
        other => return Err(row.error(format!("seduced: {other:?} is neither 1 nor 0; an empty cell is 0"))),
    };
    Ok(Label {
        time: row.time("time")?,
        sensor: row.text("sensor").to_owned(),
        number: row.integer("number")?,
        id: row.filled("id"),
        seduced,
        identity: row.filled("identity"),
    })
}

/// Reads `id,number,attack,from,until`.
pub(super) fn attacks(name: &str, text: &str) -> Result<Vec<Attack>, InputFileError> {
    let columns = CsvColumns::of(name, text, &["id", "number", "attack", "from", "until"])?;
    columns.rows(text).map(|row| attack(&row?)).collect()
}

fn attack(row: &CsvRow<'_>) -> Result<Attack, InputFileError> {
    let kind = AttackKind::of_name(row.text("attack")).ok_or_else(|| {
        let names = AttackKind::ALL.map(AttackKind::name).join(", ");
        row.error(format!("attack: {:?} is none of {names}", row.text("attack")))
    })?;
    let (from, until) = (row.time("from")?, row.time("until")?);
    let (id, number) = (row.text("id").to_owned(), row.integer("number")?);
    Ok(Attack { id, number, kind, from, until })
}

/// Reads points as `replay` writes them (`source`, `track_number`), or as in the conformance flights (`kind`,
/// `number`).
pub(super) fn output(name: &str, text: &str) -> Result<Vec<OutputPoint>, InputFileError> {
    let columns = CsvColumns::of(name, text, &["time", "lat", "lon"])?;
    let source = columns.one_of(&["source", "kind"])?;
    let number = columns.one_of(&["track_number", "number"])?;
    columns.rows(text).map(|row| point(&row?, source, number)).collect()
}

fn point(row: &CsvRow<'_>, source: &str, number: &str) -> Result<OutputPoint, InputFileError> {
    let source = match row.text(source) {
        "fused" => PointSource::Fused,
        "radar" => PointSource::Radar,
        "transponder" => PointSource::Transponder,
        "camera" => PointSource::Camera,
        other => {
            return Err(
                row.error(format!("{source}: {other:?} is none of fused, radar, transponder, camera"))
            );
        }
    };
    Ok(OutputPoint {
        time: row.time("time")?,
        place: row.place()?,
        source,
        number: row.integer(number)?,
        radar_track: row.optional("radar_track")?,
        sensor: sensor(row.text("id")).map(str::to_owned),
        transponder: row.optional("transponder")?,
        identity: row.filled("identity"),
        covariance: None,
        flags: flags(row)?,
    })
}

/// The columns for integrity exist only if it was assessed.
fn flags(row: &CsvRow<'_>) -> Result<PointFlags, InputFileError> {
    let reasons = row.text("reasons").split('+').filter(|reason| !reason.is_empty());
    let integrity = match row.text("integrity") {
        "" => None,
        state => Some(cells::integrity(state, reasons).map_err(|what| row.error(what))?),
    };
    let is_uncooperative = match row.text("uncooperative") {
        "" | "0" | "false" => false,
        "1" | "true" => true,
        other => return Err(row.error(format!("uncooperative: {other:?} is neither true nor false"))),
    };
    Ok(PointFlags { integrity, is_uncooperative })
}

/// Id of the radar within a radar track's id, `R-<sensor>-<number>-<first seen>`.
fn sensor(id: &str) -> Option<&str> {
    let (rest, _first_seen) = id.strip_prefix("R-")?.rsplit_once('-')?;
    rest.rsplit_once('-').map(|(sensor, _number)| sensor)
}

/// Names of the columns.
struct CsvColumns<'a> {
    name: &'a str,
    names: StringRecord,
}

/// A row below the header.
struct CsvRow<'c> {
    columns: &'c CsvColumns<'c>,
    line: u64,
    cells: StringRecord,
}

impl<'a> CsvColumns<'a> {
    fn of(name: &'a str, text: &str, required: &[&'static str]) -> Result<Self, InputFileError> {
        let names = reader(text).headers().map_err(|error| csv_error(name, text, &error))?.clone();
        let columns = Self { name, names };
        for &column in required {
            columns.one_of(&[column])?;
        }
        Ok(columns)
    }

    /// Returns the first of these names that is a column.
    fn one_of(&self, names: &[&'static str]) -> Result<&'static str, InputFileError> {
        let found = names.iter().find(|&&name| self.names.iter().any(|column| column == name));
        found.copied().ok_or_else(|| {
            let wanted = names.join("` or `");
            let found = self.names.iter().collect::<Vec<_>>().join(",");
            let what =
                format!("no column `{wanted}`; the first line must name the columns, and it is {found:?}");
            InputFileError::at(self.name, 1, what)
        })
    }

    fn rows(&self, text: &str) -> impl Iterator<Item = Result<CsvRow<'_>, InputFileError>> {
        reader(text).into_records().map(move |record| match record {
            Ok(cells) => Ok(CsvRow { columns: self, line: line_of(text, cells.position()), cells }),
            Err(error) => Err(csv_error(self.name, text, &error)),
        })
    }
}

/// Line number of a record, from 1. The reported position may be before blank lines.
fn line_of(text: &str, position: Option<&Position>) -> u64 {
    let Some(position) = position else { return 1 };
    let rest = text.as_bytes().get(position.byte() as usize..).unwrap_or_default();
    let blank = rest.iter().take_while(|octet| octet.is_ascii_whitespace());
    position.line() + blank.filter(|&&octet| octet == b'\n').count() as u64
}

fn reader(text: &str) -> csv::Reader<&[u8]> {
    ReaderBuilder::new().trim(Trim::All).from_reader(text.as_bytes())
}

fn csv_error(name: &str, text: &str, error: &csv::Error) -> InputFileError {
    let line = line_of(text, error.position());
    match error.kind() {
        ErrorKind::UnequalLengths { expected_len, len, .. } => InputFileError::at(
            name,
            line,
            format!(
                "{len} cells, and {expected_len} columns are named; was the file cut, or edited by hand?"
            ),
        ),
        _ => InputFileError::at(name, line, error.to_string()),
    }
}

impl CsvRow<'_> {
    fn error(&self, what: impl Into<String>) -> InputFileError {
        InputFileError::at(self.columns.name, self.line, what)
    }

    /// Text in a column; empty if there is no such column.
    fn text(&self, column: &str) -> &str {
        let place = self.columns.names.iter().position(|name| name == column);
        place.and_then(|place| self.cells.get(place)).unwrap_or_default()
    }

    /// Text in a column, if it is not empty.
    fn filled(&self, column: &str) -> Option<String> {
        Some(self.text(column)).filter(|text| !text.is_empty()).map(str::to_owned)
    }

    fn time(&self, column: &str) -> Result<Time, InputFileError> {
        let text = self.text(column);
        cells::time(text).ok_or_else(|| {
            self.error(format!(
                "{column}: {text:?} is no time; write seconds UTC since 1970 (1773478800.25) or RFC 3339 (2026-03-14T09:00:00.25Z)"
            ))
        })
    }

    fn place(&self) -> Result<GeodeticPlace, InputFileError> {
        Ok(GeodeticPlace {
            latitude_deg: self.number("lat", (-90.0, 90.0), "degrees")?,
            longitude_deg: self.number("lon", (-180.0, 180.0), "degrees")?,
            altitude_amsl_m: match self.text("alt_msl") {
                "" => None,
                _ => Some(self.number("alt_msl", HEIGHTS_M, "metres")?),
            },
        })
    }

    fn number(&self, column: &str, (low, high): (f64, f64), unit: &str) -> Result<f64, InputFileError> {
        let text = self.text(column);
        cells::number(text, low, high).ok_or_else(|| {
            self.error(format!("{column}: {text:?} is no number of {unit} from {low} to {high}"))
        })
    }

    fn integer<T: FromStr>(&self, column: &str) -> Result<T, InputFileError> {
        let text = self.text(column);
        text.parse().map_err(|_| self.error(format!("{column}: {text:?} is no track number")))
    }

    fn optional<T: FromStr>(&self, column: &str) -> Result<Option<T>, InputFileError> {
        if self.text(column).is_empty() { Ok(None) } else { self.integer(column).map(Some) }
    }
}
