//! One description of an item makes its type, its accessors and its layout.
//!
//! [`items!`] holds the descriptions of a module:
//!
//! | description | what | the type holds |
//! |---|---|---|
//! | `pub struct Name(octets) { fields }` | a fixed number of octets | the octets |
//! | `pub struct Name(octets) = field` | the same, of one field, which has no documentation of its own | the octets |
//! | `extended pub struct Name { part { fields } … }` | parts of seven bits and FX | a [`Chain`](crate::Chain) |
//! | `words pub struct Name { name: type { fields } … }` | whole-octet words of one or several fields | the words |
//! | `compound pub struct Name { "key" name: Type, … }` | subfields, each of which may be absent | each as an `Option` |
//! | `expansion pub struct Name { … }` | the same, of a reserved expansion field | the same |
//! | `pub enum Name { Code = 0, … }` | the table of a field's codes | – |
//! | `all pub enum Name { Code, … }` | the same where it names all codes, from 0 on | – |
//!
//! A field is described as `kind bits "key" accessor / setter: type = scale, decimals;`, from the highest bit down. What a
//! field has no use for is left out, the accessor and the setter too.
//!
//! | kind | what | the accessor gives, the setter takes |
//! |---|---|---|
//! | `spare` | bits without meaning | – |
//! | `flag` | one bit | `bool` |
//! | `unset` | one bit that is 0 where it holds | `bool` |
//! | `code …: Table` | a code | the enum of a table |
//! | `count …: u16`, `octal`, `hex`, `address` | a number | that type; the setter gives `None` where the bits do not hold it |
//! | `count_from …: u8 = first` | a number whose count 0 stands for `first` | the same |
//! | `count_or …: u16 = unknown` | a number of which one count means "unknown" | the same, the count |
//! | `populated …: u8`, `populated_flag` | a value behind the bit that says whether there is one | `Option` of it |
//! | `unsigned … = lsb, decimals`, `signed` | a physical value | `f64` in the unit of the key; the setter takes the nearest count, `None` out of range |
//! | `signed_per … = counts, decimals` | the same, so many counts to a unit | the same |
//! | `angle … = lsb, decimals` | degrees | the same; the setter brings any finite angle into one turn |
//! | `known … = lsb, decimals` | a physical value whose highest count means "unknown" | – |
//! | `ascii`, `icao` | characters of 8 or 6 bits | – |
//! | `constant … = value` | a number that marks the layout | – |

use std::io::{Read, Seek};

use deku::reader::Reader;
use deku::{DekuError, ctx::Order};

