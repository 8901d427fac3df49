//! The encounter: two light aircraft that meet nearly head on, and their relative motion.
//!
//! Times are relative to the closest point of approach, negative before it. Coordinates are east, north, up, in metres;
//! the own ship is at the origin at the closest point.

use fusion::Enu;
use nalgebra::Vector3;
use tracker::{Observer, wrapped};

/// Speed of both aircraft, metres per second.
pub const SPEED: f64 = 39.0;
/// Final angle between their headings and the line of sight, degrees; they close at 75 m/s.
pub const OFF_DEG: f64 = 15.94;
/// Beginning and end of their turns towards each other, seconds: near the first detections by the radar and by the
/// camera.
const TURN_S: (f64, f64) = (-41.0, -31.0);
/// Additional angle before the turns, degrees; they close at 65.6 m/s.
pub const FURTHER_DEG: (f64, f64) = (16.0, 17.7);
/// Position of the intruder relative to the own ship at the closest point, for straight flight: to the side, and above,
/// metres.
pub const MISS_M: (f64, f64) = (12.0, 30.0);
/// Climb rate of the intruder before straight flight, metres per second.
const CLIMB: f64 = 1.0;
/// Beginning and time step of the paths, seconds.
const BEGIN_S: f64 = -50.0;
const STEP_S: f64 = 0.01;

/// Position and velocity.
#[derive(Clone, Copy, Debug)]
pub struct AircraftMotion {
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
}

/// Both aircraft, at intervals of [`STEP_S`] from [`BEGIN_S`] to the closest point.
pub struct SimulatedEncounter {
    own: Vec<AircraftMotion>,
    intruder: Vec<AircraftMotion>,
}

/// Motion of one aircraft relative to the other, as in the columns of Table 2. Metres and radians, and their rates.
#[derive(Clone, Copy, Debug)]
pub struct RelativeGeometry {
    pub range: f64,
    pub azimuth: f64,
    pub elevation: f64,
    pub range_rate: f64,
    pub azimuth_rate: f64,
    pub elevation_rate: f64,
}

impl RelativeGeometry {
    pub fn of(line: &Vector3<f64>, rate: &Vector3<f64>) -> Self {
        let (range, ground) = (line.norm(), line.x.hypot(line.y));
        let ground_rate = (line.x * rate.x + line.y * rate.y) / ground;
        Self {
            range,
            azimuth: line.x.atan2(line.y),
            elevation: line.z.atan2(ground),
            range_rate: line.dot(rate) / range,
            azimuth_rate: (line.y * rate.x - line.x * rate.y) / (ground * ground),
            elevation_rate: (ground * rate.z - line.z * ground_rate) / (range * range),
        }
    }

    /// Values in the units of Table 2: metres, degrees, seconds.
    pub fn columns(&self) -> [f64; 6] {
        let Self { range, azimuth, elevation, range_rate, azimuth_rate, elevation_rate } = *self;
        [
            range,
            azimuth.to_degrees(),
            elevation.to_degrees(),
            range_rate,
            azimuth_rate.to_degrees(),
            elevation_rate.to_degrees(),
        ]
    }

    /// Errors relative to the truth, in the units of [`RelativeGeometry::columns`].
    pub fn errors(&self, truth: &Self) -> [f64; 6] {
        let (mut errors, truth_columns) = (self.columns(), truth.columns());
        errors.iter_mut().zip(truth_columns).for_each(|(error, truth)| *error -= truth);
        errors[1] = wrapped(self.azimuth - truth.azimuth).to_degrees();
        errors
    }
}

