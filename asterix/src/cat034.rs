//! Category 034, monoradar service messages, edition 1.29 (EUROCONTROL-SPEC-0149-2b): measured, not yet read.

use crate::uap::item;
use crate::{Format, UapItem};

/// A bit of a primary subfield that announces nothing.
const SPARE: Format = Format::Fixed(0);

/// The items of category 034 in the order of the record: `UAP[n]` has FRN n + 1.
pub const UAP: [UapItem; 14] = [
    item(1, "010", "Data Source Identifier", Format::Fixed(2)),
    item(2, "000", "Message Type", Format::Fixed(1)),
    item(3, "030", "Time of Day", Format::Fixed(3)),
    item(4, "020", "Sector Number", Format::Fixed(1)),
    item(5, "041", "Antenna Rotation Speed", Format::Fixed(2)),
    item(
        6,
        "050",
        "System Configuration and Status",
        Format::Compound(&[
            Format::Fixed(1), // COM, common part
            SPARE,
            SPARE,
            Format::Fixed(1), // PSR
            Format::Fixed(1), // SSR
            Format::Fixed(2), // MDS, Mode S
        ]),
    ),
    item(
        7,
        "060",
        "System Processing Mode",
        Format::Compound(&[
            Format::Fixed(1), // COM
            SPARE,
            SPARE,
            Format::Fixed(1), // PSR
            Format::Fixed(1), // SSR
            Format::Fixed(1), // MDS
        ]),
    ),
    item(8, "070", "Message Count Values", Format::Repetitive(2)),
    item(9, "100", "Generic Polar Window", Format::Fixed(8)),
    item(10, "110", "Data Filter", Format::Fixed(1)),
    item(11, "120", "3D-Position of Data Source", Format::Fixed(8)),
    item(12, "090", "Collimation Error", Format::Fixed(2)),
    item(13, "RE", "Reserved Expansion Field", Format::Explicit),
    item(14, "SP", "Special Purpose Field", Format::Explicit),
];
