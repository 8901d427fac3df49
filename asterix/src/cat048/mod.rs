//! Category 048, monoradar target reports, edition 1.32 (EUROCONTROL-SPEC-0149-4).

mod identity;
mod plot;
mod profile;
mod target_report;
mod track;
mod warnings;

use std::io::Cursor;

use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuRead, DekuReader, DekuWrite, DekuWriter};

use crate::uap::{explain, read_fspec};
use crate::{DataSource, Explicit, Fault, Fspec, RawItem, TimeOfDay};

pub use identity::{AircraftAddress, AircraftIdentification, Mode3A};
pub use plot::{FlightLevel, Height3D, PolarPosition};
pub use profile::UAP;
pub use target_report::{DetectionType, FriendOrFoe, TargetReport};
pub use track::{ClimbMode, TrackNumber, TrackSensor, TrackStatus, TrackVelocity};
pub use warnings::{Warnings, warning_name};

use profile::{BDS_REGISTERS, PLOT_CHARACTERISTICS, RADIAL_DOPPLER};

/// A CAT048 record: the items in the order of [`UAP`]; an absent item is `None`.
///
/// Items with a type of their own are understood; the others keep their octets, see [`Record::raw_items`].
#[derive(Clone, Debug, Default, PartialEq, DekuRead, DekuWrite)]
#[deku(ctx = "fspec: Fspec")]
pub struct Record {
    /// I048/010, the radar.
    #[deku(cond = "fspec.has(1)")]
    pub data_source: Option<DataSource>,
    /// I048/140, when the radar measured the target.
    #[deku(cond = "fspec.has(2)")]
    pub time_of_day: Option<TimeOfDay>,
    /// I048/020, how the target was detected.
    #[deku(cond = "fspec.has(3)")]
    pub target_report: Option<TargetReport>,
    /// I048/040, slant range and azimuth.
    #[deku(cond = "fspec.has(4)")]
    pub polar_position: Option<PolarPosition>,
    /// I048/070, Mode 3/A code.
    #[deku(cond = "fspec.has(5)")]
    pub mode_3a: Option<Mode3A>,
    /// I048/090, flight level.
    #[deku(cond = "fspec.has(6)")]
    pub flight_level: Option<FlightLevel>,
    /// I048/130, radar plot characteristics: raw.
    #[deku(cond = "fspec.has(7)", ctx = "PLOT_CHARACTERISTICS")]
    pub plot_characteristics: Option<RawItem>,
    /// I048/220, 24-bit aircraft address.
    #[deku(cond = "fspec.has(8)")]
    pub aircraft_address: Option<AircraftAddress>,
    /// I048/240, aircraft identification.
    #[deku(cond = "fspec.has(9)")]
    pub aircraft_identification: Option<AircraftIdentification>,
    /// I048/250, BDS register data: raw.
    #[deku(cond = "fspec.has(10)", ctx = "BDS_REGISTERS")]
    pub bds_registers: Option<RawItem>,
    /// I048/161, the radar's number of the track.
    #[deku(cond = "fspec.has(11)")]
    pub track_number: Option<TrackNumber>,
    /// I048/042, calculated Cartesian position: raw.
    #[deku(cond = "fspec.has(12)")]
    pub cartesian_position: Option<[u8; 4]>,
    /// I048/200, calculated speed and heading of the track.
    #[deku(cond = "fspec.has(13)")]
    pub track_velocity: Option<TrackVelocity>,
    /// I048/170, status of the track.
    #[deku(cond = "fspec.has(14)")]
    pub track_status: Option<TrackStatus>,
    /// I048/210, track quality: raw.
    #[deku(cond = "fspec.has(15)")]
    pub track_quality: Option<[u8; 4]>,
    /// I048/030, warnings, error conditions and target classification.
    #[deku(cond = "fspec.has(16)")]
    pub warnings: Option<Warnings>,
    /// I048/080, Mode 3/A code confidence: raw.
    #[deku(cond = "fspec.has(17)")]
    pub mode_3a_confidence: Option<[u8; 2]>,
    /// I048/100, Mode C code and confidence: raw.
    #[deku(cond = "fspec.has(18)")]
    pub mode_c: Option<[u8; 4]>,
    /// I048/110, height measured by a 3D radar.
    #[deku(cond = "fspec.has(19)")]
    pub height_3d: Option<Height3D>,
    /// I048/120, radial Doppler speed: raw.
    #[deku(cond = "fspec.has(20)", ctx = "RADIAL_DOPPLER")]
    pub radial_doppler: Option<RawItem>,
    /// I048/230, communications and ACAS capability, flight status: raw.
    #[deku(cond = "fspec.has(21)")]
    pub capability: Option<[u8; 2]>,
    /// I048/260, ACAS resolution advisory: raw.
    #[deku(cond = "fspec.has(22)")]
    pub acas_advisory: Option<[u8; 7]>,
    /// I048/055, Mode 1 code: raw.
    #[deku(cond = "fspec.has(23)")]
    pub mode_1: Option<[u8; 1]>,
    /// I048/050, Mode 2 code: raw.
    #[deku(cond = "fspec.has(24)")]
    pub mode_2: Option<[u8; 2]>,
    /// I048/065, Mode 1 code confidence: raw.
    #[deku(cond = "fspec.has(25)")]
    pub mode_1_confidence: Option<[u8; 1]>,
    /// I048/060, Mode 2 code confidence: raw.
    #[deku(cond = "fspec.has(26)")]
    pub mode_2_confidence: Option<[u8; 2]>,
    /// SP, the special purpose field.
    #[deku(cond = "fspec.has(27)")]
    pub special_purpose: Option<Explicit>,
    /// RE, the reserved expansion field: raw.
    #[deku(cond = "fspec.has(28)")]
    pub reserved_expansion: Option<Explicit>,
    /// FSPEC octets beyond the minimal ones, which announce nothing; 0 in a record built anew. The whole FSPEC never gets
    /// longer than [`Fspec::MAX_OCTETS`].
    #[deku(skip, default = "fspec.padding()")]
    pub fspec_padding: u8,
}

