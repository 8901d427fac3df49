//! Birds, vehicles and clutter: radar targets other than drones.

use nalgebra::{Vector2, Vector3};

use super::{FlightPath, KinematicState, STEP_S, towards, turn};
use crate::scenario::{Airspace, Birds, Clutter, Span};
use crate::streams::{Entity, GaussMarkov, RandomStream, RandomStreams};

/// Rate of turn of birds: standard deviation in rad/s and time constant in seconds (Gauss–Markov).
const WHEELING: (f64, f64) = (0.15, 5.0);
/// Rate of turn of vehicles: standard deviation in rad/s and time constant in seconds (Gauss–Markov).
const STEERING: (f64, f64) = (0.02, 10.0);
/// Time constant of the offsets within a flock, seconds.
const FLOCK_TIME_S: f64 = 8.0;

/// Paths of all birds: single birds first, then flock by flock.
pub fn birds(model: &Birds, airspace: &Airspace, steps: usize, streams: &RandomStreams) -> Vec<FlightPath> {
    let mut paths: Vec<FlightPath> = (0..model.count as usize)
        .map(|index| bird(model, airspace, steps, &mut streams.of(Entity::Bird, index)))
        .collect();
    for flock in 0..model.flocks as usize {
        let mut stream = streams.of(Entity::Flock, flock);
        let leader = bird(model, airspace, steps, &mut stream);
        paths.extend((0..model.flock_size).map(|_| follower(model, &leader, &mut stream)));
    }
    paths
}

/// Paths of vehicles, then of the fixed points on the ground.
pub fn clutter(
    model: &Clutter,
    airspace: &Airspace,
    steps: usize,
    streams: &RandomStreams,
) -> Vec<FlightPath> {
    let vehicle = |index| {
        let mut stream = streams.of(Entity::Vehicle, index);
        let start = anywhere(airspace, Span::new(1.5, 1.5), &mut stream);
        let speed = stream.within(model.vehicle_speed_m_s);
        wander(airspace, steps, start, speed, STEERING, &mut stream)
    };
    let point = |index| {
        let mut stream = streams.of(Entity::Clutter, index);
        FlightPath::standing(anywhere(airspace, Span::new(0.0, 15.0), &mut stream))
    };
    (0..model.vehicles as usize).map(vehicle).chain((0..model.points as usize).map(point)).collect()
}

fn bird(model: &Birds, airspace: &Airspace, steps: usize, stream: &mut RandomStream) -> FlightPath {
    let start = anywhere(airspace, model.height_agl_m, stream);
    let speed = stream.within(model.speed_m_s);
    wander(airspace, steps, start, speed, WHEELING, stream)
}

/// Random position in the airspace, uniform over its area.
pub(super) fn anywhere(airspace: &Airspace, height_agl_m: Span, stream: &mut RandomStream) -> Vector3<f64> {
    let radius = airspace.radius_m * stream.within(Span::new(0.0, 1.0)).sqrt();
    let place = middle(airspace) + towards(stream.heading()) * radius;
    place.push(stream.within(height_agl_m))
}

pub(super) fn middle(airspace: &Airspace) -> Vector2<f64> {
    Vector2::new(airspace.east_m, airspace.north_m)
}

/// Path at constant speed and height; its course wanders, and turns back at the edge of the airspace.
fn wander(
    airspace: &Airspace,
    steps: usize,
    start: Vector3<f64>,
    speed: f64,
    (deviation, time_s): (f64, f64),
    stream: &mut RandomStream,
) -> FlightPath {
    let mut position = start;
    let mut heading = stream.heading();
    let mut rate = GaussMarkov::new(deviation, time_s, 0.0, stream);
    let samples = (0..steps).map(|step| {
        let velocity = (towards(heading) * speed).push(0.0);
        let state = KinematicState { position, velocity };
        position += velocity * STEP_S;
        heading += rate.at(step as f64 * STEP_S, stream) * STEP_S;
        let home = middle(airspace) - position.xy();
        if home.norm() > airspace.radius_m {
            heading += turn(heading, home.x.atan2(home.y)).clamp(-0.3, 0.3) * STEP_S;
        }
        state
    });
    FlightPath(samples.collect())
}

/// Path of a bird in the leader's flock.
fn follower(model: &Birds, leader: &FlightPath, stream: &mut RandomStream) -> FlightPath {
    let spread = model.flock_spread_m;
    let mut offset = [spread, spread, spread / 3.0].map(|d| GaussMarkov::new(d, FLOCK_TIME_S, 0.0, stream));
    let mut next = |t_s: f64| Vector3::from(offset.each_mut().map(|axis| axis.at(t_s, stream)));
    // Offsets are drawn once per second, with a smooth path in between.
    let seconds = leader.samples().len().div_ceil(super::RATE_HZ) + 1;
    let knots: Vec<Vector3<f64>> = (0..seconds).map(|second| next(second as f64)).collect();
    let place = |step: usize| {
        let (second, part) = (step / super::RATE_HZ, (step % super::RATE_HZ) as f64 * STEP_S);
        knots[second].lerp(&knots[second + 1], part)
    };
    let samples = leader.samples().iter().enumerate().map(|(step, state)| {
        let mut position = state.position + place(step);
        position.z = position.z.max(2.0);
        let drift = if step > 0 { (place(step) - place(step - 1)) / STEP_S } else { Vector3::zeros() };
        KinematicState { position, velocity: state.velocity + drift }
    });
    FlightPath(samples.collect())
}
