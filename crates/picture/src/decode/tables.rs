//! Records as tables: one per category, and one for everything that was not read.

use std::collections::BTreeMap;
use std::io;

use asterix::{Fault, Profile, UapItem, profile};

use super::{Faults, Sink};
use crate::formats::records::RecordColumns;
use crate::formats::table::{ColumnKind, TableCell, TableColumn, TableWriter};
use fusion::time::Time;
use input::gateways::remote_id::BroadcastLine;
use input::hex;
use input::json::{EditionError, Editions, Entry, Place, REMOTE_ID, Reading, SKIPPED};
use input::pipeline::LineFault;

/// Creates the table with this name and these columns; `None` if it is not wanted.
type Opener<'a> = dyn FnMut(&str, &[TableColumn]) -> io::Result<Option<Box<dyn TableWriter + 'a>>> + 'a;

/// Tables that are created when their first row is due: `cat048`, for instance, and `unread`.
pub struct Tables<'a> {
    open: Box<Opener<'a>>,
    /// Whether to include the octets of each record.
    hex: bool,
    records: BTreeMap<u8, Records<'a>>,
    /// Table of what could not be read or was not decoded; `None` before its first row.
    unread: Option<Box<dyn TableWriter + 'a>>,
    faults: Faults,
}

/// Table of a category.
struct Records<'a> {
    columns: RecordColumns,
    table: Box<dyn TableWriter + 'a>,
}

/// Columns before the items of a record.
const BEFORE: [(&str, ColumnKind); 7] = [
    ("time", ColumnKind::Instant),
    ("input", ColumnKind::Text),
    ("offset", ColumnKind::Count),
    ("block", ColumnKind::Count),
    ("sac", ColumnKind::Count),
    ("sic", ColumnKind::Count),
    ("hex", ColumnKind::Text),
];

/// Columns of the table `unread`.
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

/// Reason for a block that was not decoded.
const BLOCK: &str = "block";

/// Reason for octets that a sender appends to the blocks of a datagram.
const TRAILER: &str = "trailer";

impl<'a> Tables<'a> {
    /// Tables created by `open`; `hex` adds the octets of each record.
    pub fn new(
        hex: bool,
        open: impl FnMut(&str, &[TableColumn]) -> io::Result<Option<Box<dyn TableWriter + 'a>>> + 'a,
    ) -> Self {
        Self { open: Box::new(open), hex, records: BTreeMap::new(), unread: None, faults: Faults::default() }
    }

    /// Creates the table of a category, even if no record follows.
    ///
    /// # Errors
    /// The category has no public definition, or the table cannot be created.
    pub fn begin(&mut self, category: u8, editions: &Editions) -> io::Result<()> {
        let all = match editions.of(category) {
            Reading::Typed => profile(category).map(Profile::items),
            Reading::Cat021(edition) => Some(edition.profile().items()),
            Reading::Untyped(definition) => Some(definition.items()),
            Reading::Unknown => None,
        };
        let all = all.ok_or_else(|| io::Error::other(EditionError::Category(category)))?;
        self.table(category, all).map(|_| ())
    }

    /// The errors so far.
    pub fn faults(&mut self) -> &mut Faults {
        &mut self.faults
    }

    /// Completes the tables.
    ///
    /// # Errors
    /// A table cannot be written.
    pub fn finish(self) -> io::Result<()> {
        self.records.into_values().try_for_each(|records| records.table.finish())?;
        self.unread.map_or(Ok(()), <dyn TableWriter>::finish)
    }

    /// The table of a category with these items; `None` if it is not wanted.
    fn table(&mut self, category: u8, all: &'static [UapItem]) -> io::Result<Option<&mut Records<'a>>> {
        if !self.records.contains_key(&category) {
            let mut columns = RecordColumns::of(category, all, named(&BEFORE));
            let table = (self.open)(&format!("cat{category:03}"), columns.columns())?;
            let Some(table) = table else { return Ok(None) };
            columns.keep(|column| table.wants(column));
            self.records.insert(category, Records { columns, table });
        }
        Ok(self.records.get_mut(&category))
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
            self.unread = (self.open)("unread", &named(&UNREAD))?;
        }
        let Some(table) = &mut self.unread else { return Ok(()) };
        let text = |text: &str| Some(TableCell::Text(text.to_owned().into()));
        let cells = [
            text(kind),
            place.input.and_then(text),
            count(place.offset),
            count(place.block),
            category.and_then(|category| count(category.into())),
            item.and_then(text),
            detail.map(|detail| TableCell::Text(detail.into())),
            Some(TableCell::Text(hex::text(octets).into())),
        ];
        set(&mut **table, cells);
        table.end_row()
    }
}

impl Sink for Tables<'_> {
    type Error = io::Error;

    fn record(&mut self, entry: &Entry<'_>) -> io::Result<()> {
        let hex = self.hex;
        let Some(Records { columns, table }) = self.table(entry.category, entry.all)? else { return Ok(()) };
        let Place { input, offset, block } = entry.place;
        let cells = [
            entry.time.map(TableCell::Instant),
            input.map(|input| TableCell::Text(input.into())),
            count(offset),
            count(block),
            entry.source.and_then(|source| count(source.sac.into())),
            entry.source.and_then(|source| count(source.sic.into())),
            hex.then(|| TableCell::Text(hex::text(entry.octets).into())),
        ];
        set(&mut **table, cells);
        columns.fill(&mut **table, entry.items());
        table.end_row()
    }

    fn block(&mut self, category: u8, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.unread(BLOCK, place, Some(category), None, None, octets)
    }

    fn fault(&mut self, fault: Fault, octets: &[u8], origin: u64, place: Place<'_>) -> io::Result<()> {
        self.faults.note(fault.kind.name(), place, octets);
        let offset = usize::try_from(origin + fault.offset as u64).unwrap_or(usize::MAX);
        let detail = Fault { offset, ..fault }.to_string();
        self.unread(fault.kind.name(), place, fault.category, fault.item, Some(detail), octets)
    }

    fn skipped(&mut self, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.faults.note(SKIPPED, place, octets);
        self.unread(SKIPPED, place, None, None, None, octets)
    }

    fn trailer(&mut self, octets: &[u8], place: Place<'_>) -> io::Result<()> {
        self.unread(TRAILER, place, None, None, None, octets)
    }

    /// Remote ID has no table.
    fn remote_id(
        &mut self,
        line: Result<&BroadcastLine, LineFault>,
        octets: &[u8],
        _: Option<Time>,
        place: Place<'_>,
    ) -> io::Result<()> {
        if line.is_err() {
            self.faults.note(REMOTE_ID, place, octets);
        }
        self.unread(SKIPPED, place, None, None, None, octets)
    }
}

fn named(columns: &[(&'static str, ColumnKind)]) -> Vec<TableColumn> {
    columns.iter().map(|&(name, kind)| TableColumn::new(name, kind)).collect()
}

fn count(number: u64) -> Option<TableCell<'static>> {
    i64::try_from(number).ok().map(TableCell::Count)
}

/// Sets the first cells of a row.
fn set<const N: usize>(table: &mut dyn TableWriter, cells: [Option<TableCell<'_>>; N]) {
    for (column, cell) in cells.into_iter().enumerate() {
        if let Some(cell) = cell {
            table.set(column, cell);
        }
    }
}
