//! Reads Parquet files with the crate's reader.

use std::collections::BTreeMap;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::{Value, json};

/// The rows: cells that are not null by the names of their columns; instants in microseconds.
pub fn rows(file: Vec<u8>) -> Vec<BTreeMap<String, Value>> {
    let reader = SerializedFileReader::new(bytes::Bytes::from(file)).unwrap();
    let rows = reader.get_row_iter(None).unwrap();
    let cell = |field: &Field| match field {
        Field::Null => None,
        Field::Bool(flag) => Some(json!(flag)),
        Field::Long(count) | Field::TimestampMicros(count) => Some(json!(count)),
        Field::Double(value) => Some(json!(value)),
        Field::Str(text) => Some(json!(text)),
        other => panic!("no such column is written: {other:?}"),
    };
    let row = |row: parquet::record::Row| {
        row.get_column_iter().filter_map(|(name, field)| Some((name.clone(), cell(field)?))).collect()
    };
    rows.map(Result::unwrap).map(row).collect()
}
