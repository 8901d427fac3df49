//! Every category and edition that has a public machine-readable definition, without types: records by their layouts.
//!
//! [`category`] finds the editions of a category, an edition is a [`Definition`], and that takes blocks apart into
//! [`Untyped`] records: items with their octets and their [`Layout`]s. What is read is what the typed records read, by the
//! same rules; the same [`Fault`]s say what is not. CAT129, of which there is no public definition, has the layouts of its
//! typed record.
//!
//! Keys are made by one rule. A field is called what the specification calls it, in small letters; in a group that name stands
//! before it (`tid_lat_deg`), and `VAL` is called as its group. A physical value ends with its unit: lengths are metres (`_m`),
//! speeds metres a second (`_m_s`), whatever the specification counts in; flight levels stay flight levels. A value without a
//! name is `value_` and its unit, a time of day a number alone. Bits without more ado are a whole number, or hexadecimal if
//! there are more than 32 of them or they are an aircraft address. Codes stay the numbers of their tables.
//!
//! ```
//! use utm_asterix::{DataSource, all, blocks};
//!
//! let datagram = [10, 0, 10, 0xd0, 25, 7, 1, 0x54, 0x60, 0x40];
//! let surface = all::category(10).expect("CAT010 is defined").newest();
//! for block in blocks(&datagram) {
//!     for located in surface.records(block?) {
//!         let record = located?.record;
//!         assert_eq!(record.data_source(), Some(DataSource { sac: 25, sic: 7 }));
//!         let numbers: Vec<&str> = record.items().map(|(item, _)| item.item).collect();
//!         assert_eq!(numbers, ["010", "000", "140"]);
//!     }
//! }
//! # Ok::<(), utm_asterix::Fault>(())
//! ```
//!
//! The tables are text, which is read when an edition is first asked for: a fifth of a millisecond and 100 kB at most, kept as
//! long as the program runs.

mod text;
mod units;

use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use crate::fault::{Fault, FaultKind};
use crate::{
    Block, DataSource, Field, Fspec, Layout, Located, Profile, Record, TimeOfDay, UapItem, cat129, items,
};

macro_rules! tables {
    ($($category:literal),*) => { [$(include_str!(concat!("../../definitions/cat", $category, ".txt"))),*] };
}

/// The tables, see `definitions/make.py`.
const TABLES: [&str; 27] = tables![
    "001", "002", "004", "007", "008", "009", "010", "011", "015", "016", "017", "018", "019", "020", "021",
    "023", "025", "032", "034", "048", "062", "063", "065", "150", "205", "240", "247"
];

/// A category and its editions.
#[derive(Debug)]
pub struct Category {
    head: text::Head,
    /// `None` of CAT129.
    table: Option<&'static str>,
}

static CATEGORIES: LazyLock<Vec<Category>> = LazyLock::new(|| {
    let of_table = |table| {
        let head = text::head(table).expect("the tests read every table");
        Category { head, table: Some(table) }
    };
    let head = text::Head {
        number: cat129::Record::CATEGORY,
        title: "UAS Identification and Target Reports",
        editions: vec!["1.2"],
        expansions: Vec::new(),
    };
    let mut categories: Vec<_> = TABLES.into_iter().map(of_table).collect();
    categories.push(Category { head, table: None });
    categories.sort_by_key(Category::number);
    categories
});

/// Every category that is defined, in the order of their numbers.
pub fn categories() -> impl Iterator<Item = &'static Category> {
    CATEGORIES.iter()
}

/// The category with this number; `None` where it has no public definition.
pub fn category(number: u8) -> Option<&'static Category> {
    categories().find(|category| category.number() == number)
}

/// An edition that a category does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{given:?} is no edition of CAT{category:03} that is known; known are {known}")]
pub struct UnknownEdition {
    /// The category.
    pub category: u8,
    /// What was given.
    pub given: String,
    /// Those that are known.
    pub known: String,
}

