//! Kinds of values: how each is read, checked, shown and explained.

use std::fmt::Display;
use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::ops::RangeInclusive;
use std::path::{self, Path, PathBuf};

use jiff::SignedDuration;

use super::cidr::Network;
use super::names::Named;
use super::reader::{Item, Section};
use super::table::{Row, Table};
use super::tree::quoted;

/// A kind of values `T` of a key.
pub(crate) trait Kind<T> {
    /// The value; finds fault with one that is not valid.
    fn read(&self, item: &Item<'_>) -> Option<T>;

    /// The value as TOML, where there is one.
    fn show(&self, value: &T) -> Option<String>;

    /// Which values are valid.
    fn values(&self) -> String;

    /// The keys of a value that is a table.
    fn keys(&self) -> Vec<Row> {
        Vec::new()
    }
}

/// A key that may be absent.
impl<T, K: Kind<T>> Kind<Option<T>> for K {
    fn read(&self, item: &Item<'_>) -> Option<Option<T>> {
        Kind::<T>::read(self, item).map(Some)
    }

    fn show(&self, value: &Option<T>) -> Option<String> {
        value.as_ref().and_then(|value| Kind::<T>::show(self, value))
    }

    fn values(&self) -> String {
        Kind::<T>::values(self)
    }

    fn keys(&self) -> Vec<Row> {
        Kind::<T>::keys(self)
    }
}

/// A finite number that is valid; the rule says which are.
pub(crate) struct Number(pub(crate) &'static str, pub(crate) fn(f64) -> bool);

impl Kind<f64> for Number {
    fn read(&self, item: &Item<'_>) -> Option<f64> {
        item.number(self.0, self.1)
    }

    fn show(&self, value: &f64) -> Option<String> {
        Some(format!("{value:?}"))
    }

    fn values(&self) -> String {
        self.0.to_owned()
    }
}

/// A type whose values are shown as they are displayed.
pub(crate) trait Plain: Display {}
impl Plain for u8 {}
impl Plain for u16 {}
impl Plain for u32 {}
impl Plain for SocketAddr {}
impl Plain for Network {}

/// A whole number in a range; the rule says which.
pub(crate) struct Whole<T>(pub(crate) &'static str, pub(crate) RangeInclusive<T>);

impl<T: Plain + TryFrom<i64> + PartialOrd + Copy> Kind<T> for Whole<T> {
    fn read(&self, item: &Item<'_>) -> Option<T> {
        item.whole(self.1.clone(), self.0)
    }

    fn show(&self, value: &T) -> Option<String> {
        Some(value.to_string())
    }

    fn values(&self) -> String {
        self.0.to_owned()
    }
}

/// A count whose 0 means no limit.
pub(crate) struct Limit(pub(crate) &'static str);

/// The highest [`Limit`].
const MAX_LIMIT: u32 = 1_000_000;

impl Kind<Option<NonZeroU32>> for Limit {
    fn read(&self, item: &Item<'_>) -> Option<Option<NonZeroU32>> {
        item.whole(0..=MAX_LIMIT, self.0).map(NonZeroU32::new)
    }

    fn show(&self, value: &Option<NonZeroU32>) -> Option<String> {
        Some(value.map_or(0, NonZeroU32::get).to_string())
    }

    fn values(&self) -> String {
        self.0.to_owned()
    }
}

/// A duration in seconds.
pub(crate) struct Seconds(pub(crate) &'static str, pub(crate) fn(f64) -> bool);

impl Kind<SignedDuration> for Seconds {
    fn read(&self, item: &Item<'_>) -> Option<SignedDuration> {
        item.seconds(self.0, self.1)
    }

    fn show(&self, value: &SignedDuration) -> Option<String> {
        Some(format!("{:?}", value.as_secs_f64()))
    }

    fn values(&self) -> String {
        self.0.to_owned()
    }
}

/// True or false.
pub(crate) struct Flag;

impl Kind<bool> for Flag {
    fn read(&self, item: &Item<'_>) -> Option<bool> {
        item.flag()
    }

    fn show(&self, value: &bool) -> Option<String> {
        Some(value.to_string())
    }

    fn values(&self) -> String {
        "`true` or `false`".to_owned()
    }
}

/// Text that is valid; the rule says which is.
pub(crate) struct Text(pub(crate) &'static str, pub(crate) fn(&str) -> bool);

/// Any text that is not blank.
pub(crate) const TEXT: Text = Text("text that is not blank", |_| true);

impl Kind<String> for Text {
    fn read(&self, item: &Item<'_>) -> Option<String> {
        let text = item.text()?;
        if !(self.1)(text) {
            item.refuse(self.0);
        }
        Some(text.to_owned())
    }

    fn show(&self, value: &String) -> Option<String> {
        Some(quoted(value))
    }

    fn values(&self) -> String {
        self.0.to_owned()
    }
}

/// Whether `text` is made of letters, digits, `_` and `-`.
pub(crate) fn is_plain(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
}

/// A path that is relative to the working directory.
pub(crate) struct Directory;

impl Kind<PathBuf> for Directory {
    fn read(&self, item: &Item<'_>) -> Option<PathBuf> {
        Some(item.text()?.into())
    }

    fn show(&self, value: &PathBuf) -> Option<String> {
        Some(quoted(&value.to_string_lossy()))
    }

    fn values(&self) -> String {
        "a path, relative to the working directory".to_owned()
    }
}

/// A path that is relative to the configuration; what is read is absolute.
pub(crate) struct Beside;

impl Kind<PathBuf> for Beside {
    fn read(&self, item: &Item<'_>) -> Option<PathBuf> {
        let written = Path::new(item.file()).parent().unwrap_or(Path::new("")).join(item.text()?);
        Some(path::absolute(&written).unwrap_or(written))
    }

    fn show(&self, value: &PathBuf) -> Option<String> {
        Directory.show(value)
    }

    fn values(&self) -> String {
        "a path, relative to the configuration file".to_owned()
    }
}

/// One of the names of an enumeration.
pub(crate) struct Name;

impl<T: Named> Kind<T> for Name {
    fn read(&self, item: &Item<'_>) -> Option<T> {
        T::named(item.text()?).map_err(|error| item.refuse(error)).ok()
    }

    fn show(&self, value: &T) -> Option<String> {
        Some(quoted(value.text()))
    }

    fn values(&self) -> String {
        let names =
            T::ALL.iter().map(|(name, _, about)| format!("`\"{name}\"`:{}", about.trim_end_matches('.')));
        names.collect::<Vec<_>>().join("; ")
    }
}

/// The address of a host or group.
pub(crate) struct Ipv4(pub(crate) &'static str, pub(crate) fn(Ipv4Addr) -> bool);

impl Kind<Ipv4Addr> for Ipv4 {
    fn read(&self, item: &Item<'_>) -> Option<Ipv4Addr> {
        let address = item.ipv4()?;
        if !(self.1)(address) {
            item.refuse(self.0);
        }
        Some(address)
    }

    fn show(&self, value: &Ipv4Addr) -> Option<String> {
        Some(quoted(&value.to_string()))
    }

    fn values(&self) -> String {
        self.0.to_owned()
    }
}

/// Text that `read` understands; `values` says which, and is also what is wrong with any other.
pub(crate) struct Parsed<T> {
    pub(crate) values: &'static str,
    pub(crate) read: fn(&str) -> Result<T, String>,
}

impl<T: Plain> Kind<T> for Parsed<T> {
    fn read(&self, item: &Item<'_>) -> Option<T> {
        (self.read)(item.text()?).map_err(|error| item.refuse(error)).ok()
    }

    fn show(&self, value: &T) -> Option<String> {
        Some(quoted(&value.to_string()))
    }

    fn values(&self) -> String {
        self.values.to_owned()
    }
}

/// A list on one line.
pub(crate) struct List<K>(pub(crate) K);

impl<T, K: Kind<T>> Kind<Vec<T>> for List<K> {
    fn read(&self, item: &Item<'_>) -> Option<Vec<T>> {
        Some(item.list()?.iter().filter_map(|entry| self.0.read(entry)).collect())
    }

    fn show(&self, value: &Vec<T>) -> Option<String> {
        let entries: Vec<_> = value.iter().filter_map(|entry| self.0.show(entry)).collect();
        Some(format!("[{}]", entries.join(", ")))
    }

    fn values(&self) -> String {
        format!("a list; {}", self.0.values())
    }
}

/// A table on one line.
pub(crate) struct Inline;

impl<T: Table> Kind<T> for Inline {
    fn read(&self, item: &Item<'_>) -> Option<T> {
        item.section().map(T::read)
    }

    fn show(&self, value: &T) -> Option<String> {
        Some(value.inline())
    }

    fn values(&self) -> String {
        "a table of the keys below".to_owned()
    }

    fn keys(&self) -> Vec<Row> {
        T::rows()
    }
}

/// A list of tables, each on a line.
pub(crate) struct Tables;

impl<T: Table> Kind<Vec<T>> for Tables {
    fn read(&self, item: &Item<'_>) -> Option<Vec<T>> {
        Some(tables(Some(item.clone()), |_, _| {}))
    }

    fn show(&self, value: &Vec<T>) -> Option<String> {
        if value.is_empty() {
            return Some("[]".to_owned());
        }
        let lines = value.iter().map(|table| format!("    {},\n", table.inline()));
        Some(format!("[\n{}]", lines.collect::<String>()))
    }

    fn values(&self) -> String {
        "a list of tables of the keys below".to_owned()
    }

    fn keys(&self) -> Vec<Row> {
        T::rows()
    }
}

/// Every table of a list, each looked at by `check` before its unknown keys are refused. An absent list is empty.
pub(crate) fn tables<T: Table>(list: Option<Item<'_>>, mut check: impl FnMut(&T, &Section<'_>)) -> Vec<T> {
    let sections = list.and_then(|list| list.list()).unwrap_or_default().into_iter();
    sections
        .filter_map(|item| {
            let mut section = item.section()?;
            let table = T::read_keys(&mut section);
            check(&table, &section);
            section.finish();
            Some(table)
        })
        .collect()
}
