//! Records as tables: one per category, and one of what could not be read.

use std::collections::BTreeMap;
use std::io;

use asterix::{Fault, Profile, UapItem, profile};

use super::{Faults, Sink};
use crate::formats::records::RecordColumns;
use crate::formats::table::{Cell, Column, ColumnKind, Table};
use crate::gateways::remote_id::Line;
use crate::hex;
use crate::json::{EditionError, Editions, Entry, Place, REMOTE_ID, Reading, SKIPPED};
use crate::pipeline::LineFault;
use fusion::time::Time;

/// Makes the table of this name, with these columns; `None` where it is not wanted.
type Opener<'a> = dyn FnMut(&str, &[Column]) -> io::Result<Option<Box<dyn Table + 'a>>> + 'a;

/// Tables that are made as there is something for them: `cat048`, say, and `unread`.
pub struct Tables<'a> {
    open: Box<Opener<'a>>,
    /// Whether the octets of each record are wanted.
    hex: bool,
    records: BTreeMap<u8, Records<'a>>,
    /// What could not be read or was not looked into; `None` before the first of it.
    unread: Option<Box<dyn Table + 'a>>,
    faults: Faults,
}

/// The table of a category.
struct Records<'a> {
    columns: RecordColumns,
    table: Box<dyn Table + 'a>,
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
    /// Those that `open` makes; with the octets of each record where `hex` asks for them.
    pub fn new(
        hex: bool,
        open: impl FnMut(&str, &[Column]) -> io::Result<Option<Box<dyn Table + 'a>>> + 'a,
    ) -> Self {
        Self { open: Box::new(open), hex, records: BTreeMap::new(), unread: None, faults: Faults::default() }
    }

    /// Begins the table of a category, whether or not there is anything for it.
    ///
    /// # Errors
    /// It has no public definition; or the table cannot be made.
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

    /// What could not be read so far.
    pub fn faults(&mut self) -> &mut Faults {
        &mut self.faults
    }

    /// Completes them.
    ///
    /// # Errors
    /// One cannot be written.
    pub fn finish(self) -> io::Result<()> {
        self.records.into_values().try_for_each(|records| records.table.finish())?;
        self.unread.map_or(Ok(()), <dyn Table>::finish)
    }

    /// That of a category with these items; `None` where it is not wanted.
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
}

impl Sink for Tables<'_> {
    type Error = io::Error;

    fn record(&mut self, entry: &Entry<'_>) -> io::Result<()> {
        let hex = self.hex;
        let Some(Records { columns, table }) = self.table(entry.category, entry.all)? else { return Ok(()) };
        let Place { input, offset, block } = entry.place;
        let cells = [
            entry.time.map(Cell::Instant),
            input.map(|input| Cell::Text(input.into())),
            count(offset),
            count(block),
            entry.source.and_then(|source| count(source.sac.into())),
            entry.source.and_then(|source| count(source.sic.into())),
            hex.then(|| Cell::Text(hex::text(entry.octets).into())),
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

    /// It has no table.
    fn remote_id(
        &mut self,
        line: Result<&Line, LineFault>,
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
