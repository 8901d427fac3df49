//! Last measurement used for the track: I062/340.

use crate::DataSource;
use crate::cat048::DetectionType;
use crate::item::items;

items! {
    /// I062/340, measured information.
    compound pub struct MeasuredInformation {
        /// SID, the sensor.
        "sid" sensor: DataSource,
        /// POS, measured position.
        "pos" position: MeasuredPosition,
        /// HEIGHT, measured by a 3D radar.
        "height_m" height: MeasuredHeight,
        /// MDC, the last Mode C code.
        "mdc" mode_c: MeasuredModeC,
        /// MDA, the last Mode 3/A code.
        "mda" mode_3a: MeasuredMode3A,
        /// TYP, kind of the report.
        "typ" report_type: ReportType,
        _,
    }

    /// POS in I062/340, local to the sensor.
    pub struct MeasuredPosition(4) {
        /// Distance in metres: LSB 1/256 NM (7.234375 m), 0 to below 256 NM.
        unsigned 16 "rho_m" range_m / with_range_m = 1852.0 / 256.0, 1;
        /// Azimuth in degrees, clockwise: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
        angle 16 "theta_deg" azimuth_deg / with_azimuth_deg = 360.0 / 65536.0, 3;
    }

    /// HEIGHT in I062/340; signed from edition 1.20 on.
    /// Metres: LSB 25 ft (7.62 m), -249,692 to 249,685 m.
    pub struct MeasuredHeight(2) = signed 16 "" metres / with_metres = 25.0 * 0.3048, 2;

    /// MDC in I062/340.
    pub struct MeasuredModeC(2) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// Flight level: LSB 1/4 (25 ft), -2048 to 2047.75.
        signed 14 "flight_level" flight_level / with_flight_level = 0.25, 2;
    }

    /// MDA in I062/340.
    pub struct MeasuredMode3A(2) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// L: the code is smoothed by the sensor's tracker, not read from the reply.
        flag 1 "l" is_smoothed / with_smoothed;
        spare 1 "spare";
        /// The code, 0 to octal 7777.
        octal 12 "mode_3a" code / with_code: u16;
    }

    /// TYP in I062/340.
    pub struct ReportType(1) {
        /// TYP: means of detection.
        code 3 "typ" detection / with_detection: DetectionType;
        /// SIM: a simulated target.
        flag 1 "sim" is_simulated / with_simulated;
        /// RAB: from a field monitor, not from an aircraft.
        flag 1 "rab" is_field_monitor / with_field_monitor;
        /// TST: a test target.
        flag 1 "tst" is_test / with_test;
        spare 2 "spare";
    }
}
