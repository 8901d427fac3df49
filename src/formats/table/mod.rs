//! Tables: rows of named columns, as Parquet or as comma-separated values.

mod commas;
mod parquet;

use std::borrow::Cow;
use std::io;

pub(crate) use commas::Commas;
pub(crate) use parquet::Parquet;

use fusion::time::Time;

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name with its unit, unique in the table.
    pub name: Cow<'static, str>,
    /// What is in it.
    pub kind: ColumnKind,
}

/// What is in a column; a cell that was not set is null.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Yes or no.
    Flag,
    /// Whole numbers.
    Count,
    /// Physical values.
    Quantity,
    /// UTF-8.
    Text,
    /// Instants, UTC, in whole microseconds.
    Instant,
}

/// A value; its variant is that of its column's kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell<'a> {
    /// Yes or no.
    Flag(bool),
    /// A whole number.
    Count(i64),
    /// A physical value.
    Quantity(f64),
    /// UTF-8.
    Text(Cow<'a, str>),
    /// An instant; what is finer than a microsecond is cut off.
    Instant(Time),
}

/// A table that is being written, row by row.
pub trait Table {
    /// Whether cells of this column are taken; others need not be made.
    fn wants(&self, column: usize) -> bool {
        let _ = column;
        true
    }

    /// Sets a cell of the row that is being made; those that are not set are null.
    fn set(&mut self, column: usize, cell: Cell<'_>);

    /// Ends the row.
    fn end_row(&mut self) -> io::Result<()>;

    /// Completes the table, and writes everything that is buffered. A table that was not completed is no whole file.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

impl Column {
    /// A column of this name.
    pub fn new(name: impl Into<Cow<'static, str>>, kind: ColumnKind) -> Self {
        Self { name: name.into(), kind }
    }
}

/// Whole microseconds since the epoch, as Parquet and CSV have instants.
fn micros(time: Time) -> i64 {
    time.nanos().div_euclid(1000)
}
