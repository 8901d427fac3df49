//! Records: one declaration of a category's items generates the record, its builder and its profile.

use alloc::vec::Vec;
use core::marker::PhantomData;

use deku::no_std_io::{self, Read, Seek, SeekFrom, Write};
use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuWriter};

use crate::fault::{Fault, FaultKind};
use crate::fspec::{Frns, Fspec};
use crate::items::{DataSource, TimeOfDay};
use crate::layout::uap::{Profile, walk};

/// A category's record, decoded from the octets of a block and encoded to the same octets.
///
/// The default record is empty.
pub trait Record: Default {
    /// Category, as in the first octet of its blocks.
    const CATEGORY: u8;
    /// The items of the category, in the order of the record.
    const UAP: &'static Profile;
    /// The edition, for categories whose editions differ in layout; otherwise `()`.
    type Edition: Copy;

    /// [`Record::UAP`] in an edition: the same items in the same places.
    fn profile(edition: Self::Edition) -> &'static Profile;

    /// Data source, item 010.
    fn data_source(&self) -> Option<DataSource>;

    /// Time of day, in whichever item the category has it.
    fn time_of_day(&self) -> Option<TimeOfDay>;

    /// The FSPEC of this record.
    fn fspec(&self) -> Fspec;

    /// Decodes the record at the start of `octets`, which begin with its FSPEC and extend to the end of the block. Returns it
    /// with its length in octets. Offsets in the fault are relative to the FSPEC.
    fn decode(octets: &[u8], edition: Self::Edition) -> Result<(Self, usize), Fault> {
        let mut record = Self::default();
        let length = record.decode_into(octets, edition)?;
        Ok((record, length))
    }

    /// Decodes into `self`, which must be empty, and returns the length in octets. Unlike [`Record::decode`] this does not move
    /// the record. Items of `self` that are not in `octets` would be kept; after a fault, `self` has the items before it.
    fn decode_into(&mut self, octets: &[u8], edition: Self::Edition) -> Result<usize, Fault>;

    /// Appends the encoded record: its FSPEC and its items.
    fn encode_into(&self, out: &mut Vec<u8>);
}

/// Reason why a record was not built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum BuildError {
    /// The constructor of this item returned `None`: a value is out of range.
    #[error("CAT{category:03} item {item}: a value is out of the range that the item can hold")]
    OutOfRange {
        /// The category.
        category: u8,
        /// Number of the item.
        item: &'static str,
    },
    /// None of these items is present; the specification requires one of them.
    #[error("CAT{category:03}: one of the items {items} must be there")]
    Missing {
        /// The category.
        category: u8,
        /// Numbers of the items.
        items: &'static str,
    },
}

