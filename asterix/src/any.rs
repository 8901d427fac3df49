//! Records of any category with types.

use alloc::vec::Vec;

use crate::block::{Block, Located, Records};
use crate::{
    DataSource, Fault, Fspec, Record, TimeOfDay, cat015, cat021, cat034, cat048, cat062, cat063, cat065,
    cat129,
};

/// Generates [`AnyRecord`] and [`AnyRecords`] from the categories with types, one per line.
macro_rules! categories {
    ([$edition:ident] $($name:ident $category:ident $given:expr;)*) => {
        /// A record of any category with types, from [`Block::any_records`].
        ///
        /// For programs that handle several categories alike. It is as large as the largest record; a program that needs one
        /// category should read records of that type from the block.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        #[expect(clippy::large_enum_variant, reason = "a record is read without an allocation")]
        pub enum AnyRecord {
            $(
                #[doc = concat!("See [`", stringify!($category), "`].")]
                $name($category::Record),
            )*
        }

        impl AnyRecord {
            /// The categories that have types, ascending.
            pub const CATEGORIES: &'static [u8] = &[$($category::Record::CATEGORY),*];

            /// The category.
            pub const fn category(&self) -> u8 {
                match self {
                    $(Self::$name(_) => $category::Record::CATEGORY,)*
                }
            }

            /// Data source, item 010, which every category has.
            pub fn data_source(&self) -> Option<DataSource> {
                match self {
                    $(Self::$name(record) => record.data_source,)*
                }
            }

            /// Time of day, in whichever item the category has it: see [`Record::time_of_day`].
            pub fn time_of_day(&self) -> Option<TimeOfDay> {
                match self {
                    $(Self::$name(record) => record.time_of_day(),)*
                }
            }

            /// The FSPEC of this record.
            pub fn fspec(&self) -> Fspec {
                match self {
                    $(Self::$name(record) => record.fspec(),)*
                }
            }

            /// Appends the encoded record: its FSPEC and its items, without a block header.
            pub fn encode_into(&self, out: &mut Vec<u8>) {
                match self {
                    $(Self::$name(record) => record.encode_into(out),)*
                }
            }
        }

        $(
            impl From<$category::Record> for AnyRecord {
                fn from(record: $category::Record) -> Self {
                    Self::$name(record)
                }
            }
        )*

        /// The records of a block of one category.
        #[derive(Clone, Debug)]
        enum Typed<'a> {
            $($name(Records<'a, $category::Record>),)*
        }

        impl<'a> Typed<'a> {
            fn of(block: &Block<'a>, $edition: cat021::Edition) -> Option<Self> {
                Some(match block.category {
                    $($category::Record::CATEGORY => Self::$name(block.records_in($given)),)*
                    _ => return None,
                })
            }
        }

        impl Iterator for AnyRecords<'_> {
            type Item = Result<Located<AnyRecord>, Fault>;

            fn next(&mut self) -> Option<Self::Item> {
                Some(match &mut self.0 {
                    $(Typed::$name(records) => records.next()?.map(|Located { offset, length, record }| {
                        Located { offset, length, record: AnyRecord::$name(record) }
                    }),)*
                })
            }
        }
    };
}

categories! {
    [edition]
    Cat015 cat015 ();
    Cat021 cat021 edition;
    Cat034 cat034 ();
    Cat048 cat048 ();
    Cat062 cat062 ();
    Cat063 cat063 ();
    Cat065 cat065 ();
    Cat129 cat129 ();
}

/// The iterator of [`Block::any_records`]: the records up to the end of the block or to the first [`Fault`], which is returned
/// once and last.
#[derive(Clone, Debug)]
pub struct AnyRecords<'a>(Typed<'a>);

impl core::iter::FusedIterator for AnyRecords<'_> {}

impl<'a> Block<'a> {
    /// The records of the block in order, for any of [`AnyRecord::CATEGORIES`]; `None` for other categories.
    ///
    /// `cat021` is the edition that the senders of CAT021 use. It cannot be seen from a record, and reading in a wrong edition
    /// gives wrong values, often without a fault: see [`cat021::Edition`]. The other categories do not need it.
    ///
    /// ```
    /// use utm_asterix::cat021::Edition;
    /// use utm_asterix::{AnyRecord, blocks};
    ///
    /// let datagram = [0x30, 0x00, 0x0a, 0x90, 0x19, 0x07, 0x01, 0x00, 0x40, 0x00, 0x01, 0x00, 0x04, 0x00];
    /// for block in blocks(&datagram) {
    ///     let block = block?;
    ///     let Some(records) = block.any_records(Edition::V2_1) else {
    ///         assert_eq!(block.category, 1); // no types
    ///         continue;
    ///     };
    ///     for located in records {
    ///         let record = located?.record;
    ///         assert_eq!((record.category(), record.data_source().map(|source| source.sic)), (48, Some(7)));
    ///         if let AnyRecord::Cat048(record) = record {
    ///             assert_eq!(record.polar_position.map(|position| position.range_m()), Some(1852.0));
    ///         }
    ///     }
    /// }
    /// # Ok::<(), utm_asterix::Fault>(())
    /// ```
    pub fn any_records(&self, cat021: cat021::Edition) -> Option<AnyRecords<'a>> {
        Typed::of(self, cat021).map(AnyRecords)
    }
}
