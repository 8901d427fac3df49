//! Columns in the format of Apache Arrow.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use arrow_array::builder::{
    BooleanBuilder, Float64Builder, Int64Builder, StringBuilder, TimestampMicrosecondBuilder,
};
use arrow_array::{Array, ArrayRef, RecordBatch, RecordBatchOptions, new_null_array};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef, TimeUnit};
use utm_fusion::formats::table::{ColumnKind, TableCell, TableColumn, TableWriter};

/// Maximum number of rows in a batch.
const BATCH_ROWS: usize = 1 << 16;

/// A complete table.
#[derive(Clone)]
pub(crate) struct Frame {
    pub(crate) schema: SchemaRef,
    pub(crate) batches: Vec<RecordBatch>,
}

/// Complete tables by name.
pub(crate) type Shelf = Arc<Mutex<BTreeMap<String, Frame>>>;

/// Removes a table from the shelf.
pub(crate) fn take(shelf: &Shelf, name: &str) -> Option<Frame> {
    shelf.lock().unwrap_or_else(PoisonError::into_inner).remove(name)
}

/// Builds a table.
pub(crate) struct Gatherer {
    name: String,
    frame: Frame,
    /// The selected columns, at their index among all columns.
    columns: Vec<Option<Kept>>,
    /// Indices of the selected columns, in the order of the table.
    order: Vec<usize>,
    /// Number of rows of the current batch.
    rows: usize,
    shelf: Shelf,
}

/// A column, and the number of rows for which it has a value or null.
struct Kept {
    rows: usize,
    values: Values,
}

enum Values {
    Flags(BooleanBuilder),
    Counts(Int64Builder),
    Quantities(Float64Builder),
    Texts(StringBuilder),
    Instants(TimestampMicrosecondBuilder),
}

impl Gatherer {
    /// A table with these columns, which is put on the shelf when it is complete.
    pub(crate) fn new(name: &str, columns: &[TableColumn], shelf: &Shelf) -> Self {
        let all = columns.iter().enumerate().map(|(place, column)| (place, column.name.to_string()));
        Self::of(name, columns, all.collect(), shelf)
    }

    /// A table with the wanted columns: each is a column's name, and its name in the table.
    ///
    /// # Errors
    /// No column has one of the names.
    pub(crate) fn only(
        name: &str,
        columns: &[TableColumn],
        wanted: &[(&str, &str)],
        shelf: &Shelf,
    ) -> io::Result<Self> {
        let place = |&(column, called): &(&str, &str)| {
            let place = columns.iter().position(|known| known.name == column);
            let place = place.ok_or_else(|| io::Error::other(format!("{name} has no column {column:?}")))?;
            Ok((place, called.to_owned()))
        };
        let wanted = wanted.iter().map(place).collect::<io::Result<Vec<_>>>()?;
        Ok(Self::of(name, columns, wanted, shelf))
    }

    fn of(name: &str, columns: &[TableColumn], wanted: Vec<(usize, String)>, shelf: &Shelf) -> Self {
        let mut kept: Vec<Option<Kept>> = columns.iter().map(|_| None).collect();
        let (mut fields, mut order) = (Vec::new(), Vec::new());
        for (place, called) in wanted {
            let kind = columns[place].kind;
            kept[place] = Some(Kept { rows: 0, values: Values::new(kind) });
            fields.push(Field::new(called, data_type(kind), true));
            order.push(place);
        }
        let frame = Frame { schema: Arc::new(Schema::new(fields)), batches: Vec::new() };
        Self { name: name.to_owned(), frame, columns: kept, order, rows: 0, shelf: Arc::clone(shelf) }
    }

