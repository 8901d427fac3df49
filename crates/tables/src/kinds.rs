//! Kinds of values: the valid range, and how they are read and shown.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::ops::RangeInclusive;
use std::path::{self, Path, PathBuf};

use http::Uri;
use jiff::{SignedDuration, Timestamp};

use crate::named::Named;
use crate::reader::{Item, Section};
use crate::table::{Row, Table};
use crate::tree::quoted;

/// Reads a value. `None`: the value is not valid, and an error has been added.
type Read<T> = Box<dyn Fn(&Item<'_>) -> Option<T>>;

/// The kind of a key's values.
pub struct Kind<T> {
    /// The valid values, in Markdown.
    pub values: String,
    /// Reads a value; adds an error if it is not valid.
    pub read: Read<T>,
}

impl<T> Kind<T> {
    /// A kind with a description of its valid values (Markdown) and a function that reads one.
    pub fn new(values: impl Into<String>, read: impl Fn(&Item<'_>) -> Option<T> + 'static) -> Self {
        Self { values: values.into(), read: Box::new(read) }
    }
}

/// The kind of an optional key.
impl<T: 'static> From<Kind<T>> for Kind<Option<T>> {
    fn from(kind: Kind<T>) -> Self {
        Self::new(kind.values, move |item| (kind.read)(item).map(Some))
    }
}

/// A finite number that is `valid`; `rule` describes the valid numbers.
pub fn number(rule: &'static str, valid: fn(f64) -> bool) -> Kind<f64> {
    Kind::new(rule, move |item| item.number(rule, valid))
}

/// A whole number in `range`; `rule` describes the range.
pub fn whole<T>(rule: &'static str, range: RangeInclusive<T>) -> Kind<T>
where
    T: TryFrom<i64> + PartialOrd + Copy + 'static,
{
    Kind::new(rule, move |item| item.whole(range.clone(), rule))
}

/// A count up to a million; 0 means no limit.
pub fn limit(rule: &'static str) -> Kind<Option<NonZeroU32>> {
    Kind::new(rule, move |item| item.whole(0..=1_000_000, rule).map(NonZeroU32::new))
}

/// A duration in seconds.
pub fn seconds(rule: &'static str, valid: fn(f64) -> bool) -> Kind<SignedDuration> {
    Kind::new(rule, move |item| item.seconds(rule, valid))
}

/// `true` or `false`.
pub fn flag() -> Kind<bool> {
    fn read(item: &Item<'_>) -> Option<bool> {
        item.flag()
    }
    Kind::new("`true` or `false`", read)
}

/// Text that is `valid`; `rule` describes valid text.
pub fn text(rule: &'static str, valid: fn(&str) -> bool) -> Kind<String> {
    parsed(rule, move |text| if valid(text) { Ok(text.to_owned()) } else { Err(rule) })
}

/// Text that is not blank.
pub fn any_text() -> Kind<String> {
    text("text that is not blank", |_| true)
}

/// Whether `text` has only letters, digits, `_` and `-`.
pub fn is_plain(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
}

/// Text that `read` accepts; the error of `read` says what is wrong with other text.
pub fn parsed<T, E: Display>(values: &str, read: impl Fn(&str) -> Result<T, E> + 'static) -> Kind<T> {
    Kind::new(values, move |item| read(item.text()?).map_err(|error| item.refuse(error)).ok())
}

/// An IPv4 address that is `valid`; `rule` describes valid addresses.
pub fn ipv4(rule: &'static str, valid: fn(Ipv4Addr) -> bool) -> Kind<Ipv4Addr> {
    Kind::new(rule, move |item| {
        let address = item.ipv4()?;
        if !valid(address) {
            item.refuse(rule);
        }
        Some(address)
    })
}

/// A path relative to the working directory.
pub fn directory() -> Kind<PathBuf> {
    Kind::new("a path, relative to the working directory", |item| Some(item.text()?.into()))
}

/// A path relative to the configuration file; the value that is read is absolute.
pub fn beside() -> Kind<PathBuf> {
    Kind::new("a path, relative to the configuration file", |item| {
        let written = Path::new(item.file()).parent().unwrap_or(Path::new("")).join(item.text()?);
        Some(path::absolute(&written).unwrap_or(written))
    })
}

/// The name of a value of an enumeration.
pub fn named<T: Named>() -> Kind<T> {
    let names = T::NAMES.iter().map(|(name, about)| format!("`\"{name}\"`:{}", about.trim_end_matches('.')));
    parsed(&names.collect::<Vec<_>>().join("; "), T::named)
}

/// A list of values.
pub fn list<T: 'static>(kind: Kind<T>) -> Kind<Vec<T>> {
    let values = format!("a list; {}", kind.values);
    Kind::new(values, move |item| Some(item.list()?.iter().filter_map(&*kind.read).collect()))
}

/// An interval of numbers; in a file `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Span {
    /// The interval from `low` to `high`.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }
}

