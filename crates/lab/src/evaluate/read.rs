//! Reads truth, labels and points, recognising files by their content. Sans-IO: the input is octets.
//!
//! A line that cannot be read is an error that names it, because a score of a part of a file would be wrong.

mod asterix;
mod cells;
mod csv;
mod error;
mod gpx;
mod json;
mod kind;
mod parsed;

pub use self::asterix::DayReference;
pub use self::cells::time;
pub use self::error::InputFileError;
pub use self::kind::{FileKind, kind};
pub use self::parsed::{OutputFile, TruthTracks};

use std::collections::BTreeMap;

use super::conflicts::ConflictPrediction;
use super::integrity::{AlertLine, Attack};
use super::labels::Label;

/// Reads a truth: CSV with `time,id,lat,lon,alt_msl`, or GPX. `name` appears in messages; `stem` is the id of a GPX
/// track without a name.
///
/// # Errors
/// The file is neither, or a line of it cannot be read.
pub fn truth(name: &str, stem: &str, octets: &[u8]) -> Result<TruthTracks, InputFileError> {
    refuse_unless(FileKind::Truth, name, octets)?;
    let text = text(name, octets)?;
    if text.trim_start().starts_with('<') { gpx::truth(name, stem, text) } else { csv::truth(name, text) }
}

/// Reads the class of each aircraft from the column `class` of a truth; empty without that column, and for GPX.
///
/// # Errors
/// A line cannot be read.
pub fn classes(name: &str, octets: &[u8]) -> Result<BTreeMap<String, String>, InputFileError> {
    let text = text(name, octets)?;
    if text.trim_start().starts_with('<') { Ok(BTreeMap::new()) } else { csv::classes(name, text) }
}

/// Reads the output of a tracker: any format of `replay`, `expected.csv` of the conformance flights, or any CAT129.
/// `days` determines the day of the first time of day in raw ASTERIX.
///
/// # Errors
/// The file is none of these, or a line or record of it cannot be read.
pub fn output(name: &str, octets: Vec<u8>, days: DayReference) -> Result<OutputFile, InputFileError> {
    refuse_unless(FileKind::Output, name, &octets)?;
    if !kind::is_text(&octets) {
        return asterix::output(name, octets, days);
    }
    let text = text(name, &octets)?;
    let points =
        if text.trim_start().starts_with('{') { json::output(name, text)? } else { csv::output(name, text)? };
    Ok(OutputFile { points, ..OutputFile::default() })
}

/// Reads labels: CSV with `time,sensor,number,id,seduced,identity`. An empty id is not a drone; `seduced` (no) and
/// `identity` (not stated) may be empty or missing.
///
/// # Errors
/// A column is missing, or a line cannot be read.
pub fn labels(name: &str, octets: &[u8]) -> Result<Vec<Label>, InputFileError> {
    refuse_unless(FileKind::Labels, name, octets)?;
    csv::labels(name, text(name, octets)?)
}

/// Reads attacks on transponders: CSV with `id,number,attack,from,until`.
///
/// # Errors
/// A column is missing, or a line cannot be read.
pub fn attacks(name: &str, octets: &[u8]) -> Result<Vec<Attack>, InputFileError> {
    refuse_unless(FileKind::Attacks, name, octets)?;
    csv::attacks(name, text(name, octets)?)
}

/// Reads alerts as `replay --alerts` writes them. The file may be empty.
///
/// # Errors
/// A line cannot be read.
pub fn alerts(name: &str, octets: &[u8]) -> Result<Vec<AlertLine>, InputFileError> {
    if octets.is_empty() { Ok(Vec::new()) } else { json::alerts(name, text(name, octets)?) }
}

/// Reads conflicts as `replay --conflicts` writes them, each with the name of its volume. The file may be empty.
///
/// # Errors
/// A line cannot be read.
pub fn conflicts(name: &str, octets: &[u8]) -> Result<Vec<(String, ConflictPrediction)>, InputFileError> {
    if octets.is_empty() { Ok(Vec::new()) } else { json::conflicts(name, text(name, octets)?) }
}

/// Refuses a file that is evidently of a kind other than `wanted`.
fn refuse_unless(wanted: FileKind, name: &str, octets: &[u8]) -> Result<(), InputFileError> {
    match kind(octets) {
        Some(found) if found != wanted => {
            Err(InputFileError::whole(name, format!("this is {found}, not {wanted}; {}", found.place())))
        }
        _ => Ok(()),
    }
}

/// Returns the text without a byte order mark; refuses empty text.
fn text<'a>(name: &str, octets: &'a [u8]) -> Result<&'a str, InputFileError> {
    let text = str::from_utf8(octets).map_err(|error| {
        let line = octets[..error.valid_up_to()].iter().filter(|&&octet| octet == b'\n').count() as u64 + 1;
        InputFileError::at(name, line, "this is no text in UTF-8; is it the right file?")
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(InputFileError::whole(name, "is empty; did the program that writes it run to its end?"));
    }
    Ok(text)
}
