//! Tables as Apache Parquet.
//!
//! Rows are collected and written as row groups, so memory is bounded by one of them. The footer comes last; a file without it
//! cannot be read.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::{ColumnKind, TableCell, TableColumn, TableWriter, micros};

/// Maximum number of rows of a row group.
const GROUP_ROWS: usize = 1 << 16;

/// Maximum length of all texts of a row group, in octets; its last row may exceed it.
const GROUP_TEXT: usize = 16 << 20;

/// A table as Parquet. Every column may be null; the compression is gzip, which every reader supports.
pub struct Parquet<W: Write + Send> {
    out: SerializedFileWriter<W>,
    columns: Vec<ColumnBuffer>,
    rows: usize,
    /// Length of the collected texts, in octets.
    text: usize,
}

/// Values of a column collected for the next row group.
struct ColumnBuffer {
    /// Definition levels: for each row up to the last one with a value, whether it has a value.
    defined: Vec<i16>,
    values: ColumnValues,
}

enum ColumnValues {
    Flags(Vec<bool>),
    Counts(Vec<i64>),
    Quantities(Vec<f64>),
    Texts(Vec<ByteArray>),
    Instants(Vec<i64>),
}

impl<W: Write + Send> Parquet<W> {
    /// Writes the beginning of the file.
    pub fn new(out: W, columns: &[TableColumn]) -> io::Result<Self> {
        let properties = WriterProperties::builder()
            .set_compression(Compression::GZIP(Default::default()))
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_offset_index_disabled(true)
            .build();
        let out = SerializedFileWriter::new(out, schema(columns).map_err(io_error)?, Arc::new(properties));
        let columns = columns.iter().map(|column| ColumnBuffer::new(column.kind)).collect();
        Ok(Self { out: out.map_err(io_error)?, columns, rows: 0, text: 0 })
    }

    /// Writes the collected rows as a row group.
    fn write_group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.out.next_row_group()?;
        for column in &mut self.columns {
            let writer = group.next_column()?;
            let mut writer = writer.ok_or_else(|| ParquetError::General("a column is missing".to_owned()))?;
            column.defined.resize(self.rows, 0);
            column.values.write(&column.defined, &mut writer)?;
            writer.close()?;
            column.defined.clear();
        }
        group.close()?;
        (self.rows, self.text) = (0, 0);
        Ok(())
    }
}

impl<W: Write + Send> TableWriter for Parquet<W> {
    fn set(&mut self, column: usize, cell: TableCell<'_>) {
        let column = &mut self.columns[column];
        debug_assert!(column.defined.len() <= self.rows, "a cell is set once");
        column.defined.resize(self.rows, 0);
        column.defined.push(1);
        match (&mut column.values, cell) {
            (ColumnValues::Flags(values), TableCell::Flag(flag)) => values.push(flag),
            (ColumnValues::Counts(values), TableCell::Count(count)) => values.push(count),
            (ColumnValues::Quantities(values), TableCell::Quantity(value)) => values.push(value),
            (ColumnValues::Texts(values), TableCell::Text(text)) => {
                self.text += text.len();
                values.push(text.into_owned().into_bytes().into());
            }
            (ColumnValues::Instants(values), TableCell::Instant(time)) => values.push(micros(time)),
            (_, cell) => unreachable!("{cell:?} is of another kind than its column"),
        }
    }

    fn end_row(&mut self) -> io::Result<()> {
        self.rows += 1;
        if self.rows < GROUP_ROWS && self.text < GROUP_TEXT {
            return Ok(());
        }
        self.write_group().map_err(io_error)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if self.rows > 0 {
            self.write_group().map_err(io_error)?;
        }
        let mut out = self.out.into_inner().map_err(io_error)?;
        out.flush()
    }
}

impl ColumnBuffer {
    fn new(kind: ColumnKind) -> Self {
        let values = match kind {
            ColumnKind::Flag => ColumnValues::Flags(Vec::new()),
            ColumnKind::Count => ColumnValues::Counts(Vec::new()),
            ColumnKind::Quantity => ColumnValues::Quantities(Vec::new()),
            ColumnKind::Text => ColumnValues::Texts(Vec::new()),
            ColumnKind::Instant => ColumnValues::Instants(Vec::new()),
        };
        Self { defined: Vec::new(), values }
    }
}

