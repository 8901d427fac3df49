//! Initial state of a replay: from the directory of `[state]`, or from files beside a recording.

use std::io;
use std::path::{Path, PathBuf};

use super::{
    CORRELATIONS, ENGINE, NUMBERS, REGISTRATION, RecordedDecisions, SavedRegistrations, read_correlations,
    read_numbers, read_registration,
};
use fusion::numbering::Given;

/// State of an earlier run.
#[derive(Clone, Debug, Default)]
pub struct SavedState {
    /// Assigned transponder numbers.
    pub numbers: Vec<Given>,
    /// Registration of the radars.
    pub registrations: SavedRegistrations,
    /// Operators' decisions during the recording.
    pub correlations: RecordedDecisions,
    /// State of the engine before the recording's first datagram ([`EngineState`](super::EngineState)).
    pub engine: Option<Vec<u8>>,
}

/// Reads the state at a path. The path is a directory with `numbers.json` and `registration.json`, or one of these two
/// files. In a recording it is `<name>.numbers.json`, `<name>.registration.json`, or `<name>` with or without `.pcap`.
/// Either file may be missing. A recording's `<name>.decisions.jsonl` and `<name>.engine` are read too, if they exist.
///
/// # Errors
/// Neither file exists, or one cannot be read or is invalid; the error names it.
pub fn read_kept(path: &Path) -> io::Result<SavedState> {
    let (numbers, registration) = files(path);
    let numbers = read_numbers(&numbers);
    let registrations = match registration {
        Some(file) => match read_registration(&file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            read => Some(read?),
        },
        None => None,
    };
    let numbers = match (numbers, &registrations) {
        (Err(error), Some(_)) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
        (numbers, _) => numbers?,
    };
    let correlations = if path.is_dir() { RecordedDecisions::default() } else { read_beside(path)? };
    let engine = if path.is_dir() { None } else { engine_beside(path)? };
    Ok(SavedState { numbers, registrations: registrations.unwrap_or_default(), correlations, engine })
}

fn engine_beside(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let path = beside(path, ENGINE);
    match std::fs::read(&path) {
        Ok(octets) => Ok(Some(octets)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(io::Error::new(error.kind(), format!("{}: {error}", path.display()))),
    }
}

/// Operators' decisions during this file of a recording; empty if there is no such file beside it. The path may be any of
/// the recording's files, or their common name.
///
/// # Errors
/// The file cannot be read, or is invalid; the error names the file and the line.
pub fn read_beside(path: &Path) -> io::Result<RecordedDecisions> {
    match read_correlations(&beside(path, CORRELATIONS)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(RecordedDecisions::default()),
        read => read,
    }
}

/// Transponder numbers in use in this file of a recording; empty if there is no such file beside it. The path is as for
/// [`read_beside`].
///
/// # Errors
/// The file cannot be read, or is invalid; the error names it.
pub fn read_numbers_beside(path: &Path) -> io::Result<Vec<Given>> {
    match read_numbers(&beside(path, NUMBERS)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        read => read,
    }
}

/// Path of the file with the ending `wanted` in the same recording.
fn beside(path: &Path, wanted: &str) -> PathBuf {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let ends = [NUMBERS, REGISTRATION, CORRELATIONS, ENGINE, "pcap", "pcap.part", "pcap.gz"];
    let stem = ends.iter().find_map(|end| name.strip_suffix(end)?.strip_suffix('.')).unwrap_or(name);
    path.with_file_name(format!("{stem}.{wanted}"))
}

/// Paths of the numbers, and of the registration.
fn files(path: &Path) -> (PathBuf, Option<PathBuf>) {
    if path.is_dir() {
        return (path.join(NUMBERS), Some(path.join(REGISTRATION)));
    }
    let beside = |name: &str| path.with_file_name(name);
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let of =
        |stem: &str| (beside(&format!("{stem}{NUMBERS}")), Some(beside(&format!("{stem}{REGISTRATION}"))));
    if let Some(stem) = name.strip_suffix(NUMBERS).or_else(|| name.strip_suffix(REGISTRATION)) {
        return of(stem);
    }
    let stem = name.strip_suffix(".pcap").unwrap_or(name);
    // A file of another name contains numbers.
    if path.is_file() && stem == name { (path.to_owned(), None) } else { of(&format!("{stem}.")) }
}
