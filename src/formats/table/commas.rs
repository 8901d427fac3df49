//! Tables as comma-separated values (RFC 4180, lines that end in a line feed).

use std::io::{self, Write};

use super::{Cell, Column, Table, micros};

/// A table as text: instants in seconds UTC since the epoch, null as nothing.
pub(crate) struct Commas<W: Write> {
    out: csv::Writer<W>,
    /// Of the row that is being made; their memory is used again.
    cells: Vec<String>,
}

impl<W: Write> Commas<W> {
    /// Writes the names of the columns.
    pub(crate) fn new(out: W, columns: &[Column]) -> io::Result<Self> {
        let mut out = csv::Writer::from_writer(out);
        out.write_record(columns.iter().map(|column| column.name.as_bytes())).map_err(unwrapped)?;
        Ok(Self { out, cells: vec![String::new(); columns.len()] })
    }
}

impl<W: Write> Table for Commas<W> {
    fn set(&mut self, column: usize, cell: Cell<'_>) {
        let text = &mut self.cells[column];
        *text = match cell {
            Cell::Flag(flag) => flag.to_string(),
            Cell::Count(count) => count.to_string(),
            Cell::Quantity(value) => value.to_string(),
            Cell::Text(said) => said.into_owned(),
            Cell::Instant(time) => {
                let micros = micros(time);
                format!("{}.{:06}", micros.div_euclid(1_000_000), micros.rem_euclid(1_000_000))
            }
        };
    }

    fn end_row(&mut self) -> io::Result<()> {
        self.out.write_record(&self.cells).map_err(unwrapped)?;
        self.cells.iter_mut().for_each(String::clear);
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.out.flush()
    }
}

/// The error of the writer itself: a pipe that the reader has closed is known by its kind.
fn unwrapped(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::ColumnKind;
    use super::*;
    use fusion::time::Time;

    #[test]
    fn a_row_as_text() {
        let columns = [
            ColumnKind::Instant,
            ColumnKind::Flag,
            ColumnKind::Count,
            ColumnKind::Quantity,
            ColumnKind::Text,
            ColumnKind::Text,
        ];
        let columns: Vec<_> = columns.iter().zip("abcdef".chars()).collect();
        let columns: Vec<_> =
            columns.iter().map(|(kind, name)| Column::new(name.to_string(), **kind)).collect();
        let mut out = Vec::new();
        let mut table = Box::new(Commas::new(&mut out, &columns).unwrap());
        table.set(0, Cell::Instant(Time::from_nanos(-1_500)));
        table.set(1, Cell::Flag(true));
        table.set(2, Cell::Count(-7));
        table.set(3, Cell::Quantity(0.5));
        table.set(4, Cell::Text("[1,\"2\"]".into()));
        table.end_row().unwrap();
        table.set(5, Cell::Text("x".into()));
        table.end_row().unwrap();
        table.finish().unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "a,b,c,d,e,f\n-1.999998,true,-7,0.5,\"[1,\"\"2\"\"]\",\n,,,,,x\n");
    }
}
