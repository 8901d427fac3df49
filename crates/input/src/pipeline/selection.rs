//! Selects the reports for a cell: those inside it or in a halo around it.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use fusion::frames::TangentPlane;
use fusion::time::Time;
use fusion::{Departed, Identity, RadarTrackKey, Report};
use site::territory::Outline;

/// Time for which an aircraft is still passed on after leaving: it may return.
const FOLLOWED: SignedDuration = SignedDuration::from_secs(25);
/// Time for which a silent track or transponder is remembered.
const REMEMBERED: SignedDuration = SignedDuration::from_mins(10);

/// Reports that belong to a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Selection {
    cell: Outline,
    halo_m: f64,
    tracks: BTreeMap<RadarTrackKey, Inside>,
    transponders: BTreeMap<Identity, Inside>,
    /// Time of the last search for tracks and transponders that have left.
    looked: Option<Time>,
}

/// A radar track or transponder that was inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Inside {
    /// Time of the latest report from inside.
    latest: Time,
    /// Whether a later report came from outside.
    is_out: bool,
}

impl Selection {
    /// Selects reports in the cell or at most `halo_m` metres outside of it.
    pub const fn new(cell: Outline, halo_m: f64) -> Self {
        Self { cell, halo_m, tracks: BTreeMap::new(), transponders: BTreeMap::new(), looked: None }
    }

    /// Whether a report belongs to this cell, by its position. A radar track or transponder that was inside belongs to the cell
    /// until it has been outside for 25 s. A bearing has no position and belongs to every cell.
    pub(super) fn takes(&mut self, report: &Report, frame: &TangentPlane) -> bool {
        let is_inside = |position| self.cell.is_within(frame.to_geodetic(position), self.halo_m);
        match report {
            Report::Bearing(_) => true,
            Report::Fix(fix) => note(&mut self.transponders, fix.identity, fix.time, is_inside(fix.position)),
            Report::Plot(plot) => note(&mut self.tracks, plot.track, plot.time, is_inside(plot.position)),
        }
    }

    /// The tracks and transponders that have left by `now`; searched once a second.
    pub(super) fn left(&mut self, now: Time) -> Vec<Departed> {
        if self.looked.is_some_and(|looked| now - looked < SignedDuration::from_secs(1)) {
            return Vec::new();
        }
        self.looked = Some(now);
        let tracks = leave(&mut self.tracks, now).into_iter().map(Departed::Track);
        let transponders = leave(&mut self.transponders, now).into_iter().map(Departed::Transponder);
        tracks.chain(transponders).collect()
    }
}

fn note<K: Ord>(known: &mut BTreeMap<K, Inside>, who: K, time: Time, is_inside: bool) -> bool {
    match known.get_mut(&who) {
        Some(inside) if is_inside => *inside = Inside { latest: time.max(inside.latest), is_out: false },
        Some(inside) => {
            inside.is_out = true;
            return time - inside.latest <= FOLLOWED;
        }
        None if is_inside => _ = known.insert(who, Inside { latest: time, is_out: false }),
        None => return false,
    }
    true
}

fn leave<K: Ord + Copy>(known: &mut BTreeMap<K, Inside>, now: Time) -> Vec<K> {
    let is_left = |inside: &Inside| inside.is_out && now - inside.latest > FOLLOWED;
    let left = known.iter().filter(|(_, inside)| is_left(inside)).map(|(who, _)| *who).collect();
    known.retain(|_, inside| !is_left(inside) && now - inside.latest <= REMEMBERED);
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::frames::Geodetic;
    use fusion::{Enu, Fix, Plot, SensorIndex};
    use site::territory::{CellName, Territory};

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

    fn fix(second: i64, north_m: f64) -> Report {
        let time = Time::from_nanos(second * 1_000_000_000);
        Report::Fix(Fix::new(SENSOR, Identity::of_address(1), time, Enu::new(0.0, north_m, 100.0)))
    }

    #[test]
    fn aircraft_is_kept_for_25_s_after_leaving() {
        let (mut selection, frame) = selection();
        let at = |second: i64| Time::from_nanos(second * 1_000_000_000);
        // An aircraft from the south belongs to the cell only once it is in the halo.
        assert!(!selection.takes(&plot(1, 0, -1010.0), &frame) && !selection.takes(&fix(0, -1010.0), &frame));
        assert!(selection.takes(&plot(1, 1, -990.0), &frame) && selection.takes(&fix(1, -990.0), &frame));
        for second in [2, 26] {
            assert!(selection.takes(&plot(1, second, -1500.0), &frame));
            assert!(selection.takes(&fix(second, -1500.0), &frame));
        }
        assert_eq!(selection.left(at(26)), []);
        assert!(
            !selection.takes(&plot(1, 27, -1500.0), &frame) && !selection.takes(&fix(27, -1500.0), &frame)
        );
        assert!(!selection.takes(&plot(2, 27, -1010.0), &frame), "another track");
        let key = RadarTrackKey { sensor: SENSOR, number: 1 };
        assert_eq!(
            selection.left(at(27)),
            [Departed::Track(key), Departed::Transponder(Identity::of_address(1))]
        );
        assert_eq!(selection.left(at(28)), []);
    }

    #[test]
    fn silent_aircraft_inside_has_not_left() {
        let (mut selection, frame) = selection();
        assert!(selection.takes(&fix(0, 500.0), &frame) && selection.takes(&plot(1, 0, 500.0), &frame));
        for second in 1..700 {
            assert_eq!(selection.left(Time::from_nanos(second * 1_000_000_000)), []);
        }
        assert!(selection.tracks.is_empty() && selection.transponders.is_empty(), "remembered for good");
    }
}
