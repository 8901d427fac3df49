//! Every category and edition with a public machine-readable definition, without types: records described by layouts.
//!
//! [`category`] returns a category with its editions. An edition is a [`Definition`], which decodes blocks into [`Untyped`]
//! records: items with their octets and [`Layout`]s. Untyped and typed records are read by the same rules and report the same
//! [`Fault`]s. CAT129 has no public definition; its layouts are those of its typed record.
//!
//! Keys follow one rule. A field has its name in the specification, in lower case, after the name of its group
//! (`tid_lat_deg`); a field `VAL` has the name of its group. A physical value ends with its unit. Lengths are in metres (`_m`)
//! and speeds in metres per second (`_m_s`), whatever unit the specification uses; flight levels are unchanged. A value without
//! a name is `value_` and its unit; a time of day is a number alone. Bits without further meaning are an integer, or
//! hexadecimal if there are more than 32 of them or they are an aircraft address. Codes are numbers.
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
//! The tables are text and are parsed when an edition is first used. This takes at most a fifth of a millisecond and 100 kB,
//! which remain allocated while the program runs.

mod text;
mod units;

use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use crate::fault::{Fault, FaultKind};
use crate::{
    Block, DataSource, Field, Fspec, Layout, Located, Profile, Record, TimeOfDay, UapItem, cat129, items,
};

macro_rules! tables {
    ($($category:literal),*) => { [$(include_str!(concat!("../definitions/cat", $category, ".txt"))),*] };
}

/// The tables; `definitions/make.py` describes their form.
const TABLES: [&str; 27] = tables![
    "001", "002", "004", "007", "008", "009", "010", "011", "015", "016", "017", "018", "019", "020", "021",
    "023", "025", "032", "034", "048", "062", "063", "065", "150", "205", "240", "247"
];

/// A category with its editions.
#[derive(Debug)]
pub struct Category {
    head: text::Head,
    /// `None` for CAT129.
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

/// Every category with a definition, in the order of their numbers.
pub fn categories() -> impl Iterator<Item = &'static Category> {
    CATEGORIES.iter()
}

/// The category with this number; `None` if it has no public definition.
pub fn category(number: u8) -> Option<&'static Category> {
    categories().find(|category| category.number() == number)
}

/// Error: a category does not have this edition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{given:?} is no edition of CAT{category:03} that is known; known are {known}")]
pub struct UnknownEdition {
    /// The category.
    pub category: u8,
    /// The name of the edition as given.
    pub given: String,
    /// The known editions.
    pub known: String,
}

/// Key of a definition: category, edition, edition of the reserved expansion field.
type Key = (u8, &'static str, Option<&'static str>);

/// Definitions used so far.
static DEFINITIONS: Mutex<BTreeMap<Key, &'static Definition>> = Mutex::new(BTreeMap::new());

impl Category {
    /// The number of the category.
    pub fn number(&self) -> u8 {
        self.head.number
    }

    /// The title in the specification.
    pub fn title(&self) -> &'static str {
        self.head.title
    }

    /// The editions, oldest first.
    pub fn editions(&self) -> &[&'static str] {
        &self.head.editions
    }

    /// The editions of the reserved expansion field, oldest first; empty if it is not defined.
    pub fn expansions(&self) -> &[&'static str] {
        &self.head.expansions
    }

    /// The newest edition, with the newest reserved expansion field.
    pub fn newest(&self) -> &'static Definition {
        let newest = self.head.editions.last().expect("a category has an edition");
        self.made(newest, self.head.expansions.last().copied())
    }

    /// An edition: `"1.31"`, with the newest reserved expansion field, or `"1.31/1.12"` for a particular one.
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

/// The layout of a category in one edition.
#[derive(Debug)]
pub struct Definition {
    category: u8,
    edition: &'static str,
    /// Name of the edition, with that of the reserved expansion field if this is not the newest one.
    name: String,
    profiles: Vec<&'static Profile>,
    choice: Option<Choice>,
    items: &'static [UapItem],
}

/// The field that selects one of several profiles for a record.
#[derive(Debug)]
struct Choice {
    /// The item with the field. It is in the same place in all profiles, as are the items before it.
    item: UapItem,
    field: &'static Field,
    /// Index of the field's first bit.
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

    /// The name, as [`Category::edition`] accepts it: `"1.31"`, or `"1.31/1.12"` if the reserved expansion field is not the
    /// newest.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All items that a record of any profile may hold, numbered as if there were one profile.
    pub fn items(&self) -> &'static [UapItem] {
        self.items
    }

    /// The profiles: several in CAT001 and CAT007, one in the other categories.
    pub fn profiles(&self) -> impl Iterator<Item = &'static [UapItem]> {
        self.profiles.iter().map(|profile| profile.items())
    }

    /// The item that selects the profile of a record, if there are several profiles.
    pub fn chosen_by(&self) -> Option<&UapItem> {
        self.choice.as_ref().map(|choice| &choice.item)
    }

    /// The profile selected by the octets of [`Definition::chosen_by`], or the only one; `None` if they select none.
    pub fn chosen(&self, octets: Option<&[u8]>) -> Option<&'static Profile> {
        let Some(choice) = &self.choice else { return self.profiles.first().copied() };
        let said = choice.field.count(octets?, choice.at);
        let &(_, profile) = choice.profiles.iter().find(|(value, _)| *value == said)?;
        self.profiles.get(profile).copied()
    }

    /// The profile of the record at the start of `octets`, which extend to the end of the block.
    fn profile(&self, octets: &[u8]) -> Result<&'static Profile, Fault> {
        let first = self.profiles[0];
        let Some(choice) = &self.choice else { return Ok(first) };
        // Faults in the FSPEC and in items before the selecting one are the same in all profiles: any profile reports them.
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

    /// The record at the start of `octets`, which begin with its FSPEC and extend to the end of the block. Offsets in the fault
    /// are relative to the FSPEC.
    ///
    /// # Errors
    /// The octets are no record of this edition. The end of the record is then unknown.
    pub fn record<'a>(&'static self, octets: &'a [u8]) -> Result<Untyped<'a>, Fault> {
        let uap = self.profile(octets)?;
        let length = match self.category {
            // The length of I129/120 depends on the end of the block.
            cat129::Record::CATEGORY => cat129::Record::decode(octets, ())?.1,
            category => uap.measure(category, octets)?,
        };
        Ok(Untyped { definition: self, uap, octets: &octets[..length] })
    }

    /// The records of a block in order, up to its end or to the first [`Fault`], which is returned once and last.
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

/// The field with this key, and the index of its first bit.
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

/// The items of all profiles, each once. Random field sequencing is included in the form that all profiles share.
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

/// A record of a category or edition without types: its octets, which are known to be valid.
#[derive(Clone, Copy, Debug)]
pub struct Untyped<'a> {
    definition: &'static Definition,
    uap: &'static Profile,
    octets: &'a [u8],
}

impl<'a> Untyped<'a> {
    /// The definition by which it was decoded.
    pub fn definition(&self) -> &'static Definition {
        self.definition
    }

    /// The items of the profile that the record follows, in order.
    pub fn profile(&self) -> &'static [UapItem] {
        self.uap.items()
    }

    /// All octets of the record, with its FSPEC.
    pub fn octets(&self) -> &'a [u8] {
        self.octets
    }

    /// The items of the record, each with its octets.
    pub fn items(&self) -> impl Iterator<Item = (&'static UapItem, &'a [u8])> {
        items(self.uap, self.octets)
    }

    /// The data source: item 010 in most categories.
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

    /// The first item that is a time of day.
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