/// Category, edition, edition of the reserved expansion field.
type Key = (u8, &'static str, Option<&'static str>);

/// What has been asked for so far.
static DEFINITIONS: Mutex<BTreeMap<Key, &'static Definition>> = Mutex::new(BTreeMap::new());

impl Category {
    /// Its number.
    pub fn number(&self) -> u8 {
        self.head.number
    }

    /// What the specification calls it.
    pub fn title(&self) -> &'static str {
        self.head.title
    }

    /// Its editions, the oldest first.
    pub fn editions(&self) -> &[&'static str] {
        &self.head.editions
    }

    /// The editions of its reserved expansion field, the oldest first; empty where that is not defined.
    pub fn expansions(&self) -> &[&'static str] {
        &self.head.expansions
    }

    /// The newest edition, with the newest reserved expansion field.
    pub fn newest(&self) -> &'static Definition {
        let newest = self.head.editions.last().expect("a category has an edition");
        self.made(newest, self.head.expansions.last().copied())
    }

    /// An edition: `"1.31"`, with the newest reserved expansion field, or `"1.31/1.12"` with that one.
    ///
    /// # Errors
    /// There is no such edition.
    pub fn edition(&self, text: &str) -> Result<&'static Definition, UnknownEdition> {
        let (edition, expansion) = match text.split_once('/') {
            Some((edition, expansion)) => (edition, Some(expansion)),
            None => (text, None),
        };
        let among =
            |all: &[&'static str], wanted: &str| all.iter().copied().find(|edition| *edition == wanted);
        let edition = among(&self.head.editions, edition);
        let expansion = match expansion {
            Some(expansion) => among(&self.head.expansions, expansion).map(Some),
            None => Some(self.head.expansions.last().copied()),
        };
        match (edition, expansion) {
            (Some(edition), Some(expansion)) => Ok(self.made(edition, expansion)),
            _ => Err(UnknownEdition {
                category: self.number(),
                given: text.to_owned(),
                known: match self.head.expansions.as_slice() {
                    [] => self.head.editions.join(", "),
                    expansions => {
                        let editions = self.head.editions.join(", ");
                        format!("{editions}, each alone or with /{}", expansions.join(" or /"))
                    }
                },
            }),
        }
    }

    fn made(&self, edition: &'static str, expansion: Option<&'static str>) -> &'static Definition {
        let mut made = DEFINITIONS.lock().unwrap_or_else(PoisonError::into_inner);
        made.entry((self.number(), edition, expansion))
            .or_insert_with(|| Box::leak(Box::new(Definition::new(self, edition, expansion))))
    }
}

/// A category as one edition lays it out.
#[derive(Debug)]
pub struct Definition {
    category: u8,
    edition: &'static str,
    /// The whole of its name, where it is not the newest reserved expansion field.
    name: String,
    profiles: Vec<&'static Profile>,
    choice: Option<Choice>,
    items: &'static [UapItem],
}

/// What says which of several profiles a record follows.
#[derive(Debug)]
struct Choice {
    /// The item; all profiles have it, and what stands before it, in the same places.
    item: UapItem,
    field: &'static Field,
    /// The bit at which that begins.
    at: usize,
    profiles: Vec<(u64, usize)>,
}

impl Definition {
    fn new(category: &Category, edition: &'static str, expansion: Option<&'static str>) -> Self {
        let said = match category.table {
            Some(table) => text::edition(table, &category.head, edition, expansion),
            None => Ok(text::Edition { profiles: vec![("all", cat129::UAP)], choice: None }),
        };
        let said = said.expect("the tests read every table");
        let profiles: Vec<_> = said.profiles.iter().map(|(_, uap)| *uap).collect();
        let choice = said.choice.map(|said| {
            let item = profiles[0].iter().find(|item| item.item == said.item);
            let item = *item.expect("the profiles have the item");
            let (field, at) = find_field(&item.layout, &said.field).expect("the item has the field");
            Choice { item, field, at, profiles: said.profiles }
        });
        let is_newest = expansion == category.head.expansions.last().copied();
        let name = match expansion {
            Some(expansion) if !is_newest => format!("{edition}/{expansion}"),
            _ => edition.to_owned(),
        };
        let items = all_items(&profiles);
        Self { category: category.number(), edition, name, profiles, choice, items }
    }