/// Descriptions one after the other, see the [module](self).
macro_rules! items {
    () => {};
    ($(#[$meta:meta])* pub enum $name:ident { $($codes:tt)* } $($rest:tt)*) => {
        $crate::item::codes! { $(#[$meta])* pub enum $name { $($codes)* } }
        $crate::item::items! { $($rest)* }
    };
    ($(#[$meta:meta])* all pub enum $name:ident { $($codes:tt)* } $($rest:tt)*) => {
        $crate::item::codes! { $(#[$meta])* all pub enum $name { $($codes)* } }
        $crate::item::items! { $($rest)* }
    };
    ($(#[$meta:meta])* pub struct $name:ident($octets:literal) { $($fields:tt)* } $($rest:tt)*) => {
        $crate::item::item! { $(#[$meta])* pub struct $name($octets) { $($fields)* } }
        $crate::item::items! { $($rest)* }
    };
    (
        $(#[$doc:meta])* pub struct $name:ident($octets:literal) = $kind:ident $bits:literal $key:literal
            $($get:ident $(/ $set:ident)?)? $(: $type:ty)? $(= $scale:expr $(, $decimals:literal)?)?;
        $($rest:tt)*
    ) => {
        $crate::item::item! {
            $(#[$doc])*
            pub struct $name($octets) {
                $(#[$doc])*
                $kind $bits $key $($get $(/ $set)?)? $(: $type)? $(= $scale $(, $decimals)?)?;
            }
        }
        $crate::item::items! { $($rest)* }
    };
    ($(#[$meta:meta])* $macro:ident pub struct $name:ident { $($parts:tt)* } $($rest:tt)*) => {
        $crate::item::$macro! { $(#[$meta])* pub struct $name { $($parts)* } }
        $crate::item::items! { $($rest)* }
    };
}

/// See the [module](self).
macro_rules! item {
    ($(#[$meta:meta])* pub struct $name:ident($octets:literal) { $($fields:tt)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        pub struct $name([u8; $octets]);

        impl $name {
            /// The fields, from the highest bit down.
            pub const FIELDS: &'static [$crate::Field] = $crate::item::fields!($($fields)*);

            /// The item as it stands.
            pub const fn from_octets(octets: [u8; $octets]) -> Self {
                Self(octets)
            }

            /// The item as it stands.
            pub const fn octets(self) -> [u8; $octets] {
                self.0
            }

            $crate::item::accessors!($name bits $($fields)*);
        }

        const _: () = assert!($crate::layout::octets_of($name::FIELDS) == $octets);

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout = $crate::Layout::Fields(Self::FIELDS);
        }

        impl Default for $name {
            /// All bits 0.
            fn default() -> Self {
                Self([0; $octets])
            }
        }

        impl std::fmt::Debug for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                $crate::layout::debug(f, stringify!($name), Self::FIELDS, &self.0)
            }
        }

        $crate::item::in_place! {
            $name () reader => $crate::item::read_octets(reader).map(Self),
            self writer => writer.write_bytes(&self.0)
        }
    };
}

/// How a type is read, with a context, and written; reading is inlined.
macro_rules! in_place {
    ($name:ident ($($context:ident: $type:ty),*) $reader:ident => $read:expr, $self:ident $writer:ident => $write:expr) => {
        impl deku::DekuReader<'_, ($($type,)*)> for $name {
            #[inline(always)]
            fn from_reader_with_ctx<R: std::io::Read + std::io::Seek>(
                $reader: &mut deku::reader::Reader<R>,
                ($($context,)*): ($($type,)*),
            ) -> Result<Self, deku::DekuError> {
                $read
            }
        }

        impl deku::DekuWriter for $name {
            #[inline]
            fn to_writer<W: std::io::Write + std::io::Seek>(
                &$self,
                $writer: &mut deku::writer::Writer<W>,
                (): (),
            ) -> Result<(), deku::DekuError> {
                $write
            }
        }
    };
}

/// Reads octets all at once, where deku reads each of an array by itself.
#[inline(always)]
pub(crate) fn read_octets<const N: usize, R: Read + Seek>(
    reader: &mut Reader<R>,
) -> Result<[u8; N], DekuError> {
    let mut octets = [0; N];
    reader.read_bytes_const_into::<N>(&mut octets, Order::Msb0)?;
    Ok(octets)
}

/// See the [module](self).
macro_rules! extended {
    ($(#[$meta:meta])* pub struct $name:ident { $($part:ident { $($fields:tt)* })* }) => {
        $crate::item::chain! {
            $(#[$meta])* pub struct $name = $crate::Layout::Extended(&[$($crate::item::fields!($($fields)*)),*]);
        }

        impl $name {
            $($crate::item::accessors!($name variable $($fields)*);)*
        }
    };
}

/// A type that holds a [`Chain`].
macro_rules! chain {
    ($(#[$meta:meta])* pub struct $name:ident = $layout:expr;) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, deku::DekuRead, deku::DekuWrite)]
        pub struct $name($crate::Chain);

        impl $name {
            /// The octets as they stand.
            pub const fn chain(&self) -> &$crate::Chain {
                &self.0
            }
        }

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout = $layout;
        }

        impl From<$crate::Chain> for $name {
            /// Any octets, for what the setters do not cover.
            fn from(chain: $crate::Chain) -> Self {
                Self(chain)
            }
        }

        impl Default for $name {
            /// One octet, all bits 0.
            fn default() -> Self {
                Self($crate::Chain::new(0))
            }
        }
    };
}

/// See the [module](self).
macro_rules! words {
    ($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[$doc:meta])* $word:ident: $type:ty { $($fields:tt)* })*
    }) => {
        $(#[$meta])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, deku::DekuRead, deku::DekuWrite,
        )]
        #[deku(endian = "big")]
        $vis struct $name {
            $($(#[$doc])* $vis $word: $type,)*
        }

        impl $name {
            /// The fields, from the highest bit down.
            pub const FIELDS: &'static [$crate::Field] = $crate::item::fields!($($($fields)*)*);
        }

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout = $crate::Layout::Fields(Self::FIELDS);
        }
    };
}

/// The descriptions of fields, one after the other.
macro_rules! fields {
    ($(
        $(#[$doc:meta])* $kind:ident $bits:literal $key:literal $($get:ident $(/ $set:ident)?)? $(: $type:ty)?
        $(= $scale:expr $(, $decimals:literal)?)?;
    )*) => {
        &[$($crate::layout::field($key, $bits, $crate::item::kind!($kind $bits $(, $scale $(, $decimals)?)?)),)*]
    };
}

/// What the bits of a field are.
macro_rules! kind {
    (spare $bits:literal) => {
        $crate::Kind::Spare
    };
    (octal $bits:literal) => {
        $crate::Kind::Octal
    };
    (hex $bits:literal) => {
        $crate::Kind::Hex
    };
    (address $bits:literal) => {
        $crate::Kind::Address
    };
    (ascii $bits:literal) => {
        $crate::Kind::Ascii
    };
    (icao $bits:literal) => {
        $crate::Kind::Icao
    };
    (constant $bits:literal, $value:expr) => {
        $crate::Kind::Constant($value)
    };
    (count_or $bits:literal, $unknown:expr) => {
        $crate::Kind::CountOr($unknown)
    };
    (count_from $bits:literal, $first:expr) => {
        $crate::Kind::CountFrom($first)
    };
    (signed $bits:literal, $lsb:expr, $decimals:literal) => {
        $crate::layout::quantity(true, $lsb, $decimals)
    };
    (signed_per $bits:literal, $counts:expr, $decimals:literal) => {
        $crate::layout::quantity(true, 1.0 / $counts, $decimals)
    };
    (known $bits:literal, $lsb:expr, $decimals:literal) => {
        $crate::Kind::Quantity($crate::Quantity {
            signed: false,
            lsb: $lsb,
            decimals: $decimals,
            unknown: Some($crate::bits::mask($bits)),
        })
    };
    ($physical:ident $bits:literal, $lsb:expr, $decimals:literal) => {
        $crate::layout::quantity(false, $lsb, $decimals)
    };
    ($whole:ident $bits:literal) => {
        $crate::Kind::Count
    };
}

/// The accessors and setters of fields whose bits the functions of a module take and replace.
macro_rules! accessors {
    ($name:ident $store:ident $(
        $(#[$doc:meta])* $kind:ident $bits:literal $key:literal $($get:ident $(/ $set:ident)?)? $(: $type:ty)?
        $(= $scale:expr $(, $decimals:literal)?)?;
    )*) => {
        $($crate::item::accessor! {
            $kind [$name $store $bits $key] [$(#[$doc])*] [$($get $(/ $set)?)?] [$($type)?] [$($scale)?]
        })*
    };
}

/// The accessor and the setter of a field, if it has them.
macro_rules! accessor {
    ($kind:ident $field:tt $doc:tt [] $type:tt $scale:tt) => {};
    (flag $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] []) => {
        $crate::item::accessor!(@get $field $doc $get: bool, count => count == 1);
        $($crate::item::accessor!(@set $field $get $set(flag: bool) flag as u64);)?
    };
    (unset $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] []) => {
        $crate::item::accessor!(@get $field $doc $get: bool, count => count == 0);
        $($crate::item::accessor!(@set $field $get $set(flag: bool) !flag as u64);)?
    };
    (code $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [$type:ty] []) => {
        $crate::item::accessor!(@get $field $doc $get: $type, count => <$type>::from_code(count as u8));
        $($crate::item::accessor!(@set $field $get $set(code: $type) code.code() as u64);)?
    };
    (count_from $field:tt $doc:tt [$get:ident] [$type:ty] [$first:expr]) => {
        $crate::item::accessor!(@get $field $doc $get: $type, count => count as $type + $first);
    };
    (populated [$name:ident $store:ident $bits:literal $key:literal] [$($doc:tt)*] [$get:ident] [$type:ty] []) => {
        $($doc)*
        pub const fn $get(self) -> Option<$type> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            if $crate::$store::get(&self.0, AT - 1, 1) == 1 {
                Some($crate::$store::get(&self.0, AT, $bits) as $type)
            } else {
                None
            }
        }
    };
    (populated_flag [$name:ident $store:ident $bits:literal $key:literal] [$($doc:tt)*] [$get:ident] [] []) => {
        $($doc)*
        pub const fn $get(self) -> Option<bool> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            if $crate::$store::get(&self.0, AT - 1, 1) == 1 {
                Some($crate::$store::get(&self.0, AT, 1) == 1)
            } else {
                None
            }
        }
    };
    (unsigned $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$lsb:expr]) => {
        $crate::item::accessor!(@get $field $doc $get: f64, count => count as f64 * ($lsb));
        $($crate::item::accessor!(@nearest $field $get $set(value) value / ($lsb), 0, false);)?
    };
    (angle $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$lsb:expr]) => {
        $crate::item::accessor!(@get $field $doc $get: f64, count => count as f64 * ($lsb));
        // The count of a whole turn, which one bit more holds, is that of none.
        $($crate::item::accessor!(@nearest $field $get $set(value) value.rem_euclid(360.0) / ($lsb), 1, false);)?
    };
    (signed $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$lsb:expr]) => {
        $crate::item::accessor!(@signed $field $doc $get, count => count as f64 * ($lsb));
        $($crate::item::accessor!(@nearest $field $get $set(value) value / ($lsb), 0, true);)?
    };
    (signed_per $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$counts:expr]) => {
        $crate::item::accessor!(@signed $field $doc $get, count => count as f64 / $counts);
        $($crate::item::accessor!(@nearest $field $get $set(value) value * $counts, 0, true);)?
    };
    // The other kinds are whole numbers.
    ($whole:ident $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [$type:ty] $scale:tt) => {
        $crate::item::accessor!(@get $field $doc $get: $type, count => count as $type);
        $($crate::item::accessor!(@whole $field $get $set: $type);)?
    };
    (@get [$name:ident $store:ident $bits:literal $key:literal] [$($doc:tt)*]
        $get:ident: $type:ty, $count:ident => $value:expr) => {
        $($doc)*
        #[inline]
        pub const fn $get(self) -> $type {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            let $count = $crate::$store::get(&self.0, AT, $bits);
            $value
        }
    };
    (@signed [$name:ident $store:ident $bits:literal $key:literal] $doc:tt
        $get:ident, $count:ident => $value:expr) => {
        $crate::item::accessor!(@get [$name $store $bits $key] $doc $get: f64, $count => {
            let $count = $crate::bits::signed($count, $bits);
            $value
        });
    };
    (@set [$name:ident $store:ident $bits:literal $key:literal]
        $get:ident $set:ident($value:ident: $type:ty) $count:expr) => {
        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "); of a code as much as ", stringify!($bits), " bits hold.")]
        #[must_use]
        pub const fn $set(self, $value: $type) -> Self {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            Self($crate::$store::set(self.0, AT, $bits, $count))
        }
    };
    (@whole [$name:ident $store:ident $bits:literal $key:literal] $get:ident $set:ident: $type:ty) => {
        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "); `None` where ", stringify!($bits), " bits do not hold it.")]
        pub const fn $set(self, number: $type) -> Option<Self> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            if number as u64 <= $crate::bits::mask($bits) {
                Some(Self($crate::$store::set(self.0, AT, $bits, number as u64)))
            } else {
                None
            }
        }
    };
    (@nearest [$name:ident $store:ident $bits:literal $key:literal]
        $get:ident $set:ident($value:ident) $count:expr, $more:literal, $signed:literal) => {
        #[doc = concat!("The same with the count nearest to this [`", stringify!($get), "`](Self::", stringify!($get), "); `None` out of range.")]
        pub fn $set(self, $value: f64) -> Option<Self> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            let count = $crate::bits::nearest_count($count, $bits + $more, $signed)?;
            Some(Self($crate::$store::set(self.0, AT, $bits, count)))
        }
    };
}

/// The codes of a field. One that the edition does not define is kept; with `all`, it defines all that the bits hold.
macro_rules! codes {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$doc:meta])* $code:ident = $value:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum $name {
            $(#[doc = concat!(stringify!($value), ":")] $(#[$doc])* $code,)*
            /// A code that the edition does not define.
            Other(u8),
        }

        impl $name {
            /// What this code stands for.
            pub const fn from_code(code: u8) -> Self {
                match code {
                    $($value => Self::$code,)*
                    other => Self::Other(other),
                }
            }

            /// The code.
            pub const fn code(self) -> u8 {
                match self {
                    $(Self::$code => $value,)*
                    Self::Other(other) => other,
                }
            }
        }
    };
    ($(#[$meta:meta])* all pub enum $name:ident { $($(#[$doc:meta])* $code:ident,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name {
            $($(#[$doc])* $code,)*
        }

        impl $name {
            const ALL: &'static [Self] = &[$(Self::$code,)*];

            /// What the low bits of this code stand for.
            pub const fn from_code(code: u8) -> Self {
                const { assert!(Self::ALL.len().is_power_of_two()) }
                Self::ALL[code as usize % Self::ALL.len()]
            }

            /// The code.
            pub const fn code(self) -> u8 {
                self as u8
            }
        }
    };
}

/// An item of subfields, in the order of the bits that announce them; `_` where the specification defines none.
macro_rules! compound {
    ($(#[$meta:meta])* pub struct $name:ident { $($subfields:tt)* }) => {
        $crate::item::compound!(
            @sort [$(#[$meta])* $name Primary $crate::Layout::Compound] (0) [] [] $($subfields)*
        );
    };
    (@sort $head:tt ($at:expr) [$($fields:tt)*] [$($slots:tt)*] _, $($rest:tt)*) => {
        $crate::item::compound!(
            @sort $head ($at + 1) [$($fields)*] [$($slots)* $crate::Subfield::UNDEFINED,] $($rest)*
        );
    };
    (@sort $head:tt ($at:expr) [$($fields:tt)*] [$($slots:tt)*]
        $(#[$doc:meta])* $key:literal $field:ident: $type:ty, $($rest:tt)*) => {
        $crate::item::compound!(
            @sort $head ($at + 1)
            [$($fields)* { $(#[$doc])* $field: $type, $at }]
            [$($slots)* $crate::Subfield { key: $key, layout: <$type as $crate::Describe>::LAYOUT },]
            $($rest)*
        );
    };
    (@sort [$(#[$meta:meta])* $name:ident $announced:ident $layout:path] ($count:expr)
        [$({ $(#[$doc:meta])* $field:ident: $type:ty, $at:expr })*] [$($slots:tt)*]) => {
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
        pub struct $name {
            $($(#[$doc])* pub $field: Option<$type>,)*
        }

        impl $name {
            /// The subfields, in the order of the bits that announce them.
            pub const SUBFIELDS: &'static [$crate::Subfield] = &[$($slots)*];
        }

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout = $layout(Self::SUBFIELDS);
        }

        $crate::item::in_place! {
            $name () reader => {
                let primary = $crate::subfields::$announced::read(reader, Self::SUBFIELDS)?;
                $(let $field = if primary.has($at) {
                    Some(<$type as deku::DekuReader<'_>>::from_reader_with_ctx(reader, ())?)
                } else {
                    None
                };)*
                Ok(Self { $($field,)* })
            },
            self writer => {
                $crate::subfields::$announced::default()
                    $(.with($at, self.$field.is_some()))*
                    .write(writer)?;
                $(if let Some(subfield) = &self.$field {
                    deku::DekuWriter::to_writer(subfield, writer, ())?;
                })*
                Ok(())
            }
        }
    };
}

/// As [`compound!`], of the contents of a reserved expansion field.
macro_rules! expansion {
    ($(#[$meta:meta])* pub struct $name:ident { $($subfields:tt)* }) => {
        $crate::item::compound!(
            @sort [$(#[$meta])* $name Eight $crate::layout::expansion] (0) [] [] $($subfields)*
        );
    };
}

pub(crate) use {
    accessor, accessors, chain, codes, compound, expansion, extended, fields, in_place, item, items, kind,
    words,
};
