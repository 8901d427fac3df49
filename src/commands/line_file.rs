//! JSON Lines files of `replay --alerts` and `replay --conflicts`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

/// A JSON Lines file.
pub(super) struct LineFile {
    path: PathBuf,
    out: BufWriter<File>,
}

impl LineFile {
    /// Creates the file.
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        #[expect(clippy::disallowed_methods, reason = "the file that the user names")]
        let file = File::create(path).map_err(|error| unwritten(path, &error))?;
        Ok(Self { path: path.to_owned(), out: BufWriter::new(file) })
    }

    /// Adds a line.
    pub(super) fn write(&mut self, object: &impl Serialize) -> io::Result<()> {
        let line = serde_json::to_string(object)? + "\n";
        self.out.write_all(line.as_bytes()).map_err(|error| unwritten(&self.path, &error))
    }

    /// Flushes the file.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.out.flush().map_err(|error| unwritten(&self.path, &error))
    }
}

fn unwritten(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: cannot be written: {error}", path.display()))
}
