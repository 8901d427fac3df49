//! True relative positions of pairs of drones.

use std::collections::BTreeSet;

use nalgebra::Vector2;

use crate::evaluate::truth::{TrueTrack, Truth};
use conflict::{Interval, interval_in_height, interval_over_ground};
use fusion::time::{SECOND, Time};

/// Time step along the true paths, nanoseconds.
const STEP_NS: i64 = SECOND / 4;
/// Minimum time between two violations of one pair, nanoseconds.
const APART_NS: i64 = 10 * SECOND;

/// The true paths.
pub(super) struct TruePaths<'a>(&'a Truth);

/// A violation: two drones within the volume of each other.
pub(super) struct Meeting {
    pub(super) pair: [usize; 2],
    pub(super) begin: Time,
}

/// Two drones at the time when they are closest to each other.
pub(super) struct Nearest {
    pub(super) pair: [usize; 2],
    pub(super) time: Time,
    /// 3-D distance, metres; over ground if a height is unknown.
    pub(super) distance_m: f64,
    /// Distance over ground, metres.
    pub(super) ground_m: f64,
}

/// The true paths within the horizon.
pub(super) struct TrueApproach {
    /// Time to the closest point of approach over ground, seconds.
    pub(super) after_s: f64,
    /// Miss vector from the first to the second at that time, east and north, metres.
    pub(super) miss: Vector2<f64>,
    /// Time at which the volume is first violated, seconds; `None`: it is not.
    pub(super) entry_s: Option<f64>,
}

/// Position and velocity of one drone relative to another.
#[derive(Clone, Copy)]
pub(super) struct RelativeMotion {
    position: Vector2<f64>,
    velocity: Vector2<f64>,
    height_m: f64,
    climb: f64,
}

impl RelativeMotion {
    /// Time to the closest point of approach over ground (seconds) and distance at it (metres), for straight flight.
    pub(super) fn closest(&self, horizon_s: f64) -> (f64, f64) {
        let squared = self.velocity.norm_squared();
        let t = if squared > 0.0 { -self.position.dot(&self.velocity) / squared } else { 0.0 };
        let t = t.clamp(0.0, horizon_s);
        (t, (self.position + self.velocity * t).norm())
    }

    /// Whether straight flight leads into the volume.
    pub(super) fn leads_into(&self, volume: (f64, f64), horizon_s: f64) -> bool {
        let ahead = Interval { entry_s: 0.0, exit_s: horizon_s };
        let ground = interval_over_ground(&self.position, &self.velocity, volume.0, 0.0);
        let above = interval_in_height(self.height_m, self.climb, volume.1);
        ground.zip(above).and_then(|(ground, above)| ground.and(above)?.and(ahead)).is_some()
    }
}

impl<'a> TruePaths<'a> {
    pub(super) fn of(truth: &'a Truth) -> Self {
        Self(truth)
    }

    /// Total flight time of the drones, hours.
    pub(super) fn hours(&self) -> f64 {
        let spans = self.0.tracks().iter().map(TrueTrack::span);
        spans.map(|(from, until)| until.seconds_since(from) / 3600.0).sum()
    }

    /// East and north, and up, from the first drone to the second.
    fn apart(&self, [a, b]: [usize; 2], at: Time) -> Option<(Vector2<f64>, Option<f64>)> {
        let tracks = self.0.tracks();
        let offset = tracks[b].at(at)?.offset_from(&tracks[a].at(at)?);
        Some((Vector2::new(offset.east_m, offset.north_m), offset.up_m))
    }

    pub(super) fn relative(&self, pair: [usize; 2], at: Time) -> Option<RelativeMotion> {
        let (position, height_m) = self.apart(pair, at)?;
        let (before, below_m) = self.apart(pair, Time::from_nanos(at.nanos() - SECOND / 2))?;
        let (after, above_m) = self.apart(pair, Time::from_nanos(at.nanos() + SECOND / 2))?;
        Some(RelativeMotion {
            position,
            velocity: after - before,
            height_m: height_m.unwrap_or(0.0),
            climb: above_m.zip(below_m).map_or(0.0, |(above_m, below_m)| above_m - below_m),
        })
    }

    /// The approach from `from` on; `None` if the truth does not cover the horizon.
    pub(super) fn approach(
        &self,
        pair: [usize; 2],
        from: Time,
        horizon_s: f64,
        (horizontal_m, vertical_m): (f64, f64),
    ) -> Option<TrueApproach> {
        let steps = (horizon_s * SECOND as f64) as i64 / STEP_NS;
        let (mut closest, mut entry_s): (Option<(f64, Vector2<f64>)>, Option<f64>) = (None, None);
        for step in 0..=steps {
            let at = Time::from_nanos(from.nanos() + step * STEP_NS);
            let (apart, height_m) = self.apart(pair, at)?;
            let after_s = at.seconds_since(from);
            if closest.is_none_or(|(_, miss)| apart.norm() < miss.norm()) {
                closest = Some((after_s, apart));
            }
            if apart.norm() < horizontal_m && height_m.is_none_or(|up_m| up_m.abs() < vertical_m) {
                entry_s = entry_s.or(Some(after_s));
            }
        }
        closest.map(|(after_s, miss)| TrueApproach { after_s, miss, entry_s })
    }

    /// Violations among these drones, pair by pair.
    pub(super) fn meetings(&self, drones: &BTreeSet<usize>, volume: (f64, f64)) -> Vec<Meeting> {
        let mut meetings = Vec::new();
        for &a in drones {
            for &b in drones.range(a + 1..) {
                let mut last: Option<Time> = None;
                for at in self.time_steps() {
                    let Some((apart, height_m)) = self.apart([a, b], at) else { continue };
                    if apart.norm() < volume.0 && height_m.is_none_or(|up_m| up_m.abs() < volume.1) {
                        if last.is_none_or(|last| at.nanos() - last.nanos() > APART_NS) {
                            meetings.push(Meeting { pair: [a, b], begin: at });
                        }
                        last = Some(at);
                    }
                }
            }
        }
        meetings
    }

    /// The two drones that come closest in 3-D, once both have flown for `flown_s` seconds.
    pub(super) fn nearest(&self, drones: &BTreeSet<usize>, flown_s: f64) -> Option<Nearest> {
        let mut nearest: Option<Nearest> = None;
        for &a in drones {
            for &b in drones.range(a + 1..) {
                let begun = self.0.tracks()[a].span().0.max(self.0.tracks()[b].span().0);
                for time in self.time_steps().filter(|time| time.seconds_since(begun) >= flown_s) {
                    let Some((over_ground, up_m)) = self.apart([a, b], time) else { continue };
                    let ground_m = over_ground.norm();
                    let distance_m = ground_m.hypot(up_m.unwrap_or(0.0));
                    if nearest.as_ref().is_none_or(|nearest| distance_m < nearest.distance_m) {
                        nearest = Some(Nearest { pair: [a, b], time, distance_m, ground_m });
                    }
                }
            }
        }
        nearest
    }

    /// Time steps over the span of the truth.
    fn time_steps(&self) -> impl Iterator<Item = Time> {
        let span = self.0.span().into_iter();
        span.flat_map(|(from, until)| time_steps(from, until))
    }
}

/// Time steps from one time to another.
pub(super) fn time_steps(from: Time, until: Time) -> impl Iterator<Item = Time> {
    let steps = (until.nanos() - from.nanos()) / STEP_NS;
    (0..=steps).map(move |step| Time::from_nanos(from.nanos() + step * STEP_NS))
}
