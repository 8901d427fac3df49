//! Reasons why a radar, or a value of it, is not determined, and flights that would show it.

use std::fmt;

/// Why a radar is not located.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotLocated {
    /// There are no plots with time, range, azimuth and track number.
    #[error("no plot has a time, a position and a track number")]
    NoPlots,
    /// There are no reports of transponders.
    #[error("no transponder reports a position: let a drone with a transponder fly where the radar sees it")]
    NoReports,
    /// The radar and transponders reported at different times.
    #[error(
        "radar tracks and transponders do not overlap in time: check both clocks, and record both together"
    )]
    NoOverlap,
    /// No position makes enough radar tracks agree with transponders.
    #[error(
        "no position of the radar makes its tracks agree with the transponders: does it see these drones?"
    )]
    NoConsensus,
    /// Too little time in common.
    #[error(
        "radar and transponders have only {common_s:.0} s in common; at least {needed_s:.0} s are needed: record longer"
    )]
    TooShort {
        /// Time in common, seconds.
        common_s: f64,
        /// Minimum, seconds.
        needed_s: f64,
    },
    /// Two positions explain the recording about equally well.
    #[error(
        "two positions of the radar explain the recording ({:.0} % as well): record longer, and fly different paths",
        runner_up.min(1.0) * 100.0
    )]
    Ambiguous {
        /// Score of the second position, as a share of the best one's.
        runner_up: f64,
    },
    /// Plots and reports scatter more than a radar of drones does: some pairs are wrong.
    #[error(
        "radar tracks and transponders agree only to {range_m:.0} m in range and {azimuth_deg:.1} degrees: pairs may be wrong; record \
         longer, with fewer or steadier drones"
    )]
    Scattered {
        /// Standard deviation of slant ranges, metres.
        range_m: f64,
        /// Standard deviation of azimuths, degrees.
        azimuth_deg: f64,
    },
    /// The halves of the recording contradict each other.
    #[error(
        "the halves of the recording show different positions or bearings ({deviations:.1} deviations apart): did the radar move?"
    )]
    Contradictory {
        /// Distance in deviations.
        deviations: f64,
    },
    /// The result is too uncertain to be useful.
    #[error(
        "position and bearing remain uncertain (standard deviations {position_m:.0} m and {bearing_deg:.1} degrees): {}",
        remedy.text()
    )]
    Uncertain {
        /// Standard deviation of the position over ground, metres.
        position_m: f64,
        /// Standard deviation of the bearing, degrees.
        bearing_deg: f64,
        /// Flights that would help.
        remedy: Remedy,
    },
}

/// Flights that would show what a recording does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// The drones were seen in a narrow sector, degrees.
    FlyAcross(f64),
    /// The drones hardly moved.
    Move,
    /// More time.
    Longer,
    /// Drones at several distances.
    Distances,
    /// Drones at a steep elevation.
    Higher,
    /// Heights in I048/110.
    Heights,
}

impl Remedy {
    /// Advice for the operator.
    pub fn text(&self) -> String {
        match self {
            Self::FlyAcross(degrees) => {
                format!("all drones lie within {degrees:.0} degrees of bearing: fly across")
            }
            Self::Move => "the drones hardly moved: fly to and fro".to_owned(),
            Self::Longer => "record longer".to_owned(),
            Self::Distances => "fly at several distances: near, and twice as far".to_owned(),
            Self::Higher => "fly high and near the radar, more than 20 degrees above its horizon".to_owned(),
            Self::Heights => "the radar reports no heights (I048/110)".to_owned(),
        }
    }
}

/// A value that the recording does not show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unobservable {
    /// Name of the value.
    pub value: &'static str,
    /// Flights that would show the value.
    pub remedy: Remedy,
}

impl fmt::Display for Unobservable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} not observable: {}", self.value, self.remedy.text())
    }
}
