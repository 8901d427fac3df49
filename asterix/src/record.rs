//! Records: one declaration of a category's items makes the record, its builder and its profile.

use alloc::vec::Vec;
use core::marker::PhantomData;

use deku::no_std_io::{self, Read, Seek, SeekFrom, Write};
use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuWriter};

use crate::fault::{Fault, FaultKind};
use crate::fspec::{Frns, Fspec};
use crate::items::{DataSource, TimeOfDay};
use crate::uap::{Profile, walk};

/// A category's record: decoded from the octets of a block and encoded back to the same octets.
///
/// The default record is the empty one, which has no item.
pub trait Record: Default {
    /// The category, as in the first octet of its blocks.
    const CATEGORY: u8;
    /// The items of the category, in the order of the record.
    const UAP: &'static Profile;
    /// What a reader has to know: the edition, of a category whose editions lay octets out differently; else nothing.
    type Edition: Copy;

    /// [`Record::UAP`] as it was in an edition: with the same items in the same places.
    fn profile(edition: Self::Edition) -> &'static Profile;

    /// Item 010, who reports.
    fn data_source(&self) -> Option<DataSource>;

    /// The item of the time of day, whatever its number.
    fn time_of_day(&self) -> Option<TimeOfDay>;

    /// The FSPEC that announces the items of this record.
    fn fspec(&self) -> Fspec;

    /// Decodes the record at the front of `octets`, which begin with its FSPEC and go to the end of the block, and says
    /// how many octets it took. Offsets in the fault count from the FSPEC.
    fn decode(octets: &[u8], edition: Self::Edition) -> Result<(Self, usize), Fault> {
        let mut record = Self::default();
        let length = record.decode_into(octets, edition)?;
        Ok((record, length))
    }

    /// The same into `self`, which is empty, as [`Default`] makes it: a record that is returned is moved, this one is not. Items
    /// that `self` has and these octets have not would stay; after a fault it has those that were read before.
    fn decode_into(&mut self, octets: &[u8], edition: Self::Edition) -> Result<usize, Fault>;

    /// Appends the record: its FSPEC and its items.
    fn encode_into(&self, out: &mut Vec<u8>);
}

/// Why a record was not built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum BuildError {
    /// The constructor of this item gave `None`: a value was out of its range.
    #[error("CAT{category:03} item {item}: a value is out of the range that the item can hold")]
    OutOfRange {
        /// The category.
        category: u8,
        /// Number of the item.
        item: &'static str,
    },
    /// None of these items, of which the specification wants one, is there.
    #[error("CAT{category:03}: one of the items {items} must be there")]
    Missing {
        /// The category.
        category: u8,
        /// Numbers of the items.
        items: &'static str,
    },
}

/// Declares a category's record, its builder and its profile, an item a line in the order of the record:
/// `must` or `may`, FRN, number, name, accessor and type.
///
/// * `must` is an item without which no record is built; `one_of` names items of which a record must have one.
/// * `as` names the type that describes the item where the record keeps it as something else.
/// * `in (Edition)` is a category whose editions differ: that type has a function `profile`.
/// * `time function` gives the time of day of a record that has no item of that name.
/// * `= function` reads the item where its type alone does not say how; it may use the context that the record is read
///   `with`. The function behind that context decodes a record.
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

        /// What a constant refers to is there once only where it is a static: else each crate has one of its own.
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
            /// FSPEC octets beyond the minimal ones, which announce nothing; 0 in a record built anew. The whole FSPEC never
            /// gets longer than [`Fspec::MAX_OCTETS`](crate::Fspec::MAX_OCTETS).
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

            // Inlined into its caller it is slower: the compiler then gathers the items elsewhere first.
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

/// What is given, or else the other expression.
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

/// The builder of a category's record: the items that every record must have, then the others.
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
        /// An item may be given as it is or as the `Option` that its constructor returns. `None` is a mistake and not an
        /// absent item: [`OutOfRange`](crate::BuildError::OutOfRange). The first mistake counts.
        #[derive(Clone, Debug)]
        #[must_use]
        pub struct Builder {
            record: Record,
            mistake: Option<$crate::BuildError>,
        }

        impl Record {
            /// Begins a record with the items that every record must have; a `None` is refused by [`Builder::build`].
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
            /// An item was `None`: its constructor found a value out of range. Or a record must have one of several items
            /// and has none.
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

pub(crate) use {builder, given, record};

/// The field reference numbers that a profile defines, as bits of an FSPEC.
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

/// Reads the FSPEC at the front of a record that announces no item beyond those of its category.
#[inline]
pub(crate) fn read_fspec<R: Record>(octets: &[u8], edition: R::Edition) -> Result<Fspec, Fault> {
    match Fspec::read(octets) {
        Ok(fspec) if fspec.is_within(Defined::<R>::FRNS) => Ok(fspec),
        _ => Err(explain::<R>(octets, edition)),
    }
}

/// A record that takes its items from a reader, which stands behind the FSPEC.
pub(crate) trait ReadItems<C> {
    /// Each item is put where it stays as soon as it is read. Were they collected in a record that is returned, all of them
    /// would be fetched from the stack again, many by loads that wait for several narrower stores.
    fn read_items<R: Read + Seek>(&mut self, reader: &mut Reader<R>, context: C) -> Result<(), DekuError>;
}

/// Reads the items behind this FSPEC, which is at the front of `octets`. Says how many octets the record takes.
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

/// Decodes the record at the front of `octets`, see [`Record::decode_into`].
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

/// Appends an item or the items of a record to a vector, or fills octets with them.
#[inline]
pub(crate) fn append<W>(items: &impl DekuWriter, out: W)
where
    Forward<W>: Write + Seek,
{
    items.to_writer(&mut Writer::new(Forward(out)), ()).expect("writing whole octets to memory cannot fail");
}

/// Octets that are read from the front or written to the end: `Cursor` without its position, which the compiler sees
/// through.
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
    /// Nothing here goes back.
    fn seek(&mut self, _: SeekFrom) -> no_std_io::Result<u64> {
        Err(no_std_io::ErrorKind::Unsupported.into())
    }
}

/// Finds what is wrong with a record, the first thing in the order of its octets.
///
/// The readers of the categories carry no bookkeeping; only when one fails is the record walked again, item by item.
#[cold]
pub(crate) fn explain<R: Record>(octets: &[u8], edition: R::Edition) -> Fault {
    walk(R::CATEGORY, R::profile(edition), octets).err().unwrap_or_else(|| {
        // Not reached: the table and the reader of a category agree, which the tests of both hold them to.
        debug_assert!(false, "CAT{:03}: the reader refused a record that its table accepts", R::CATEGORY);
        Fault { category: Some(R::CATEGORY), item: None, offset: 0, kind: FaultKind::ItemPastEnd }
    })
}
