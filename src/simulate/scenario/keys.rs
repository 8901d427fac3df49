//! Sections of a scenario: each key is written once, with its meaning, default and limits, and is read, shown and
//! documented from there.

use std::ops::RangeInclusive;

use crate::config::reader::Item;
use crate::config::tree::quoted;

/// Evenly distributed between two ends, the lower first; in a file `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Span {
    /// From `low` to `high`.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }
}

/// How drones choose their way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Anywhere in the airspace.
    Free,
    /// There and back through its middle.
    Crossing,
}

/// A value that a key may have.
pub(super) trait Key: Sized {
    /// Reads it; finds fault with it where it is none, or beyond the limits.
    fn read(item: &Item<'_>, limits: &RangeInclusive<f64>) -> Option<Self>;
    /// As TOML.
    fn show(&self) -> String;
}

fn rule(limits: &RangeInclusive<f64>) -> String {
    format!("this is between {} and {}", limits.start(), limits.end())
}

impl Key for f64 {
    fn read(item: &Item<'_>, limits: &RangeInclusive<f64>) -> Option<Self> {
        item.number(&rule(limits), |value| limits.contains(&value))
    }

    fn show(&self) -> String {
        format!("{self:?}")
    }
}

impl Key for u32 {
    fn read(item: &Item<'_>, limits: &RangeInclusive<f64>) -> Option<Self> {
        let range = *limits.start() as u32..=*limits.end() as u32;
        item.whole(range, &format!("{}, a whole number", rule(limits)))
    }

    fn show(&self) -> String {
        self.to_string()
    }
}

impl Key for bool {
    fn read(item: &Item<'_>, _: &RangeInclusive<f64>) -> Option<Self> {
        item.flag()
    }

    fn show(&self) -> String {
        self.to_string()
    }
}

impl Key for Span {
    fn read(item: &Item<'_>, limits: &RangeInclusive<f64>) -> Option<Self> {
        let ends = item.list()?;
        let rule = rule(limits);
        let values: Option<Vec<f64>> =
            ends.iter().map(|end| end.number(&rule, |value| limits.contains(&value))).collect();
        match values?[..] {
            [low, high] if low <= high => Some(Self { low, high }),
            _ => {
                item.refuse("two numbers are expected, the lower first: [low, high]");
                None
            }
        }
    }

    fn show(&self) -> String {
        format!("[{:?}, {:?}]", self.low, self.high)
    }
}

impl Key for Pattern {
    fn read(item: &Item<'_>, _: &RangeInclusive<f64>) -> Option<Self> {
        item.word(&[("free", Self::Free), ("crossing", Self::Crossing)])
    }

    fn show(&self) -> String {
        quoted(match self {
            Self::Free => "free",
            Self::Crossing => "crossing",
        })
    }
}

impl Key for String {
    fn read(item: &Item<'_>, _: &RangeInclusive<f64>) -> Option<Self> {
        let text = item.text()?;
        let plain = text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        if !plain {
            item.refuse("use only letters A-Z a-z, digits, _ and -");
        }
        plain.then(|| text.to_owned())
    }

    fn show(&self) -> String {
        quoted(self)
    }
}

/// Limits of a key that has none.
pub(super) const ANY: RangeInclusive<f64> = f64::MIN..=f64::MAX;
/// A share or probability.
pub(super) const SHARE: RangeInclusive<f64> = 0.0..=1.0;
/// A number of things.
pub(super) const COUNT: RangeInclusive<f64> = 0.0..=2000.0;
/// Seconds within a simulation.
pub(super) const SECONDS: RangeInclusive<f64> = 0.0..=1e6;
/// Metres.
pub(super) const METRES: RangeInclusive<f64> = 0.0..=100_000.0;

/// Defines a section: `/// meaning` `key: type = default, limits;`.
macro_rules! section {
    ($(#[doc = $about:literal])* $name:ident { $($(#[doc = $meaning:literal])* $key:ident: $type:ty = $default:expr, $limits:expr;)* }) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name { $($(#[doc = $meaning])* pub $key: $type,)* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }

        impl $name {
            /// Reads the keys that are given; the others keep their defaults.
            pub(super) fn read(mut section: $crate::config::reader::Section<'_>) -> Self {
                let mut read = Self::default();
                $(if let Some(item) = section.item(stringify!($key))
                    && let Some(value) = <$type as $crate::simulate::scenario::keys::Key>::read(&item, &$limits)
                {
                    read.$key = value;
                })*
                section.finish();
                read
            }

            /// The section as TOML under this header, each key with its meaning.
            pub(super) fn show(&self, header: &str) -> String {
                let mut text = format!("\n#{}\n{header}\n", concat!($($about),*));
                $(
                    let value = <$type as $crate::simulate::scenario::keys::Key>::show(&self.$key);
                    let meaning = concat!($($meaning),*).trim();
                    text += &$crate::simulate::scenario::keys::line(stringify!($key), &value, meaning);
                )*
                text
            }
        }
    };
}
pub(super) use section;

/// `key = value` and behind it, in the same column for all, what it means.
pub(super) fn line(key: &str, value: &str, meaning: &str) -> String {
    format!("{:COLUMN$} # {meaning}\n", format!("{key} = {value}"))
}

/// As wide as the longest key with its value.
const COLUMN: usize = 36;
