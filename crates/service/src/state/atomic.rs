//! Atomic writes of state files.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file atomically: after a crash it has either the old or the new contents.
///
/// # Errors
/// The directory or the file cannot be written.
pub fn write_atomically(path: &Path, contents: impl AsRef<[u8]>) -> io::Result<()> {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let part = PathBuf::from(part);
    #[expect(clippy::disallowed_methods, reason = "the state is a file")]
    let mut file = File::create(&part)?;
    file.write_all(contents.as_ref())?;
    file.sync_all()?;
    fs::rename(&part, path)
}
