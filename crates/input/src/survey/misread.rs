//! Sources whose blocks cannot be read in the usual edition, and the editions in which they can.

use asterix::{Block, DataSource, TimeOfDay, all};

use super::SOURCES;
use super::bounded::Bounded;
use super::report::MisreadReport;

/// Minimum number of misread blocks from which an edition is concluded.
const LEAST: u64 = 3;
/// Maximum number of a source's misread blocks that are decoded in other editions.
const TRIED: u64 = 1000;

/// Statistics of the blocks, by category and source.
#[derive(Debug, Default)]
pub(super) struct Misread(Bounded<(u8, Option<DataSource>), Counts, SOURCES>);

#[derive(Clone, Debug, Default)]
struct Counts {
    blocks: u64,
    misread: u64,
    /// Number of misread blocks that were decoded in every edition.
    tried: u64,
    /// Number of these that can be read, by edition.
    read_in: Vec<u64>,
}

impl Misread {
    /// Counts a block of a category that has definitions. `is_misread`: a record cannot be read or has an invalid time of day.
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

    /// The sources with more misread than readable blocks.
    pub(super) fn report(&self) -> Vec<MisreadReport> {
        let report = |(&(number, source), counts): (&(u8, Option<DataSource>), &Counts)| {
            let is_told = counts.misread >= LEAST && counts.misread * 2 > counts.blocks;
            let known = all::category(number).filter(|_| is_told)?.editions();
            // Nine in ten blocks suffice, because some may be damaged.
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

/// Whether all records of a block can be read in an edition and have valid times of day.
fn is_read_in(block: Block<'_>, category: &all::Category, edition: &str) -> bool {
    let Ok(definition) = category.edition(edition) else { return false };
    let mut records = definition.records(block).peekable();
    records.peek().is_some()
        && records.all(|located| {
            located.is_ok_and(|located| located.record.time_of_day().is_none_or(TimeOfDay::in_range))
        })
}
