//! The table of keys: `section!` states each key once, and from it follow the field of its type, its default, how it is
//! read, checked and shown, whether SIGHUP reloads it, and its row of the reference page.

use crate::kinds::{Kind, Toml};
use crate::reader::Section;

/// A table whose keys are known, as `section!` defines it. Its `Default` is that of an empty table, blank where a key has
/// no default.
pub trait Table: ByHand + Default + 'static {
    /// What the table is.
    const ABOUT: &'static str;

    /// Reads every key; what is missing or refused keeps its default.
    fn read_keys(section: &mut Section<'_>) -> Self;

    /// The keys with their values as TOML.
    fn entries(&self) -> Vec<Entry>;

    /// What the reference page says of each key.
    fn rows() -> Vec<Row>;

    /// Takes the keys that SIGHUP reloads from `wanted`.
    fn reload(&mut self, wanted: &Self);

    /// Reads every key and refuses the rest.
    fn read(mut section: Section<'_>) -> Self {
        let read = Self::read_keys(&mut section);
        section.finish();
        read
    }

    /// The table on one line.
    fn inline(&self) -> String {
        let entries = self.entries().into_iter();
        let entries = entries.filter_map(|entry| Some(format!("{} = {}", entry.key, entry.value.ok()?)));
        format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
    }
}

/// What of a table cannot be said key by key.
pub trait ByHand: Sized {
    /// Reads further keys, and finds fault with keys that contradict each other.
    fn more(&mut self, _: &mut Section<'_>) {}

    /// Adds the further keys to those of the table, each in its place.
    fn arrange(&self, _: &mut Vec<Entry>) {}

    /// Adds what the reference page says of the further keys.
    fn explain(_: &mut Vec<Row>) {}
}

/// A key and its value as TOML, or what its absence means.
pub struct Entry {
    /// The key.
    pub key: &'static str,
    /// The value, or what it means that there is none.
    pub value: Result<String, &'static str>,
}

impl Entry {
    /// A key that has a value.
    pub fn new(key: &'static str, value: impl Into<String>) -> Self {
        Self { key, value: Ok(value.into()) }
    }
}

/// A row of the reference page.
pub struct Row {
    /// The key.
    pub key: &'static str,
    /// What it does.
    pub about: &'static str,
    /// Which values are valid.
    pub values: String,
    /// What is taken where it is left out; `None`: it has to be given.
    pub default: Option<String>,
    /// SIGHUP reloads it.
    pub reloaded: bool,
    /// The keys of a value that is a table.
    pub keys: Vec<Row>,
}

impl Row {
    /// A key that is read by hand.
    pub fn by_hand(key: &'static str, default: Option<&str>, values: &str, about: &'static str) -> Self {
        let (values, default) = (values.to_owned(), default.map(str::to_owned));
        Self { key, about, values, default, reloaded: false, keys: Vec::new() }
    }
}

/// What is taken for a key that is left out.
pub struct Fallback<T> {
    value: T,
    /// It has to be given: what to add.
    needed: Option<&'static str>,
    /// The default in words, where the value does not say it.
    words: Option<&'static str>,
}

impl<T> From<T> for Fallback<T> {
    fn from(value: T) -> Self {
        Self { value, needed: None, words: None }
    }
}

/// The key has to be given; `add` tells what to write.
pub fn need<T: Default>(add: &'static str) -> Fallback<T> {
    Fallback { value: T::default(), needed: Some(add), words: None }
}

/// No value, which means `words`.
pub const fn absent<T>(words: &'static str) -> Fallback<Option<T>> {
    Fallback { value: None, needed: None, words: Some(words) }
}

/// A default that depends on other keys, as `words` say: [`ByHand::more`] sets it, and it is `value` in an empty table.
pub const fn depends<T>(words: &'static str, value: T) -> Fallback<T> {
    Fallback { value, needed: None, words: Some(words) }
}

/// A key of a table, as its row states it.
pub struct Column<T> {
    /// The key.
    pub name: &'static str,
    /// Which values are valid, and how one is read.
    pub kind: Kind<T>,
    /// What is taken where it is left out.
    pub fallback: Fallback<T>,
}

impl<T: Toml> Column<T> {
    /// The default, or a blank.
    pub fn blank(self) -> T {
        self.fallback.value
    }

