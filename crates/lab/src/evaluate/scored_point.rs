//! Attribution of points to drones, their errors, and whether they count.

use super::counted_slots::CountedSlots;
use super::labels::Labels;
use super::place::{GeodeticPlace, LocalOffset};
use super::point_owner::{PointKind, PointOwner, PointOwners};
use super::truth::Truth;
use super::types::{ErrorSample, OutputPoint, PolarPlace, Scoring};
use fusion::slots::{Slot, SlotGrid};

/// A point that counts.
#[derive(Clone, Debug)]
pub(crate) struct ScoredPoint<'a> {
    pub(crate) point: &'a OutputPoint,
    pub(crate) slot: Slot,
    /// Drone of the point; `None`: not a drone.
    pub(crate) drone: Option<usize>,
    /// True position of the drone at the point's time.
    pub(crate) truth: Option<GeodeticPlace>,
    /// Error: from the true position to the point.
    pub(crate) error: Option<LocalOffset>,
    /// Whether its radar track and transponder belong to one drone; `None` if not scored.
    pub(crate) paired: Option<bool>,
    /// Whether its radar track was seduced at that time.
    pub(crate) seduced: bool,
    /// State of its drone; `None` without a drone, or if the truth does not determine it.
    pub(crate) state: Option<MotionState>,
}

/// State of a drone; the radar's errors differ between states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionState {
    /// Flies straight on, or hovers.
    Straight,
    /// Turns.
    Turning,
    /// The radar track is seduced, away from the drone.
    WalkedOff,
}

/// Reference data for scoring.
#[derive(Clone, Copy)]
pub(crate) struct ScoringReference<'a> {
    pub(crate) truth: &'a Truth,
    pub(crate) labels: Option<&'a Labels>,
    pub(crate) counted: &'a CountedSlots,
    pub(crate) grid: SlotGrid,
}

/// Returns the points that count, in the given order.
pub(crate) fn score_points<'a>(
    points: &'a [OutputPoint],
    kind: PointKind,
    reference: ScoringReference<'_>,
) -> Vec<ScoredPoint<'a>> {
    let ScoringReference { truth, labels, grid, .. } = reference;
    let mut owners = PointOwners::new(truth, labels, grid, kind);
    // Owners are found fastest slot by slot; the given order is restored afterwards.
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_key(|&place| grid.of(points[place].time));
    let mut scored_point: Vec<(usize, ScoredPoint<'a>)> = order
        .into_iter()
        .filter_map(|place| Some((place, score_point(&points[place], &mut owners, reference)?)))
        .collect();
    scored_point.sort_by_key(|(place, _)| *place);
    scored_point.into_iter().map(|(_, scored_point)| scored_point).collect()
}

/// Scores one point. `None` if it does not count: outside the drone's counted slots, or with an unknown true position.
fn score_point<'a>(
    point: &'a OutputPoint,
    owners: &mut PointOwners<'_>,
    reference: ScoringReference<'_>,
) -> Option<ScoredPoint<'a>> {
    let ScoringReference { truth, counted, grid, .. } = reference;
    let slot = grid.of(point.time);
    if !counted.run_contains(slot) {
        return None;
    }
    let finding = owners.find(point);
    let state = |drone: usize| match truth.tracks()[drone].turns(point.time) {
        _ if finding.walked_off => Some(MotionState::WalkedOff),
        turns => turns.map(|turns| if turns { MotionState::Turning } else { MotionState::Straight }),
    };
    let (drone, at) = match finding.owner {
        PointOwner::Drone(drone) if counted.contains(drone, slot) => {
            (Some(drone), Some(truth.tracks()[drone].at(point.time)?))
        }
        PointOwner::NoDrone => (None, None),
        PointOwner::Drone(_) | PointOwner::UnknownPosition => return None,
    };
    Some(ScoredPoint {
        point,
        slot,
        drone,
        truth: at,
        error: at.map(|at| point.place.offset_from(&at)),
        paired: finding.paired,
        seduced: finding.seduced,
        // The state is needed only to score a covariance.
        state: drone.filter(|_| point.covariance.is_some()).and_then(state),
    })
}

impl ScoredPoint<'_> {
    /// Published form of the point.
    pub(crate) fn sample(&self, settings: &Scoring) -> ErrorSample {
        ErrorSample {
            time: self.point.time,
            place: self.point.place,
            source: self.point.source,
            number: self.point.number,
            drone: self.drone,
            error: self.error,
            seen: settings
                .site
                .zip(self.truth)
                .map(|(site, truth)| PolarPlace::from(&truth.offset_from(&site))),
        }
    }
}

impl From<&LocalOffset> for PolarPlace {
    fn from(offset: &LocalOffset) -> Self {
        let azimuth_deg = offset.east_m.atan2(offset.north_m).to_degrees().rem_euclid(360.0);
        Self { range_m: offset.horizontal_m(), azimuth_deg }
    }
}
