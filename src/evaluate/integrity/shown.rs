//! What an output shows of a drone while its transponder is flagged.

use std::collections::BTreeSet;

use fusion::slots::Slot;
use serde::Serialize;

use super::Flight;
use super::attacks::Attack;
use super::flags::{Flagged, stretches};
use crate::evaluate::judged::Judged;
use crate::evaluate::metrics::nees;
use crate::evaluate::truth::TrueTrack;
use crate::evaluate::types::OutputPoint;

/// A point so near the truth shows the drone, metres over ground.
const NEAR_M: f64 = 60.0;

/// What is shown while the transponder is flagged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Shown {
    /// Slots with a plot of the drone, of a track that had not walked off.
    pub seen_slots: u64,
    /// Those among them with a point within 60 m of the drone.
    pub near_slots: u64,
    /// Points of the transponder that state a covariance.
    pub points: u64,
    /// Sum over them of the normalised error squared over ground, a half of it: 1 each where covariances are honest.
    pub squares: f64,
}

impl Shown {
    /// Of an attack: the flagged points of its transponder, and all of them; `points`: those of the output that count, of all
    /// drones.
    pub(super) fn of<'a>(
        attack: &Attack,
        (flagged, own): (&[Flagged], impl Iterator<Item = &'a OutputPoint>),
        drone: (usize, &TrueTrack),
        points: &[Judged<'_>],
        flight: &Flight<'_>,
    ) -> Self {
        let grid = flight.settings.grid;
        let stretches = stretches(flagged);
        let is_flagged = |slot: Slot| {
            stretches.iter().any(|stretch| (stretch.first.slot..=stretch.last.slot).contains(&slot))
        };
        let (index, truth) = drone;
        let plots = flight.labels.plots_of(&attack.id).filter(|plot| !plot.seduced);
        let seen: BTreeSet<Slot> = plots
            .map(|plot| grid.of(plot.time))
            .filter(|&slot| is_flagged(slot) && truth.at(grid.centre(slot)).is_some())
            .collect();
        let near = points.iter().filter(|judged| judged.drone == Some(index) && seen.contains(&judged.slot));
        let near = near.filter(|judged| judged.error.is_some_and(|error| error.horizontal_m() <= NEAR_M));
        let near: BTreeSet<Slot> = near.map(|judged| judged.slot).collect();
        let mut shown =
            Self { seen_slots: seen.len() as u64, near_slots: near.len() as u64, ..Self::default() };
        for point in own.filter(|point| is_lie(point, attack)) {
            let Some((truth, covariance)) = truth.at(point.time).zip(point.covariance) else { continue };
            if let Some(square) = nees::of_plane(&point.place.offset_from(&truth), &covariance) {
                shown.points += 1;
                shown.squares += square;
            }
        }
        shown
    }

    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            seen_slots: self.seen_slots + other.seen_slots,
            near_slots: self.near_slots + other.near_slots,
            points: self.points + other.points,
            squares: self.squares + other.squares,
        }
    }

    /// Slots with a point near the drone over slots with a plot of it.
    pub fn near_share(&self) -> Option<f64> {
        (self.seen_slots > 0).then(|| self.near_slots as f64 / self.seen_slots as f64)
    }

    /// Mean of the normalised error squared over ground, a half of it.
    pub fn nees(&self) -> Option<f64> {
        (self.points > 0).then(|| self.squares / self.points as f64)
    }
}

/// Whether a point of the attacked transponder is flagged, while it is attacked.
fn is_lie(point: &OutputPoint, attack: &Attack) -> bool {
    point.flags.integrity.is_some_and(|(state, _)| state.is_flagged())
        && (attack.from..attack.until).contains(&point.time)
}