fn rule(limits: &RangeInclusive<f64>) -> String {
    format!("this is between {} and {}", limits.start(), limits.end())
}

/// A finite number within the limits.
impl From<RangeInclusive<f64>> for Kind<f64> {
    fn from(limits: RangeInclusive<f64>) -> Self {
        let rule = rule(&limits);
        Self::new(rule.clone(), move |item| item.number(&rule, |value| limits.contains(&value)))
    }
}

/// A whole number within the limits.
impl From<RangeInclusive<f64>> for Kind<u32> {
    fn from(limits: RangeInclusive<f64>) -> Self {
        let rule = format!("{}, a whole number", rule(&limits));
        let limits = *limits.start() as u32..=*limits.end() as u32;
        Self::new(rule.clone(), move |item| item.whole(limits.clone(), &rule))
    }
}

/// Two numbers within the limits.
impl From<RangeInclusive<f64>> for Kind<Span> {
    fn from(limits: RangeInclusive<f64>) -> Self {
        let end = Kind::<f64>::from(limits);
        Self::new(format!("[low, high]; {}", end.values), move |item| {
            let ends: Option<Vec<f64>> = item.list()?.iter().map(&*end.read).collect();
            match ends?[..] {
                [low, high] if low <= high => Some(Span { low, high }),
                _ => {
                    item.refuse("two numbers are expected, the lower first: [low, high]");
                    None
                }
            }
        })
    }
}

/// A table.
pub fn inline<T: Table>() -> Kind<T> {
    Kind::new("a table of the keys below", |item| item.section().map(T::read))
}

/// A list of tables.
pub fn tables<T: Table>() -> Kind<Vec<T>> {
    let read = |item: &Item<'_>| Some(checked_tables(Some(item.clone()), |_, _| {}));
    Kind::new("a list of tables of the keys below", read)
}

/// Reads every table of a list. `check` sees each table before its unknown keys are refused. An absent list is empty.
pub fn checked_tables<T: Table>(list: Option<Item<'_>>, mut check: impl FnMut(&T, &Section<'_>)) -> Vec<T> {
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

/// The value of a key, as it is shown.
pub trait Toml {
    /// The keys of the value, if it is a table.
    fn keys() -> Vec<Row> {
        Vec::new()
    }

    /// The value as TOML; `None` if there is none.
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
toml!(value => quoted(&value.to_string()); String, Ipv4Addr, SocketAddr, Uri, Timestamp);
toml!(value => quoted(&value.to_string_lossy()); PathBuf);
toml!(value => format!("{:?}", value.as_secs_f64()); SignedDuration);
toml!(value => format!("[{:?}, {:?}]", value.0, value.1); (f64, f64));
toml!(value => format!("[{:?}, {:?}]", value.low, value.high); Span);
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

/// A list is shown on one line; a list of tables has one line per table.
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

/// Displays values as their names.
#[macro_export]
macro_rules! written_by_name {
    ($($name:ident),*) => { $(impl $crate::kinds::Toml for $name {
        fn toml(&self) -> Option<String> {
            Some($crate::tree::quoted(self.name()))
        }
    })* };
}
