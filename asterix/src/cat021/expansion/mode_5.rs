//! MES in RE: military extended squitter.

use crate::aircraft::{FigureOfMerit, XPulses};
use crate::item::items;

items! {
    /// MES in RE: military extended squitter.
    compound pub struct MilitarySquitter {
        /// SUM, summary.
        "sum" summary: Mode5Summary,
        /// PNO, PIN and national origin.
        "pno" origin: NationalOrigin,
        /// EM1, extended Mode 1 code.
        "em1" extended_mode_1: ExtendedMode1,
        /// XP, X pulses.
        "xp" x_pulses: XPulses,
        /// FOM, figure of merit.
        "fom" figure_of_merit: FigureOfMerit,
        /// M2, Mode 2 code.
        "m2" mode_2: Mode2,
        _,
    }

    /// SUM in MES.
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
        /// MC: flight level from a Mode 5 reply or report.
        flag 1 "mc" has_flight_level / with_flight_level;
        /// PO: position from a Mode 5 report.
        flag 1 "po" has_position / with_position;
    }

    /// PNO in MES: PIN and national origin.
    pub struct NationalOrigin(4) {
        spare 2 "spare";
        /// PIN code, 0 to 16383.
        count 14 "pin" pin / with_pin: u16;
        spare 5 "spare_2";
        /// NO, national origin, 0 to 2047.
        count 11 "no" national_origin / with_national_origin: u16;
    }

    /// EM1 in MES: extended Mode 1 code.
    pub struct ExtendedMode1(2) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        spare 1 "spare";
        /// L: the code is smoothed by a local tracker, not read from the report.
        flag 1 "l" is_smoothed / with_smoothed;
        spare 1 "spare_2";
        /// The code, 0 to octal 7777.
        octal 12 "em1" code / with_code: u16;
    }

    /// M2 in MES: Mode 2 code.
    pub struct Mode2(2) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        spare 1 "spare";
        /// L: the code is smoothed by a local tracker, not read from the reply.
        flag 1 "l" is_smoothed / with_smoothed;
        spare 1 "spare_2";
        /// The code, 0 to octal 7777.
        octal 12 "mode_2" code / with_code: u16;
    }
}
