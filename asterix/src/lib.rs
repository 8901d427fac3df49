//! EUROCONTROL ASTERIX, the format in which radars and transponder networks report, read and written: CAT034, CAT048,
//! CAT065 and CAT129, every item.
//!
//! | category | specification (EUROCONTROL-SPEC-0149) | here |
//! |---|---|---|
//! | data block, FSPEC, item formats | part 1 | [`blocks`], [`Block`], [`Fspec`], [`Layout`], [`encode_block`] |
//! | CAT034, monoradar service messages | part 2b, edition 1.29 | [`cat034::Record`], [`cat034::UAP`] |
//! | CAT048, monoradar target reports | part 4, edition 1.32; RE: appendix A, edition 1.13 | [`cat048::Record`], [`cat048::UAP`] |
//! | CAT065, service status reports | part 15, edition 1.6 | [`cat065::Record`], [`cat065::UAP`] |
//! | CAT129, UAS identification and target reports | part 29, edition 1.2 | [`cat129::Record`], [`cat129::UAP`] |
//! | what can be wrong | | [`Fault`], [`FaultKind`] |
//!
//! * An item keeps the count that stood on the wire; methods give it in a unit, which is in their name. So a record that
//!   was read is written back octet by octet, with its spare bits and with an FSPEC longer than needed.
//! * Constructors and setters take physical values and round to the nearest count, halves away from zero; `None` is out of
//!   range. A builder (`Record::builder`) does not let such a `None` pass for an absent item.
//! * What came from outside never panics. A bad record costs neither the records before it nor the next block; its
//!   [`Fault`] names category, item, octet and reason.
//! * A value that the item can hold decodes, even where it makes no sense (a latitude of 100 degrees, a time of day past
//!   midnight): whoever uses it decides.
//! * A [`Layout`] says what the bits of an item mean, as data: [`profile`] lists those of a category, and [`items`] takes a
//!   record apart without knowing its type.
//! * No clock, no files, no sockets; no allocation for a record, but for more than 24 octets in SP or RE and for more
//!   than four parts of a repetitive item.
//!
//! Reading:
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
//!
//! Writing:
//!
//! ```
//! use asterix::cat048::{DetectionType, PolarPosition, Record, TargetReport, TrackNumber};
//! use asterix::{BuildError, DataSource, TimeOfDay, encode_block};
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
//!
//! # The items
//!
//! In the order of the record. Section: of the category's specification. Types of a category are in its module, and say
//! more of each value.
//!
//! ## CAT048
//!
//! | item | section | type | what, LSB, range |
//! |---|---|---|---|
//! | 010 | 5.2.1 | [`DataSource`] | SAC, SIC |
//! | 140 | 5.2.17 | [`TimeOfDay`] | UTC since midnight: 1/128 s, below 86,400 s |
//! | 020 | 5.2.2 | [`cat048::TargetReport`] | detection type and flags, up to 5 extensions |
//! | 040 | 5.2.4 | [`cat048::PolarPosition`] | slant range 1/256 NM (7.23 m), below 256 NM; azimuth 360/2^16 degrees |
//! | 070 | 5.2.10 | [`cat048::Mode3A`] | Mode 3/A code, 4 octal digits |
//! | 090 | 5.2.12 | [`cat048::FlightLevel`] | 1/4 FL (25 ft), signed: -2048 to 2047.75 |
//! | 130 | 5.2.16 | [`cat048::PlotCharacteristics`] | run lengths 360/2^13 degrees, replies, amplitudes 1 dBm, PSR less SSR: 1/256 NM, 360/2^14 degrees |
//! | 220 | 5.2.22 | [`cat048::AircraftAddress`] | 24-bit Mode S address |
//! | 240 | 5.2.24 | [`cat048::AircraftIdentification`] | 8 characters |
//! | 250 | 5.2.25 | [`Repeated`] of [`cat048::BdsRegister`] | 56 bits and the register number, up to 255 times |
//! | 161 | 5.2.18 | [`cat048::TrackNumber`] | 0 to 4095 |
//! | 042 | 5.2.5 | [`cat048::CartesianPosition`] | x, y: 1/128 NM (14.5 m), signed |
//! | 200 | 5.2.20 | [`cat048::TrackVelocity`] | ground speed 2^-14 NM/s (0.113 m/s), heading 360/2^16 degrees |
//! | 170 | 5.2.19 | [`cat048::TrackStatus`] | flags, 1 extension |
//! | 210 | 5.2.21 | [`cat048::TrackQuality`] | standard deviations: 1/128 NM, 2^-14 NM/s, 360/2^12 degrees |
//! | 030 | 5.2.3 | [`cat048::Warnings`] | codes 0 to 127, up to 16 |
//! | 080 | 5.2.11 | [`cat048::Mode3AConfidence`] | 12 pulses |
//! | 100 | 5.2.13 | [`cat048::ModeC`] | Gray code and its 12 pulses |
//! | 110 | 5.2.14 | [`cat048::Height3D`] | 25 ft (7.62 m), signed, above mean sea level |
//! | 120 | 5.2.15 | [`cat048::RadialDoppler`] | calculated 1 m/s, signed, 10 bits; raw 1 m/s and 1 MHz |
//! | 230 | 5.2.23 | [`cat048::Capability`] | capabilities, flight status |
//! | 260 | 5.2.26 | [`cat048::AcasAdvisory`] | 56 bits of BDS 3,0 |
//! | 055 | 5.2.7 | [`cat048::Mode1`] | Mode 1 code, 5 bits |
//! | 050 | 5.2.6 | [`cat048::Mode2`] | Mode 2 code, 4 octal digits |
//! | 065 | 5.2.9 | [`cat048::Mode1Confidence`] | 5 pulses |
//! | 060 | 5.2.8 | [`cat048::Mode2Confidence`] | 12 pulses |
//! | SP |  | [`Explicit`] | up to 254 octets, by agreement |
//! | RE | A | [`cat048::ReservedExpansion`] | MD5, M5N, M4E, RPC, ERR, RTC, CPC, GEN48 of appendix A, edition 1.13 |
//!
//! ## CAT034
//!
//! | item | section | type | what, LSB, range |
//! |---|---|---|---|
//! | 010 | 5.2.2 | [`DataSource`] | SAC, SIC |
//! | 000 | 5.2.1 | [`cat034::MessageType`] | north marker, sector crossing, … |
//! | 030 | 5.2.4 | [`TimeOfDay`] | 1/128 s |
//! | 020 | 5.2.3 | [`cat034::SectorNumber`] | azimuth 360/2^8 degrees |
//! | 041 | 5.2.5 | [`cat034::RotationPeriod`] | 1/128 s, below 512 s |
//! | 050 | 5.2.6 | [`cat034::SystemStatus`] | NOGO, reset, overload, time source; PSR, SSR, Mode S |
//! | 060 | 5.2.7 | [`cat034::SystemMode`] | steps of load reduction |
//! | 070 | 5.2.8 | [`Repeated`] of [`cat034::MessageCount`] | kind and count, 0 to 2047 |
//! | 100 | 5.2.10 | [`cat034::PolarWindow`] | 1/256 NM, 360/2^16 degrees |
//! | 110 | 5.2.11 | [`cat034::DataFilter`] | what is filtered |
//! | 120 | 5.2.12 | [`cat034::SourcePosition`] | 1 m, signed; 180/2^23 degrees (2.4 m) |
//! | 090 | 5.2.9 | [`cat034::CollimationError`] | 1/128 NM, 360/2^14 degrees, signed |
//! | RE, SP |  | [`Explicit`] | up to 254 octets, by agreement |
//!
//! ## CAT065
//!
//! | item | section | type | what, LSB, range |
//! |---|---|---|---|
//! | 010 | 5.2.2 | [`DataSource`] | SAC, SIC |
//! | 000 | 5.2.1 | [`cat065::MessageType`] | system status, end of batch, service status |
//! | 015 | 5.2.3 | [`cat065::ServiceIdentification`] | 0 to 255 |
//! | 030 | 5.2.5 | [`TimeOfDay`] | 1/128 s |
//! | 020 | 5.2.4 | [`cat065::BatchNumber`] | 0 to 255 |
//! | 040 | 5.2.6 | [`cat065::SystemStatus`] | NOGO, overload, time source, renumbering |
//! | 050 | 5.2.7 | [`cat065::ServiceStatus`] | what happened to the service |
//! | RE, SP |  | [`Explicit`] | up to 254 octets, by agreement |
//!
//! ## CAT129
//!
//! | item | section | type | what, LSB, range |
//! |---|---|---|---|
//! | 010 | 5.2.1 | [`DataSource`] | SAC, SIC |
//! | 015 | 5.2.2 | [`cat129::DataDestination`] | DAC, DIC |
//! | 020, 030 | 5.2.3, 5.2.4 | `[u8; 3]` | manufacturer, model: 3 ASCII characters each |
//! | 040 | 5.2.5 | `[u8; 12]` | serial number |
//! | 050 | 5.2.6 | `[u8; 2]` | country, ISO 3166-1 |
//! | 070 | 5.2.7 | [`TimeOfDay`] | 1/128 s |
//! | 080 | 5.2.8 | [`cat129::Position`] | WGS-84, 180/2^30 degrees (1.9 cm) |
//! | 090, 100 | 5.2.9, 5.2.10 | [`cat129::Altitude`] | 0.1 m, signed; above mean sea level, above ground |
//! | 110 | 5.2.11 | [`cat129::GnssAccuracy`] | 1 m, 50 % circular error |
//! | 120 | 5.2.12 | [`cat129::OperationalRisk`] | categories; 1 octet or 3 |
//! | SP |  | [`cat129::FusionReport`] | the fusion service's own layout, or another's octets |
//! | 185 | 5.2.13 | [`cat129::HorizontalVelocity`] | east, north: 0.01 m/s, signed, 20 bits |
//! | 220 | 5.2.14 | [`cat129::VerticalVelocity`] | up: 0.01 m/s, signed, 20 bits |