/// Declares a category's record, its builder and its profile: one item per line, in the order of the record, with
/// `must` or `may`, FRN, number, name, accessor and type.
///
/// * `must` marks a mandatory item; `one_of` lists items of which a record must have one.
/// * `as` names the type that describes the item if the record stores it in another form.
/// * `in (Edition)` marks a category whose editions differ; that type has a function `profile`.
/// * `time function` returns the time of day of a record without an item of that name.
/// * `= function` decodes the item if its type alone does not determine how. It may use the context after `with`; the function
///   after that context decodes a record.
macro_rules! record {
    (
        $(#[$meta:meta])*
        pub struct Record($category:literal) $(in ($edition:ty))? $(with ($context:ident: $context_type:ty) $decode:path)? {
            $(
                $(#[$doc:meta])*
                $use:ident $frn:literal $number:literal $title:literal $item:ident: $type:ty
                    $(as $described:ty)? $(= $read:expr)?;
            )*
        }
        $(one_of $numbers:literal $($one:ident)*;)?
        $(time $time:path;)?
    ) => {
        /// The items in the order of the record.
        pub const UAP: &$crate::Profile = &PROFILE;

        /// A static, because each crate would get a copy of what a constant refers to.
        static PROFILE: $crate::Profile = $crate::Profile::new(&[$($crate::UapItem::new(
            $frn,
            $number,
            $title,
            $crate::record::given!(
                [$(<$described as $crate::Describe>::LAYOUT)?] <$type as $crate::Describe>::LAYOUT
            ),
        ),)*]);

        $(#[$meta])*
        ///
        /// | FRN | item | name | | field | type |
        /// |---|---|---|---|---|---|
        $(#[doc = concat!(
            "| ", $frn, " | ", $number, " | ", $title, " | ", stringify!($use), " | [`", stringify!($item),
            "`](Self::", stringify!($item), ") | [`", stringify!($type), "`] |",
        )])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Record {
            $(
                #[doc = concat!("Item ", $number, ", ", $title, ".")]
                #[doc = ""]
                $(#[$doc])*
                pub $item: Option<$type>,
            )*
            /// Number of superfluous FSPEC octets, which announce nothing; 0 in a new record. The whole FSPEC never exceeds
            /// [`Fspec::MAX_OCTETS`](crate::Fspec::MAX_OCTETS).
            pub fspec_padding: u8,
        }

        impl $crate::record::ReadItems<($crate::Fspec, $($context_type)?)> for Record {
            #[inline(always)]
            fn read_items<R: deku::no_std_io::Read + deku::no_std_io::Seek>(
                &mut self,
                reader: &mut deku::reader::Reader<R>,
                (fspec, $($context)?): ($crate::Fspec, $($context_type)?),
            ) -> Result<(), deku::DekuError> {
                $(if fspec.has($frn) {
                    self.$item = Some($crate::record::given!(
                        [$(($read)(&mut *reader))?]
                        <$type as deku::DekuReader<'_>>::from_reader_with_ctx(reader, ())
                    )?);
                })*
                self.fspec_padding = fspec.padding();
                Ok(())
            }
        }

        impl deku::DekuWriter for Record {
            #[inline]
            fn to_writer<W: deku::no_std_io::Write + deku::no_std_io::Seek>(
                &self,
                writer: &mut deku::writer::Writer<W>,
                (): (),
            ) -> Result<(), deku::DekuError> {
                $(if let Some(item) = &self.$item {
                    deku::DekuWriter::to_writer(item, writer, ())?;
                })*
                Ok(())
            }
        }

        impl $crate::Record for Record {
            const CATEGORY: u8 = $category;
            const UAP: &'static $crate::Profile = UAP;
            type Edition = $crate::record::given!(@type [$($edition)?] ());

            fn profile(edition: Self::Edition) -> &'static $crate::Profile {
                $crate::record::given!([$(<$edition>::profile)?] |()| UAP)(edition)
            }

            fn data_source(&self) -> Option<$crate::DataSource> {
                self.data_source
            }

            fn time_of_day(&self) -> Option<$crate::TimeOfDay> {
                $crate::record::given!([$($time)?] |record: &Self| record.time_of_day)(self)
            }

            fn fspec(&self) -> $crate::Fspec {
                let frns = $crate::fspec::Frns::NONE$(.with($frn, self.$item.is_some()))*;
                $crate::Fspec::announcing(frns, self.fspec_padding)
            }

            // Slower if inlined: the compiler then collects the items elsewhere first.
            #[inline(never)]
            fn decode_into(&mut self, octets: &[u8], edition: Self::Edition) -> Result<usize, $crate::Fault> {
                $crate::record::given!([$($decode)?] $crate::record::decode)(self, octets, edition)
            }

            fn encode_into(&self, out: &mut alloc::vec::Vec<u8>) {
                $crate::record::encode(self, out);
            }
        }

        $crate::record::builder! {
            $category [] $({ $use $number $item $type })* ; [$($numbers $($one)*)?]
        }
    };
}

/// The given expression or type, or else the other one.
macro_rules! given {
    ([] $other:expr) => {
        $other
    };
    ([$given:expr] $other:expr) => {
        $given
    };
    (@type [] $other:ty) => {
        $other
    };
    (@type [$given:ty] $other:ty) => {
        $given
    };
}

/// The builder of a category's record: mandatory items first, then the others.
macro_rules! builder {
    ($category:literal [$($must:tt)*] { must $($item:tt)* } $($rest:tt)*) => {
        $crate::record::builder!($category [$($must)* { $($item)* }] $($rest)*);
    };
    ($category:literal [$($must:tt)*] { may $($item:tt)* } $($rest:tt)*) => {
        $crate::record::builder!(@may $category [$($must)*] [{ $($item)* }] $($rest)*);
    };
    (@may $category:literal [$($must:tt)*] [$($may:tt)*] { must $($item:tt)* } $($rest:tt)*) => {
        $crate::record::builder!(@may $category [$($must)* { $($item)* }] [$($may)*] $($rest)*);
    };
    (@may $category:literal [$($must:tt)*] [$($may:tt)*] { may $($item:tt)* } $($rest:tt)*) => {
        $crate::record::builder!(@may $category [$($must)*] [$($may)* { $($item)* }] $($rest)*);
    };
    (
        @may $category:literal
        [$({ $must_number:literal $must:ident $must_type:ty })*]
        [$({ $number:literal $item:ident $type:ty })*] ;
        [$($one_of:literal $($one:ident)*)?]
    ) => {
        #[doc = concat!("Builds a CAT", stringify!($category), " record that lacks nothing it must have.")]
        ///
        /// An item is given as a value or as the `Option` that its constructor returns. `None` is an error, not an absent item:
        /// [`OutOfRange`](crate::BuildError::OutOfRange). The first error counts.
        #[derive(Clone, Debug)]
        #[must_use]
        pub struct Builder {
            record: Record,
            mistake: Option<$crate::BuildError>,
        }

        impl Record {
            /// Starts a record with its mandatory items; [`Builder::build`] refuses a `None`.
            pub fn builder($($must: impl Into<Option<$must_type>>),*) -> Builder {
                let mut builder = Builder { record: Record::default(), mistake: None };
                $(builder.record.$must = builder.checked($must_number, $must.into());)*
                builder
            }
        }

        impl Builder {
            $(
                #[doc = concat!("With item ", $number, ".")]
                pub fn $item(mut self, item: impl Into<Option<$type>>) -> Self {
                    self.record.$item = self.checked($number, item.into());
                    self
                }
            )*

            /// The record.
            ///
            /// # Errors
            /// An item was `None`, because its constructor found a value out of range. Or none of several items is present of
            /// which the record must have one.
            pub fn build(self) -> Result<Record, $crate::BuildError> {
                if let Some(mistake) = self.mistake {
                    return Err(mistake);
                }
                $(if $(self.record.$one.is_none())&&* {
                    return Err($crate::BuildError::Missing { category: $category, items: $one_of });
                })?
                Ok(self.record)
            }

            fn checked<T>(&mut self, number: &'static str, item: Option<T>) -> Option<T> {
                if item.is_none() && self.mistake.is_none() {
                    self.mistake = Some($crate::BuildError::OutOfRange { category: $category, item: number });
                }
                item
            }
        }
    };
}

/// Conversion between a reserved expansion field and its contents.
macro_rules! expansion_field {
    ($name:ident) => {
        impl $name {
            /// Decodes a reserved expansion field. `None` if its octets do not follow this edition, or if
            /// [`to_field`](Self::to_field) would not restore them. Such a field is damaged or of another edition, and only its
            /// octets are known.
            pub fn read(field: &$crate::Explicit) -> Option<Self> {
                let mut contents = $crate::record::Forward(field.contents());
                let mut reader = deku::reader::Reader::new(&mut contents);
                let read = <Self as deku::DekuReader<'_>>::from_reader_with_ctx(&mut reader, ()).ok()?;
                (read.to_field().as_ref() == Some(field)).then_some(read)
            }

            /// The field with these contents; `None` if it is longer than 254 octets.
            pub fn to_field(&self) -> Option<$crate::Explicit> {
                let mut contents = alloc::vec::Vec::new();
                $crate::record::append(self, &mut contents);
                $crate::Explicit::new(&contents)
            }
        }
    };
}

pub(crate) use {builder, expansion_field, given, record};

/// The field reference numbers defined by a profile, as bits of an FSPEC.
struct Defined<R>(PhantomData<R>);

impl<R: Record> Defined<R> {
    const FRNS: Frns = {
        let (mut frns, mut index) = (Frns::NONE, 0);
        while index < R::UAP.items().len() {
            frns = frns.with(R::UAP.items()[index].frn, true);
            index += 1;
        }
        frns
    };
}

/// Decodes the FSPEC at the start of a record, which must announce only items of its category.
#[inline]
pub(crate) fn read_fspec<R: Record>(octets: &[u8], edition: R::Edition) -> Result<Fspec, Fault> {
    match Fspec::read(octets) {
        Ok(fspec) if fspec.is_within(Defined::<R>::FRNS) => Ok(fspec),
        _ => Err(explain::<R>(octets, edition)),
    }
}

/// A record that decodes its items from a reader positioned after the FSPEC.
pub(crate) trait ReadItems<C> {
    /// Stores each item in its final place at once. Collecting the items in a returned record would fetch all of them from the
    /// stack again, many by loads that stall on several narrower stores.
    fn read_items<R: Read + Seek>(&mut self, reader: &mut Reader<R>, context: C) -> Result<(), DekuError>;
}

/// Decodes the items after this FSPEC, which is at the start of `octets`. Returns the length of the record in octets.
#[inline(always)]
pub(crate) fn read<C>(
    record: &mut impl ReadItems<C>,
    octets: &[u8],
    fspec: Fspec,
    context: C,
) -> Result<usize, DekuError> {
    let mut reader = Reader::new(Forward(&octets[fspec.length()..]));
    record.read_items(&mut reader, context)?;
    let Forward(rest) = reader.into_inner();
    Ok(octets.len() - rest.len())
}

/// Decodes the record at the start of `octets`, see [`Record::decode_into`].
#[inline(always)]
pub(crate) fn decode<R>(record: &mut R, octets: &[u8], (): ()) -> Result<usize, Fault>
where
    R: Record<Edition = ()> + ReadItems<(Fspec,)>,
{
    let fspec = read_fspec::<R>(octets, ())?;
    read(record, octets, fspec, (fspec,)).map_err(|_| explain::<R>(octets, ()))
}

/// Appends a record, see [`Record::encode_into`].
#[inline]
pub(crate) fn encode<R: Record + DekuWriter>(record: &R, out: &mut Vec<u8>) {
    record.fspec().encode_into(out);
    append(record, out);
}

/// Appends items to a vector, or fills octets with them.
#[inline]
pub(crate) fn append<W>(items: &impl DekuWriter, out: W)
where
    Forward<W>: Write + Seek,
{
    items.to_writer(&mut Writer::new(Forward(out)), ()).expect("writing whole octets to memory cannot fail");
}

/// Octets that are read from the start or written to the end: a `Cursor` without a position, which the compiler can optimise.
pub(crate) struct Forward<T>(pub T);

impl<T: Read> Read for Forward<T> {
    #[inline(always)]
    fn read(&mut self, buffer: &mut [u8]) -> no_std_io::Result<usize> {
        self.0.read(buffer)
    }

    #[inline(always)]
    fn read_exact(&mut self, buffer: &mut [u8]) -> no_std_io::Result<()> {
        self.0.read_exact(buffer)
    }
}

impl Write for Forward<&mut [u8]> {
    #[inline(always)]
    fn write(&mut self, octets: &[u8]) -> no_std_io::Result<usize> {
        self.0.write(octets)
    }

    fn flush(&mut self) -> no_std_io::Result<()> {
        Ok(())
    }
}

impl Write for Forward<&mut Vec<u8>> {
    #[inline(always)]
    fn write(&mut self, octets: &[u8]) -> no_std_io::Result<usize> {
        self.0.extend_from_slice(octets);
        Ok(octets.len())
    }

    #[inline(always)]
    fn write_all(&mut self, octets: &[u8]) -> no_std_io::Result<()> {
        self.0.extend_from_slice(octets);
        Ok(())
    }

    fn flush(&mut self) -> no_std_io::Result<()> {
        Ok(())
    }
}

impl<T> Seek for Forward<T> {
    /// Seeking is not supported.
    fn seek(&mut self, _: SeekFrom) -> no_std_io::Result<u64> {
        Err(no_std_io::ErrorKind::Unsupported.into())
    }
}

/// Finds the first fault of a record in the order of its octets.
///
/// The decoders of the categories keep no record of their place. Only if one fails, the record is examined again, item by item.
#[cold]
pub(crate) fn explain<R: Record>(octets: &[u8], edition: R::Edition) -> Fault {
    walk(R::CATEGORY, R::profile(edition), octets).err().unwrap_or_else(|| {
        // Unreachable: tests verify that the table and the decoder of each category agree.
        debug_assert!(false, "CAT{:03}: the reader refused a record that its table accepts", R::CATEGORY);
        Fault { category: Some(R::CATEGORY), item: None, offset: 0, kind: FaultKind::ItemPastEnd }
    })
}
