//! Reasons why a record gives no report.

use asterix::DataSource;
use fusion::SensorIndex;

/// Reason why a record gives no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Refusal {
    /// No data source identifier (I048/010, I129/010, I021/010).
    NoDataSource,
    /// No configured sensor has this category, SAC and SIC.
    UnknownSource {
        /// Category of the record.
        category: u8,
        /// SAC and SIC.
        source: DataSource,
    },
    /// No configured sensor is the receiver in a gateway's line; or the line states none, and there is more than one
    /// receiver, or none.
    UnknownReceiver,
    /// No time of day (I048/140, I129/070; I021/071, 073 and 077).
    NoTime,
    /// No position (I048/040, I129/080, I021/130 and 131).
    NoPosition,
    /// Latitude and longitude are both 0: the drone has no position (Remote ID).
    NoFix,
    /// No track number (I048/161).
    NoTrackNumber,
    /// The radar track is coasted: TYP = 0 in I048/020.
    NoDetection,
    /// A simulated target: SIM in I048/020, I021/040.
    Simulated,
    /// A test target: TST in I048/020, I021/040; RAB, a field monitor.
    TestTarget,
    /// The ground station marked the position as invalid: NOGO, CPR, LDPJ, RCF or IPC in I021/040.
    NotBelieved,
    /// The slant range is 0.
    ZeroRange,
    /// No serial number, or a blank one (I129/040); no address (I021/080); no Basic ID from the same transmitter within 5 s
    /// (Remote ID).
    NoIdentity,
    /// No height above mean sea level (I129/090); in the `reference` profile, no height at all.
    NoHeight,
    /// Latitude or longitude beyond the poles or the antimeridian (I129/080).
    PositionOutOfRange,
    /// The time of day is above 86400 s.
    TimeOutOfRange,
    /// Inside a mask of `[[areas]]`.
    Masked,
    /// The time is ahead of the reception by more than `max_future_s`.
    Future,
    /// The report is older than the window.
    Late,
    /// Another sender is accepted for this sensor: two have the same SAC/SIC.
    OtherSender,
    /// The sender is not one of the hosts that the sensor's inputs name as `source`.
    ForeignSource,
    /// A repeated broadcast of the same transmitter (Remote ID): each is sent several times.
    Repeated,
    /// A broadcast without a position (Remote ID), or the end of a camera's track (I015/000). In the `reference` profile
    /// also each bearing.
    NotUsed,
}

impl Refusal {
    /// Short name for counters, stable over releases.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoDataSource => "no_data_source",
            Self::UnknownSource { .. } => "unknown_source",
            Self::UnknownReceiver => "unknown_receiver",
            Self::NoTime => "no_time",
            Self::NoPosition => "no_position",
            Self::NoFix => "no_fix",
            Self::NoTrackNumber => "no_track_number",
            Self::NoDetection => "no_detection",
            Self::Simulated => "simulated",
            Self::TestTarget => "test_target",
            Self::NotBelieved => "not_believed",
            Self::ZeroRange => "zero_range",
            Self::NoIdentity => "no_identity",
            Self::NoHeight => "no_height",
            Self::PositionOutOfRange => "position_out_of_range",
            Self::TimeOutOfRange => "time_out_of_range",
            Self::Masked => "masked",
            Self::Future => "future",
            Self::Late => "late",
            Self::OtherSender => "other_sender",
            Self::ForeignSource => "foreign_source",
            Self::Repeated => "repeated",
            Self::NotUsed => "not_used",
        }
    }
}

/// A record without a report: its sensor, if known, and the reason.
pub type Refused = (Option<SensorIndex>, Refusal);

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    /// Compares the names in the code, in quotation marks after `=>`, with the rows of the table in the document.
    #[test]
    fn documentation_lists_every_refusal() {
        let (code, _) = include_str!("refusal.rs").split_once("#[cfg(test)]").unwrap();
        let named = |line: &'static str| line.split_once("=> \"")?.1.split('"').next();
        let named: BTreeSet<&str> = code.lines().filter_map(named).collect();
        let page = include_str!("../../../../docs/INPUTS.md");
        let (_, section) = page.split_once("## What gives no report").unwrap();
        let (section, _) = section.split_once("\n## ").unwrap();
        let rows = section.lines().filter_map(|line| line.strip_prefix("| `")?.split('|').next());
        let rows: Vec<&str> = rows.flat_map(|names| names.split(['`', ',', ' '])).collect();
        let rows: BTreeSet<&str> = rows.into_iter().filter(|name| !name.is_empty()).collect();
        assert!(named.len() > 20);
        assert_eq!(named, rows);
    }
}
