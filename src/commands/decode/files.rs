//! Files of the tables of `decode`.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::DecodeFormat;
use picture::decode::Tables;
use picture::formats::table::{Commas, Parquet, TableWriter};

/// Tables in files of `directory`, which is created if missing.
pub(super) fn within(format: DecodeFormat, directory: &Path, hex: bool) -> io::Result<Tables<'_>> {
    fs::create_dir_all(directory).map_err(|error| unwritten(directory, &error))?;
    Ok(Tables::new(hex, move |name, columns| {
        let path = directory.join(format!("{name}.{}", format.extension()));
        #[expect(clippy::disallowed_methods, reason = "a file in the directory that the user names")]
        let file = File::create(&path).map_err(|error| unwritten(&path, &error))?;
        let file = BufWriter::new(file);
        let table: Box<dyn TableWriter> = match format {
            DecodeFormat::Parquet => Box::new(Parquet::new(file, columns)?),
            DecodeFormat::Csv | DecodeFormat::Json => Box::new(Commas::new(file, columns)?),
        };
        Ok(Some(table))
    }))
}

/// The first table as CSV to `out`. Further tables are not written.
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
