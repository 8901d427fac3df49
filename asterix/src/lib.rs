//! EUROCONTROL ASTERIX, the format in which radars and transponder networks report: CAT034, CAT048,
//! CAT065 and CAT129, read and written.
//!
//! | what | specification (EUROCONTROL-SPEC-0149) | here |
//! |---|---|---|
//! | data block, FSPEC, item formats | part 1 | [`blocks`], [`Block`], [`Fspec`], [`Layout`], [`encode_block`] |
//! | CAT048, monoradar target reports | part 4, edition 1.32 | [`cat048::Record`], [`cat048::UAP`] |
//! | I048/010, 140 | | [`DataSource`], [`TimeOfDay`] |
//! | I048/020 | | [`cat048::TargetReport`] |
//! | I048/040, 090, 110 | | [`cat048::PolarPosition`], [`cat048::FlightLevel`], [`cat048::Height3D`] |
//! | I048/070, 220, 240 | | [`cat048::Mode3A`], [`cat048::AircraftAddress`], [`cat048::AircraftIdentification`] |
//! | I048/161, 170, 200 | | [`cat048::TrackNumber`], [`cat048::TrackStatus`], [`cat048::TrackVelocity`] |
//! | I048/030 | | [`cat048::Warnings`] |
//! | every other item of CAT048 | | a type of the item's name in [`cat048`] |
//! | RE of CAT048 | part 4, appendix A, edition 1.13 | [`cat048::ReservedExpansion`] |
//! | CAT129, UAS identification and target reports | part 29, edition 1.2 | [`cat129::Record`], [`cat129::UAP`] |
//! | CAT034, monoradar service messages | part 2b, edition 1.29 | [`cat034::Record`], [`cat034::UAP`] |
//! | CAT065, service status reports | part 15, edition 1.6 | [`cat065::Record`], [`cat065::UAP`] |
//! | SP of the fusion service's own CAT129 | | [`cat129::FusionReport`] |
//! | what can be wrong | | [`Fault`], [`FaultKind`] |
//!
//! * An item keeps the count that stood on the wire; methods give it in a unit, which is in their name. So a record that
//!   was read is written back octet by octet, with its spare bits and with an FSPEC longer than needed.
//! * Constructors take physical values and round to the nearest count, halves away from zero; `None` is out of range.
//! * What came from outside never panics. A bad record costs neither the records before it nor the next block; its
//!   [`Fault`] names category, item, octet and reason.
//! * A value that the item can hold decodes, even where it makes no sense (a latitude of 100 degrees, a time of day past
//!   midnight): whoever uses it decides.
//! * No clock, no files, no sockets; no allocation for a record, but for more than 24 octets in SP or RE and for more
//!   than four parts of a repetitive item.
//!
//! ```
//! use asterix::{DataSource, Record, blocks, cat048};
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
//! # Ok::<(), asterix::Fault>(())
//! ```

mod bits;
mod block;
mod fault;
mod fspec;
mod item;
mod items;
mod layout;
mod uap;
mod variable;

pub mod cat034;
pub mod cat048;
pub mod cat065;
pub mod cat129;

pub use block::{Block, BlockTooLong, Blocks, Located, Record, Records, blocks, encode_block};
pub use fault::{Fault, FaultKind};
pub use fspec::Fspec;
pub use item::{Describe, Repeated};
pub use items::{DataSource, TimeOfDay};
pub use layout::{Contents, Field, Kind, Layout, Quantity, Subfield, octets_of};
pub use uap::{UapItem, items, profile};
pub use variable::{Chain, Explicit};
