//! Enumerations whose values have names.

use super::tree::quoted;

/// An enumeration whose values have names in the configuration.
pub(crate) trait Named: Copy + 'static {
    /// What the values are: "there is no such …".
    const WHAT: &'static str;
    /// Each name, its value and its meaning.
    const ALL: &'static [(&'static str, Self, &'static str)];

    /// The name of the value.
    fn text(self) -> &'static str;

    /// The value of that name.
    fn named(name: &str) -> Result<Self, UnknownName> {
        let value = Self::ALL.iter().find(|(known, ..)| *known == name).map(|&(_, value, _)| value);
        value.ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|(name, ..)| quoted(name)).collect();
            UnknownName { what: Self::WHAT, names: names.join(" or ") }
        })
    }
}

/// A name that no value has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no such {what}; use {names}")]
pub struct UnknownName {
    what: &'static str,
    names: String,
}

/// Defines an enumeration: `/// meaning`, `Value = "name"`. The first value is the default.
macro_rules! names {
    (
        $(#[doc = $about:literal])*
        $visible:vis $name:ident, $what:literal { $($(#[doc = $meaning:literal])* $value:ident = $text:literal,)* }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visible enum $name { $($(#[doc = $meaning])* $value,)* }

        impl $crate::config::names::Named for $name {
            const WHAT: &'static str = $what;
            const ALL: &'static [(&'static str, Self, &'static str)] =
                &[$(($text, Self::$value, concat!($($meaning),*))),*];

            fn text(self) -> &'static str {
                self.name()
            }
        }

        impl $name {
            /// The name in the configuration.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$value => $text,)* }
            }
        }

        /// The first.
        impl Default for $name {
            fn default() -> Self {
                <Self as $crate::config::names::Named>::ALL[0].1
            }
        }

        /// By name.
        impl std::str::FromStr for $name {
            type Err = $crate::config::names::UnknownName;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                $crate::config::names::Named::named(name)
            }
        }
    };
}
pub(crate) use names;
