//! The user application profile of category 048.

use crate::uap::item;
use crate::{Format, UapItem};

/// I048/130: seven subfields of one octet.
pub(super) const PLOT_CHARACTERISTICS: Format = Format::Compound(&[Format::Fixed(1); 7]);

/// I048/250: 56 bits of message and 8 bits of register address each.
pub(super) const BDS_REGISTERS: Format = Format::Repetitive(8);

/// I048/120: calculated Doppler speed; raw Doppler speeds of 6 octets each.
pub(super) const RADIAL_DOPPLER: Format = Format::Compound(&[Format::Fixed(2), Format::Repetitive(6)]);

/// The items of category 048, edition 1.32, in the order of the record: `UAP[n]` has FRN n + 1.
pub const UAP: [UapItem; 28] = [
    item(1, "010", "Data Source Identifier", Format::Fixed(2)),
    item(2, "140", "Time of Day", Format::Fixed(3)),
    item(3, "020", "Target Report Descriptor", Format::Extended),
    item(4, "040", "Measured Position in Polar Co-ordinates", Format::Fixed(4)),
    item(5, "070", "Mode-3/A Code in Octal Representation", Format::Fixed(2)),
    item(6, "090", "Flight Level in Binary Representation", Format::Fixed(2)),
    item(7, "130", "Radar Plot Characteristics", PLOT_CHARACTERISTICS),
    item(8, "220", "Aircraft Address", Format::Fixed(3)),
    item(9, "240", "Aircraft Identification", Format::Fixed(6)),
    item(10, "250", "BDS Register Data", BDS_REGISTERS),
    item(11, "161", "Track Number", Format::Fixed(2)),
    item(12, "042", "Calculated Position in Cartesian Co-ordinates", Format::Fixed(4)),
    item(13, "200", "Calculated Track Velocity in Polar Co-ordinates", Format::Fixed(4)),
    item(14, "170", "Track Status", Format::Extended),
    item(15, "210", "Track Quality", Format::Fixed(4)),
    item(16, "030", "Warning/Error Conditions and Target Classification", Format::Extended),
    item(17, "080", "Mode-3/A Code Confidence Indicator", Format::Fixed(2)),
    item(18, "100", "Mode-C Code and Code Confidence Indicator", Format::Fixed(4)),
    item(19, "110", "Height Measured by a 3D Radar", Format::Fixed(2)),
    item(20, "120", "Radial Doppler Speed", RADIAL_DOPPLER),
    item(21, "230", "Communications/ACAS Capability and Flight Status", Format::Fixed(2)),
    item(22, "260", "ACAS Resolution Advisory Report", Format::Fixed(7)),
    item(23, "055", "Mode-1 Code in Octal Representation", Format::Fixed(1)),
    item(24, "050", "Mode-2 Code in Octal Representation", Format::Fixed(2)),
    item(25, "065", "Mode-1 Code Confidence Indicator", Format::Fixed(1)),
    item(26, "060", "Mode-2 Code Confidence Indicator", Format::Fixed(2)),
    item(27, "SP", "Special Purpose Field", Format::Explicit),
    item(28, "RE", "Reserved Expansion Field", Format::Explicit),
];
