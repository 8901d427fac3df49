//! Encoder of ASTERIX from the lines of `decode`.

use asterix::{Fspec, Profile, UapItem, profile};

use super::editions::{EditionError, Editions, Reading};
use super::line::Line;
use super::parsed::{Node, Object, Value, emptied};
use super::read::{octets, read_item};

/// Error of a line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineError {
    /// The line is not a JSON object with the expected members.
    #[error("is not a line that `decode` prints: {0}")]
    Json(String),
    /// The line has neither items nor octets.
    #[error("has neither `items` nor `hex`, so there is nothing to encode")]
    Nothing,
    /// The line has items but no category.
    #[error("has `items` but no `cat`")]
    NoCategory,
    /// The category has no profile.
    #[error("category {0} is not known; give the octets of its block as `hex`")]
    UnknownCategory(u8),
    /// The edition is unknown.
    #[error("`edition`: {0}")]
    Edition(#[from] EditionError),
    /// The item that selects one of several profiles is missing or invalid.
    #[error("item {0} must say which profile of its category the record follows")]
    NoProfile(&'static str),
    /// The category does not define the item.
    #[error("category {category:03} has no item {item}")]
    UnknownItem {
        /// Number of the category.
        category: u8,
        /// Number of the item, as given.
        item: String,
    },
    /// The value of the item cannot be encoded.
    #[error("item {item}: {trouble}")]
    Item {
        /// Number of the item.
        item: &'static str,
        /// Problem, with the path inside the item.
        trouble: String,
    },
    /// The FSPEC is invalid, or does not match the items of the line.
    #[error("`fspec` does not announce the items of this line; leave it out to have the shortest one")]
    Fspec,
    /// The hexadecimal text is invalid.
    #[error("`hex` {0}")]
    Hex(String),
    /// The record and the block that it continues differ in category.
    #[error("category {record:03} in a block of category {block:03}")]
    OtherCategory {
        /// Category of the record.
        record: u8,
        /// Category of the block.
        block: u8,
    },
    /// The block is longer than the maximum.
    #[error("its block has {0} octets, which does not fit LEN, which ends at 65535")]
    BlockTooLong(usize),
}

/// Text of a JSON error without its line number, which the caller adds.
fn of_one_line(error: &str) -> String {
    error.replace(" at line 1 column ", " at column ")
}

/// Block of a line: its file, and the offset there.
type Key = (Option<String>, u64);

/// Encodes lines of `decode` as ASTERIX, one block for the lines that name the same one.
///
/// A line that names no block becomes a block of its own. Octets of unknown blocks, and octets that could not be read, are
/// written unchanged.
#[derive(Debug, Default)]
pub struct Encoder {
    /// Current block, with LEN not yet set.
    block: Vec<u8>,
    /// Key of the current block.
    key: Option<Key>,
    /// Editions of lines that name none.
    editions: Editions,
    /// Memory reused for the values of lines.
    nodes: Vec<Node<'static>>,
    record: Vec<u8>,
}

/// Length of CAT and LEN, in octets.
const HEADER: usize = 3;

impl Encoder {
    /// Creates an encoder. Lines without an edition use `editions`.
    pub fn new(editions: impl Into<Editions>) -> Self {
        Self { editions: editions.into(), ..Self::default() }
    }

    /// Encodes a line, and appends the previous block to `out` if it is now complete.
    ///
    /// # Errors
    /// The line cannot be encoded. The current block is kept without it, and written with the next call.
    pub fn line(&mut self, line: &str, out: &mut Vec<u8>) -> Result<(), LineError> {
        let mut nodes = emptied(std::mem::take(&mut self.nodes));
        let mut record = std::mem::take(&mut self.record);
        record.clear();
        let done = self.read_line(line, &mut nodes, &mut record, out);
        (self.nodes, self.record) = (emptied(nodes), record);
        done
    }

    /// Encodes a line, with the empty list `nodes` as memory.
    fn read_line<'a>(
        &mut self,
        line: &'a str,
        nodes: &mut Vec<Node<'a>>,
        record: &mut Vec<u8>,
        out: &mut Vec<u8>,
    ) -> Result<(), LineError> {
        let line =
            Line::read(line, nodes).map_err(|error| LineError::Json(of_one_line(&error.to_string())))?;
        if let Some(items) = line.items(nodes) {
            let category = line.category.ok_or(LineError::NoCategory)?;
            let reading = match &line.edition {
                Some(edition) => Reading::named(category, edition, line.untyped)?,
                None => self.editions.of(category),
            };
            let uap = uap_of(category, reading, &items)?;
            encode_record(record, category, uap, &items, line.fspec(nodes))?;
            let key = line.block.map(|block| (line.input, block));
            return self.append(key, category, record, out);
        }
        let hex = line.hex(nodes).ok_or(LineError::Nothing)?;
        let octets = octets(hex).map_err(LineError::Hex)?;
        // The rest of a block after a bad record follows the header of its block. All other octets are complete.
        match line.category {
            Some(category) if line.is_error && line.offset > line.block => {
                let key = line.block.map(|block| (line.input, block));
                self.append(key, category, &octets, out)
            }
            _ => {
                self.finish(out);
                out.extend(octets);
                Ok(())
            }
        }
    }

    /// Appends the last block to `out`.
    pub fn finish(&mut self, out: &mut Vec<u8>) {
        if let Ok(length) = u16::try_from(self.block.len())
            && !self.block.is_empty()
        {
            self.block[1..HEADER].copy_from_slice(&length.to_be_bytes());
            out.append(&mut self.block);
        }
        self.key = None;
    }

    fn append(
        &mut self,
        key: Option<Key>,
        category: u8,
        octets: &[u8],
        out: &mut Vec<u8>,
    ) -> Result<(), LineError> {
        let goes_on = key.is_some() && key == self.key;
        if goes_on && self.block[0] != category {
            return Err(LineError::OtherCategory { record: category, block: self.block[0] });
        }
        let length = if goes_on { self.block.len() } else { HEADER } + octets.len();
        if length > usize::from(u16::MAX) {
            return Err(LineError::BlockTooLong(length));
        }
        if !goes_on {
            self.finish(out);
            self.block.extend([category, 0, 0]);
            self.key = key;
        }
        self.block.extend(octets);
        Ok(())
    }
}