mod bits;
mod block;
mod builder;
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
pub use builder::BuildError;
pub use fault::{Fault, FaultKind};
pub use fspec::Fspec;
pub use item::{Describe, Repeated};
pub use items::{DataSource, TimeOfDay};
pub use layout::{Contents, Field, Kind, Layout, Quantity, Subfield, octets_of};
pub use uap::{UapItem, items, profile};
pub use variable::{Chain, Explicit};

/// The example of the crate's README, which is compiled and run with the others.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

#[cfg(test)]
mod tests {
    /// The table of a category on the front page lists the items of its profile, in their order.
    #[test]
    fn the_front_page_names_every_item() {
        let page = include_str!("lib.rs");
        for category in [34, 48, 65, 129] {
            let title = format!("//! ## CAT{category:03}\n");
            let table = page.split(&title).nth(1).and_then(|rest| rest.split("//! ##").next()).unwrap_or("");
            let rows = table.lines().skip(3).map_while(|row| row.strip_prefix("//! | "));
            let named: Vec<&str> =
                rows.flat_map(|row| row.split(" | ").next().unwrap_or("").split(", ")).collect();
            let profile: Vec<&str> =
                super::profile(category).into_iter().flatten().map(|item| item.item).collect();
            assert_eq!(named, profile, "CAT{category:03}");
        }
    }
}
