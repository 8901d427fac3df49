//! Decoder and encoder for EUROCONTROL ASTERIX, the format of reports from radars and transponder networks: CAT015, CAT021,
//! CAT034, CAT048, CAT062, CAT063, CAT065 and CAT129, every item.
//!
//! | category | specification (EUROCONTROL-SPEC-0149) | items | types |
//! |---|---|---|---|
//! | data block, FSPEC, item formats | part 1 | | [`blocks`], [`Block`], [`Fspec`], [`Layout`], [`encode_block`] |
//! | CAT015, INCS target reports | part 15B, edition 1.2 | [26](cat015::Record) | [`cat015`], [`DataSource`], [`TimeOfDay`], [`Repeated`], [`Explicit`] |
//! | CAT021, ADS-B target reports | part 12, editions 2.1 to 2.7 | [44](cat021::Record) | [`cat021`], [`aircraft`], [`DataSource`], [`TimeOfDay`], [`Repeated`], [`Explicit`] |
//! | RE of CAT021 | part 12, appendix A, edition 1.5 | [8](cat021::ReservedExpansion) | [`cat021::expansion`] |
//! | CAT034, monoradar service messages | part 2b, edition 1.29 | [14](cat034::Record) | [`cat034`], [`DataSource`], [`TimeOfDay`], [`Repeated`], [`Explicit`] |
//! | CAT048, monoradar target reports | part 4, edition 1.32 | [28](cat048::Record) | [`cat048`], [`aircraft`], [`DataSource`], [`TimeOfDay`], [`Repeated`], [`Explicit`] |
//! | RE of CAT048 | part 4, appendix A, edition 1.13 | [8](cat048::ReservedExpansion) | [`cat048::expansion`] |
//! | CAT062, system track data | part 9, edition 1.21 | [29](cat062::Record) | [`cat062`], [`aircraft`], [`DataSource`], [`TimeOfDay`], [`Repeated`], [`Explicit`] |
//! | RE of CAT062 | part 9, appendix A, edition 1.3 | [5](cat062::ReservedExpansion) | [`cat062::expansion`] |
//! | CAT063, sensor status reports | part 10, edition 1.7 | [13](cat063::Record) | [`cat063`], [`DataSource`], [`TimeOfDay`], [`Explicit`] |
//! | CAT065, service status reports | part 15, edition 1.6 | [9](cat065::Record) | [`cat065`], [`DataSource`], [`TimeOfDay`], [`Explicit`] |
//! | CAT129, UAS identification and target reports | part 29, edition 1.2 | [15](cat129::Record) | [`cat129`], [`DataSource`], [`TimeOfDay`], [`Explicit`] |
//! | any of these categories | | | [`AnyRecord`], [`Block::any_records`] |
//! | every category that has a public definition, with the feature `all` | 28, in 69 editions | | `all` |
//! | faults and errors | | | [`Fault`], [`FaultKind`], [`BuildError`] |
//!
//! The number of items links to their table, which is generated from the declaration of the record: place in the record,
//! number, name, whether it is mandatory, and type. A type states its section of the specification, LSB, range and unit.
//!
//! * An item stores the count received; methods return it in the unit that their name states. A decoded record is therefore
//!   encoded to the same octets, including spare bits and an FSPEC longer than necessary.
//! * Constructors and setters take physical values and round to the nearest count, halves away from zero; `None` means out of
//!   range. A builder (`Record::builder`) does not take such a `None` for an absent item.
//! * Input never causes a panic. A bad record affects neither the records before it nor the next block; its [`Fault`] states
//!   category, item, octet and reason.
//! * A value that the item can hold is decoded even if it is not plausible (a latitude of 100 degrees, a time of day past
//!   midnight): the caller decides.
//! * A [`Layout`] describes the bits of an item as data: [`profile`] lists those of a category, and [`items`] splits a record
//!   without knowing its type.
//! * No clock, no files, no sockets. No allocation per record, except for more than 24 octets in SP or RE and more than four
//!   parts of a repetitive item.
//!
//! Reading:
//!
//! ```
//! use utm_asterix::{DataSource, Record, blocks, cat048};
//!
//! let datagram = [0x30, 0x00, 0x0a, 0x90, 0x19, 0x07, 0x01, 0x00, 0x40, 0x00];
//! for block in blocks(&datagram) {
//!     let block = block?;
//!     if block.category != cat048::Record::CATEGORY {
//!         continue; // another category in the same datagram
//!     }
//!     for located in block.records::<cat048::Record>() {
//!         let record = located?.record;
//!         assert_eq!(record.data_source, Some(DataSource { sac: 25, sic: 7 }));
//!         let position = record.polar_position.expect("I048/040 is there");
//!         assert_eq!((position.range_m(), position.azimuth_deg()), (1852.0, 90.0));
//!     }
//! }
//! # Ok::<(), utm_asterix::Fault>(())
//! ```
//!
//! Writing:
//!
//! ```
//! use utm_asterix::cat048::{DetectionType, PolarPosition, Record, TargetReport, TrackNumber};
//! use utm_asterix::{BuildError, DataSource, TimeOfDay, encode_block};
//!
//! let radar = DataSource { sac: 25, sic: 7 };
//! let noon = TimeOfDay::from_seconds(43_200.0);
//! let plot = |range_m| {
//!     Record::builder(radar, noon, TargetReport::new(DetectionType::Primary))
//!         .polar_position(PolarPosition::new(range_m, 90.0))
//!         .track_number(TrackNumber::new(7))
//!         .build()
//! };
//! let mut datagram = Vec::new();
//! encode_block(&[plot(1852.0)?], &mut datagram)?;
//! assert_eq!(datagram.len(), 17);
//! assert_eq!(plot(500_000.0), Err(BuildError::OutOfRange { category: 48, item: "040" }));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(not(any(feature = "std", test)), no_std)]

