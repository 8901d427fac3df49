//! Category 129, UAS identification and target reports, edition 1.2 (EUROCONTROL-SPEC-0149-29).

pub mod fusion_report;
mod items;
mod profile;

use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuError, DekuRead, DekuReader, DekuWrite, DekuWriter};

use crate::builder::builder;
use crate::uap::{Appender, Octets, explain, read, read_fspec, read_octets, record};
use crate::{DataSource, Explicit, Fault, Fspec, TimeOfDay};

pub use fusion_report::FusionReport;
pub use items::{
    Altitude, CertificationCategory, DataDestination, GnssAccuracy, HorizontalVelocity, OperationalRisk,
    Position, VerticalVelocity,
};
pub use profile::UAP;

/// A CAT129 record: the items in the order of [`UAP`]; an absent item is `None`.
///
/// Texts are kept as the octets that were sent. The category has no RE field.
#[derive(Clone, Debug, Default, PartialEq, DekuRead, DekuWrite)]
#[deku(ctx = "fspec: Fspec, long_risk: bool")]
pub struct Record {
    /// I129/010, who reports. Mandatory; 0/0 is recommended for the air-to-ground link.
    #[deku(reader = "read(deku::reader, fspec, 1)")]
    pub data_source: Option<DataSource>,
    /// I129/015, for whom.
    #[deku(reader = "read(deku::reader, fspec, 2)")]
    pub data_destination: Option<DataDestination>,
    /// I129/020, manufacturer: three ASCII characters.
    #[deku(reader = "read_octets(deku::reader, fspec, 3)")]
    pub manufacturer: Option<[u8; 3]>,
    /// I129/030, model: three ASCII characters.
    #[deku(reader = "read_octets(deku::reader, fspec, 4)")]
    pub model: Option<[u8; 3]>,
    /// I129/040, serial number: 12 octets. No encoding is stated; ASCII in practice.
    #[deku(reader = "read_octets(deku::reader, fspec, 5)")]
    pub serial_number: Option<[u8; 12]>,
    /// I129/050, country of registration: two ASCII characters, ISO 3166-1 alpha-2. Mandatory.
    #[deku(reader = "read_octets(deku::reader, fspec, 6)")]
    pub registration_country: Option<[u8; 2]>,
    /// I129/070, time of transmission. Mandatory.
    #[deku(reader = "read(deku::reader, fspec, 7)")]
    pub time_of_day: Option<TimeOfDay>,
    /// I129/080, position in WGS-84. Mandatory.
    #[deku(reader = "read(deku::reader, fspec, 8)")]
    pub position: Option<Position>,
    /// I129/090, altitude above mean sea level. This or I129/100 is mandatory.
    #[deku(reader = "read(deku::reader, fspec, 9)")]
    pub altitude_amsl: Option<Altitude>,
    /// I129/100, altitude above ground level.
    #[deku(reader = "read(deku::reader, fspec, 10)")]
    pub altitude_agl: Option<Altitude>,
    /// I129/110, accuracy of the position.
    #[deku(reader = "read(deku::reader, fspec, 11)")]
    pub gnss_accuracy: Option<GnssAccuracy>,
    /// I129/120, operational risk, in the length it was read with.
    #[deku(cond = "fspec.has(12)", ctx = "long_risk")]
    pub operational_risk: Option<OperationalRisk>,
    /// SP, the special purpose field; [`FusionReport`] is one layout of it.
    #[deku(reader = "read(deku::reader, fspec, 13)")]
    pub special_purpose: Option<Explicit>,
    /// I129/185, horizontal velocity.
    #[deku(reader = "read(deku::reader, fspec, 14)")]
    pub horizontal_velocity: Option<HorizontalVelocity>,
    /// I129/220, vertical velocity.
    #[deku(reader = "read(deku::reader, fspec, 15)")]
    pub vertical_velocity: Option<VerticalVelocity>,
    /// FSPEC octets beyond the minimal ones, which announce nothing; 0 in a record built anew. The whole FSPEC never gets
    /// longer than [`Fspec::MAX_OCTETS`].
    #[deku(skip, default = "fspec.padding()")]
    pub fspec_padding: u8,
}

impl Record {
    /// The record at the front of `octets` and its length, I129/120 read as 3 octets or as 1.
    fn read(octets: &[u8], fspec: Fspec, long_risk: bool) -> Result<(Self, usize), DekuError> {
        let mut items = Octets(&octets[fspec.length()..]);
        let record = Self::from_reader_with_ctx(&mut Reader::new(&mut items), (fspec, long_risk))?;
        Ok((record, octets.len() - items.0.len()))
    }

    /// I129/120 is read with the length that ends the record at the end of its block.
    fn decode_either(octets: &[u8]) -> Result<(Self, usize), Fault> {
        let fspec = read_fspec::<Self>(octets)?;
        let mut read = Self::read(octets, fspec, false);
        let ends_the_block =
            |read: &Result<(Self, usize), _>| matches!(read, Ok((_, length)) if *length == octets.len());
        if fspec.has(OperationalRisk::FRN) && !ends_the_block(&read) {
            // The edition contradicts itself on the length of I129/120. A block holds one record, so its end tells.
            let long = Self::read(octets, fspec, true);
            if ends_the_block(&long) {
                read = long;
            }
        }
        read.map_err(|_| explain::<Self>(octets))
    }

    fn append(&self, out: &mut Vec<u8>) {
        let fspec = crate::Record::fspec(self);
        fspec.encode_into(out);
        let long_risk = self.operational_risk.is_some_and(|risk| risk.undescribed.is_some());
        self.to_writer(&mut Writer::new(Appender(out)), (fspec, long_risk))
            .expect("writing whole octets to a vector cannot fail");
    }
}

builder! {
    129,
    must {
        data_source: DataSource = "010",
        registration_country: [u8; 2] = "050",
        time_of_day: TimeOfDay = "070",
        position: Position = "080",
    }
    may {
        data_destination: DataDestination = "015",
        manufacturer: [u8; 3] = "020",
        model: [u8; 3] = "030",
        serial_number: [u8; 12] = "040",
        altitude_amsl: Altitude = "090",
        altitude_agl: Altitude = "100",
        gnss_accuracy: GnssAccuracy = "110",
        operational_risk: OperationalRisk = "120",
        special_purpose: Explicit = "SP",
        horizontal_velocity: HorizontalVelocity = "185",
        vertical_velocity: VerticalVelocity = "220",
    }
    one_of "090, 100" { altitude_amsl | altitude_agl }
}

record! {
    129 {
        1 data_source,
        2 data_destination,
        3 manufacturer,
        4 model,
        5 serial_number,
        6 registration_country,
        7 time_of_day,
        8 position,
        9 altitude_amsl,
        10 altitude_agl,
        11 gnss_accuracy,
        12 operational_risk,
        13 special_purpose,
        14 horizontal_velocity,
        15 vertical_velocity,
    }
    Record::decode_either, Record::append
}
