//! Identities that are not heard, and the aircraft seen by radar alone that each of them explains.

use nalgebra::{Matrix2, Vector2};

use crate::integrity::ReportRules;
use crate::operational::cycle::Cycle;
use crate::operational::targets::{Target, Targets};
use crate::point::Point;
use crate::time::Time;

/// An identity explains an aircraft for so many seconds of its silence, and where it has not been heard before, so many seconds
/// before its first report;
const LOST_S: f64 = 120.0;
/// within so many deviations of where it would be.
const LOST_SIGMAS: f64 = 3.0;
/// What was seen for longer than this before its last report, seconds, is another one: it was heard elsewhere then.
const BEFORE_S: f64 = 2.0;
/// Away from its report the sigma of each axis grows by so many m/s where it is no target: the speed of a drone that flies on.
const AWAY_M_S: f64 = 15.0;

/// Where an identity would be that is not heard at the slot.
struct Lost {
    /// Its last report up to the slot; `None`: it had not been heard often enough by then to be known from anything else.
    heard: Option<Time>,
    /// Over ground.
    place: Vector2<f64>,
    covariance: Matrix2<f64>,
}

/// Takes off the points that nothing explains what each of those that are not heard does: one, the likeliest.
pub(super) fn explain(points: &mut [Point], reports: &ReportRules, targets: &Targets, cycle: &Cycle) {
    let unexplained = points.iter().filter(|point| point.is_unexplained);
    if let Some(newest) = unexplained.map(|point| point.first_seen).max() {
        assign(points, all(newest, reports, targets, cycle));
    }
}

fn assign(points: &mut [Point], all: impl Iterator<Item = Lost>) {
    for lost in all {
        let unexplained = points.iter_mut().filter(|point| point.is_unexplained);
        let near = unexplained.filter_map(|point| Some((lost.sigmas(point)?, point)));
        let likeliest = near.min_by(|(one, _), (other, _)| one.total_cmp(other));
        if let Some((sigmas, point)) = likeliest {
            point.is_unexplained = sigmas >= LOST_SIGMAS;
        }
    }
}

/// Those that are not heard at the slot, but for those that were heard elsewhere when the newest aircraft was seen first.
fn all(newest: Time, reports: &ReportRules, targets: &Targets, cycle: &Cycle) -> impl Iterator<Item = Lost> {
    reports.newest().filter_map(move |(identity, heard, place, is_known)| {
        let away_s = cycle.centre.seconds_since(heard).abs();
        if away_s >= LOST_S {
            return None;
        }
        let target = targets.of_identity(identity).and_then(|id| targets.get(id));
        // The end of a gap may be known already.
        let until = |target: &Target| target.transponder()?.last_until(cycle.centre);
        let heard = target.map_or((heard <= cycle.centre).then_some(heard), until).filter(|_| is_known);
        // Most are heard all the time: where they would be is not worked out for nothing.
        if heard.is_some_and(|heard| is_another(newest, heard))
            || target.is_some_and(|target| target.on_curve(cycle.centre, cycle.settings).is_some())
        {
            return None;
        }
        let (place, covariance) = match target.and_then(|target| target.estimate(cycle.centre)) {
            Some(estimate) => (estimate.position.0.xy(), estimate.horizontal),
            None => (place.0.xy(), Matrix2::identity() * (AWAY_M_S * away_s).powi(2)),
        };
        Some(Lost { heard, place, covariance })
    })
}

/// Whether what was seen first then is another one than who was heard last at `heard`.
fn is_another(first_seen: Time, heard: Time) -> bool {
    first_seen.seconds_since(heard) < -BEFORE_S
}

impl Lost {
    /// How far an aircraft is from where it would be, in deviations; `None`: it is another one.
    fn sigmas(&self, point: &Point) -> Option<f64> {
        if self.heard.is_some_and(|heard| is_another(point.first_seen, heard)) {
            return None;
        }
        let own = point.estimate.map_or_else(Matrix2::zeros, |estimate| estimate.horizontal);
        let apart = point.position.0.xy() - self.place;
        let inverse = (self.covariance + own).try_inverse()?;
        Some(apart.dot(&(inverse * apart)).sqrt())
    }
}

#[cfg(test)]
mod tests;
