//! Silent identities, and the aircraft detected only by radar that each of them explains.

use nalgebra::{Matrix2, Vector2};

use crate::integrity::ReportRules;
use crate::operational::cycle::Cycle;
use crate::operational::targets::{Target, Targets};
use crate::point::Point;
use crate::time::Time;

/// Duration of a silence for which an identity explains an aircraft, seconds; also the time before the first report of
/// an identity.
const LOST_S: f64 = 120.0;
/// Maximum distance to its expected position, standard deviations.
const LOST_SIGMAS: f64 = 3.0;
/// Margin, seconds: an aircraft that was detected this long before the identity's last report is another one.
const BEFORE_S: f64 = 2.0;
/// Growth of the standard deviation of each axis for an identity without a target, m/s: the speed of a drone that flies
/// on.
const AWAY_M_S: f64 = 15.0;

/// Expected position of an identity that is silent at the slot.
struct LostIdentity {
    /// Time of its last report up to the slot; `None`: until then it had too few reports to be recognised.
    heard: Option<Time>,
    /// Position over ground.
    place: Vector2<f64>,
    covariance: Matrix2<f64>,
}

/// Clears the mark of unexplained points: each silent identity explains one, the likeliest.
pub(super) fn explain(points: &mut [Point], reports: &ReportRules, targets: &Targets, cycle: &Cycle) {
    let unexplained = points.iter().filter(|point| point.is_unexplained);
    if let Some(newest) = unexplained.map(|point| point.first_seen).max() {
        assign(points, all(newest, reports, targets, cycle));
    }
}

fn assign(points: &mut [Point], all: impl Iterator<Item = LostIdentity>) {
    for lost in all {
        let unexplained = points.iter_mut().filter(|point| point.is_unexplained);
        let near = unexplained.filter_map(|point| Some((lost.sigmas(point)?, point)));
        let likeliest = near.min_by(|(one, _), (other, _)| one.total_cmp(other));
        if let Some((sigmas, point)) = likeliest {
            point.is_unexplained = sigmas >= LOST_SIGMAS;
        }
    }
}

/// The identities that are silent at the slot, except those that reported elsewhere when the newest aircraft was first
/// detected.
fn all(
    newest: Time,
    reports: &ReportRules,
    targets: &Targets,
    cycle: &Cycle,
) -> impl Iterator<Item = LostIdentity> {
    reports.newest().filter_map(move |(identity, heard, place, is_known)| {
        let away_s = cycle.centre.seconds_since(heard).abs();
        if away_s >= LOST_S {
            return None;
        }
        let target = targets.of_identity(identity).and_then(|id| targets.get(id));
        // The report that ends a gap may be known already.
        let until = |target: &Target| target.transponder()?.last_until(cycle.centre);
        let heard = target.map_or((heard <= cycle.centre).then_some(heard), until).filter(|_| is_known);
        // Most identities are not silent; their expected position is not computed.
        if heard.is_some_and(|heard| is_another(newest, heard))
            || target.is_some_and(|target| target.is_on_curve(cycle.centre, cycle.settings))
        {
            return None;
        }
        let (place, covariance) = match target.and_then(|target| target.estimate(cycle.centre)) {
            Some(estimate) => (estimate.position.0.xy(), estimate.horizontal),
            None => (place.0.xy(), Matrix2::identity() * (AWAY_M_S * away_s).powi(2)),
        };
        Some(LostIdentity { heard, place, covariance })
    })
}

/// Whether an aircraft first detected at `first_seen` is another one than the identity whose last report is at `heard`.
fn is_another(first_seen: Time, heard: Time) -> bool {
    first_seen.seconds_since(heard) < -BEFORE_S
}

impl LostIdentity {
    /// Distance of an aircraft from the expected position, in standard deviations; `None`: it is another aircraft.
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