    /// The category.
    pub fn category(&self) -> u8 {
        self.category
    }

    /// The edition of the category: `"1.31"`.
    pub fn edition(&self) -> &'static str {
        self.edition
    }

    /// As [`Category::edition`] takes it: `"1.31"`, or `"1.31/1.12"` where it is not the newest reserved expansion field.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Every item that a record may hold, whatever its profile, numbered as if it were one profile.
    pub fn items(&self) -> &'static [UapItem] {
        self.items
    }

    /// Its profiles: one, but of CAT001 and CAT007.
    pub fn profiles(&self) -> impl Iterator<Item = &'static [UapItem]> {
        self.profiles.iter().map(|profile| profile.items())
    }

    /// The item that says which of several profiles a record follows, where there are several.
    pub fn chosen_by(&self) -> Option<&UapItem> {
        self.choice.as_ref().map(|choice| &choice.item)
    }

    /// The profile that is meant by the octets of [`Definition::chosen_by`], or the only one; `None` where they mean none.
    pub fn chosen(&self, octets: Option<&[u8]>) -> Option<&'static Profile> {
        let Some(choice) = &self.choice else { return self.profiles.first().copied() };
        let said = choice.field.count(octets?, choice.at);
        let &(_, profile) = choice.profiles.iter().find(|(value, _)| *value == said)?;
        self.profiles.get(profile).copied()
    }

    /// The profile of the record at the front of `octets`, which go to the end of the block.
    fn profile(&self, octets: &[u8]) -> Result<&'static Profile, Fault> {
        let first = self.profiles[0];
        let Some(choice) = &self.choice else { return Ok(first) };
        // What is wrong with the FSPEC or an item before it is told as of any profile.
        let before = first.iter().take_while(|item| item.frn <= choice.item.frn);
        let mut item = None;
        let fspec = Fspec::read(octets).ok();
        let mut offset = fspec.map_or(0, Fspec::length);
        for known in before.filter(|known| fspec.is_some_and(|fspec| fspec.has(known.frn))) {
            let rest = octets.get(offset..).unwrap_or_default();
            let Ok(length) = known.measure(rest) else { return Ok(first) };
            if known.frn == choice.item.frn {
                item = Some((offset, &rest[..length]));
            }
            offset += length;
        }
        let fault =
            |item, offset| Fault { category: Some(self.category), item, offset, kind: FaultKind::NoProfile };
        match (fspec, item) {
            (None, _) => Ok(first),
            (_, None) => Err(fault(None, 0)),
            (_, Some((at, octets))) => {
                self.chosen(Some(octets)).ok_or_else(|| fault(Some(choice.item.item), at))
            }
        }
    }

    /// The record at the front of `octets`, which begin with its FSPEC and go to the end of the block. Offsets in the fault
    /// count from the FSPEC.
    ///
    /// # Errors
    /// It is not a record of this edition; where it would end is then unknown.
    pub fn record<'a>(&'static self, octets: &'a [u8]) -> Result<Untyped<'a>, Fault> {
        let uap = self.profile(octets)?;
        let length = match self.category {
            // The length of one of its items shows only at the end of the block.
            cat129::Record::CATEGORY => cat129::Record::decode(octets, ())?.1,
            category => uap.measure(category, octets)?,
        };
        Ok(Untyped { definition: self, uap, octets: &octets[..length] })
    }

    /// The records of a block, in order: every one up to the end of the block or to the first [`Fault`], which comes once and
    /// last.
    pub fn records<'a>(
        &'static self,
        block: Block<'a>,
    ) -> impl Iterator<Item = Result<Located<Untyped<'a>>, Fault>> {
        let mut rest = block.contents();
        let mut offset = block.offset + block.octets.len() - rest.len();
        std::iter::from_fn(move || {
            if rest.is_empty() {
                return None;
            }
            let at = offset;
            Some(match self.record(rest) {
                Ok(record) => {
                    let length = record.octets.len();
                    rest = &rest[length..];
                    offset += length;
                    Ok(Located { offset: at, length, record })
                }
                Err(fault) => {
                    rest = &[];
                    Err(Fault { offset: at + fault.offset, ..fault })
                }
            })
        })
    }
}

