//! Tables of comma-separated values with a header, plain or compressed.

use std::collections::HashMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;

/// A row by column name.
pub(crate) type Row = HashMap<String, String>;

/// The folder of the oracle; `None`, with a message, if there is none.
pub(crate) fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("UTM_FUSION_SHARED_DATA").map(|root| PathBuf::from(root).join("daa"));
    if folder.is_none() {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    }
    folder
}

pub(crate) fn rows(path: &Path) -> Vec<Row> {
    let is_packed = path.extension().is_some_and(|end| end == "gz");
    let octets = fs::read(path).unwrap();
    let text: Box<dyn Read + '_> =
        if is_packed { Box::new(GzDecoder::new(&*octets)) } else { Box::new(&*octets) };
    csv::Reader::from_reader(text).deserialize().map(Result::unwrap).collect()
}

/// The number in a column; `None` if it is blank.
pub(crate) fn number(row: &Row, column: &str) -> Option<f64> {
    let text = &row[column];
    (!text.is_empty()).then(|| text.parse().unwrap())
}

pub(crate) fn numbers<const N: usize>(row: &Row, columns: [&str; N]) -> [f64; N] {
    columns.map(|column| number(row, column).unwrap())
}
