//! Output for a drone while its transponder is flagged.

use std::collections::BTreeSet;

use fusion::slots::Slot;
use serde::Serialize;

use super::IntegrityFlight;
use super::attacks::Attack;
use super::flags::{FlaggedPoint, flag_intervals};
use crate::evaluate::metrics::nees;
use crate::evaluate::scored_point::ScoredPoint;
use crate::evaluate::truth::TrueTrack;
use crate::evaluate::types::OutputPoint;

/// Maximum horizontal distance from the truth at which a point shows the drone, metres.
const NEAR_M: f64 = 60.0;

/// Points of a drone while its transponder is flagged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FlaggedCoverage {
    /// Number of slots with a plot of the drone, of a track that is not seduced.
    pub seen_slots: u64,
    /// Number of these slots with a point within 60 m of the drone.
    pub near_slots: u64,
    /// Number of points of the transponder that have a covariance.
    pub points: u64,
    /// Sum of half the normalised error squared over ground for these points; 1 per point for consistent covariances.
    pub squares: f64,
}

impl FlaggedCoverage {
    /// Score for an attack. `flagged` and `own` are the flagged points and all points of its transponder; `points` are
    /// the counted points of the output, of all drones.
    pub(super) fn of<'a>(
        attack: &Attack,
        (flagged, own): (&[FlaggedPoint], impl Iterator<Item = &'a OutputPoint>),
        drone: (usize, &TrueTrack),
        points: &[ScoredPoint<'_>],
        flight: &IntegrityFlight<'_>,
    ) -> Self {
        let grid = flight.settings.grid;
        let flag_intervals = flag_intervals(flagged);
        let is_flagged = |slot: Slot| {
            flag_intervals.iter().any(|stretch| (stretch.first.slot..=stretch.last.slot).contains(&slot))
        };
        let (index, truth) = drone;
        let plots = flight.labels.plots_of(&attack.id).filter(|plot| !plot.seduced);
        let seen: BTreeSet<Slot> = plots
            .map(|plot| grid.of(plot.time))
            .filter(|&slot| is_flagged(slot) && truth.at(grid.centre(slot)).is_some())
            .collect();
        let near = points
            .iter()
            .filter(|scored_point| scored_point.drone == Some(index) && seen.contains(&scored_point.slot));
        let near = near
            .filter(|scored_point| scored_point.error.is_some_and(|error| error.horizontal_m() <= NEAR_M));
        let near: BTreeSet<Slot> = near.map(|scored_point| scored_point.slot).collect();
        let mut shown =
            Self { seen_slots: seen.len() as u64, near_slots: near.len() as u64, ..Self::default() };
        for point in own.filter(|point| is_attack(point, attack)) {
            let Some((truth, covariance)) = truth.at(point.time).zip(point.covariance) else { continue };
            if let Some(square) = nees::of_plane(&point.place.offset_from(&truth), &covariance) {
                shown.points += 1;
                shown.squares += square;
            }
        }
        shown
    }

    /// Adds another score.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            seen_slots: self.seen_slots + other.seen_slots,
            near_slots: self.near_slots + other.near_slots,
            points: self.points + other.points,
            squares: self.squares + other.squares,
        }
    }

    /// Share of the slots with a plot of the drone that have a point near it.
    pub fn near_share(&self) -> Option<f64> {
        (self.seen_slots > 0).then(|| self.near_slots as f64 / self.seen_slots as f64)
    }

    /// Mean of half the normalised error squared over ground.
    pub fn nees(&self) -> Option<f64> {
        (self.points > 0).then(|| self.squares / self.points as f64)
    }
}

/// Whether a point of the attacked transponder is flagged during the attack.
fn is_attack(point: &OutputPoint, attack: &Attack) -> bool {
    point.flags.integrity.is_some_and(|(state, _)| state.is_flagged())
        && (attack.from..attack.until).contains(&point.time)
}
