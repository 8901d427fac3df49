//! Category 048, monoradar target reports, edition 1.32 (EUROCONTROL-SPEC-0149-4).

mod characteristics;
mod data_link;
pub mod expansion;
mod identity;
mod plot;
mod profile;
mod reply;
mod target_report;
mod track;
mod warnings;

use deku::{DekuRead, DekuWrite};

use crate::builder::builder;
use crate::uap::{self, read, record};
use crate::{DataSource, Explicit, Fspec, Repeated, TimeOfDay};

pub use characteristics::{
    Amplitude, AzimuthDifference, CalculatedDoppler, PlotCharacteristics, RadialDoppler, RangeDifference,
    RawDoppler, Replies, RunLength,
};
pub use data_link::{AcasAdvisory, BdsRegister, Capability, Communications, FlightStatus};
pub use expansion::ReservedExpansion;
pub use identity::{AircraftAddress, AircraftIdentification, Mode3A};
pub use plot::{FlightLevel, Height3D, PolarPosition};
pub use profile::UAP;
pub use reply::{Mode1, Mode1Confidence, Mode2, Mode2Confidence, Mode3AConfidence, ModeC};
pub use target_report::{DetectionType, FriendOrFoe, TargetReport};
pub use track::{
    CartesianPosition, ClimbMode, TrackNumber, TrackQuality, TrackSensor, TrackStatus, TrackVelocity,
};
pub use warnings::{Warnings, warning_name};

/// A CAT048 record: the items in the order of [`UAP`]; an absent item is `None`.
#[derive(Clone, Debug, Default, PartialEq, DekuRead, DekuWrite)]
#[deku(ctx = "fspec: Fspec")]
pub struct Record {
    /// I048/010, the radar.
    #[deku(reader = "read(deku::reader, fspec, 1)")]
    pub data_source: Option<DataSource>,
    /// I048/140, when the radar measured the target.
    #[deku(reader = "read(deku::reader, fspec, 2)")]
    pub time_of_day: Option<TimeOfDay>,
    /// I048/020, how the target was detected.
    #[deku(reader = "read(deku::reader, fspec, 3)")]
    pub target_report: Option<TargetReport>,
    /// I048/040, slant range and azimuth.
    #[deku(reader = "read(deku::reader, fspec, 4)")]
    pub polar_position: Option<PolarPosition>,
    /// I048/070, Mode 3/A code.
    #[deku(reader = "read(deku::reader, fspec, 5)")]
    pub mode_3a: Option<Mode3A>,
    /// I048/090, flight level.
    #[deku(reader = "read(deku::reader, fspec, 6)")]
    pub flight_level: Option<FlightLevel>,
    /// I048/130, radar plot characteristics.
    #[deku(reader = "read(deku::reader, fspec, 7)")]
    pub plot_characteristics: Option<PlotCharacteristics>,
    /// I048/220, 24-bit aircraft address.
    #[deku(reader = "read(deku::reader, fspec, 8)")]
    pub aircraft_address: Option<AircraftAddress>,
    /// I048/240, aircraft identification.
    #[deku(reader = "read(deku::reader, fspec, 9)")]
    pub aircraft_identification: Option<AircraftIdentification>,
    /// I048/250, BDS register data.
    #[deku(reader = "read(deku::reader, fspec, 10)")]
    pub bds_registers: Option<Repeated<BdsRegister>>,
    /// I048/161, the radar's number of the track.
    #[deku(reader = "read(deku::reader, fspec, 11)")]
    pub track_number: Option<TrackNumber>,
    /// I048/042, calculated Cartesian position.
    #[deku(reader = "read(deku::reader, fspec, 12)")]
    pub cartesian_position: Option<CartesianPosition>,
    /// I048/200, calculated speed and heading of the track.
    #[deku(reader = "read(deku::reader, fspec, 13)")]
    pub track_velocity: Option<TrackVelocity>,
    /// I048/170, status of the track.
    #[deku(reader = "read(deku::reader, fspec, 14)")]
    pub track_status: Option<TrackStatus>,
    /// I048/210, track quality.
    #[deku(reader = "read(deku::reader, fspec, 15)")]
    pub track_quality: Option<TrackQuality>,
    /// I048/030, warnings, error conditions and target classification.
    #[deku(reader = "read(deku::reader, fspec, 16)")]
    pub warnings: Option<Warnings>,
    /// I048/080, Mode 3/A code confidence.
    #[deku(reader = "read(deku::reader, fspec, 17)")]
    pub mode_3a_confidence: Option<Mode3AConfidence>,
    /// I048/100, Mode C code and confidence.
    #[deku(reader = "read(deku::reader, fspec, 18)")]
    pub mode_c: Option<ModeC>,
    /// I048/110, height measured by a 3D radar.
    #[deku(reader = "read(deku::reader, fspec, 19)")]
    pub height_3d: Option<Height3D>,
    /// I048/120, radial Doppler speed.
    #[deku(reader = "read(deku::reader, fspec, 20)")]
    pub radial_doppler: Option<RadialDoppler>,
    /// I048/230, communications and ACAS capability, flight status.
    #[deku(reader = "read(deku::reader, fspec, 21)")]
    pub capability: Option<Capability>,
    /// I048/260, ACAS resolution advisory.
    #[deku(reader = "read(deku::reader, fspec, 22)")]
    pub acas_advisory: Option<AcasAdvisory>,
    /// I048/055, Mode 1 code.
    #[deku(reader = "read(deku::reader, fspec, 23)")]
    pub mode_1: Option<Mode1>,
    /// I048/050, Mode 2 code.
    #[deku(reader = "read(deku::reader, fspec, 24)")]
    pub mode_2: Option<Mode2>,
    /// I048/065, Mode 1 code confidence.
    #[deku(reader = "read(deku::reader, fspec, 25)")]
    pub mode_1_confidence: Option<Mode1Confidence>,
    /// I048/060, Mode 2 code confidence.
    #[deku(reader = "read(deku::reader, fspec, 26)")]
    pub mode_2_confidence: Option<Mode2Confidence>,
    /// SP, the special purpose field.
    #[deku(reader = "read(deku::reader, fspec, 27)")]
    pub special_purpose: Option<Explicit>,
    /// RE, the reserved expansion field; [`ReservedExpansion`] is what edition 1.13 puts there.
    #[deku(reader = "read(deku::reader, fspec, 28)")]
    pub reserved_expansion: Option<Explicit>,
    /// FSPEC octets beyond the minimal ones, which announce nothing; 0 in a record built anew. The whole FSPEC never gets
    /// longer than [`Fspec::MAX_OCTETS`].
    #[deku(skip, default = "fspec.padding()")]
    pub fspec_padding: u8,
}

