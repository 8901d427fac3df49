//! One description of an item generates its type, its accessors and its layout.
//!
//! [`items!`] contains the descriptions of a module:
//!
//! | description | item | the type stores |
//! |---|---|---|
//! | `pub struct Name(octets) { fields }` | a fixed number of octets | the octets |
//! | `pub struct Name(octets) = field` | a fixed number of octets with one field, which has no documentation of its own | the octets |
//! | `extended pub struct Name { part { fields } … }` | parts of seven bits and FX | a [`Chain`](crate::Chain) |
//! | `parts pub struct Name { part { fields } … }` | parts of whole octets; a part that leaves a bit free has FX | [`Parts`](crate::Parts) |
//! | `words pub struct Name { name: type { fields } … }` | whole-octet words of one or several fields | the words |
//! | `compound pub struct Name { "key" name: Type, … }` | subfields, each of which may be absent | each as an `Option` |
//! | `padded pub struct Name { … }` | subfields, with a primary subfield that may be longer than needed | each as an `Option`, and the number of superfluous octets |
//! | `expansion pub struct Name { … }` | subfields of a reserved expansion field | each as an `Option` |
//! | `pub enum Name { Code = 0, … }` | the table of a field's codes | – |
//! | `all pub enum Name { Code, … }` | the table of a field's codes, complete from 0 on | – |
//!
//! A field is described as `kind bits "key" accessor / setter: type = scale, decimals;`, from the highest bit down. Unused parts
//! of the description, including accessor and setter, are left out.
//!
//! | kind | bits | type of accessor and setter |
//! |---|---|---|
//! | `spare` | bits without meaning | – |
//! | `flag` | one bit | `bool` |
//! | `unset` | one bit, inverted: 0 is true | `bool` |
//! | `code …: Table` | a code | the enum of a table |
//! | `count …: u16`, `octal`, `hex`, `address` | a number | that type; the setter returns `None` if the bits cannot hold it |
//! | `count_from …: u8 = first` | a number whose count 0 represents `first` | that type |
//! | `count_or …: u16 = unknown` | a number of which one count means "unknown" | that type, the count |
//! | `populated …: u8`, `populated_flag` | a value after a bit that states whether it is populated | `Option` of the value; a setter of a number returns `None` if the bits cannot hold it |
//! | `unsigned … = lsb, decimals`, `signed` | a physical value | `f64` in the unit of the key; the setter uses the nearest count and returns `None` out of range |
//! | `signed_per … = counts, decimals` | a physical value, with the number of counts per unit | as for `signed` |
//! | `angle … = lsb, decimals` | degrees | as for `unsigned`; the setter reduces any finite angle to one turn |
//! | `known … = lsb, decimals` | a physical value whose highest count means "unknown" | – |
//! | `ascii`, `icao` | characters of 8 or 6 bits | – |
//! | `constant … = value` | a number that marks the layout | – |