impl ColumnValues {
    fn write(&mut self, defined: &[i16], out: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        match self {
            Self::Flags(values) => write::<BoolType>(values, defined, out),
            Self::Counts(values) | Self::Instants(values) => write::<Int64Type>(values, defined, out),
            Self::Quantities(values) => write::<DoubleType>(values, defined, out),
            Self::Texts(values) => write::<ByteArrayType>(values, defined, out),
        }
    }
}

fn write<T: DataType>(
    values: &mut Vec<T::T>,
    defined: &[i16],
    out: &mut SerializedColumnWriter<'_>,
) -> Result<(), ParquetError> {
    out.typed::<T>().write_batch(values, Some(defined), None)?;
    values.clear();
    Ok(())
}

/// Columns as a Parquet schema.
fn schema(columns: &[TableColumn]) -> Result<TypePtr, ParquetError> {
    let field = |column: &TableColumn| {
        let (physical, logical) = match column.kind {
            ColumnKind::Flag => (Physical::BOOLEAN, None),
            ColumnKind::Count => (Physical::INT64, None),
            ColumnKind::Quantity => (Physical::DOUBLE, None),
            ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            ColumnKind::Instant => (Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))),
        };
        let field = Type::primitive_type_builder(&column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        Ok(Arc::new(field.build()?))
    };
    let fields = columns.iter().map(field).collect::<Result<_, ParquetError>>()?;
    Ok(Arc::new(Type::group_type_builder("schema").with_fields(fields).build()?))
}

/// Error of the underlying file, unchanged.
fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::time::Time;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    fn columns() -> Vec<TableColumn> {
        let kinds = [ColumnKind::Count, ColumnKind::Text, ColumnKind::Instant];
        ["n", "t", "at"].into_iter().zip(kinds).map(|(name, kind)| TableColumn::new(name, kind)).collect()
    }

    fn written(rows: usize, text: &str) -> Vec<u8> {
        let mut out = Vec::new();
        let mut table = Box::new(Parquet::new(&mut out, &columns()).unwrap());
        for row in 0..rows {
            if row % 3 == 0 {
                table.set(0, TableCell::Count(row as i64));
            }
            table.set(1, TableCell::Text(text.into()));
            if row % 2 == 0 {
                table.set(2, TableCell::Instant(Time::from_nanos(row as i64 * 1000 + 999)));
            }
            table.end_row().unwrap();
        }
        table.finish().unwrap();
        out
    }

    fn groups(file: Vec<u8>) -> Vec<i64> {
        let reader = SerializedFileReader::new(bytes::Bytes::from(file)).unwrap();
        reader
            .metadata()
            .row_groups()
            .iter()
            .map(parquet::file::metadata::RowGroupMetaData::num_rows)
            .collect()
    }

    #[test]
    fn row_groups_are_bounded_without_loss() {
        let rows = 2 * GROUP_ROWS + 5;
        let file = written(rows, "x");
        let reader = SerializedFileReader::new(bytes::Bytes::from(file.clone())).unwrap();
        for (index, row) in reader.get_row_iter(None).unwrap().enumerate() {
            let row = row.unwrap();
            assert_eq!(row.get_long(0).ok(), (index % 3 == 0).then_some(index as i64));
            assert_eq!(row.get_timestamp_micros(2).ok(), (index % 2 == 0).then_some(index as i64));
        }
        assert_eq!(groups(file), [GROUP_ROWS as i64, GROUP_ROWS as i64, 5]);
        assert_eq!(
            groups(written(5, &"y".repeat(GROUP_TEXT / 2))),
            [2, 2, 1],
            "long texts end a group sooner"
        );
        assert_eq!(groups(written(0, "")), Vec::<i64>::new(), "a table without rows is a table");
    }

    #[test]
    fn file_error_keeps_its_kind() {
        struct ParquetFull(usize);
        impl Write for ParquetFull {
            fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
                self.0 = self.0.checked_sub(octets.len()).ok_or(io::ErrorKind::BrokenPipe)?;
                Ok(octets.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut table = Box::new(Parquet::new(ParquetFull(100), &columns()).unwrap());
        table.set(0, TableCell::Count(1));
        table.end_row().unwrap();
        assert_eq!(table.finish().unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }
}
