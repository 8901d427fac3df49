//! A directory: where tiles, or further directories, lie.

use super::Span;

/// Sorted by number.
#[derive(Debug, Default)]
pub(super) struct Directory(Vec<Entry>);

#[derive(Debug)]
struct Entry {
    /// Of the first tile.
    number: u64,
    /// How many tiles from there on are the same; 0: it is a directory.
    run: u64,
    span: Span,
}

/// What a directory has of a tile.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// Where it lies among the tiles.
    Tile(Span),
    /// Where the directory that knows lies among the directories.
    Directory(Span),
}

/// Octets that an entry takes at least: one in each of the four columns.
const LEAST_OF_AN_ENTRY: usize = 4;

impl Directory {
    /// Reads one: a count, then column by column the steps between numbers, runs, lengths, and places.
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
            // 0: right behind the one before; else one more than the place.
            entry.span.at = match varints.next()? {
                0 => end.ok_or(BROKEN)?,
                place => place - 1,
            };
            end = entry.span.at.checked_add(entry.span.length);
        }
        Ok(Self(entries))
    }

    /// The tile with that number, or the directory that knows it; `None` where there is none.
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

/// Numbers of seven bits an octet, the lowest first; the highest bit of each octet but the last is set.
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
