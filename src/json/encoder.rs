//! ASTERIX from the lines of `decode`.

use asterix::{Fspec, Profile, UapItem, profile};

use super::editions::{EditionError, Editions, Reading};
use super::line::Line;
use super::parsed::{Node, Object, Value, emptied};
use super::read::{octets, read_item};

/// What is wrong with a line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineError {
    /// It is no JSON object with the members of a line.
    #[error("is not a line that `decode` prints: {0}")]
    Json(String),
    /// It has neither items nor octets.
    #[error("has neither `items` nor `hex`, so there is nothing to encode")]
    Nothing,
    /// It has items and no category.
    #[error("has `items` but no `cat`")]
    NoCategory,
    /// Its category has no profile.
    #[error("category {0} is not known; give the octets of its block as `hex`")]
    UnknownCategory(u8),
    /// An edition that is not known.
    #[error("`edition`: {0}")]
    Edition(#[from] EditionError),
    /// The item is not there, or does not say, which of several profiles the record follows.
    #[error("item {0} must say which profile of its category the record follows")]
    NoProfile(&'static str),
    /// An item that its category does not define.
    #[error("category {category:03} has no item {item}")]
    UnknownItem {
        /// The category.
        category: u8,
        /// The item's number as given.
        item: String,
    },
    /// An item whose value cannot be encoded.
    #[error("item {item}: {trouble}")]
    Item {
        /// Number of the item.
        item: &'static str,
        /// What is wrong with it, and where in it.
        trouble: String,
    },
    /// An FSPEC that is none, or that does not announce the items of the line.
    #[error("`fspec` does not announce the items of this line; leave it out to have the shortest one")]
    Fspec,
    /// Octets that are no hexadecimal text.
    #[error("`hex` {0}")]
    Hex(String),
    /// A record that has another category than the block which it continues.
    #[error("category {record:03} in a block of category {block:03}")]
    OtherCategory {
        /// Of the record.
        record: u8,
        /// Of the block.
        block: u8,
    },
    /// More octets than a block can hold.
    #[error("its block has {0} octets, which does not fit LEN, which ends at 65535")]
    BlockTooLong(usize),
}

/// The text of an error without the number of the line: the caller knows that.
fn of_one_line(error: &str) -> String {
    error.replace(" at line 1 column ", " at column ")
}

/// Which block a line belongs to: its file and offset there.
type Key = (Option<String>, u64);

/// Makes ASTERIX of the lines that `decode` prints, a block of those that name the same one.
///
/// Lines that name no block are a block each. The octets of unknown blocks and of what could not be read come out as they
/// went in.
#[derive(Debug, Default)]
pub struct Encoder {
    /// The block that is being made, LEN not yet set, and what it was called.
    block: Vec<u8>,
    key: Option<Key>,
    /// Those of lines that name none.
    editions: Editions,
    /// The memory of lines and of records, while neither is there.
    nodes: Vec<Node<'static>>,
    record: Vec<u8>,
}

/// Octets of CAT and LEN.
const HEADER: usize = 3;

impl Encoder {
    /// One that takes lines which name no edition as those of these.
    pub fn new(editions: impl Into<Editions>) -> Self {
        Self { editions: editions.into(), ..Self::default() }
    }

    /// Takes a line, and appends to `out` the block before it, if that is now complete.
    ///
    /// # Errors
    /// The line cannot be encoded. The block that it belongs to, as far as it was made, is not lost: it comes out with the
    /// next one.
    pub fn line(&mut self, line: &str, out: &mut Vec<u8>) -> Result<(), LineError> {
        let mut nodes = emptied(std::mem::take(&mut self.nodes));
        let mut record = std::mem::take(&mut self.record);
        record.clear();
        let done = self.read_line(line, &mut nodes, &mut record, out);
        (self.nodes, self.record) = (emptied(nodes), record);
        done
    }

    /// As [`Encoder::line`], by way of these, which are empty.
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
        // The rest of a block from a bad record on stands behind the block's header. Everything else is whole.
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

    /// Appends to `out` the last block.
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

/// The profile that a record with these items follows.
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

/// Appends the octets of a record of this profile with these items.
fn encode_record(
    out: &mut Vec<u8>,
    category: u8,
    uap: &'static [UapItem],
    items: &Object<'_>,
    fspec: Option<Value<'_>>,
) -> Result<(), LineError> {
    // Each item of the profile by its place, as far as it is there.
    let mut values = [None; 7 * Fspec::MAX_OCTETS];
    let mut next = 0;
    for (key, value) in items.iter() {
        // Mostly they come in the order of the record, and are of three characters, which are compared without a call.
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

/// The FSPEC that is given, if it announces the same as the shortest one.
fn padded(minimal: Fspec, given: Value<'_>) -> Option<Fspec> {
    let octets = octets(given).ok()?;
    let fspec = Fspec::read(&octets).ok()?;
    let same = (1..=7 * Fspec::MAX_OCTETS as u8).all(|frn| fspec.has(frn) == minimal.has(frn));
    (same && fspec.length() == octets.len()).then_some(fspec)
}
