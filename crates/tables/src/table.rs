//! Tables of keys. `section!` defines each key once; the definition yields its field, its default, how it is read, checked and
//! shown, whether SIGHUP reloads it, and its row of the reference page.

use crate::kinds::{Kind, Toml};
use crate::reader::Section;

/// A table defined by `section!`. Its `Default` is an empty table; keys without a default are blank.
pub trait Table: ByHand + Default + 'static {
    /// A description of the table.
    const ABOUT: &'static str;

    /// Reads every key; a missing or refused key keeps its default.
    fn read_keys(section: &mut Section<'_>) -> Self;

    /// The keys with their values as TOML.
    fn entries(&self) -> Vec<Entry>;

    /// The rows of the reference page, one per key.
    fn rows() -> Vec<Row>;

    /// Copies from `wanted` the keys that SIGHUP reloads.
    fn reload(&mut self, wanted: &Self);

    /// Reads every key and refuses unknown ones.
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

/// Handling of keys that `section!` cannot express.
pub trait ByHand: Sized {
    /// Reads further keys, and adds errors about keys that contradict each other.
    fn more(&mut self, _: &mut Section<'_>) {}

    /// Adds the further keys to the entries of the table, each in its place.
    fn arrange(&self, _: &mut Vec<Entry>) {}

    /// Adds the rows of the further keys to the reference page.
    fn explain(_: &mut Vec<Row>) {}
}

/// A key and its value as TOML, or the meaning of its absence.
pub struct Entry {
    /// The key.
    pub key: &'static str,
    /// The value, or the meaning of its absence.
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
    /// The meaning of the key.
    pub about: &'static str,
    /// The valid values.
    pub values: String,
    /// The default; `None`: the key is required.
    pub default: Option<String>,
    /// Whether SIGHUP reloads the key.
    pub reloaded: bool,
    /// The keys of the value, if the value is a table.
    pub keys: Vec<Row>,
}

impl Row {
    /// A key that is read by [`ByHand`].
    pub fn by_hand(key: &'static str, default: Option<&str>, values: &str, about: &'static str) -> Self {
        let (values, default) = (values.to_owned(), default.map(str::to_owned));
        Self { key, about, values, default, reloaded: false, keys: Vec::new() }
    }
}

/// The default of a key.
pub struct Fallback<T> {
    value: T,
    /// Text to add to the file; `None`: the key is optional.
    needed: Option<&'static str>,
    /// The default in words, if its value does not explain it.
    words: Option<&'static str>,
}

impl<T> From<T> for Fallback<T> {
    fn from(value: T) -> Self {
        Self { value, needed: None, words: None }
    }
}

/// A required key; `add` says what to write.
pub fn need<T: Default>(add: &'static str) -> Fallback<T> {
    Fallback { value: T::default(), needed: Some(add), words: None }
}

/// No value; `words` say what that means.
pub const fn absent<T>(words: &'static str) -> Fallback<Option<T>> {
    Fallback { value: None, needed: None, words: Some(words) }
}

/// A default that depends on other keys, as `words` say. [`ByHand::more`] sets it; in an empty table it is `value`.
pub const fn depends<T>(words: &'static str, value: T) -> Fallback<T> {
    Fallback { value, needed: None, words: Some(words) }
}

/// The definition of a key.
pub struct Column<T> {
    /// The key.
    pub name: &'static str,
    /// The valid values, and how one is read.
    pub kind: Kind<T>,
    /// The default.
    pub fallback: Fallback<T>,
}

impl<T: Toml> Column<T> {
    /// The default, or a blank value.
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

    /// The key with its value as it is shown.
    pub fn entry(&self, value: &T) -> Entry {
        let value = value.toml().ok_or(self.fallback.words.unwrap_or_default());
        Entry { key: self.name, value }
    }

    /// The row of the reference page; `usual` holds the defaults as they are shown.
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

/// Defines a table: `/// meaning`, `field as "key": type = default, kind, reloaded;`. Without `as` the key has the name of the
/// field. The default is a value, `need`, `absent` or `depends`. Without `reloaded` a change needs a restart. Fields in
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

            /// An empty table; keys without a default are blank.
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
