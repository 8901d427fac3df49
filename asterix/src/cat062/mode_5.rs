//! Mode 5 reports: I062/110.

use crate::aircraft::CoarsePosition;
use crate::item::items;

items! {
    /// I062/110, Mode 5 reports and the extended Mode 1 code.
    compound pub struct Mode5 {
        /// SUM, summary.
        "sum" summary: Mode5Summary,
        /// PMN, PIN, national origin and mission code.
        "pmn" origin: NationalOrigin,
        /// POS, reported position.
        "pos" position: CoarsePosition,
        /// GA, GNSS altitude.
        "ga" altitude: Mode5Altitude,
        /// EM1, extended Mode 1 code.
        "em1" extended_mode_1: ExtendedMode1,
        /// TOS, time offset of POS and GA.
        "tos_s" time_offset: TimeOffset,
        /// XP, X pulses.
        "xp" x_pulses: XPulses,
    }

    /// SUM in I062/110.
    pub struct Mode5Summary(1) {
        /// M5: interrogated in Mode 5.
        flag 1 "m5" is_interrogated / with_interrogated;
        /// ID: authenticated ID reply.
        flag 1 "id" has_identity / with_identity;
        /// DA: authenticated data reply or report.
        flag 1 "da" has_data / with_data;
        /// M1: Mode 1 code from a Mode 5 reply.
        flag 1 "m1" has_mode_1 / with_mode_1;
        /// M2: Mode 2 code from a Mode 5 reply.
        flag 1 "m2" has_mode_2 / with_mode_2;
        /// M3: Mode 3 code from a Mode 5 reply.
        flag 1 "m3" has_mode_3 / with_mode_3;
        /// MC: Mode C altitude from a Mode 5 reply.
        flag 1 "mc" has_mode_c / with_mode_c;
        /// X: X pulse in the data reply or report.
        flag 1 "x" has_x_pulse / with_x_pulse;
    }

    /// PMN in I062/110: PIN, national origin and mission code.
    pub struct NationalOrigin(4) {
        spare 2 "spare";
        /// PIN code, 0 to 16383.
        count 14 "pin" pin / with_pin: u16;
        spare 3 "spare_2";
        /// NAT, national origin, 0 to 31.
        count 5 "nat" national_origin / with_national_origin: u8;
        spare 2 "spare_3";
        /// MIS, mission code, 0 to 63.
        count 6 "mis" mission / with_mission: u8;
    }

    /// GA in I062/110: altitude above the WGS-84 ellipsoid from GNSS.
    pub struct Mode5Altitude(2) {
        spare 1 "spare";
        /// RES: given to 25 ft; not set: to 100 ft.
        flag 1 "res" is_to_25_ft / with_25_ft;
        /// Altitude in metres: LSB 25 ft (7.62 m), -62,423 to 62,415 m.
        signed 14 "altitude_m" altitude_m / with_altitude_m = 25.0 * 0.3048, 2;
    }

    /// EM1 in I062/110: extended Mode 1 code.
    pub struct ExtendedMode1(2) {
        spare 4 "spare";
        /// The code, 0 to octal 7777.
        octal 12 "em1" code / with_code: u16;
    }

    /// TOS in I062/110: time from I062/070 to the position and altitude.
    /// Seconds: LSB 1/128 s, -1 to below 1 s.
    pub struct TimeOffset(1) = signed 8 "" seconds / with_seconds = 1.0 / 128.0, 7;

    /// XP in I062/110: the replies in which an X pulse was present.
    pub struct XPulses(1) {
        spare 3 "spare";
        /// X5: Mode 5 data.
        flag 1 "x5" in_mode_5_data / with_mode_5_data;
        /// XC: Mode C.
        flag 1 "xc" in_mode_c / with_mode_c;
        /// X3: Mode 3/A.
        flag 1 "x3" in_mode_3a / with_mode_3a;
        /// X2: Mode 2.
        flag 1 "x2" in_mode_2 / with_mode_2;
        /// X1: Mode 1.
        flag 1 "x1" in_mode_1 / with_mode_1;
    }
}