impl SimulatedEncounter {
    pub fn fly() -> Self {
        // Integrates backwards from the end by the midpoint rule.
        let fly = |end: Vector3<f64>, course: fn(f64) -> Vector3<f64>| {
            let steps = (-BEGIN_S / STEP_S).round() as usize;
            let mut path = vec![AircraftMotion { position: end, velocity: course(0.0) }];
            for step in 1..=steps {
                let at = -STEP_S * step as f64;
                let next = path[step - 1].position - course(at + STEP_S / 2.0) * STEP_S;
                path.push(AircraftMotion { position: next, velocity: course(at) });
            }
            path.reverse();
            path
        };
        let own = fly(Vector3::zeros(), |at| heading(OFF_DEG + FURTHER_DEG.0 * turned(at)));
        let intruder = fly(Vector3::new(MISS_M.0, 0.0, MISS_M.1), |at| {
            -heading(-OFF_DEG - FURTHER_DEG.1 * turned(at)) + Vector3::z() * CLIMB * turned(at)
        });
        Self { own, intruder }
    }

    /// State of the own ship, from the beginning to the closest point.
    pub fn own(&self, at: f64) -> AircraftMotion {
        between(&self.own, at)
    }

    fn intruder(&self, at: f64) -> AircraftMotion {
        between(&self.intruder, at)
    }

    /// The own ship as an observer.
    pub fn observer(&self, at: f64) -> Observer {
        let AircraftMotion { position, velocity } = self.own(at);
        Observer { position: Enu::from(position), velocity }
    }

    /// Line of sight from the own ship to the intruder, and its rate.
    pub fn line(&self, at: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (own, intruder) = (self.own(at), self.intruder(at));
        (intruder.position - own.position, intruder.velocity - own.velocity)
    }

    pub fn relative(&self, at: f64) -> RelativeGeometry {
        let (line, rate) = self.line(at);
        RelativeGeometry::of(&line, &rate)
    }

    /// Time at which the aircraft are this far apart, seconds.
    pub fn when_apart(&self, range_m: f64) -> f64 {
        let places = self.own.iter().zip(&self.intruder);
        let step =
            places.take_while(|(own, intruder)| (intruder.position - own.position).norm() > range_m).count();
        BEGIN_S + STEP_S * step as f64
    }
}

/// Share of the turn that is still ahead: 1 before it, 0 after.
fn turned(at: f64) -> f64 {
    smooth((TURN_S.1 - at) / (TURN_S.1 - TURN_S.0))
}

/// Smooth step from 0 to 1, with zero slope at both ends.
fn smooth(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Velocity for a heading, clockwise from north.
fn heading(degrees: f64) -> Vector3<f64> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vector3::new(sin, cos, 0.0) * SPEED
}

fn between(path: &[AircraftMotion], at: f64) -> AircraftMotion {
    let place = ((at - BEGIN_S) / STEP_S).clamp(0.0, (path.len() - 1) as f64);
    let (before, after) = (path[place.floor() as usize], path[place.ceil() as usize]);
    let mix = |a: Vector3<f64>, b: Vector3<f64>| a + (b - a) * place.fract();
    AircraftMotion {
        position: mix(before.position, after.position),
        velocity: mix(before.velocity, after.velocity),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::approach::closest;

    #[test]
    fn encounter_matches_the_paper() {
        let encounter = SimulatedEncounter::fly();
        let first = encounter.when_apart(2950.0);
        assert!((first + 40.0).abs() < 0.5, "{first}");
        let (line, rate) = encounter.line(first);
        assert!((closest(&line, &rate).time_s - 45.0).abs() < 2.0);
        assert!((encounter.relative(-20.0).range_rate + 75.0).abs() < 0.1);
        assert!((encounter.when_apart(2250.0) + 30.0).abs() < 0.1);
        let (line, rate) = encounter.line(-10.0);
        let miss = closest(&line, &rate).miss.norm();
        assert!((20.0..50.0).contains(&miss), "a few tens of metres: {miss}");
    }

    #[test]
    fn rates_are_the_derivatives() {
        let encounter = SimulatedEncounter::fly();
        for at in [-38.0, -33.0, -20.0, -5.0] {
            let rates = encounter.relative(at).columns();
            let (after, before) = (encounter.relative(at + 0.05), encounter.relative(at - 0.05));
            let changes = after.errors(&before).map(|change| change / 0.1);
            for column in 0..3 {
                assert!((rates[3 + column] - changes[column]).abs() < 0.02, "{at}: {rates:?} {changes:?}");
            }
        }
    }
}
