//! Stands in for Apache Parquet in a program that was built without it.

use std::convert::Infallible;
use std::io::{self, Write};
use std::marker::PhantomData;

use super::{TableCell, TableColumn, TableWriter};

/// A table that cannot be made.
pub struct Parquet<W: Write + Send>(Infallible, PhantomData<W>);

impl<W: Write + Send> Parquet<W> {
    /// # Errors
    /// Always.
    pub fn new(_: W, _: &[TableColumn]) -> io::Result<Self> {
        Err(io::Error::from(io::ErrorKind::Unsupported))
    }
}

impl<W: Write + Send> TableWriter for Parquet<W> {
    fn set(&mut self, _: usize, _: TableCell<'_>) {
        match self.0 {}
    }

    fn end_row(&mut self) -> io::Result<()> {
        match self.0 {}
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        match self.0 {}
    }
}
