//! A directory of a PMTiles file: positions of tiles and of further directories.

use super::Span;

/// Entries sorted by tile number.
#[derive(Debug, Default)]
pub(super) struct Directory(Vec<Entry>);

#[derive(Debug)]
struct Entry {
    /// Number of the first tile.
    number: u64,
    /// Number of consecutive tiles with this content; 0: the entry is a directory.
    run: u64,
    span: Span,
}

/// The entry of a tile in a directory.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// Position within the tile data.
    Tile(Span),
    /// Position of the directory that has the tile, within the leaf directories.
    Directory(Span),
}

/// Minimum length of an entry, in octets: one in each of the four columns.
const LEAST_OF_AN_ENTRY: usize = 4;

impl Directory {
    /// Decodes a directory: a count, then the columns number (as differences), run, length, and position.
    pub(super) fn parse(octets: &[u8]) -> Result<Self, &'static str> {
        let mut varints = Varints(octets);
        let count = usize::try_from(varints.next()?).map_err(|_| BROKEN)?;
        if count > octets.len() / LEAST_OF_AN_ENTRY {
            return Err(BROKEN);
        }
        let mut number = 0_u64;
        let mut entries = Vec::with_capacity(count);
        for _ in 0..count {
            number = number.checked_add(varints.next()?).ok_or(BROKEN)?;
            entries.push(Entry { number, run: 0, span: Span::default() });
        }
        for entry in &mut entries {
            entry.run = varints.next()?;
        }
        for entry in &mut entries {
            entry.span.length = varints.next()?;
        }
        let mut end = None;
        for entry in &mut entries {
            // 0: directly after the previous entry; otherwise the position plus one.
            entry.span.at = match varints.next()? {
                0 => end.ok_or(BROKEN)?,
                place => place - 1,
            };
            end = entry.span.at.checked_add(entry.span.length);
        }
        Ok(Self(entries))
    }

    /// The entry for the tile with that number; `None`: the file does not have the tile.
    pub(super) fn find(&self, number: u64) -> Option<Found> {
        let behind = self.0.partition_point(|entry| entry.number <= number);
        let entry = self.0.get(behind.checked_sub(1)?)?;
        match entry.run {
            0 => Some(Found::Directory(entry.span)),
            run => (number - entry.number < run).then_some(Found::Tile(entry.span)),
        }
    }
}

const BROKEN: &str = "a directory of it is broken";

/// Variable-length integers: seven bits per octet, lowest first; all octets but the last have their highest bit set.
struct Varints<'a>(&'a [u8]);

impl Varints<'_> {
    fn next(&mut self) -> Result<u64, &'static str> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let (&octet, rest) = self.0.split_first().ok_or(BROKEN)?;
            self.0 = rest;
            value |= u64::from(octet & 0x7f) << shift;
            if octet < 0x80 {
                return Ok(value);
            }
        }
        Err(BROKEN)
    }
}
