//! One description of an item makes its type and its layout.
//!
//! * [`item!`]: octets of fixed length, with an accessor and a setter for each field.
//! * [`codes!`]: the table of a field's codes.
//! * [`compound!`]: an item of subfields, each of which may be absent.
//!
//! A field is described as `kind bits "key" accessor / setter …;`, from the highest bit down:
//!
//! | kind | what | the accessor gives, the setter takes |
//! |---|---|---|
//! | `spare 3 "spare"` | bits without meaning | – |
//! | `flag "v"` | one bit | `bool` |
//! | `code 3 "com" …: Table` | a code | the enum of a table |
//! | `count 12 "trn" …: u16`, `octal`, `hex` | a number | that type; the setter gives `None` where the bits do not hold it |
//! | `unsigned 16 "rho_m" … = lsb, decimals`, `signed` | a physical value | `f64` in the unit of the key; the setter takes the nearest count, `None` out of range |

use std::io::{Read, Seek, Write};

use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuReader, DekuWriter};
use smallvec::SmallVec;

use crate::variable::{REFUSED, read_octet};
use crate::{Layout, Subfield};

/// What has a place in the description of a category.
pub trait Describe {
    /// Its structure and what its bits mean.
    const LAYOUT: Layout;
}

/// The count nearest to `value / lsb`, halves away from zero, as `width` bits; `None` where they do not hold it.
pub(crate) fn nearest_count(value: f64, lsb: f64, width: usize, signed: bool) -> Option<u64> {
    let count = (value / lsb).round();
    let range = (1_u64 << width) as f64; // the fields with a unit have at most 32 bits
    let (low, high) = if signed { (-range / 2.0, range / 2.0) } else { (0.0, range) };
    (count >= low && count < high).then_some(count as i64 as u64)
}

