//! Tables as comma-separated values (RFC 4180, with line feeds).

use std::io::{self, Write};

use super::{TableCell, TableColumn, TableWriter, micros};

/// A table as text. Instants are in seconds UTC since the epoch; null is empty.
pub struct Commas<W: Write> {
    out: csv::Writer<W>,
    /// Cells of the current row. Their memory is reused.
    cells: Vec<String>,
}

impl<W: Write> Commas<W> {
    /// Writes the names of the columns.
    pub fn new(out: W, columns: &[TableColumn]) -> io::Result<Self> {
        let mut out = csv::Writer::from_writer(out);
        out.write_record(columns.iter().map(|column| column.name.as_bytes())).map_err(unwrapped)?;
        Ok(Self { out, cells: vec![String::new(); columns.len()] })
    }
}

impl<W: Write> TableWriter for Commas<W> {
    fn set(&mut self, column: usize, cell: TableCell<'_>) {
        let text = &mut self.cells[column];
        *text = match cell {
            TableCell::Flag(flag) => flag.to_string(),
            TableCell::Count(count) => count.to_string(),
            TableCell::Quantity(value) => value.to_string(),
            TableCell::Text(said) => said.into_owned(),
            TableCell::Instant(time) => {
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

/// Error of the underlying writer, whose kind identifies a closed pipe.
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
    fn row_is_written_as_text() {
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
            columns.iter().map(|(kind, name)| TableColumn::new(name.to_string(), **kind)).collect();
        let mut out = Vec::new();
        let mut table = Box::new(Commas::new(&mut out, &columns).unwrap());
        table.set(0, TableCell::Instant(Time::from_nanos(-1_500)));
        table.set(1, TableCell::Flag(true));
        table.set(2, TableCell::Count(-7));
        table.set(3, TableCell::Quantity(0.5));
        table.set(4, TableCell::Text("[1,\"2\"]".into()));
        table.end_row().unwrap();
        table.set(5, TableCell::Text("x".into()));
        table.end_row().unwrap();
        table.finish().unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "a,b,c,d,e,f\n-1.999998,true,-7,0.5,\"[1,\"\"2\"\"]\",\n,,,,,x\n");
    }
}
