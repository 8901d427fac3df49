//! What `decode` writes as tables: one per category, and one of what could not be read.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use asterix::all::Untyped;
use asterix::{DataSource, Fault, Record, UapItem, items};

use super::Format;
use crate::formats::records::RecordColumns;
use crate::formats::table::{Cell, Column, ColumnKind, Commas, Parquet, Table};
use crate::hex;
use crate::json::{Named, Place, SKIPPED, dated};
use fusion::time::Time;

/// Where tables go.
enum Destination<'a> {
    /// A file for each.
    Directory(PathBuf),
    /// The only one.
    Output(Option<&'a mut dyn Write>),
}

/// Tables that are made as there is something for them.
pub(super) struct Tables<'a> {
    format: Format,
    place: Destination<'a>,
    records: BTreeMap<u8, Records<'a>>,
    /// What could not be read or was not looked into; `None` before the first of it.
    unread: Option<Box<dyn Table + 'a>>,
}

/// The table of a category.
struct Records<'a> {
    columns: RecordColumns,
    table: Box<dyn Table + 'a>,
}

/// What is known of a record beside its items.
struct Head<'a> {
    time: Option<Time>,
    place: Place<'a>,
    source: Option<DataSource>,
    /// Whether its octets are wanted.
    hex: bool,
}

/// What comes before the items of a record, in this order.
const BEFORE: [(&str, ColumnKind); 7] = [
    ("time", ColumnKind::Instant),
    ("input", ColumnKind::Text),
    ("offset", ColumnKind::Count),
    ("block", ColumnKind::Count),
    ("sac", ColumnKind::Count),
    ("sic", ColumnKind::Count),
    ("hex", ColumnKind::Text),
];

/// The columns of what was not read.
const UNREAD: [(&str, ColumnKind); 8] = [
    ("kind", ColumnKind::Text),
    ("input", ColumnKind::Text),
    ("offset", ColumnKind::Count),
    ("block", ColumnKind::Count),
    ("category", ColumnKind::Count),
    ("item", ColumnKind::Text),
    ("detail", ColumnKind::Text),
    ("hex", ColumnKind::Text),
];

/// Of a block that was not looked into.
const BLOCK: &str = "block";

/// Of what a sender puts behind the blocks of a datagram.
const TRAILER: &str = "trailer";

impl<'a> Tables<'a> {
    /// Into files of this directory, which is made where it is missing.
    pub(super) fn within(format: Format, directory: &Path) -> io::Result<Self> {
        fs::create_dir_all(directory).map_err(|error| unwritten(directory, &error))?;
        Ok(Self::new(format, Destination::Directory(directory.to_owned())))
    }

    /// The only table into `out`.
    pub(super) fn only(format: Format, out: &'a mut dyn Write) -> Self {
        Self::new(format, Destination::Output(Some(out)))
    }

    fn new(format: Format, place: Destination<'a>) -> Self {
        Self { format, place, records: BTreeMap::new(), unread: None }
    }

    /// Adds a record with these octets, received at `received`; with its octets where `hex` asks for them.
    pub(super) fn record<R: Record<Edition: Named>>(
        &mut self,
        record: &R,
        edition: R::Edition,
        octets: &[u8],
        place: Place<'_>,
        received: Option<Time>,
        hex: bool,
    ) -> io::Result<()> {
        let profile = R::profile(edition);
        let head =
            Head { time: dated(record.time_of_day(), received), place, source: record.data_source(), hex };
        self.add(R::CATEGORY, profile, &head, items(profile, octets), octets)
    }

    /// The same of a record without a type.
    pub(super) fn untyped(
        &mut self,
        record: &Untyped<'_>,
        place: Place<'_>,
        received: Option<Time>,
        hex: bool,
    ) -> io::Result<()> {
        let definition = record.definition();
        let head =
            Head { time: dated(record.time_of_day(), received), place, source: record.data_source(), hex };
        self.add(definition.category(), definition.items(), &head, record.items(), record.octets())
    }

