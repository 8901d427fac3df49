//! What a replay begins with: the directory of `[state]`, or what stands beside a recording.

use std::io;
use std::path::{Path, PathBuf};

use super::{NUMBERS, REGISTRATION, Registrations, read_numbers, read_registration};
use crate::fusion::Given;

/// What an earlier life knew.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// The transponder numbers given.
    pub numbers: Vec<Given>,
    /// How the radars are set up wrongly.
    pub registrations: Registrations,
}

/// Reads what is kept at a path: a directory with `numbers.json` and `registration.json`, one of these two files, in a
/// recording `<name>.numbers.json` and `<name>.registration.json`, or `<name>` alone, with `.pcap` or without. The other file
/// is taken with it; one of them may be missing.
///
/// # Errors
/// Neither exists, or one cannot be read or not be understood; the error names it.
pub fn read_kept(path: &Path) -> io::Result<Kept> {
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
    Ok(Kept { numbers, registrations: registrations.unwrap_or_default() })
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
