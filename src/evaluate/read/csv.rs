//! Comma-separated values with a line of names first: truth, labels, and points.

use std::collections::BTreeMap;
use std::str::FromStr;

use csv::{ErrorKind, Position, ReaderBuilder, StringRecord, Trim};

use super::cells;
use super::error::FileError;
use super::parsed::Tracks;
use crate::evaluate::integrity::{Attack, AttackKind};
use crate::evaluate::labels::Label;
use crate::evaluate::place::Place;
use crate::evaluate::types::{Flags, OutputPoint, PointSource};
use fusion::time::Time;

/// Heights that something which flies can have, metres.
const HEIGHTS_M: (f64, f64) = (-1_000.0, 100_000.0);

/// `time,id,lat,lon,alt_msl`; further columns are passed over.
pub(super) fn truth(name: &str, text: &str) -> Result<Tracks, FileError> {
    let columns = Columns::of(name, text, &["time", "id", "lat", "lon", "alt_msl"])?;
    let mut tracks: BTreeMap<String, Vec<(Time, Place)>> = BTreeMap::new();
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

/// `time,sensor,number,id,seduced,identity`; an empty id is no drone, `seduced` (no) and `identity` (not stated) may be empty or
/// missing.
pub(super) fn labels(name: &str, text: &str) -> Result<Vec<Label>, FileError> {
    let columns = Columns::of(name, text, &["time", "sensor", "number", "id"])?;
    columns.rows(text).map(|row| label(&row?)).collect()
}

fn label(row: &Row<'_>) -> Result<Label, FileError> {
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

/// `id,number,attack,from,until`.
pub(super) fn attacks(name: &str, text: &str) -> Result<Vec<Attack>, FileError> {
    let columns = Columns::of(name, text, &["id", "number", "attack", "from", "until"])?;
    columns.rows(text).map(|row| attack(&row?)).collect()
}

fn attack(row: &Row<'_>) -> Result<Attack, FileError> {
    let kind = AttackKind::of_name(row.text("attack")).ok_or_else(|| {
        let names = AttackKind::ALL.map(AttackKind::name).join(", ");
        row.error(format!("attack: {:?} is none of {names}", row.text("attack")))
    })?;
    let (from, until) = (row.time("from")?, row.time("until")?);
    let (id, number) = (row.text("id").to_owned(), row.integer("number")?);
    Ok(Attack { id, number, kind, from, until })
}

/// Points as `replay` writes them (`source`, `track_number`), or as the conformance flights have them (`kind`,
/// `number`).
pub(super) fn output(name: &str, text: &str) -> Result<Vec<OutputPoint>, FileError> {
    let columns = Columns::of(name, text, &["time", "lat", "lon"])?;
    let source = columns.one_of(&["source", "kind"])?;
    let number = columns.one_of(&["track_number", "number"])?;
    columns.rows(text).map(|row| point(&row?, source, number)).collect()
}

fn point(row: &Row<'_>, source: &str, number: &str) -> Result<OutputPoint, FileError> {
    let source = match row.text(source) {
        "fused" => PointSource::Fused,
        "radar" => PointSource::Radar,
        "transponder" => PointSource::Transponder,
        other => {
            return Err(row.error(format!("{source}: {other:?} is none of fused, radar, transponder")));
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

/// Only where a transponder's integrity was judged are there columns for it.
fn flags(row: &Row<'_>) -> Result<Flags, FileError> {
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
    Ok(Flags { integrity, is_uncooperative })
}

/// The radar in the id of a radar's track, `R-<sensor>-<number>-<first seen>`.
fn sensor(id: &str) -> Option<&str> {
    let (rest, _first_seen) = id.strip_prefix("R-")?.rsplit_once('-')?;
    rest.rsplit_once('-').map(|(sensor, _number)| sensor)
}

/// The names of the columns.
struct Columns<'a> {
    name: &'a str,
    names: StringRecord,
}

/// A line below them.
struct Row<'c> {
    columns: &'c Columns<'c>,
    line: u64,
    cells: StringRecord,
}

impl<'a> Columns<'a> {
    fn of(name: &'a str, text: &str, required: &[&'static str]) -> Result<Self, FileError> {
        let names = reader(text).headers().map_err(|error| csv_error(name, text, &error))?.clone();
        let columns = Self { name, names };
        for &column in required {
            columns.one_of(&[column])?;
        }
        Ok(columns)
    }

    /// The one of these names that there is.
    fn one_of(&self, names: &[&'static str]) -> Result<&'static str, FileError> {
        let found = names.iter().find(|&&name| self.names.iter().any(|column| column == name));
        found.copied().ok_or_else(|| {
            let wanted = names.join("` or `");
            let found = self.names.iter().collect::<Vec<_>>().join(",");
            let what =
                format!("no column `{wanted}`; the first line must name the columns, and it is {found:?}");
            FileError::at(self.name, 1, what)
        })
    }

    fn rows(&self, text: &str) -> impl Iterator<Item = Result<Row<'_>, FileError>> {
        reader(text).into_records().map(move |record| match record {
            Ok(cells) => Ok(Row { columns: self, line: line_of(text, cells.position()), cells }),
            Err(error) => Err(csv_error(self.name, text, &error)),
        })
    }
}

/// The line of a record, counted from 1: where it is told to begin, blank lines may come first.
fn line_of(text: &str, position: Option<&Position>) -> u64 {
    let Some(position) = position else { return 1 };
    let rest = text.as_bytes().get(position.byte() as usize..).unwrap_or_default();
    let blank = rest.iter().take_while(|octet| octet.is_ascii_whitespace());
    position.line() + blank.filter(|&&octet| octet == b'\n').count() as u64
}

fn reader(text: &str) -> csv::Reader<&[u8]> {
    ReaderBuilder::new().trim(Trim::All).from_reader(text.as_bytes())
}

fn csv_error(name: &str, text: &str, error: &csv::Error) -> FileError {
    let line = line_of(text, error.position());
    match error.kind() {
        ErrorKind::UnequalLengths { expected_len, len, .. } => FileError::at(
            name,
            line,
            format!(
                "{len} cells, and {expected_len} columns are named; was the file cut, or edited by hand?"
            ),
        ),
        _ => FileError::at(name, line, error.to_string()),
    }
}

impl Row<'_> {
    fn error(&self, what: impl Into<String>) -> FileError {
        FileError::at(self.columns.name, self.line, what)
    }

    /// What stands in a column; nothing where there is no such column.
    fn text(&self, column: &str) -> &str {
        let place = self.columns.names.iter().position(|name| name == column);
        place.and_then(|place| self.cells.get(place)).unwrap_or_default()
    }

    /// The same, if it is not empty.
    fn filled(&self, column: &str) -> Option<String> {
        Some(self.text(column)).filter(|text| !text.is_empty()).map(str::to_owned)
    }

    fn time(&self, column: &str) -> Result<Time, FileError> {
        let text = self.text(column);
        cells::time(text).ok_or_else(|| {
            self.error(format!(
                "{column}: {text:?} is no time; write seconds UTC since 1970 (1773478800.25) or RFC 3339 (2026-03-14T09:00:00.25Z)"
            ))
        })
    }

    fn place(&self) -> Result<Place, FileError> {
        Ok(Place {
            latitude_deg: self.number("lat", (-90.0, 90.0), "degrees")?,
            longitude_deg: self.number("lon", (-180.0, 180.0), "degrees")?,
            altitude_amsl_m: match self.text("alt_msl") {
                "" => None,
                _ => Some(self.number("alt_msl", HEIGHTS_M, "metres")?),
            },
        })
    }

    fn number(&self, column: &str, (low, high): (f64, f64), unit: &str) -> Result<f64, FileError> {
        let text = self.text(column);
        cells::number(text, low, high).ok_or_else(|| {
            self.error(format!("{column}: {text:?} is no number of {unit} from {low} to {high}"))
        })
    }

    fn integer<T: FromStr>(&self, column: &str) -> Result<T, FileError> {
        let text = self.text(column);
        text.parse().map_err(|_| self.error(format!("{column}: {text:?} is no track number")))
    }

    fn optional<T: FromStr>(&self, column: &str) -> Result<Option<T>, FileError> {
        if self.text(column).is_empty() { Ok(None) } else { self.integer(column).map(Some) }
    }
}
