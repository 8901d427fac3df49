//! The user application profile of category 129.

use crate::item::Describe;
use crate::layout::text;
use crate::uap::item;
use crate::{Contents, DataSource, Layout, TimeOfDay, UapItem};

use super::{
    Altitude, DataDestination, FusionReport, GnssAccuracy, HorizontalVelocity, OperationalRisk, Position,
    VerticalVelocity,
};

/// The items of category 129, edition 1.2, in the order of the record: `UAP[n]` has FRN n + 1. FRN 16 to 21 are reserved.
pub const UAP: [UapItem; 15] = [
    item(1, "010", "Data Source Identifier", DataSource::LAYOUT),
    item(2, "015", "Data Destination Identifier", DataDestination::LAYOUT),
    item(3, "020", "UAS Manufacturer Identification", Layout::Fields(&[text(3)])),
    item(4, "030", "UAS Model Identification", Layout::Fields(&[text(3)])),
    item(5, "040", "UAS Serial Number", Layout::Fields(&[text(12)])),
    item(6, "050", "UAS Registration Country", Layout::Fields(&[text(2)])),
    item(7, "070", "Time of Day", TimeOfDay::LAYOUT),
    item(8, "080", "Position in WGS-84 Co-ordinates", Position::LAYOUT),
    item(9, "090", "Altitude above Mean Sea Level", Altitude::LAYOUT),
    item(10, "100", "Altitude above Ground Level", Altitude::LAYOUT),
    item(11, "110", "GNSS Signal Accuracy", GnssAccuracy::LAYOUT),
    item(12, "120", "Operational Risk", OperationalRisk::LAYOUT),
    item(13, "SP", "Special Purpose Field", Layout::Explicit(Contents::Known("uf", FusionReport::FIELDS))),
    item(14, "185", "Horizontal Velocity", HorizontalVelocity::LAYOUT),
    item(15, "220", "Vertical Velocity", VerticalVelocity::LAYOUT),
];
