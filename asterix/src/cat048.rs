//! Category 048, monoradar target reports, edition 1.32 (EUROCONTROL-SPEC-0149-4).

mod characteristics;
mod data_link;
pub mod expansion;
mod identity;
mod plot;
mod reply;
mod target_report;
mod track;
mod warnings;

use crate::record::record;
use crate::{DataSource, Explicit, Repeated, TimeOfDay};

pub use crate::aircraft::{AircraftAddress, AircraftIdentification, BdsRegister};
pub use characteristics::{
    Amplitude, AzimuthDifference, CalculatedDoppler, PlotCharacteristics, RadialDoppler, RangeDifference,
    RawDoppler, Replies, RunLength,
};
pub use data_link::{AcasAdvisory, Capability, Communications, FlightStatus};
pub use expansion::ReservedExpansion;
pub use identity::Mode3A;
pub use plot::{FlightLevel, Height3D, PolarPosition};
pub use reply::{Mode1, Mode1Confidence, Mode2, Mode2Confidence, Mode3AConfidence, ModeC};
pub use target_report::{DetectionType, FriendOrFoe, TargetReport};
pub use track::{
    CartesianPosition, ClimbMode, TrackNumber, TrackQuality, TrackSensor, TrackStatus, TrackVelocity,
};
pub use warnings::{Warnings, warning_name};

record! {
    /// A CAT048 record: the items in the order of [`UAP`]; an absent item is `None`.
    pub struct Record(48) {
        must 1 "010" "Data Source Identifier" data_source: DataSource;
        /// Time of the measurement.
        must 2 "140" "Time of Day" time_of_day: TimeOfDay;
        /// Means of detection of the target.
        must 3 "020" "Target Report Descriptor" target_report: TargetReport;
        may 4 "040" "Measured Position in Polar Co-ordinates" polar_position: PolarPosition;
        may 5 "070" "Mode-3/A Code in Octal Representation" mode_3a: Mode3A;
        may 6 "090" "Flight Level in Binary Representation" flight_level: FlightLevel;
        may 7 "130" "Radar Plot Characteristics" plot_characteristics: PlotCharacteristics;
        may 8 "220" "Aircraft Address" aircraft_address: AircraftAddress;
        may 9 "240" "Aircraft Identification" aircraft_identification: AircraftIdentification;
        may 10 "250" "BDS Register Data" bds_registers: Repeated<BdsRegister>;
        may 11 "161" "Track Number" track_number: TrackNumber;
        may 12 "042" "Calculated Position in Cartesian Co-ordinates" cartesian_position: CartesianPosition;
        may 13 "200" "Calculated Track Velocity in Polar Co-ordinates" track_velocity: TrackVelocity;
        may 14 "170" "Track Status" track_status: TrackStatus;
        may 15 "210" "Track Quality" track_quality: TrackQuality;
        may 16 "030" "Warning/Error Conditions and Target Classification" warnings: Warnings;
        may 17 "080" "Mode-3/A Code Confidence Indicator" mode_3a_confidence: Mode3AConfidence;
        may 18 "100" "Mode-C Code and Code Confidence Indicator" mode_c: ModeC;
        may 19 "110" "Height Measured by a 3D Radar" height_3d: Height3D;
        may 20 "120" "Radial Doppler Speed" radial_doppler: RadialDoppler;
        may 21 "230" "Communications/ACAS Capability and Flight Status" capability: Capability;
        may 22 "260" "ACAS Resolution Advisory Report" acas_advisory: AcasAdvisory;
        may 23 "055" "Mode-1 Code in Octal Representation" mode_1: Mode1;
        may 24 "050" "Mode-2 Code in Octal Representation" mode_2: Mode2;
        may 25 "065" "Mode-1 Code Confidence Indicator" mode_1_confidence: Mode1Confidence;
        may 26 "060" "Mode-2 Code Confidence Indicator" mode_2_confidence: Mode2Confidence;
        may 27 "SP" "Special Purpose Field" special_purpose: Explicit;
        /// Decoded as [`ReservedExpansion`], edition 1.13 of appendix A.
        may 28 "RE" "Reserved Expansion Field" reserved_expansion: Explicit as ReservedExpansion;
    }
}
