//! Shape and class of the target: I015/270, 300, 631.

use crate::item::items;

items! {
    /// I015/270, target size and orientation.
    compound pub struct SizeAndOrientation {
        /// LEN, along the target's motion.
        "len_m" length: Size,
        /// WDT, across the target's motion.
        "wdt_m" width: Size,
        /// HGT, vertically.
        "hgt_m" height: Size,
        /// ORT, direction of the nose.
        "ort_deg" orientation: Orientation,
    }

    /// LEN, WDT, HGT in I015/270.
    /// Metres: LSB 0.01 m, 0 to 655.35 m.
    pub struct Size(2) = unsigned 16 "" metres / with_metres = 0.01, 2;

    /// ORT in I015/270.
    /// Degrees clockwise from true north: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
    pub struct Orientation(2) = angle 16 "" degrees / with_degrees = 360.0 / 65536.0, 3;

    /// A part of I015/300, object classification: the users define the classes.
    pub struct Classification(2) {
        /// CLS, the class, 0 to 511.
        count 9 "cls" class / with_class: u16;
        /// PRB, its probability in percent, 0 to 127 (values above 100 have no meaning).
        count 7 "prb" probability_percent / with_probability_percent: u8;
    }

    /// A part of I015/631, contour: an elementary presence of the plot.
    pub struct ContourPoint(8) {
        /// AZCON, azimuth in degrees clockwise from true north: LSB 360/65536 degrees, 0 to below 360 degrees.
        angle 16 "azcon_deg" azimuth_deg / with_azimuth_deg = 360.0 / 65536.0, 3;
        /// ELCON, elevation in degrees: LSB 180/65536 degrees, -90 to below 90 degrees.
        signed 16 "elcon_deg" elevation_deg / with_elevation_deg = 180.0 / 65536.0, 4;
        /// RGCONSTOP, end in range, in metres: LSB 10,000/65,536 m (about 0.15 m), 0 to 9,999.8 m.
        unsigned 16 "rgconstop_m" range_stop_m / with_range_stop_m = 10_000.0 / 65536.0, 2;
        /// RGCONSTART, start in range, in metres: LSB 10,000/65,536 m (about 0.15 m), 0 to 9,999.8 m.
        unsigned 16 "rgconstart_m" range_start_m / with_range_start_m = 10_000.0 / 65536.0, 2;
    }
}
