//! MD5 and M5N in RE: Mode 5 reports.

use crate::aircraft::{FigureOfMerit, XPulses};
use crate::item::items;

/// Degrees per count of a 24-bit position.
const POSITION_LSB_DEG: f64 = 180.0 / 8_388_608.0;

items! {
    /// MD5 in RE: Mode 5 reports and the extended Mode 1 code.
    compound pub struct Mode5 {
        /// SUM, summary.
        "sum" summary: Mode5Summary,
        /// PMN, PIN, national origin and mission code.
        "pmn" origin: NationalOrigin,
        /// POS, reported position.
        "pos" position: Mode5Position,
        /// GA, GNSS altitude.
        "ga" altitude: Mode5Altitude,
        /// EM1, extended Mode 1 code.
        "em1" extended_mode_1: ExtendedMode1,
        /// TOS, time offset of POS and GA.
        "tos_s" time_offset: TimeOffset,
        /// XP, X pulses.
        "xp" x_pulses: XPulses,
    }

    /// M5N in RE: Mode 5 reports in the new format.
    compound pub struct Mode5New {
        /// SUM, summary.
        "sum" summary: Mode5Summary,
        /// PMN, PIN and national origin.
        "pmn" origin: NewNationalOrigin,
        /// POS, reported position.
        "pos" position: Mode5Position,
        /// GA, GNSS altitude.
        "ga" altitude: Mode5Altitude,
        /// EM1, extended Mode 1 code.
        "em1" extended_mode_1: ExtendedMode1,
        /// TOS, time offset of POS and GA.
        "tos_s" time_offset: TimeOffset,
        /// XP, X pulses.
        "xp" x_pulses: XPulses,
        /// FOM, figure of merit.
        "fom" figure_of_merit: FigureOfMerit,
    }

    /// SUM in MD5 and M5N.
    pub struct Mode5Summary(1) {
        /// M5: interrogated in Mode 5.
        flag 1 "m5" is_interrogated / with_interrogated;
        /// ID: authenticated ID reply or report.
        flag 1 "id" has_identity / with_identity;
        /// DA: authenticated data reply or report.
        flag 1 "da" has_data / with_data;
        /// M1: Mode 1 code from a Mode 5 reply or report.
        flag 1 "m1" has_mode_1 / with_mode_1;
        /// M2: Mode 2 code from a Mode 5 reply or report.
        flag 1 "m2" has_mode_2 / with_mode_2;
        /// M3: Mode 3 code from a Mode 5 reply or report.
        flag 1 "m3" has_mode_3 / with_mode_3;
        /// MC: Mode C altitude from a Mode 5 reply or report.
        flag 1 "mc" has_mode_c / with_mode_c;
        spare 1 "spare";
    }

    /// PMN in MD5: PIN, national origin and mission code.
    pub struct NationalOrigin(4) {
        spare 2 "spare";
        /// PIN code, 0 to 16383.
        count 14 "pin" pin / with_pin: u16;
        spare 2 "spare_2";
        /// NAV: the national origin is not valid.
        flag 1 "nav" is_origin_invalid / with_origin_invalid;
        /// NAT, national origin, 0 to 31.
        count 5 "nat" national_origin / with_national_origin: u8;
        spare 2 "spare_3";
        /// MIS, mission code, 0 to 63.
        count 6 "mis" mission / with_mission: u8;
    }

    /// PMN in M5N: PIN and national origin.
    pub struct NewNationalOrigin(4) {
        spare 2 "spare";
        /// PIN code, 0 to 16383.
        count 14 "pin" pin / with_pin: u16;
        spare 4 "spare_2";
        /// NOV: the national origin is not valid.
        flag 1 "nov" is_origin_invalid / with_origin_invalid;
        /// NO, national origin, 0 to 2047.
        count 11 "no" national_origin / with_national_origin: u16;
    }

    /// POS in MD5 and M5N: reported position in WGS-84.
    pub struct Mode5Position(6) {
        /// Latitude in degrees, north positive: LSB 180/2^23 degrees (2.4 m), -90 to 90 degrees; the bits hold -180 to below
        /// 180.
        signed 24 "latitude_deg" latitude_deg / with_latitude_deg = POSITION_LSB_DEG, 5;
        /// Longitude in degrees, east positive: LSB 180/2^23 degrees (2.4 m), -180 to below 180 degrees.
        signed 24 "longitude_deg" longitude_deg / with_longitude_deg = POSITION_LSB_DEG, 5;
    }

    /// GA in MD5 and M5N: altitude above the WGS-84 ellipsoid from GNSS.
    pub struct Mode5Altitude(2) {
        spare 1 "spare";
        /// RES: given to 25 ft; not set: to 100 ft.
        flag 1 "res" is_to_25_ft / with_25_ft;
        /// Altitude in feet: LSB 25 ft, at least -1000 ft; the bits hold -204,800 to 204,775.
        signed 14 "altitude_ft" altitude_ft / with_altitude_ft = 25.0, 0;
    }

    /// EM1 in MD5 and M5N: extended Mode 1 code.
    pub struct ExtendedMode1(2) {
        /// V: the code is validated (the reverse of I048/055).
        flag 1 "v" is_validated / with_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// L: the code was not extracted during the last scan.
        flag 1 "l" is_not_extracted / with_not_extracted;
        spare 1 "spare";
        /// The code, 0 to octal 7777.
        octal 12 "em1" code / with_code: u16;
    }

    /// TOS in MD5 and M5N: time from I048/140 to the position and altitude.
    /// Seconds: LSB 1/128 s, 0 to below 2 s.
    pub struct TimeOffset(1) = unsigned 8 "" seconds / with_seconds = 1.0 / 128.0, 7;
}
