//! Which records reach the engine of a cell: those in it and in a halo around it.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use crate::territory::Outline;
use fusion::frames::TangentPlane;
use fusion::time::Time;
use fusion::{RadarTrackKey, Report};

/// A radar track is followed for so long outside: what returns is the same aircraft.
const FOLLOWED: SignedDuration = SignedDuration::from_secs(25);

/// What a cell's engine is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Selection {
    cell: Outline,
    halo_m: f64,
    /// Radar tracks that had a plot inside: the time of the latest one.
    inside: BTreeMap<RadarTrackKey, Time>,
    /// The latest time of a plot.
    latest: Option<Time>,
}

impl Selection {
    /// What lies in the cell or at most `halo_m` metres outside.
    pub const fn new(cell: Outline, halo_m: f64) -> Self {
        Self { cell, halo_m, inside: BTreeMap::new(), latest: None }
    }

    /// The same with nothing seen yet.
    #[must_use]
    pub fn afresh(&self) -> Self {
        Self::new(self.cell.clone(), self.halo_m)
    }

    /// Whether a report is for this cell: by its position, of a radar track the whole once a plot of it was inside, until it has
    /// been outside for 25 s. A bearing has no position, and is for every cell.
    pub(super) fn takes(&mut self, report: &Report, frame: &TangentPlane) -> bool {
        let is_inside = |position| self.cell.is_within(frame.to_geodetic(position), self.halo_m);
        let plot = match report {
            Report::Bearing(_) => return true,
            Report::Fix(fix) => return is_inside(fix.position),
            Report::Plot(plot) => plot,
        };
        let is_inside = is_inside(plot.position);
        self.forget(plot.time);
        match self.inside.get_mut(&plot.track) {
            Some(latest) if is_inside => *latest = plot.time.max(*latest),
            Some(latest) => return plot.time - *latest <= FOLLOWED,
            None if is_inside => {
                self.inside.insert(plot.track, plot.time);
            }
            None => return false,
        }
        true
    }

    /// Once a second: tracks that have been outside for too long.
    fn forget(&mut self, now: Time) {
        if self.latest.is_none_or(|latest| now - latest >= SignedDuration::from_secs(1)) {
            self.latest = Some(now);
            self.inside.retain(|_, latest| now - *latest <= FOLLOWED);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::territory::{CellName, Territory};
    use fusion::frames::Geodetic;
    use fusion::{Enu, Fix, Identity, Plot, SensorIndex};

    const SENSOR: SensorIndex = SensorIndex(0);

    /// A cell whose southern edge runs through the frame's origin.
    fn selection() -> (Selection, TangentPlane) {
        let cell = Territory::grid(0.1).unwrap().outline(&CellName::new("n512-e0043").unwrap()).unwrap();
        let frame = TangentPlane::at_site(Geodetic::from_degrees(51.2, 4.35, 0.0));
        (Selection::new(cell, 1000.0), frame)
    }

    fn plot(number: u16, second: i64, north_m: f64) -> Report {
        let track = RadarTrackKey { sensor: SENSOR, number };
        let time = Time::from_nanos(second * 1_000_000_000);
        Report::Plot(Plot::new(track, time, Enu::new(0.0, north_m, 100.0), 1000.0))
    }

    #[test]
    fn a_radar_track_is_followed_out_of_the_halo_for_25_s() {
        let (mut selection, frame) = selection();
        let mut takes = |number, second, north_m| selection.takes(&plot(number, second, north_m), &frame);
        // Coming from the south: not before it is in the halo.
        assert!(!takes(1, 0, -1010.0));
        assert!(takes(1, 1, -990.0));
        assert!(takes(1, 2, -1010.0) && takes(1, 26, -1500.0));
        assert!(!takes(1, 27, -1500.0), "outside for longer");
        assert!(!takes(2, 27, -1010.0), "another track");
        assert!(takes(2, 28, 3000.0));
        assert!(!takes(2, 60, -1010.0), "silent for longer");
    }

    #[test]
    fn a_report_is_taken_by_its_own_place() {
        let (mut selection, frame) = selection();
        let fix = |north_m| {
            let identity = Identity::of_address(1);
            Report::Fix(Fix::new(SENSOR, identity, Time::default(), Enu::new(0.0, north_m, 100.0)))
        };
        assert!(selection.takes(&fix(-990.0), &frame));
        assert!(!selection.takes(&fix(-1010.0), &frame));
        assert!(selection.takes(&fix(9000.0), &frame));
    }
}