/// Profile of a record with these items.
fn uap_of(category: u8, reading: Reading, items: &Object<'_>) -> Result<&'static [UapItem], LineError> {
    let definition = match reading {
        Reading::Typed => {
            return profile(category).map(Profile::items).ok_or(LineError::UnknownCategory(category));
        }
        Reading::Cat021(edition) => return Ok(edition.profile().items()),
        Reading::Unknown => return Err(LineError::UnknownCategory(category)),
        Reading::Untyped(definition) => definition,
    };
    let mut octets = None;
    let chosen_by = definition.chosen_by();
    if let Some(item) = chosen_by
        && let Some(value) = items.clone().get(item.item)
    {
        let out = octets.insert(Vec::new());
        read_item(out, &item.layout, value)
            .map_err(|trouble| LineError::Item { item: item.item, trouble })?;
    }
    let number = chosen_by.map_or("", |item| item.item);
    definition.chosen(octets.as_deref()).map(Profile::items).ok_or(LineError::NoProfile(number))
}

/// Appends the octets of a record with this profile and these items.
fn encode_record(
    out: &mut Vec<u8>,
    category: u8,
    uap: &'static [UapItem],
    items: &Object<'_>,
    fspec: Option<Value<'_>>,
) -> Result<(), LineError> {
    // Values of the items, by their position in the profile.
    let mut values = [None; 7 * Fspec::MAX_OCTETS];
    let mut next = 0;
    for (key, value) in items.iter() {
        // Keys mostly come in the order of the record. Three characters can be compared without a call.
        let number: Option<&[u8; 3]> = key.as_bytes().try_into().ok();
        let is_it = |item: &UapItem| match number {
            Some(number) => item.item.as_bytes() == number,
            None => item.item == key,
        };
        let behind = uap[next..].iter().position(is_it).map(|place| next + place);
        let place = behind.or_else(|| uap[..next].iter().position(is_it));
        let place = place.ok_or_else(|| LineError::UnknownItem { category, item: key.to_owned() })?;
        if values[place].replace(value).is_some() {
            return Err(LineError::Item { item: uap[place].item, trouble: "is there twice".to_owned() });
        }
        next = place + 1;
    }
    let there = uap.iter().zip(&values).filter(|(_, value)| value.is_some());
    let minimal: Fspec = there.map(|(item, _)| item.frn).collect();
    let fspec = match fspec {
        Some(given) => padded(minimal, given).ok_or(LineError::Fspec)?,
        None => minimal,
    };
    fspec.encode_into(out);
    for (item, value) in uap.iter().zip(values) {
        if let Some(value) = value {
            read_item(out, &item.layout, value)
                .map_err(|trouble| LineError::Item { item: item.item, trouble })?;
        }
    }
    Ok(())
}

/// The given FSPEC, if it announces the same items as the shortest one.
fn padded(minimal: Fspec, given: Value<'_>) -> Option<Fspec> {
    let octets = octets(given).ok()?;
    let fspec = Fspec::read(&octets).ok()?;
    let same = (1..=7 * Fspec::MAX_OCTETS as u8).all(|frn| fspec.has(frn) == minimal.has(frn));
    (same && fspec.length() == octets.len()).then_some(fspec)
}