extern crate alloc;

mod any;
mod bits;
mod block;
mod fault;
mod fields;
mod fspec;
mod item;
mod items;
mod joined;
mod layout;
mod octets;
mod parts;
mod record;
mod subfields;
mod variable;

pub mod aircraft;
#[cfg(feature = "all")]
pub mod all;
pub mod cat015;
pub mod cat021;
pub mod cat034;
pub mod cat048;
pub mod cat062;
pub mod cat063;
pub mod cat065;
pub mod cat129;

pub use any::{AnyRecord, AnyRecords};
pub use block::{Block, BlockTooLong, Blocks, Located, Records, blocks, encode_block};
pub use fault::{Fault, FaultKind};
pub use fspec::Fspec;

pub use items::{DataSource, TimeOfDay};
pub use joined::Joined;
pub use layout::uap::{Profile, UapItem, items};
pub use layout::{Contents, Dependence, Describe, Field, Form, Kind, Layout, Quantity, Subfield, octets_of};
pub use parts::Parts;
pub use record::{BuildError, Record};
pub use subfields::Repeated;
pub use variable::{Chain, Explicit};

/// The profile of a category, if it has types; for CAT021 that of the newest edition.
pub const fn profile(category: u8) -> Option<&'static Profile> {
    Some(match category {
        15 => cat015::UAP,
        21 => cat021::UAP,
        34 => cat034::UAP,
        48 => cat048::UAP,
        62 => cat062::UAP,
        63 => cat063::UAP,
        65 => cat065::UAP,
        129 => cat129::UAP,
        _ => return None,
    })
}

/// The profiles of a category with different layouts, newest first; empty if it has no types.
pub fn profiles(category: u8) -> impl Iterator<Item = &'static Profile> {
    let old = (category == cat021::Record::CATEGORY).then(|| cat021::Edition::V2_1.profile());
    profile(category).into_iter().chain(old)
}

/// The example of the crate's README, compiled and run as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

#[cfg(test)]
mod tests {
    /// The table at the top states the number of items of each category.
    #[test]
    fn the_front_page_counts_the_items() {
        let page = include_str!("lib.rs");
        for category in [15, 21, 34, 48, 62, 63, 65, 129] {
            let items = super::profile(category).map_or(0, |items| items.len());
            let cell = format!("| [{items}](cat{category:03}::Record) |");
            let row = page.lines().find(|row| row.starts_with(&format!("//! | CAT{category:03}, ")));
            assert!(row.is_some_and(|row| row.contains(&cell)), "CAT{category:03}: {cell}");
        }
    }
}
