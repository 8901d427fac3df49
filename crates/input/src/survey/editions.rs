//! The edition of CAT021 that each source follows. Blocks are decoded in every edition with a layout of its own.

use std::cmp::Ordering;

use asterix::cat021::{Edition, Record, Surface};
use asterix::{Block, DataSource};

use super::SOURCES;
use super::bounded::Bounded;
use super::report::EditionReport;

/// How well the editions fit the blocks of each source.
#[derive(Debug, Default)]
pub(super) struct Editions(Bounded<Option<DataSource>, Fits, SOURCES>);

#[derive(Clone, Debug, Default)]
struct Fits {
    blocks: u64,
    old: Misfits,
    new: Misfits,
    /// The oldest edition that defines everything found, if the blocks are decoded in a new edition.
    least: Option<Edition>,
}

/// Evidence against an edition; the edition with less of it fits better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Misfits {
    /// Number of blocks that cannot be read.
    unreadable: u64,
    /// Number of records with bits set that must be 0.
    odd: u64,
}

impl Misfits {
    fn of(block: Block<'_>, edition: Edition) -> (Self, Option<Edition>, Option<DataSource>) {
        let (mut misfits, mut least, mut source) = (Self::default(), None, None);
        for located in block.records_in::<Record>(edition) {
            match located {
                Ok(located) => {
                    misfits.odd += u64::from(located.record.surface.is_some_and(is_odd));
                    least = least.max(Edition::least(&located.record));
                    source = source.or(located.record.data_source);
                }
                Err(_) => misfits.unreadable += 1,
            }
        }
        (misfits, least, source)
    }

    fn add(&mut self, other: Self) {
        self.unreadable += other.unreadable;
        self.odd += other.odd;
    }
}

/// Whether spare bits of the second octet are set, or a third octet is present.
fn is_odd(surface: Surface) -> bool {
    match surface {
        Surface::Edition21(item) => item.octets().get(1).is_some_and(|second| second & 0xf0 != 0),
        Surface::Edition22(item) => {
            item.chain().octet(1).is_some_and(|second| second & 0x0e != 0) || item.chain().octet(2).is_some()
        }
    }
}

impl Editions {
    /// Counts a block. Returns the edition in which to read it: the one that fits this block better, or else its source.
    pub(super) fn block(&mut self, block: Block<'_>) -> Edition {
        let (old, _, source) = Misfits::of(block, Edition::V2_1);
        let (new, least, _) = Misfits::of(block, Edition::default());
        let Some(fits) = self.0.get(source) else { return Edition::default() };
        fits.blocks += 1;
        fits.old.add(old);
        fits.new.add(new);
        fits.least = fits.least.max(least);
        match old.cmp(&new).then(fits.old.cmp(&fits.new)) {
            Ordering::Less => Edition::V2_1,
            _ => Edition::default(),
        }
    }

    pub(super) fn report(&self) -> Vec<EditionReport> {
        let report = |(source, fits): (&Option<DataSource>, &Fits)| {
            let old = EditionReport {
                sac: source.map(|source| source.sac),
                sic: source.map(|source| source.sic),
                edition: Some(Edition::V2_1.name()),
                or_later: false,
                blocks: fits.blocks,
                unreadable: fits.old.unreadable,
                unreadable_otherwise: fits.new.unreadable,
            };
            let new = |edition: Option<Edition>| EditionReport {
                edition: edition.map(Edition::name),
                or_later: true,
                unreadable: fits.new.unreadable,
                unreadable_otherwise: fits.old.unreadable,
                ..old.clone()
            };
            match fits.old.cmp(&fits.new) {
                Ordering::Less => old,
                Ordering::Equal => new(fits.least),
                Ordering::Greater => new(fits.least.max(Some(Edition::V2_2))),
            }
        };
        self.0.iter().map(report).collect()
    }
}
