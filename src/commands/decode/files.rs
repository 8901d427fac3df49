//! Where the tables of `decode` go.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::Format;
use crate::decode::Tables;
use crate::formats::table::{Commas, Parquet, Table};

/// Into files of this directory, which is made where it is missing.
pub(super) fn within(format: Format, directory: &Path, hex: bool) -> io::Result<Tables<'_>> {
    fs::create_dir_all(directory).map_err(|error| unwritten(directory, &error))?;
    Ok(Tables::new(hex, move |name, columns| {
        let path = directory.join(format!("{name}.{}", format.extension()));
        #[expect(clippy::disallowed_methods, reason = "a file in the directory that the user names")]
        let file = File::create(&path).map_err(|error| unwritten(&path, &error))?;
        let file = BufWriter::new(file);
        let table: Box<dyn Table> = match format {
            Format::Parquet => Box::new(Parquet::new(file, columns)?),
            Format::Csv | Format::Json => Box::new(Commas::new(file, columns)?),
        };
        Ok(Some(table))
    }))
}

/// The only table, as CSV, into `out`. A second one has no place.
pub(super) fn only(out: &mut dyn Write, hex: bool) -> Tables<'_> {
    let mut out = Some(out);
    Tables::new(hex, move |_, columns| {
        let Some(out) = out.take() else { return Ok(None) };
        Ok(Some(Box::new(Commas::new(out, columns)?)))
    })
}

fn unwritten(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: cannot be written: {error}", path.display()))
}
