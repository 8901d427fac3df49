//! The user application profile of category 048.

use crate::item::{Describe, Repeated};
use crate::uap::item;
use crate::{Contents, DataSource, Layout, TimeOfDay, UapItem};

use super::{
    AcasAdvisory, AircraftAddress, AircraftIdentification, BdsRegister, Capability, CartesianPosition,
    FlightLevel, Height3D, Mode1, Mode1Confidence, Mode2, Mode2Confidence, Mode3A, Mode3AConfidence, ModeC,
    PlotCharacteristics, PolarPosition, RadialDoppler, ReservedExpansion, TargetReport, TrackNumber,
    TrackQuality, TrackStatus, TrackVelocity, Warnings,
};

/// The items of category 048, edition 1.32, in the order of the record: `UAP[n]` has FRN n + 1.
pub const UAP: [UapItem; 28] = [
    item(1, "010", "Data Source Identifier", DataSource::LAYOUT),
    item(2, "140", "Time of Day", TimeOfDay::LAYOUT),
    item(3, "020", "Target Report Descriptor", TargetReport::LAYOUT),
    item(4, "040", "Measured Position in Polar Co-ordinates", PolarPosition::LAYOUT),
    item(5, "070", "Mode-3/A Code in Octal Representation", Mode3A::LAYOUT),
    item(6, "090", "Flight Level in Binary Representation", FlightLevel::LAYOUT),
    item(7, "130", "Radar Plot Characteristics", PlotCharacteristics::LAYOUT),
    item(8, "220", "Aircraft Address", AircraftAddress::LAYOUT),
    item(9, "240", "Aircraft Identification", AircraftIdentification::LAYOUT),
    item(10, "250", "BDS Register Data", Repeated::<BdsRegister>::LAYOUT),
    item(11, "161", "Track Number", TrackNumber::LAYOUT),
    item(12, "042", "Calculated Position in Cartesian Co-ordinates", CartesianPosition::LAYOUT),
    item(13, "200", "Calculated Track Velocity in Polar Co-ordinates", TrackVelocity::LAYOUT),
    item(14, "170", "Track Status", TrackStatus::LAYOUT),
    item(15, "210", "Track Quality", TrackQuality::LAYOUT),
    item(16, "030", "Warning/Error Conditions and Target Classification", Warnings::LAYOUT),
    item(17, "080", "Mode-3/A Code Confidence Indicator", Mode3AConfidence::LAYOUT),
    item(18, "100", "Mode-C Code and Code Confidence Indicator", ModeC::LAYOUT),
    item(19, "110", "Height Measured by a 3D Radar", Height3D::LAYOUT),
    item(20, "120", "Radial Doppler Speed", RadialDoppler::LAYOUT),
    item(21, "230", "Communications/ACAS Capability and Flight Status", Capability::LAYOUT),
    item(22, "260", "ACAS Resolution Advisory Report", AcasAdvisory::LAYOUT),
    item(23, "055", "Mode-1 Code in Octal Representation", Mode1::LAYOUT),
    item(24, "050", "Mode-2 Code in Octal Representation", Mode2::LAYOUT),
    item(25, "065", "Mode-1 Code Confidence Indicator", Mode1Confidence::LAYOUT),
    item(26, "060", "Mode-2 Code Confidence Indicator", Mode2Confidence::LAYOUT),
    item(27, "SP", "Special Purpose Field", Layout::Explicit(Contents::Opaque)),
    item(28, "RE", "Reserved Expansion Field", ReservedExpansion::LAYOUT),
];