    /// Adds a record of a category of which these are all items.
    fn add<'b>(
        &mut self,
        category: u8,
        all: &'static [UapItem],
        head: &Head<'_>,
        items: impl Iterator<Item = (&'static UapItem, &'b [u8])>,
        octets: &[u8],
    ) -> io::Result<()> {
        if !self.records.contains_key(&category) {
            let columns = RecordColumns::of(category, all, named(&BEFORE));
            let table = self.open(&format!("cat{category:03}"), columns.columns())?;
            // A second table has no place where there is only one.
            let Some(table) = table else { return Ok(()) };
            self.records.insert(category, Records { columns, table });
        }
        let Some(Records { columns, table }) = self.records.get_mut(&category) else { return Ok(()) };
        let &Head { time, place, source, hex } = head;
        let cells = [
            time.map(Cell::Instant),
            place.input.map(|input| Cell::Text(input.into())),
            count(place.offset),
            count(place.block),
            source.and_then(|source| count(source.sac.into())),
            source.and_then(|source| count(source.sic.into())),
            hex.then(|| Cell::Text(hex::text(octets).into())),
        ];
        set(&mut **table, cells);
        columns.fill(&mut **table, items);
        table.end_row()
    }

    /// Adds a block that is not looked into.
    pub(super) fn block(&mut self, category: u8, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.unread(BLOCK, place, Some(category), None, None, octets)
    }

    /// Adds octets that cannot be read; the offset of the fault counts from `origin` in the file.
    pub(super) fn fault(
        &mut self,
        fault: Fault,
        octets: &[u8],
        origin: u64,
        place: Place<'_>,
    ) -> io::Result<()> {
        let offset = usize::try_from(origin + fault.offset as u64).unwrap_or(usize::MAX);
        let detail = Fault { offset, ..fault }.to_string();
        self.unread(fault.kind.name(), place, fault.category, fault.item, Some(detail), octets)
    }

    /// Adds octets that belong to no block.
    pub(super) fn skipped(&mut self, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.unread(SKIPPED, place, None, None, None, octets)
    }

    /// Adds what stands behind the blocks of a datagram.
    pub(super) fn trailer(&mut self, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.unread(TRAILER, place, None, None, None, octets)
    }

    /// Completes them.
    pub(super) fn finish(self) -> io::Result<()> {
        self.records.into_values().try_for_each(|records| records.table.finish())?;
        self.unread.map_or(Ok(()), <dyn Table>::finish)
    }

    fn unread(
        &mut self,
        kind: &str,
        place: Place<'_>,
        category: Option<u8>,
        item: Option<&str>,
        detail: Option<String>,
        octets: &[u8],
    ) -> io::Result<()> {
        if self.unread.is_none() {
            self.unread = self.open("unread", &named(&UNREAD))?;
        }
        let Some(table) = &mut self.unread else { return Ok(()) };
        let text = |text: &str| Some(Cell::Text(text.to_owned().into()));
        let cells = [
            text(kind),
            place.input.and_then(text),
            count(place.offset),
            count(place.block),
            category.and_then(|category| count(category.into())),
            item.and_then(text),
            detail.map(|detail| Cell::Text(detail.into())),
            Some(Cell::Text(hex::text(octets).into())),
        ];
        set(&mut **table, cells);
        table.end_row()
    }

    /// A new table; `None` where the only one is another.
    fn open(&mut self, name: &str, columns: &[Column]) -> io::Result<Option<Box<dyn Table + 'a>>> {
        let directory = match &mut self.place {
            Destination::Directory(directory) => directory,
            Destination::Output(out) => {
                let Some(out) = out.take() else { return Ok(None) };
                return Ok(Some(Box::new(Commas::new(out, columns)?)));
            }
        };
        let path = directory.join(format!("{name}.{}", self.format.extension()));
        #[expect(clippy::disallowed_methods, reason = "a file in the directory that the user names")]
        let file = File::create(&path).map_err(|error| unwritten(&path, &error))?;
        let file = BufWriter::new(file);
        Ok(Some(match self.format {
            Format::Parquet => Box::new(Parquet::new(file, columns)?),
            Format::Csv | Format::Json => Box::new(Commas::new(file, columns)?),
        }))
    }
}

fn named(columns: &[(&'static str, ColumnKind)]) -> Vec<Column> {
    columns.iter().map(|&(name, kind)| Column::new(name, kind)).collect()
}

fn count(number: u64) -> Option<Cell<'static>> {
    i64::try_from(number).ok().map(Cell::Count)
}

/// Sets the first cells of a row.
fn set<const N: usize>(table: &mut dyn Table, cells: [Option<Cell<'_>>; N]) {
    for (column, cell) in cells.into_iter().enumerate() {
        if let Some(cell) = cell {
            table.set(column, cell);
        }
    }
}

fn unwritten(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: cannot be written: {error}", path.display()))
}