    /// Reads the key into `value`.
    pub fn read(&self, section: &mut Section<'_>, value: &mut T) {
        let item = match self.fallback.needed {
            Some(add) => section.need(self.name, add),
            None => section.item(self.name),
        };
        if let Some(read) = item.and_then(|item| (self.kind.read)(&item)) {
            *value = read;
        }
    }

    /// The key as it is shown.
    pub fn entry(&self, value: &T) -> Entry {
        let value = value.toml().ok_or(self.fallback.words.unwrap_or_default());
        Entry { key: self.name, value }
    }

    /// The key on the reference page, where `usual` is its default as it is shown.
    pub fn row(self, about: &'static str, usual: &[Entry], reloaded: bool) -> Row {
        let usual =
            usual.iter().find(|entry| entry.key == self.name).and_then(|entry| entry.value.as_ref().ok());
        let default = match (self.fallback.needed, self.fallback.words) {
            (Some(_), _) => None,
            (None, Some(words)) => Some(words.to_owned()),
            (None, None) => usual.map(|value| format!("`{value}`")),
        };
        Row { key: self.name, about, values: self.kind.values, default, reloaded, keys: T::keys() }
    }
}

/// Defines a table: `/// meaning`, `field as "key": type = default, kind, reloaded;`. The key is the field's name unless it
/// is given, the default is a value, `need`, `absent` or `depends`, and without `reloaded` a change needs a restart. Fields
/// `by hand` are read by the table's [`ByHand`].
#[macro_export]
macro_rules! section {
    (
        $(#[doc = $about:literal])* $(#[derive($($derived:ident),*)])?
        $name:ident { $($(#[doc = $meaning:literal])* $field:ident $(as $key:literal)?: $type:ty = $default:expr, $kind:expr $(, $reloaded:ident)?;)* }
        $(by hand { $($(#[doc = $hand_meaning:literal])* $hand:ident: $hand_type:ty = $blank:expr;)* })?
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq $(, $($derived),*)?)]
        pub struct $name {
            $($(#[doc = $meaning])* pub $field: $type,)*
            $($($(#[doc = $hand_meaning])* pub $hand: $hand_type,)*)?
        }

        const _: () = {
            use $crate::kinds::{Kind, Toml};
            use $crate::table::{ByHand, Column, Entry, Fallback, Row, Table};

            $(fn $field() -> Column<$type> {
                let (kind, fallback) = (Kind::from($kind), Fallback::from($default));
                Column { name: $crate::section!(@key $field $($key)?), kind, fallback }
            })*

            /// Of an empty table; blank where a key has no default.
            impl Default for $name {
                fn default() -> Self {
                    Self { $($field: $field().blank(),)* $($($hand: $blank,)*)? }
                }
            }

            impl Table for $name {
                const ABOUT: &'static str = concat!($($about),*);

                fn read_keys(section: &mut $crate::reader::Section<'_>) -> Self {
                    let mut read = Self::default();
                    $($field().read(section, &mut read.$field);)*
                    read.more(section);
                    read
                }

                fn entries(&self) -> Vec<Entry> {
                    let mut entries = vec![$($field().entry(&self.$field)),*];
                    self.arrange(&mut entries);
                    entries
                }

                fn rows() -> Vec<Row> {
                    let usual = Self::default().entries();
                    let mut rows =
                        vec![$($field().row(concat!($($meaning),*), &usual, $crate::section!(@flag $($reloaded)?))),*];
                    Self::explain(&mut rows);
                    rows
                }

                fn reload(&mut self, _wanted: &Self) {
                    $($($crate::section!(@take $reloaded self.$field, _wanted.$field);)?)*
                }
            }

            impl Toml for $name {
                fn keys() -> Vec<Row> {
                    Self::rows()
                }

                fn toml(&self) -> Option<String> {
                    Some(self.inline())
                }
            }

            $crate::section!(@hooks $name $(by hand { $($hand)* })?);
        };
    };
    (@key $field:ident) => { stringify!($field) };
    (@key $field:ident $key:literal) => { $key };
    (@flag) => { false };
    (@flag reloaded) => { true };
    (@take reloaded $own:expr, $wanted:expr) => { $own.clone_from(&$wanted) };
    (@hooks $name:ident) => { impl ByHand for $name {} };
    (@hooks $name:ident by hand { $($hand:ident)* }) => {};
}