    fn end_batch(&mut self) -> Result<(), ArrowError> {
        let rows = self.rows;
        let mut arrays = Vec::with_capacity(self.order.len());
        // Most columns of a category are empty in most captures; these share one array of nulls.
        let mut empty: Vec<ArrayRef> = Vec::new();
        for place in &self.order {
            let Some(column) = &mut self.columns[*place] else { continue };
            if column.rows > 0 {
                column.fill_to(rows);
                column.rows = 0;
                arrays.push(column.values.finish());
                continue;
            }
            let data_type = self.frame.schema.field(arrays.len()).data_type();
            let known = empty.iter().find(|nulls| nulls.data_type() == data_type).cloned();
            arrays.push(known.unwrap_or_else(|| {
                let nulls = new_null_array(data_type, rows);
                empty.push(Arc::clone(&nulls));
                nulls
            }));
        }
        let count = RecordBatchOptions::new().with_row_count(Some(rows));
        let batch = RecordBatch::try_new_with_options(Arc::clone(&self.frame.schema), arrays, &count)?;
        self.frame.batches.push(batch);
        self.rows = 0;
        Ok(())
    }
}

impl TableWriter for Gatherer {
    fn wants(&self, column: usize) -> bool {
        self.columns[column].is_some()
    }

    fn set(&mut self, column: usize, cell: TableCell<'_>) {
        let Some(column) = &mut self.columns[column] else { return };
        column.fill_to(self.rows);
        column.rows += 1;
        match (&mut column.values, cell) {
            (Values::Flags(values), TableCell::Flag(flag)) => values.append_value(flag),
            (Values::Counts(values), TableCell::Count(count)) => values.append_value(count),
            (Values::Quantities(values), TableCell::Quantity(value)) => values.append_value(value),
            (Values::Texts(values), TableCell::Text(text)) => values.append_value(text),
            (Values::Instants(values), TableCell::Instant(time)) => {
                values.append_value(time.nanos().div_euclid(1000));
            }
            (_, cell) => unreachable!("{cell:?} is of another kind than its column"),
        }
    }

    fn end_row(&mut self) -> io::Result<()> {
        self.rows += 1;
        if self.rows < BATCH_ROWS { Ok(()) } else { self.end_batch().map_err(io::Error::other) }
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if self.rows > 0 {
            self.end_batch().map_err(io::Error::other)?;
        }
        let Self { name, frame, shelf, .. } = *self;
        shelf.lock().unwrap_or_else(PoisonError::into_inner).insert(name, frame);
        Ok(())
    }
}

impl Kept {
    /// Adds nulls up to this row.
    fn fill_to(&mut self, rows: usize) {
        if self.rows < rows {
            self.values.append_nulls(rows - self.rows);
            self.rows = rows;
        }
    }
}

impl Values {
    fn new(kind: ColumnKind) -> Self {
        match kind {
            ColumnKind::Flag => Self::Flags(BooleanBuilder::new()),
            ColumnKind::Count => Self::Counts(Int64Builder::new()),
            ColumnKind::Quantity => Self::Quantities(Float64Builder::new()),
            ColumnKind::Text => Self::Texts(StringBuilder::new()),
            ColumnKind::Instant => Self::Instants(TimestampMicrosecondBuilder::new().with_timezone("UTC")),
        }
    }

    fn append_nulls(&mut self, count: usize) {
        match self {
            Self::Flags(values) => values.append_nulls(count),
            Self::Counts(values) => values.append_nulls(count),
            Self::Quantities(values) => values.append_nulls(count),
            Self::Texts(values) => values.append_nulls(count),
            Self::Instants(values) => values.append_nulls(count),
        }
    }

    fn finish(&mut self) -> ArrayRef {
        match self {
            Self::Flags(values) => Arc::new(values.finish()),
            Self::Counts(values) => Arc::new(values.finish()),
            Self::Quantities(values) => Arc::new(values.finish()),
            Self::Texts(values) => Arc::new(values.finish()),
            Self::Instants(values) => Arc::new(values.finish()),
        }
    }
}

fn data_type(kind: ColumnKind) -> DataType {
    match kind {
        ColumnKind::Flag => DataType::Boolean,
        ColumnKind::Count => DataType::Int64,
        ColumnKind::Quantity => DataType::Float64,
        ColumnKind::Text => DataType::Utf8,
        ColumnKind::Instant => DataType::Timestamp(TimeUnit::Microsecond, Some("UTC".into())),
    }
}