impl Record {
    /// The FSPEC that announces the items of this record.
    pub fn fspec(&self) -> Fspec {
        let present = [
            self.data_source.is_some(),
            self.time_of_day.is_some(),
            self.target_report.is_some(),
            self.polar_position.is_some(),
            self.mode_3a.is_some(),
            self.flight_level.is_some(),
            self.plot_characteristics.is_some(),
            self.aircraft_address.is_some(),
            self.aircraft_identification.is_some(),
            self.bds_registers.is_some(),
            self.track_number.is_some(),
            self.cartesian_position.is_some(),
            self.track_velocity.is_some(),
            self.track_status.is_some(),
            self.track_quality.is_some(),
            self.warnings.is_some(),
            self.mode_3a_confidence.is_some(),
            self.mode_c.is_some(),
            self.height_3d.is_some(),
            self.radial_doppler.is_some(),
            self.capability.is_some(),
            self.acas_advisory.is_some(),
            self.mode_1.is_some(),
            self.mode_2.is_some(),
            self.mode_1_confidence.is_some(),
            self.mode_2_confidence.is_some(),
            self.special_purpose.is_some(),
            self.reserved_expansion.is_some(),
        ];
        const { assert!(UAP.len() == 28) };
        Fspec::of(present, self.fspec_padding)
    }

    /// The items that are kept as octets, in the order of [`UAP`]: item number and the whole item. SP is not among them,
    /// see [`Record::special_purpose`].
    pub fn raw_items(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        fn fixed<const N: usize>(item: &Option<[u8; N]>) -> Option<&[u8]> {
            item.as_ref().map(<[u8; N]>::as_slice)
        }
        [
            ("130", self.plot_characteristics.as_ref().map(RawItem::octets)),
            ("250", self.bds_registers.as_ref().map(RawItem::octets)),
            ("042", fixed(&self.cartesian_position)),
            ("210", fixed(&self.track_quality)),
            ("080", fixed(&self.mode_3a_confidence)),
            ("100", fixed(&self.mode_c)),
            ("120", self.radial_doppler.as_ref().map(RawItem::octets)),
            ("230", fixed(&self.capability)),
            ("260", fixed(&self.acas_advisory)),
            ("055", fixed(&self.mode_1)),
            ("050", fixed(&self.mode_2)),
            ("065", fixed(&self.mode_1_confidence)),
            ("060", fixed(&self.mode_2_confidence)),
            ("RE", self.reserved_expansion.as_ref().map(Explicit::octets)),
        ]
        .into_iter()
        .filter_map(|(item, octets)| Some((item, octets?)))
    }
}

impl crate::Record for Record {
    const CATEGORY: u8 = 48;

    fn decode(octets: &[u8]) -> Result<(Self, usize), Fault> {
        let fspec = read_fspec(Self::CATEGORY, &UAP, octets)?;
        let mut items = Cursor::new(&octets[fspec.length()..]);
        match Self::from_reader_with_ctx(&mut Reader::new(&mut items), fspec) {
            Ok(record) => Ok((record, fspec.length() + items.position() as usize)),
            Err(_) => Err(explain(Self::CATEGORY, &UAP, octets)),
        }
    }

    fn encode_into(&self, out: &mut Vec<u8>) {
        let fspec = self.fspec();
        fspec.encode_into(out);
        let mut cursor = Cursor::new(out);
        cursor.set_position(cursor.get_ref().len() as u64);
        self.to_writer(&mut Writer::new(cursor), fspec)
            .expect("writing whole octets to a vector cannot fail");
    }
}
