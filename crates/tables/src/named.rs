//! Enumerations whose values have names, and possibly keys of their own.

use std::fmt::Display;

use crate::tree::quoted;

/// An enumeration whose values have names in the configuration.
pub trait Named: Sized + 'static {
    /// The names, each with its meaning.
    const NAMES: &'static [(&'static str, &'static str)];

    /// The value with that name; its own keys are blank.
    ///
    /// # Errors
    /// No value has this name.
    fn named(name: &str) -> Result<Self, UnknownName>;
}

/// A name that no value has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no such {what}; use {}", alternatives(names))]
pub struct UnknownName {
    /// The enumeration, for the message; `pattern`, for instance.
    pub what: &'static str,
    /// The valid names, each with its meaning.
    pub names: &'static [(&'static str, &'static str)],
}

fn alternatives(names: &[(&str, &str)]) -> impl Display {
    names.iter().map(|(name, _)| quoted(name)).collect::<Vec<_>>().join(" or ")
}

/// Defines an enumeration: `/// meaning`, `Value = "name"`.
#[macro_export]
macro_rules! names {
    (
        $(#[doc = $about:literal])* $(#[derive($($derived:ident),*)])?
        $name:ident, $what:literal { $(
            $(#[doc = $meaning:literal])*
            $value:ident $(($inner:ty))? $({ $(#[doc = $key_meaning:literal])* $key:ident: $type:ty })? = $text:literal,
        )* }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq $(, $($derived),*)?)]
        pub enum $name { $(
            $(#[doc = $meaning])*
            $value $(($inner))? $({ $(#[doc = $key_meaning])* $key: $type })?,
        )* }

        impl $crate::named::Named for $name {
            const NAMES: &'static [(&'static str, &'static str)] = &[$(($text, concat!($($meaning),*))),*];

            fn named(name: &str) -> Result<Self, $crate::named::UnknownName> {
                match name {
                    $($text => Ok(Self::$value { $(0: <$inner>::default())? $($key: <$type>::default())? }),)*
                    _ => Err($crate::named::UnknownName { what: $what, names: Self::NAMES }),
                }
            }
        }

        impl $name {
            /// The name in the configuration.
            pub const fn name(&self) -> &'static str {
                match self { $(Self::$value { .. } => $text,)* }
            }
        }

        /// The value with this name.
        impl std::str::FromStr for $name {
            type Err = $crate::named::UnknownName;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                $crate::named::Named::named(name)
            }
        }
    };
}