/// The field with this key and the bit at which it begins.
fn find_field(layout: &Layout, key: &str) -> Option<(&'static Field, usize)> {
    let parts: &[&'static [Field]] = match layout {
        Layout::Fields(fields) => &[*fields],
        Layout::Extended(parts) | Layout::Parts(parts) => parts,
        _ => return None,
    };
    let mut at = 0;
    for fields in parts {
        let first = at;
        for field in *fields {
            if field.key == key {
                return Some((field, at));
            }
            at += usize::from(field.bits);
        }
        at = first + (at - first).next_multiple_of(8);
    }
    None
}

/// The items of all profiles, each once; of random field sequencing the one that all of them share.
fn all_items(profiles: &[&'static Profile]) -> &'static [UapItem] {
    let [first, others @ ..] = profiles else { return &[] };
    if others.is_empty() {
        return first;
    }
    let mut items: Vec<UapItem> = Vec::new();
    for item in profiles.iter().copied().flatten() {
        if items.iter().all(|known| known.item != item.item) {
            items.push(*item);
        }
    }
    for (item, frn) in items.iter_mut().zip(1..) {
        item.frn = frn;
    }
    items.leak()
}

/// A record whose category has no type here, or of an edition that has none: its octets, which can be read.
#[derive(Clone, Copy, Debug)]
pub struct Untyped<'a> {
    definition: &'static Definition,
    uap: &'static Profile,
    octets: &'a [u8],
}

impl<'a> Untyped<'a> {
    /// The edition it was read in.
    pub fn definition(&self) -> &'static Definition {
        self.definition
    }

    /// The items in the order of the record, as the profile that it follows has them.
    pub fn profile(&self) -> &'static [UapItem] {
        self.uap.items()
    }

    /// All octets, from its FSPEC on.
    pub fn octets(&self) -> &'a [u8] {
        self.octets
    }

    /// Its items, each with its own octets.
    pub fn items(&self) -> impl Iterator<Item = (&'static UapItem, &'a [u8])> {
        items(self.uap, self.octets)
    }

    /// Who reports: of most categories item 010.
    pub fn data_source(&self) -> Option<DataSource> {
        let is_source = |item: &UapItem| match item.layout {
            Layout::Fields([sac, sic, ..]) => {
                (sac.key, sac.bits, sic.key, sic.bits) == ("sac", 8, "sic", 8)
                    && item.name.starts_with("Data Source")
            }
            _ => false,
        };
        let (_, octets) = self.items().find(|(item, _)| is_source(item))?;
        Some(DataSource { sac: *octets.first()?, sic: *octets.get(1)? })
    }

    /// The first item that is a time of day, whatever its number.
    pub fn time_of_day(&self) -> Option<TimeOfDay> {
        let is_time = |item: &UapItem| match item.layout {
            Layout::Fields([field]) => {
                field.key.is_empty()
                    && text::is_time_of_day(field.bits, field.kind)
                    && item.name.starts_with("Time")
            }
            _ => false,
        };
        let (_, octets) = self.items().find(|(item, _)| is_time(item))?;
        TimeOfDay::from_count(u32::from_be_bytes([0, *octets.first()?, *octets.get(1)?, *octets.get(2)?]))
    }
}
