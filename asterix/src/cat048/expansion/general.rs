//! RPC, ERR, CPC and GEN48 in RE.

use crate::Repeated;
use crate::item::items;

/// Metres in a nautical mile.
const NAUTICAL_MILE_M: f64 = 1852.0;

items! {
    /// RPC in RE: radar plot characteristics.
    compound pub struct PlotQuality {
        /// SCO, score.
        "sco" score: Score,
        /// SRC, ratio of signal to clutter.
        "src_db" signal_to_clutter: SignalToClutter,
        /// RW, range width.
        "rw_m" range_width: RangeWidth,
        /// AR, ambiguous range.
        "ar_m" ambiguous_range: RangeWidth,
        _,
        _,
        _,
    }

    /// SCO in RPC: quality of the plot.
    /// The score, 0 to 255.
    pub struct Score(1) = count 8 "" score / with_score: u8;

    /// SRC in RPC: ratio of signal to clutter.
    /// Decibels: LSB 0.1 dB, 0 to 6553.5 dB.
    pub struct SignalToClutter(2) = unsigned 16 "" decibels / with_decibels = 0.1, 1;

    /// RW and AR in RPC: width of the plot in range, ambiguous range.
    /// Metres: LSB 1/256 NM (7.234375 m), 0 to below 256 NM.
    pub struct RangeWidth(2) = unsigned 16 "" metres / with_metres = NAUTICAL_MILE_M / 256.0, 1;

    /// ERR in RE: slant range beyond the range of I048/040.
    /// Metres: LSB 1/256 NM (7.234375 m), 0 to below 65536 NM.
    pub struct ExtendedRange(3) = unsigned 24 "" metres / with_metres = NAUTICAL_MILE_M / 256.0, 1;

    /// CPC in RE: common and plot characteristics.
    compound pub struct Common {
        /// PNB, plot number.
        "pnb" plot_number: PlotNumber,
        /// RPL, the replies used for the plot.
        "rpl" replies: Repeated<ReplyLink>,
        /// SNB, scan number.
        "snb" scan_number: ScanNumber,
        /// DATE, day of the measurement.
        "date" date: Date,
        _,
        _,
        _,
    }

    /// PNB in CPC: plot number.
    /// The number, 0 to 65535.
    pub struct PlotNumber(2) = count 16 "" number / with_number: u16;

    /// TYPE in RPL: kind of reply.
    pub enum ReplyType {
        /// PSR echo.
        PsrEcho = 0,
        /// SSR reply.
        Ssr = 1,
        /// Mode S all-call reply.
        AllCall = 2,
        /// Mode S roll-call reply.
        RollCall = 3,
    }

    /// A part of RPL in CPC: a reply used for the plot.
    pub struct ReplyLink(3) {
        /// Kind of reply.
        code 8 "type" reply_type / with_reply_type: ReplyType;
        /// Number of the reply, 0 to 65535.
        count 16 "reply_number" number / with_number: u16;
    }

    /// SNB in CPC: scan number.
    /// The number, 0 to 255.
    pub struct ScanNumber(1) = count 8 "" number / with_number: u8;

    /// DATE in CPC: the day, in decimal digits of four bits each.
    pub struct Date(4) {
        /// Year: four digits. The accessor returns them as hexadecimal digits: 0x2026.
        hex 16 "year" year_digits / with_year_digits: u16;
        /// Month: two digits, like the year.
        hex 8 "month" month_digits / with_month_digits: u8;
        /// Day: two digits, like the year.
        hex 8 "day" day_digits / with_day_digits: u8;
    }

    /// GEN48 in RE: generic data of category 048.
    compound pub struct General {
        /// ALTM2, alternative Mode 2 code.
        "altm2" alternative_mode_2: AlternativeCode,
        /// ALTM3, alternative Mode 3/A code.
        "altm3" alternative_mode_3a: AlternativeCode,
        /// ALTFL, alternative flight level.
        "altfl" alternative_flight_level: AlternativeFlightLevel,
        /// RCSDB, radar cross section in dBm².
        "rcsdb" cross_section: CrossSection,
        /// RCSM, radar cross section in m².
        "rcsm" cross_section_area: CrossSectionArea,
        _,
        _,
    }

    /// ALTM2 and ALTM3 in GEN48: alternative Mode 2 or Mode 3/A code of the target.
    pub struct AlternativeCode(2) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// L: the code is smoothed by a local tracker, not read from the reply.
        flag 1 "l" is_smoothed / with_smoothed;
        spare 1 "spare";
        /// The code, 0 to octal 7777.
        octal 12 "code" code / with_code: u16;
    }

    /// ALTFL in GEN48: alternative flight level of the target.
    pub struct AlternativeFlightLevel(2) {
        /// V: the level is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the level is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// Flight level: LSB 1/4 flight level (25 ft), -2048 to 2047.75.
        signed 14 "flight_level" flight_level / with_flight_level = 0.25, 2;
    }

    /// RCSDB in GEN48: radar cross section.
    pub struct CrossSection(2) {
        spare 2 "spare";
        /// Decibels relative to a square metre: LSB 0.01 dBm², -60 to 30 dBm²; the bits hold -81.92 to 81.91.
        signed 14 "dbm2" dbm2 / with_dbm2 = 0.01, 2;
    }

    /// RCSM in GEN48: radar cross section.
    pub struct CrossSectionArea(4) {
        spare 2 "spare";
        /// Square metres: LSB 1e-6 m², 1e-6 to 1000 m²; the bits hold 0 to 1073.7.
        unsigned 30 "m2" m2 / with_m2 = 1e-6, 6;
    }
}
