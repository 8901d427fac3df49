//! Category 129, UAS identification and target reports, edition 1.2 (EUROCONTROL-SPEC-0149-29).

pub mod fusion_report;
mod items;
mod whole_serial;

use deku::DekuReader;

use crate::octets::read_octets;
use crate::record::{explain, read, read_fspec, record};
use crate::{DataSource, Explicit, Fault, TimeOfDay};

pub use crate::aircraft::Position;
pub use fusion_report::FusionReport;
pub use items::{
    Altitude, CertificationCategory, DataDestination, GnssAccuracy, HorizontalVelocity, OperationalRisk,
    RiskCategories, VerticalVelocity,
};
pub use whole_serial::WholeSerial;

record! {
    /// A CAT129 record: the items in the order of [`UAP`]; an absent item is `None`.
    ///
    /// Texts are kept as the octets received. The category has no RE field. FRN 16 to 21 are reserved.
    pub struct Record(129) with (long_risk: bool) decode {
        /// 0/0 is recommended for the air-to-ground link.
        must 1 "010" "Data Source Identifier" data_source: DataSource;
        may 2 "015" "Data Destination Identifier" data_destination: DataDestination;
        /// Three ASCII characters.
        may 3 "020" "UAS Manufacturer Identification" manufacturer: [u8; 3] = read_octets;
        /// Three ASCII characters.
        may 4 "030" "UAS Model Identification" model: [u8; 3] = read_octets;
        /// The encoding is not specified; ASCII in practice.
        may 5 "040" "UAS Serial Number" serial_number: [u8; 12] = read_octets;
        /// Two ASCII characters, ISO 3166-1 alpha-2.
        must 6 "050" "UAS Registration Country" registration_country: [u8; 2] = read_octets;
        /// Time of transmission.
        must 7 "070" "Time of Day" time_of_day: TimeOfDay;
        must 8 "080" "Position in WGS-84 Co-ordinates" position: Position;
        /// Either this item or item 100 is mandatory.
        may 9 "090" "Altitude above Mean Sea Level" altitude_amsl: Altitude;
        may 10 "100" "Altitude above Ground Level" altitude_agl: Altitude;
        may 11 "110" "GNSS Signal Accuracy" gnss_accuracy: GnssAccuracy;
        /// Keeps the length with which it was read.
        may 12 "120" "Operational Risk" operational_risk: OperationalRisk
            = |reader| OperationalRisk::from_reader_with_ctx(reader, (long_risk,));
        /// Its layouts are [`FusionReport`] and [`WholeSerial`].
        may 13 "SP" "Special Purpose Field" special_purpose: Explicit as FusionReport;
        may 14 "185" "Horizontal Velocity" horizontal_velocity: HorizontalVelocity;
        may 15 "220" "Vertical Velocity" vertical_velocity: VerticalVelocity;
    }
    one_of "090, 100" altitude_amsl altitude_agl;
}

/// Decodes I129/120 with the length with which the record ends at the end of its block.
fn decode(record: &mut Record, octets: &[u8], (): ()) -> Result<usize, Fault> {
    let fspec = read_fspec::<Record>(octets, ())?;
    let mut length = read(record, octets, fspec, (fspec, false));
    let ends_the_block = |length: &Result<usize, _>| matches!(length, Ok(length) if *length == octets.len());
    if fspec.has(OperationalRisk::FRN) && !ends_the_block(&length) {
        // The edition contradicts itself on the length of I129/120. A block holds one record, so its end decides.
        let mut other = Record::default();
        let long = read(&mut other, octets, fspec, (fspec, true));
        if ends_the_block(&long) {
            (*record, length) = (other, long);
        }
    }
    length.map_err(|_| explain::<Record>(octets, ()))
}
