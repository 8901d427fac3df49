//! Tables of named columns, as Parquet or comma-separated values.

mod commas;
#[cfg_attr(not(feature = "parquet"), path = "table/absent.rs")]
mod parquet;

use std::borrow::Cow;
use std::io;

pub use commas::Commas;
pub use parquet::Parquet;

use fusion::time::Time;

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableColumn {
    /// Name with its unit, unique in the table.
    pub name: Cow<'static, str>,
    /// Type of the values.
    pub kind: ColumnKind,
}

/// Type of a column's values. A cell that is not set is null.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Booleans.
    Flag,
    /// Whole numbers.
    Count,
    /// Physical values.
    Quantity,
    /// UTF-8 texts.
    Text,
    /// UTC instants, in whole microseconds.
    Instant,
}

/// A value of the type of its column.
#[derive(Clone, Debug, PartialEq)]
pub enum TableCell<'a> {
    /// A boolean.
    Flag(bool),
    /// A whole number.
    Count(i64),
    /// A physical value.
    Quantity(f64),
    /// A UTF-8 text.
    Text(Cow<'a, str>),
    /// An instant, truncated to microseconds.
    Instant(Time),
}

/// A table that is written row by row.
pub trait TableWriter {
    /// Whether cells of this column are used; others need not be computed.
    fn wants(&self, column: usize) -> bool {
        let _ = column;
        true
    }

    /// Sets a cell of the current row. Cells that are not set are null.
    fn set(&mut self, column: usize, cell: TableCell<'_>);

    /// Ends the current row.
    fn end_row(&mut self) -> io::Result<()>;

    /// Completes the table and writes all buffered data. Without this call the file is incomplete.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

impl TableColumn {
    /// A column with a name and a type.
    pub fn new(name: impl Into<Cow<'static, str>>, kind: ColumnKind) -> Self {
        Self { name: name.into(), kind }
    }
}

/// Whole microseconds since the epoch, the unit of instants in Parquet and CSV.
fn micros(time: Time) -> i64 {
    time.nanos().div_euclid(1000)
}
