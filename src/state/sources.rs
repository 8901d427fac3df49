//! What a replay begins with: the directory of `[state]`, or what stands beside a recording.

use std::io;
use std::path::{Path, PathBuf};

use super::{
    CORRELATIONS, Correlations, ENGINE, NUMBERS, REGISTRATION, Registrations, read_correlations,
    read_numbers, read_registration,
};
use fusion::numbering::Given;

/// The state of an earlier run.
#[derive(Clone, Debug, Default)]
pub struct SavedState {
    /// The transponder numbers given.
    pub numbers: Vec<Given>,
    /// The radars' registration.
    pub registrations: Registrations,
    /// Operators' decisions while the recording was made.
    pub correlations: Correlations,
    /// The state of the engine before the recording's first datagram, [`EngineState`](super::EngineState).
    pub engine: Option<Vec<u8>>,
}

/// Reads what is kept at a path: a directory with `numbers.json` and `registration.json`, one of these two files, in a
/// recording `<name>.numbers.json` and `<name>.registration.json`, or `<name>` alone, with `.pcap` or without. The other file
/// is taken with it; one of them may be missing. So are `<name>.decisions.jsonl`, where something was decided, and `<name>.engine`,
/// where the state is known.
///
/// # Errors
/// Neither exists, or one cannot be read or not be understood; the error names it.
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
    let correlations = if path.is_dir() { Correlations::default() } else { read_beside(path)? };
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

/// What operators decided while this file of a recording was made; nothing where there is no such file beside it. The name
/// may be that of any of its files, or what they have in common.
///
/// # Errors
/// It cannot be read, or not be understood; the error names it, and the line.
pub fn read_beside(path: &Path) -> io::Result<Correlations> {
    match read_correlations(&beside(path, CORRELATIONS)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Correlations::default()),
        read => read,
    }
}

/// The transponder numbers that are in use in this file of a recording; none where there is no such file beside it. The name
/// is as for [`read_beside`].
///
/// # Errors
/// It cannot be read, or not be understood; the error names it.
pub fn read_numbers_beside(path: &Path) -> io::Result<Vec<Given>> {
    match read_numbers(&beside(path, NUMBERS)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        read => read,
    }
}

/// The file of that end beside one of a recording's.
fn beside(path: &Path, wanted: &str) -> PathBuf {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let ends = [NUMBERS, REGISTRATION, CORRELATIONS, ENGINE, "pcap", "pcap.part", "pcap.gz"];
    let stem = ends.iter().find_map(|end| name.strip_suffix(end)?.strip_suffix('.')).unwrap_or(name);
    path.with_file_name(format!("{stem}.{wanted}"))
}

/// Where the numbers are, and where the registration would be.
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
    // A file of another name holds numbers.
    if path.is_file() && stem == name { (path.to_owned(), None) } else { of(&format!("{stem}.")) }
}
