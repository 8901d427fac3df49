//! Sources whose blocks cannot be read in the edition that is usual: the editions in which they can.

use asterix::{Block, DataSource, TimeOfDay, all};

use super::SOURCES;
use super::bounded::Bounded;
use super::report::MisreadReport;

/// Fewest misread blocks that say something of a source's edition.
const LEAST: u64 = 3;
/// Misread blocks of a source that are tried in other editions.
const TRIED: u64 = 1000;

/// The blocks of each category and source.
#[derive(Debug, Default)]
pub(super) struct Misread(Bounded<(u8, Option<DataSource>), Counts, SOURCES>);

#[derive(Clone, Debug, Default)]
struct Counts {
    blocks: u64,
    misread: u64,
    /// Misread blocks that were tried in every edition.
    tried: u64,
    /// Number of these that each edition reads.
    read_in: Vec<u64>,
}

impl Misread {
    /// Counts a block of a category that has definitions. `is_misread`: a record could not be read, or has a time of day that
    /// does not exist.
    pub(super) fn block(&mut self, block: Block<'_>, is_misread: bool) {
        let Some(category) = all::category(block.category) else { return };
        let Some(counts) = self.0.get((block.category, block.first_source())) else { return };
        counts.blocks += 1;
        if !is_misread {
            return;
        }
        counts.misread += 1;
        if counts.tried == TRIED {
            return;
        }
        counts.tried += 1;
        counts.read_in.resize(category.editions().len(), 0);
        for (edition, count) in category.editions().iter().zip(&mut counts.read_in) {
            *count += u64::from(is_read_in(block, category, edition));
        }
    }

    /// The sources most of whose blocks are misread.
    pub(super) fn report(&self) -> Vec<MisreadReport> {
        let report = |(&(number, source), counts): (&(u8, Option<DataSource>), &Counts)| {
            let is_told = counts.misread >= LEAST && counts.misread * 2 > counts.blocks;
            let known = all::category(number).filter(|_| is_told)?.editions();
            // Nine in ten: a source has its damage, too.
            let most = counts.read_in.iter().copied().max().filter(|most| most * 10 >= counts.tried * 9);
            let fits = |count: &u64| most.is_some_and(|most| *count == most);
            let read_in = known.iter().zip(&counts.read_in).filter(|(_, count)| fits(count));
            Some(MisreadReport {
                category: number,
                sac: source.map(|source| source.sac),
                sic: source.map(|source| source.sic),
                blocks: counts.blocks,
                misread: counts.misread,
                read_in: read_in.map(|(edition, _)| *edition).collect(),
                known: known.to_vec(),
            })
        };
        self.0.iter().filter_map(report).collect()
    }
}

/// Whether all records of a block can be read in an edition, with times of day that exist.
fn is_read_in(block: Block<'_>, category: &all::Category, edition: &str) -> bool {
    let Ok(definition) = category.edition(edition) else { return false };
    let mut records = definition.records(block).peekable();
    records.peek().is_some()
        && records.all(|located| {
            located.is_ok_and(|located| located.record.time_of_day().is_none_or(TimeOfDay::in_range))
        })
}