/// See the [module](self).
macro_rules! item {
    ($(#[$meta:meta])* pub struct $name:ident($octets:literal) { $($fields:tt)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        pub struct $name([u8; $octets]);

        $crate::item::octets!($name, $octets);

        impl $name {
            /// The fields, from the highest bit down.
            pub const FIELDS: &'static [$crate::Field] = $crate::item::fields!([] $($fields)*);

            /// The item as it stands.
            pub const fn from_octets(octets: [u8; $octets]) -> Self {
                Self(octets)
            }

            /// The item as it stands.
            pub const fn octets(self) -> [u8; $octets] {
                self.0
            }

            $crate::item::methods!((0) $($fields)*);
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
    };
}

/// Reads and writes a type that holds the item's octets: all at once, where an array derives a read for each.
macro_rules! octets {
    ($name:ident, $octets:literal) => {
        impl deku::DekuReader<'_> for $name {
            #[inline(always)]
            fn from_reader_with_ctx<R: std::io::Read + std::io::Seek>(
                reader: &mut deku::reader::Reader<R>,
                (): (),
            ) -> Result<Self, deku::DekuError> {
                let mut octets = [0; $octets];
                reader.read_bytes_const_into::<$octets>(&mut octets, deku::ctx::Order::Msb0)?;
                Ok(Self(octets))
            }
        }

        impl deku::DekuWriter for $name {
            #[inline]
            fn to_writer<W: std::io::Write + std::io::Seek>(
                &self,
                writer: &mut deku::writer::Writer<W>,
                (): (),
            ) -> Result<(), deku::DekuError> {
                writer.write_bytes(&self.0)
            }
        }
    };
}

/// The descriptions of the fields, one after the other.
macro_rules! fields {
    ([$($done:tt)*]) => { &[$($done)*] };
    ([$($done:tt)*] spare $bits:literal $key:literal; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::field($key, $bits, $crate::Kind::Spare),] $($rest)*)
    };
    ([$($done:tt)*] $(#[$doc:meta])* flag $key:literal $get:ident / $set:ident; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::field($key, 1, $crate::Kind::Count),] $($rest)*)
    };
    ([$($done:tt)*] $(#[$doc:meta])* code $bits:literal $key:literal $get:ident / $set:ident: $type:ty; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::field($key, $bits, $crate::Kind::Count),] $($rest)*)
    };
    ([$($done:tt)*] $(#[$doc:meta])* count $bits:literal $key:literal $get:ident / $set:ident: $type:ty; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::field($key, $bits, $crate::Kind::Count),] $($rest)*)
    };
    ([$($done:tt)*] $(#[$doc:meta])* octal $bits:literal $key:literal $get:ident / $set:ident: $type:ty; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::field($key, $bits, $crate::Kind::Octal),] $($rest)*)
    };
    ([$($done:tt)*] $(#[$doc:meta])* hex $bits:literal $key:literal $get:ident / $set:ident: $type:ty; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::field($key, $bits, $crate::Kind::Hex),] $($rest)*)
    };
    ([$($done:tt)*] $(#[$doc:meta])* unsigned $bits:literal $key:literal $get:ident / $set:ident = $lsb:expr, $decimals:literal; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::quantity($key, $bits, false, $lsb, $decimals),] $($rest)*)
    };
    ([$($done:tt)*] $(#[$doc:meta])* signed $bits:literal $key:literal $get:ident / $set:ident = $lsb:expr, $decimals:literal; $($rest:tt)*) => {
        $crate::item::fields!([$($done)* $crate::layout::quantity($key, $bits, true, $lsb, $decimals),] $($rest)*)
    };
}

/// The accessors and setters; the number in front is the bit where the next field begins.
macro_rules! methods {
    (($at:expr)) => {};
    (($at:expr) spare $bits:literal $key:literal; $($rest:tt)*) => {
        $crate::item::methods!(($at + $bits) $($rest)*);
    };
    (($at:expr) $(#[$doc:meta])* flag $key:literal $get:ident / $set:ident; $($rest:tt)*) => {
        $(#[$doc])*
        pub const fn $get(&self) -> bool {
            $crate::bits::get(&self.0, $at, 1) == 1
        }

        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), ").")]
        #[must_use]
        pub const fn $set(self, flag: bool) -> Self {
            Self($crate::bits::set(self.0, $at, 1, flag as u64))
        }

        $crate::item::methods!(($at + 1) $($rest)*);
    };
    (($at:expr) $(#[$doc:meta])* code $bits:literal $key:literal $get:ident / $set:ident: $type:ty; $($rest:tt)*) => {
        $(#[$doc])*
        pub const fn $get(&self) -> $type {
            <$type>::from_code($crate::bits::get(&self.0, $at, $bits) as u8)
        }

        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "), of which the bits hold ", stringify!($bits), ".")]
        #[must_use]
        pub const fn $set(self, code: $type) -> Self {
            Self($crate::bits::set(self.0, $at, $bits, code.code() as u64))
        }

        $crate::item::methods!(($at + $bits) $($rest)*);
    };
    (($at:expr) $(#[$doc:meta])* count $($field:tt)*) => {
        $crate::item::methods!(@number ($at) $(#[$doc])* $($field)*);
    };
    (($at:expr) $(#[$doc:meta])* octal $($field:tt)*) => {
        $crate::item::methods!(@number ($at) $(#[$doc])* $($field)*);
    };
    (($at:expr) $(#[$doc:meta])* hex $($field:tt)*) => {
        $crate::item::methods!(@number ($at) $(#[$doc])* $($field)*);
    };
    (@number ($at:expr) $(#[$doc:meta])* $bits:literal $key:literal $get:ident / $set:ident: $type:ty; $($rest:tt)*) => {
        $(#[$doc])*
        pub const fn $get(&self) -> $type {
            $crate::bits::get(&self.0, $at, $bits) as $type
        }

        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "); `None` where ", stringify!($bits), " bits do not hold it.")]
        pub const fn $set(self, number: $type) -> Option<Self> {
            if number as u64 <= $crate::bits::mask($bits) {
                Some(Self($crate::bits::set(self.0, $at, $bits, number as u64)))
            } else {
                None
            }
        }

        $crate::item::methods!(($at + $bits) $($rest)*);
    };
    (($at:expr) $(#[$doc:meta])* unsigned $bits:literal $key:literal $get:ident / $set:ident = $lsb:expr, $decimals:literal; $($rest:tt)*) => {
        $(#[$doc])*
        pub const fn $get(&self) -> f64 {
            $crate::bits::get(&self.0, $at, $bits) as f64 * ($lsb)
        }

        #[doc = concat!("The same with the count nearest to this [`", stringify!($get), "`](Self::", stringify!($get), "); `None` out of range.")]
        pub fn $set(self, value: f64) -> Option<Self> {
            let count = $crate::item::nearest_count(value, $lsb, $bits, false)?;
            Some(Self($crate::bits::set(self.0, $at, $bits, count)))
        }

        $crate::item::methods!(($at + $bits) $($rest)*);
    };
    (($at:expr) $(#[$doc:meta])* signed $bits:literal $key:literal $get:ident / $set:ident = $lsb:expr, $decimals:literal; $($rest:tt)*) => {
        $(#[$doc])*
        pub const fn $get(&self) -> f64 {
            $crate::bits::signed($crate::bits::get(&self.0, $at, $bits), $bits) as f64 * ($lsb)
        }

        #[doc = concat!("The same with the count nearest to this [`", stringify!($get), "`](Self::", stringify!($get), "); `None` out of range.")]
        pub fn $set(self, value: f64) -> Option<Self> {
            let count = $crate::item::nearest_count(value, $lsb, $bits, true)?;
            Some(Self($crate::bits::set(self.0, $at, $bits, count)))
        }

        $crate::item::methods!(($at + $bits) $($rest)*);
    };
}

/// The codes of a field. One that the edition does not define is kept.
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
}

/// An item of subfields, in the order of the bits that announce them; `_` where the specification defines none.
macro_rules! compound {
    ($(#[$meta:meta])* pub struct $name:ident { $($subfields:tt)* }) => {
        $crate::item::compound!(@sort [$(#[$meta])* $name] (0) [] [] $($subfields)*);
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
    (@sort [$(#[$meta:meta])* $name:ident] ($count:expr)
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
            const LAYOUT: $crate::Layout = $crate::Layout::Compound(Self::SUBFIELDS);
        }

        impl deku::DekuReader<'_> for $name {
            #[inline(always)]
            fn from_reader_with_ctx<R: std::io::Read + std::io::Seek>(
                reader: &mut deku::reader::Reader<R>,
                (): (),
            ) -> Result<Self, deku::DekuError> {
                let primary = $crate::item::Primary::read(reader, Self::SUBFIELDS)?;
                $(let $field = if primary.has($at) {
                    Some(<$type as deku::DekuReader<'_>>::from_reader_with_ctx(reader, ())?)
                } else {
                    None
                };)*
                Ok(Self { $($field,)* })
            }
        }

        impl deku::DekuWriter for $name {
            fn to_writer<W: std::io::Write + std::io::Seek>(
                &self,
                writer: &mut deku::writer::Writer<W>,
                (): (),
            ) -> Result<(), deku::DekuError> {
                $crate::item::Primary::default()
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

pub(crate) use {codes, compound, fields, item, methods, octets};

/// The primary subfield of a compound item: seven bits an octet, the first at the top.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Primary(u16);

impl Primary {
    /// FX of the first octet.
    const EXTENSION: u16 = 0x0100;

    const fn bit(index: u32) -> u16 {
        0x8000 >> (index + index / 7)
    }

    /// Reads one that announces no more than `subfields`.
    #[inline(always)]
    pub fn read<R: Read + Seek>(reader: &mut Reader<R>, subfields: &[Subfield]) -> Result<Self, DekuError> {
        let mut bits = u16::from(read_octet(reader)?) << 8;
        if bits & Self::EXTENSION != 0 && subfields.len() > 7 {
            bits = bits & !Self::EXTENSION | u16::from(read_octet(reader)?);
        }
        let mut defined = 0;
        for (index, subfield) in subfields.iter().enumerate() {
            if !subfield.key.is_empty() {
                defined |= Self::bit(index as u32);
            }
        }
        if bits & !defined == 0 { Ok(Self(bits)) } else { Err(REFUSED) }
    }

    #[inline]
    pub const fn has(self, index: u32) -> bool {
        self.0 & Self::bit(index) != 0
    }

    #[must_use]
    pub const fn with(self, index: u32, present: bool) -> Self {
        if present { Self(self.0 | Self::bit(index)) } else { self }
    }

    pub fn write<W: Write + Seek>(self, writer: &mut Writer<W>) -> Result<(), DekuError> {
        let [first, second] = self.0.to_be_bytes();
        if second == 0 { writer.write_bytes(&[first]) } else { writer.write_bytes(&[first | 1, second]) }
    }
}

/// A repetitive item: up to 255 parts of the same kind, of which four take no allocation.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Repeated<T>(SmallVec<[T; 4]>);

impl<T: Clone> Repeated<T> {
    /// These parts in this order, or `None` for more than 255.
    pub fn new(parts: &[T]) -> Option<Self> {
        (parts.len() <= usize::from(u8::MAX)).then(|| Self(parts.into()))
    }
}

impl<T: for<'a> DekuReader<'a>> Repeated<T> {
    #[inline(never)]
    fn read<R: Read + Seek>(&mut self, reader: &mut Reader<R>) -> Result<(), DekuError> {
        let count = read_octet(reader)?;
        if count > 4 {
            self.0.reserve_exact(usize::from(count));
        }
        for _ in 0..count {
            self.0.push(T::from_reader_with_ctx(reader, ())?);
        }
        Ok(())
    }
}

impl<T> std::ops::Deref for Repeated<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T: Describe> Describe for Repeated<T> {
    const LAYOUT: Layout = match T::LAYOUT {
        Layout::Fields(fields) => Layout::Repetitive(fields),
        _ => panic!("what is repeated has a fixed length"),
    };
}

impl<T: for<'a> DekuReader<'a>> DekuReader<'_> for Repeated<T> {
    #[inline(always)]
    fn from_reader_with_ctx<R: Read + Seek>(reader: &mut Reader<R>, (): ()) -> Result<Self, DekuError> {
        let mut repeated = Self(SmallVec::new());
        match repeated.read(reader) {
            Ok(()) => Ok(repeated),
            Err(error) => Err(error),
        }
    }
}

impl<T: DekuWriter> DekuWriter for Repeated<T> {
    fn to_writer<W: Write + Seek>(&self, writer: &mut Writer<W>, (): ()) -> Result<(), DekuError> {
        writer.write_bytes(&[self.0.len() as u8])?;
        for part in &self.0 {
            part.to_writer(writer, ())?;
        }
        Ok(())
    }
}
