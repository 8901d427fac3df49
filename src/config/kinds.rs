//! Kinds of values: which are valid, and how they are read and shown.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::ops::RangeInclusive;
use std::path::{self, Path, PathBuf};

use asterix::cat021::Edition;
use axum::http::Uri;
use jiff::SignedDuration;

use super::cidr::Network;
use super::names::Named;
use super::reader::{Item, Section};
use super::table::{Row, Table};
use super::tree::quoted;

/// Reads a value; finds fault with one that is not valid.
type Read<T> = Box<dyn Fn(&Item<'_>) -> Option<T>>;

/// A kind of values of a key.
pub(crate) struct Kind<T> {
    /// Which values are valid.
    pub(crate) values: String,
    pub(crate) read: Read<T>,
}

impl<T> Kind<T> {
    pub(crate) fn new(values: impl Into<String>, read: impl Fn(&Item<'_>) -> Option<T> + 'static) -> Self {
        Self { values: values.into(), read: Box::new(read) }
    }
}

/// Of a key that may be absent.
impl<T: 'static> From<Kind<T>> for Kind<Option<T>> {
    fn from(kind: Kind<T>) -> Self {
        Self::new(kind.values, move |item| (kind.read)(item).map(Some))
    }
}

/// A finite number that is valid; the rule says which are.
pub(crate) fn number(rule: &'static str, valid: fn(f64) -> bool) -> Kind<f64> {
    Kind::new(rule, move |item| item.number(rule, valid))
}

/// A whole number in a range; the rule says which.
pub(crate) fn whole<T>(rule: &'static str, range: RangeInclusive<T>) -> Kind<T>
where
    T: TryFrom<i64> + PartialOrd + Copy + 'static,
{
    Kind::new(rule, move |item| item.whole(range.clone(), rule))
}

/// A count up to a million whose 0 means no limit.
pub(crate) fn limit(rule: &'static str) -> Kind<Option<NonZeroU32>> {
    Kind::new(rule, move |item| item.whole(0..=1_000_000, rule).map(NonZeroU32::new))
}

/// A duration in seconds.
pub(crate) fn seconds(rule: &'static str, valid: fn(f64) -> bool) -> Kind<SignedDuration> {
    Kind::new(rule, move |item| item.seconds(rule, valid))
}

/// True or false.
pub(crate) fn flag() -> Kind<bool> {
    fn read(item: &Item<'_>) -> Option<bool> {
        item.flag()
    }
    Kind::new("`true` or `false`", read)
}

/// Text that is valid; the rule says which is.
pub(crate) fn text(rule: &'static str, valid: fn(&str) -> bool) -> Kind<String> {
    parsed(rule, move |text| if valid(text) { Ok(text.to_owned()) } else { Err(rule) })
}

/// Any text that is not blank.
pub(crate) fn any_text() -> Kind<String> {
    text("text that is not blank", |_| true)
}

/// Whether `text` is made of letters, digits, `_` and `-`.
pub(crate) fn is_plain(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
}

/// Text that `read` understands; its error says what is wrong with any other.
pub(crate) fn parsed<T, E: Display>(values: &str, read: impl Fn(&str) -> Result<T, E> + 'static) -> Kind<T> {
    Kind::new(values, move |item| read(item.text()?).map_err(|error| item.refuse(error)).ok())
}

/// The address of a host or group that is valid; the rule says which is.
pub(crate) fn ipv4(rule: &'static str, valid: fn(Ipv4Addr) -> bool) -> Kind<Ipv4Addr> {
    Kind::new(rule, move |item| {
        let address = item.ipv4()?;
        if !valid(address) {
            item.refuse(rule);
        }
        Some(address)
    })
}

/// A path that is relative to the working directory.
pub(crate) fn directory() -> Kind<PathBuf> {
    Kind::new("a path, relative to the working directory", |item| Some(item.text()?.into()))
}

/// A path that is relative to the configuration; what is read is absolute.
pub(crate) fn beside() -> Kind<PathBuf> {
    Kind::new("a path, relative to the configuration file", |item| {
        let written = Path::new(item.file()).parent().unwrap_or(Path::new("")).join(item.text()?);
        Some(path::absolute(&written).unwrap_or(written))
    })
}

/// One of the names of an enumeration.
pub(crate) fn named<T: Named>() -> Kind<T> {
    let names = T::NAMES.iter().map(|(name, about)| format!("`\"{name}\"`:{}", about.trim_end_matches('.')));
    parsed(&names.collect::<Vec<_>>().join("; "), T::named)
}

/// A list of values.
pub(crate) fn list<T: 'static>(kind: Kind<T>) -> Kind<Vec<T>> {
    let values = format!("a list; {}", kind.values);
    Kind::new(values, move |item| Some(item.list()?.iter().filter_map(&*kind.read).collect()))
}

/// A table.
pub(crate) fn inline<T: Table>() -> Kind<T> {
    Kind::new("a table of the keys below", |item| item.section().map(T::read))
}

/// A list of tables.
pub(crate) fn tables<T: Table>() -> Kind<Vec<T>> {
    let read = |item: &Item<'_>| Some(checked_tables(Some(item.clone()), |_, _| {}));
    Kind::new("a list of tables of the keys below", read)
}

/// Every table of a list, each looked at by `check` before its unknown keys are refused. An absent list is empty.
pub(crate) fn checked_tables<T: Table>(
    list: Option<Item<'_>>,
    mut check: impl FnMut(&T, &Section<'_>),
) -> Vec<T> {
    let sections = list.and_then(|list| list.list()).unwrap_or_default().into_iter();
    let read = |item: Item<'_>| {
        let mut section = item.section()?;
        let table = T::read_keys(&mut section);
        check(&table, &section);
        section.finish();
        Some(table)
    };
    sections.filter_map(read).collect()
}

/// A value that a key has.
pub(crate) trait Toml {
    /// The keys of a table.
    fn keys() -> Vec<Row> {
        Vec::new()
    }

    /// The value as TOML, where there is one.
    fn toml(&self) -> Option<String>;
}

macro_rules! toml {
    ($value:ident => $toml:expr; $($type:ty),*) => {
        $(impl Toml for $type {
            fn toml(&self) -> Option<String> {
                let $value = self;
                Some($toml)
            }
        })*
    };
}
toml!(value => value.to_string(); u8, u16, u32, bool);
toml!(value => format!("{value:?}"); f64);
toml!(value => quoted(&value.to_string()); String, Ipv4Addr, SocketAddr, Network, Uri, Edition);
toml!(value => quoted(&value.to_string_lossy()); PathBuf);
toml!(value => format!("{:?}", value.as_secs_f64()); SignedDuration);
toml!(value => format!("[{:?}, {:?}]", value.0, value.1); (f64, f64));
toml!(value => value.map_or(0, NonZeroU32::get).to_string(); Option<NonZeroU32>);
toml!(value => {
    let numbers = value.iter().map(|(name, number)| format!("{} = {number}", quoted(name)));
    format!("{{ {} }}", numbers.collect::<Vec<_>>().join(", "))
}; BTreeMap<String, u32>);

impl<T: Toml> Toml for Option<T> {
    fn keys() -> Vec<Row> {
        T::keys()
    }

    fn toml(&self) -> Option<String> {
        self.as_ref().and_then(T::toml)
    }
}

/// On one line; a table has a line of its own.
impl<T: Toml> Toml for Vec<T> {
    fn keys() -> Vec<Row> {
        T::keys()
    }

    fn toml(&self) -> Option<String> {
        let entries: Vec<_> = self.iter().filter_map(T::toml).collect();
        let is_table = !entries.is_empty() && !T::keys().is_empty();
        Some(if is_table {
            format!("[\n    {},\n]", entries.join(",\n    "))
        } else {
            format!("[{}]", entries.join(", "))
        })
    }
}
