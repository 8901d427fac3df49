//! The user application profile of category 129.

use crate::uap::item;
use crate::{Format, UapItem};

/// The items of category 129, edition 1.2, in the order of the record: `UAP[n]` has FRN n + 1. FRN 16 to 21 are reserved.
pub const UAP: [UapItem; 15] = [
    item(1, "010", "Data Source Identifier", Format::Fixed(2)),
    item(2, "015", "Data Destination Identifier", Format::Fixed(2)),
    item(3, "020", "UAS Manufacturer Identification", Format::Fixed(3)),
    item(4, "030", "UAS Model Identification", Format::Fixed(3)),
    item(5, "040", "UAS Serial Number", Format::Fixed(12)),
    item(6, "050", "UAS Registration Country", Format::Fixed(2)),
    item(7, "070", "Time of Day", Format::Fixed(3)),
    item(8, "080", "Position in WGS-84 Co-ordinates", Format::Fixed(8)),
    item(9, "090", "Altitude above Mean Sea Level", Format::Fixed(3)),
    item(10, "100", "Altitude above Ground Level", Format::Fixed(3)),
    item(11, "110", "GNSS Signal Accuracy", Format::Fixed(2)),
    item(12, "120", "Operational Risk", Format::OneOrThree),
    item(13, "SP", "Special Purpose Field", Format::Explicit),
    item(14, "185", "Horizontal Velocity", Format::Fixed(5)),
    item(15, "220", "Vertical Velocity", Format::Fixed(3)),
];