builder! {
    48,
    must {
        data_source: DataSource = "010",
        time_of_day: TimeOfDay = "140",
        target_report: TargetReport = "020",
    }
    may {
        polar_position: PolarPosition = "040",
        mode_3a: Mode3A = "070",
        flight_level: FlightLevel = "090",
        plot_characteristics: PlotCharacteristics = "130",
        aircraft_address: AircraftAddress = "220",
        aircraft_identification: AircraftIdentification = "240",
        bds_registers: Repeated<BdsRegister> = "250",
        track_number: TrackNumber = "161",
        cartesian_position: CartesianPosition = "042",
        track_velocity: TrackVelocity = "200",
        track_status: TrackStatus = "170",
        track_quality: TrackQuality = "210",
        warnings: Warnings = "030",
        mode_3a_confidence: Mode3AConfidence = "080",
        mode_c: ModeC = "100",
        height_3d: Height3D = "110",
        radial_doppler: RadialDoppler = "120",
        capability: Capability = "230",
        acas_advisory: AcasAdvisory = "260",
        mode_1: Mode1 = "055",
        mode_2: Mode2 = "050",
        mode_1_confidence: Mode1Confidence = "065",
        mode_2_confidence: Mode2Confidence = "060",
        special_purpose: Explicit = "SP",
        reserved_expansion: Explicit = "RE",
    }
}

record! {
    48 {
        1 data_source,
        2 time_of_day,
        3 target_report,
        4 polar_position,
        5 mode_3a,
        6 flight_level,
        7 plot_characteristics,
        8 aircraft_address,
        9 aircraft_identification,
        10 bds_registers,
        11 track_number,
        12 cartesian_position,
        13 track_velocity,
        14 track_status,
        15 track_quality,
        16 warnings,
        17 mode_3a_confidence,
        18 mode_c,
        19 height_3d,
        20 radial_doppler,
        21 capability,
        22 acas_advisory,
        23 mode_1,
        24 mode_2,
        25 mode_1_confidence,
        26 mode_2_confidence,
        27 special_purpose,
        28 reserved_expansion,
    }
    uap::decode, uap::encode
}
