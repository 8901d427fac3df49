//! Kind of the report, and identification of the target: I015/000, 020, 050, 161, 170, 400, 480.

use crate::item::items;

items! {
    /// The kinds of reports in I015/000.
    pub enum MessageKind {
        /// measurement plot.
        MeasurementPlot = 1,
        /// measurement track.
        MeasurementTrack = 2,
        /// sensor centric plot.
        SensorCentricPlot = 3,
        /// sensor centric track.
        SensorCentricTrack = 4,
        /// end of a track; its number may be used again.
        TrackEnd = 5,
    }

    /// I015/000, message type.
    pub struct MessageType(1) {
        /// MT, the kind of report.
        code 7 "mt" kind / with_kind: MessageKind;
        /// RG: event-driven; not set: periodic.
        flag 1 "rg" is_event_driven / with_event_driven;
    }

    /// MOMU in I015/020: number of sites of the sensor.
    all pub enum NumberOfSites {
        /// 0: mono-static.
        MonoStatic,
        /// 1: multi-static.
        MultiStatic,
        /// 2: another.
        Other,
        /// 3: unknown.
        Unknown,
    }

    /// TTAX in I015/020: nature of the target.
    all pub enum TargetTaxonomy {
        /// 0: an actual target.
        Actual,
        /// 1: a reference target.
        Reference,
        /// 2: a synthetic target, made inside the system.
        Synthetic,
        /// 3: a simulated or replayed target.
        Simulated,
    }

    /// SCD in I015/020: direction of the scan.
    all pub enum ScanDirection {
        /// 0: unknown.
        Unknown,
        /// 1: forward.
        Forward,
        /// 2: backward.
        Backward,
        /// 3: static.
        Static,
    }

    /// I015/020, target report descriptor: one octet; the edition describes no extension.
    extended pub struct TargetReport {
        first {
            /// MOMU, number of sites of the sensor.
            code 2 "momu" sites / with_sites: NumberOfSites;
            /// TTAX, nature of the target.
            code 2 "ttax" taxonomy / with_taxonomy: TargetTaxonomy;
            /// SCD, direction of the scan.
            code 2 "scd" scan_direction / with_scan_direction: ScanDirection;
            spare 1 "spare";
        }
    }

    /// I015/050, update period: time from the time of applicability to the next report of this target.
    pub struct UpdatePeriod(2) {
        spare 2 "spare";
        /// Seconds: LSB 1/128 s, 0 to 127.99 s.
        unsigned 14 "upd_s" seconds / with_seconds = 1.0 / 128.0, 4;
    }

    /// I015/161, track or plot number.
    /// The number, 0 to 65,535.
    pub struct ReportNumber(2) = count 16 "" number / with_number: u16;

    /// I015/170, track or plot status: one octet; the edition describes no extension.
    extended pub struct ReportStatus {
        first {
            /// BIZ: the target is in a blind zone.
            flag 1 "biz" is_in_blind_zone / with_blind_zone;
            /// BAZ: the target is in a blanked zone.
            flag 1 "baz" is_in_blanked_zone / with_blanked_zone;
            /// TUR: a user terminated the track.
            flag 1 "tur" is_ended_by_user / with_ended_by_user;
            spare 1 "spare";
            /// CSTP: the position is extrapolated.
            flag 1 "cstp" is_position_coasted / with_position_coasted;
            /// CSTH: the height is extrapolated.
            flag 1 "csth" is_height_coasted / with_height_coasted;
            /// CNF: a tentative track; not set: a confirmed one.
            flag 1 "cnf" is_tentative / with_tentative;
        }
    }

    /// I015/400, measurement identifier: pair of transmitter and receiver, and observation.
    pub struct MeasurementIdentifier(5) {
        /// PID, pair identifier, 0 to 65,535.
        count 16 "pid" pair / with_pair: u16;
        /// ON, observation number, 0 to 16,777,215.
        count 24 "on" observation / with_observation: u32;
    }

    /// A part of I015/480, associations.
    /// Associated object, 40 bits whose meaning the users define.
    pub struct Association(5) = count 40 "" number / with_number: u64;
}