/// A list of descriptions, see the [module](self).
macro_rules! items {
    () => {};
    ($(#[$meta:meta])* pub enum $name:ident { $($codes:tt)* } $($rest:tt)*) => {
        $crate::fields::codes! { $(#[$meta])* pub enum $name { $($codes)* } }
        $crate::item::items! { $($rest)* }
    };
    ($(#[$meta:meta])* all pub enum $name:ident { $($codes:tt)* } $($rest:tt)*) => {
        $crate::fields::codes! { $(#[$meta])* all pub enum $name { $($codes)* } }
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
            pub const FIELDS: &'static [$crate::Field] = $crate::fields::fields!($($fields)*);

            /// The item with these octets.
            pub const fn from_octets(octets: [u8; $octets]) -> Self {
                Self(octets)
            }

            /// The octets of the item.
            pub const fn octets(self) -> [u8; $octets] {
                self.0
            }

            $crate::fields::accessors!($name bits $($fields)*);
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

        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                $crate::layout::debug(f, stringify!($name), Self::FIELDS, &self.0)
            }
        }

        $crate::item::in_place! {
            $name () reader => $crate::octets::read_octets(reader).map(Self),
            self writer => writer.write_bytes(&self.0)
        }
    };
}

/// Implements reading of a type, with a context, and writing. Reading is inlined.
macro_rules! in_place {
    ($name:ident ($($context:ident: $type:ty),*) $reader:ident => $read:expr, $self:ident $writer:ident => $write:expr) => {
        impl deku::DekuReader<'_, ($($type,)*)> for $name {
            #[inline(always)]
            fn from_reader_with_ctx<R: deku::no_std_io::Read + deku::no_std_io::Seek>(
                $reader: &mut deku::reader::Reader<R>,
                ($($context,)*): ($($type,)*),
            ) -> Result<Self, deku::DekuError> {
                $read
            }
        }

        impl deku::DekuWriter for $name {
            #[inline]
            fn to_writer<W: deku::no_std_io::Write + deku::no_std_io::Seek>(
                &$self,
                $writer: &mut deku::writer::Writer<W>,
                (): (),
            ) -> Result<(), deku::DekuError> {
                $write
            }
        }
    };
}

/// See the [module](self).
macro_rules! extended {
    ($(#[$meta:meta])* pub struct $name:ident { $($part:ident { $($fields:tt)* })* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct $name($crate::Chain);

        $crate::item::in_place! {
            $name () reader => deku::DekuReader::from_reader_with_ctx(reader, ()).map(Self),
            self writer => deku::DekuWriter::to_writer(&self.0, writer, ())
        }

        impl $name {
            /// The octets of the item.
            pub const fn chain(&self) -> &$crate::Chain {
                &self.0
            }
        }

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout =
                $crate::Layout::Extended(&[$($crate::fields::fields!($($fields)*)),*]);
        }

        impl From<$crate::Chain> for $name {
            /// The item with these octets, for values without setters.
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

        impl $name {
            $($crate::fields::accessors!($name variable $($fields)*);)*
        }
    };
}

/// A word of [`words!`]: a number or octets.
pub(crate) trait Word<const N: usize> {
    fn from_octets(octets: [u8; N]) -> Self;
}

impl<const N: usize> Word<N> for [u8; N] {
    #[inline(always)]
    fn from_octets(octets: [u8; N]) -> Self {
        octets
    }
}

macro_rules! numbers {
    ($($type:ty: $octets:literal),*) => {
        $(impl Word<$octets> for $type {
            #[inline(always)]
            fn from_octets(octets: [u8; $octets]) -> Self {
                Self::from_be_bytes(octets)
            }
        })*
    };
}

numbers!(u8: 1, u16: 2, u32: 4);

/// See the [module](self).
macro_rules! words {
    ($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[$doc:meta])* $word:ident: $type:ty { $($fields:tt)* })*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        $vis struct $name {
            $($(#[$doc])* $vis $word: $type,)*
        }

        $crate::item::in_place! {
            $name () reader => Ok(Self {
                $($word: $crate::octets::read_octets(reader).map($crate::item::Word::from_octets)?,)*
            }),
            self writer => {
                $(deku::DekuWriter::to_writer(&self.$word, writer, deku::ctx::Endian::Big)?;)*
                Ok(())
            }
        }

        impl $name {
            /// The fields, from the highest bit down.
            pub const FIELDS: &'static [$crate::Field] = $crate::fields::fields!($($($fields)*)*);
        }

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout = $crate::Layout::Fields(Self::FIELDS);
        }
    };
}

/// See the [module](self).
macro_rules! parts {
    ($(#[$meta:meta])* pub struct $name:ident { $($part:ident { $($fields:tt)* })* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, deku::DekuRead, deku::DekuWrite)]
        pub struct $name(
            $crate::Parts<
                { $crate::parts::octets_of_all($name::PARTS) },
                { $crate::parts::extensions($name::PARTS) },
            >,
        );

        impl $name {
            /// The fields of each part, from the highest bit down.
            pub const PARTS: &'static [&'static [$crate::Field]] = &[$($crate::fields::fields!($($fields)*)),*];

            /// The octets of the item.
            pub fn octets(&self) -> &[u8] {
                self.0.octets()
            }

            $($crate::fields::accessors!($name parts $($fields)*);)*
        }

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout = $crate::Layout::Parts(Self::PARTS);
        }

        impl Default for $name {
            /// The first part, all bits 0.
            fn default() -> Self {
                Self($crate::Parts::new())
            }
        }
    };
}

/// An item with subfields, in the order of the bits that announce them; `_` stands for an undefined subfield.
macro_rules! compound {
    ($(#[$meta:meta])* pub struct $name:ident { $($subfields:tt)* }) => {
        $crate::item::compound!(
            @sort [$(#[$meta])* $name Primary [] $crate::Layout::Compound] (0) [] [] $($subfields)*
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
            [$($slots)* $crate::Subfield::new($key, <$type as $crate::Describe>::LAYOUT),]
            $($rest)*
        );
    };
    (@sort [$(#[$meta:meta])* $name:ident $announced:ident [$($padding:ident)?] $layout:path] ($count:expr)
        [$({ $(#[$doc:meta])* $field:ident: $type:ty, $at:expr })*] [$($slots:tt)*]) => {
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
        pub struct $name {
            $($(#[$doc])* pub $field: Option<$type>,)*
            $(
                /// Number of superfluous octets of the primary subfield, which announce nothing; 0 in a new item.
                pub $padding: u8,
            )?
        }

        impl $name {
            /// The subfields, in the order of the bits that announce them.
            pub const SUBFIELDS: &'static [$crate::Subfield] = &[$($slots)*];
            const DEFINED: $crate::subfields::Defined = $crate::subfields::Defined::of(Self::SUBFIELDS);
        }

        impl $crate::Describe for $name {
            const LAYOUT: $crate::Layout = $layout(Self::SUBFIELDS);
        }

        $crate::item::in_place! {
            $name () reader => {
                let primary = $crate::subfields::$announced::read(reader, Self::DEFINED)?;
                $(let $field = if primary.has($at) {
                    Some(<$type as deku::DekuReader<'_>>::from_reader_with_ctx(reader, ())?)
                } else {
                    None
                };)*
                Ok(Self { $($field,)* $($padding: primary.padding(),)? })
            },
            self writer => {
                let present = $crate::fspec::Frns::NONE$(.with($at + 1, self.$field.is_some()))*;
                let padding = 0 $(+ self.$padding)?;
                $crate::subfields::$announced::announcing(present, padding).write(writer)?;
                $(if let Some(subfield) = &self.$field {
                    deku::DekuWriter::to_writer(subfield, writer, ())?;
                })*
                Ok(())
            }
        }
    };
}

/// Like [`compound!`], for a primary subfield of two or more octets, which may be longer than necessary.
macro_rules! padded {
    ($(#[$meta:meta])* pub struct $name:ident { $($subfields:tt)* }) => {
        $crate::item::compound!(
            @sort [$(#[$meta])* $name Primary [primary_padding] $crate::Layout::Compound] (0) [] [] $($subfields)*
        );
    };
}

/// Like [`compound!`], for the contents of a reserved expansion field.
macro_rules! expansion {
    ($(#[$meta:meta])* pub struct $name:ident { $($subfields:tt)* }) => {
        $crate::item::compound!(
            @sort [$(#[$meta])* $name Eight [] $crate::layout::expansion] (0) [] [] $($subfields)*
        );
    };
}

pub(crate) use {compound, expansion, extended, in_place, item, items, padded, parts, words};
