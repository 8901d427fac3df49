//! Crewed aircraft: straight legs, standard turns, climbs, and an aerodrome's circuit. Also the aerodrome's vehicles.

use nalgebra::{Vector2, Vector3};

use super::animal::middle;
use super::{FlightPath, KinematicState, STEP_S, towards, turn};
use crate::scenario::{Airspace, Crewed, Span};
use crate::streams::RandomStream;

/// Time constant with which a turn begins and ends, seconds.
const ROLL_S: f64 = 1.5;
/// Time constant with which a climb begins and ends, seconds.
const PITCH_S: f64 = 2.0;
/// Speeds of vehicles, metres per second.
const VEHICLE_M_S: Span = Span::new(5.0, 14.0);
const VEHICLE_TURN_DEG_S: f64 = 25.0;
/// Height of a vehicle's antenna, metres.
const VEHICLE_AGL_M: f64 = 2.0;
/// Height over the runway, metres above ground.
const FLARE_AGL_M: f64 = 8.0;

/// Performance of an aircraft or vehicle.
struct CrewedPerformance {
    speed_m_s: f64,
    /// Rate of turn, radians per second.
    turn: f64,
    climb_m_s: f64,
}

/// Flight from leg to leg over the middle of the airspace, turning back at the radius.
pub fn transit(
    model: &Crewed,
    airspace: &Airspace,
    steps: usize,
    (radius_m, speed_m_s): (f64, Span),
    stream: &mut RandomStream,
) -> FlightPath {
    let performance = performance(model, stream.within(speed_m_s));
    let (centre, heights, across_m) = (middle(airspace), model.height_agl_m, airspace.radius_m);
    let begins = stream.heading();
    let (mut bearing, mut is_far) = (begins, true);
    let mut next = |stream: &mut RandomStream| {
        // Waypoints alternate between the edge and the far side of the middle.
        is_far = !is_far;
        let place = if is_far {
            bearing += std::f64::consts::PI + stream.within(Span::new(-0.7, 0.7));
            towards(bearing) * radius_m
        } else {
            towards(stream.heading()) * (across_m * stream.within(Span::new(0.0, 1.0)))
        };
        (centre + place).push(stream.within(heights))
    };
    let share = stream.within(Span::new(0.3, 1.0));
    let start = (centre + towards(begins) * (radius_m * share)).push(stream.within(heights));
    fly(&performance, steps, start, &mut next, stream)
}

/// Flight around the circuit, from a random point in it.
pub fn circuit(model: &Crewed, steps: usize, stream: &mut RandomStream) -> FlightPath {
    let performance = performance(model, stream.within(model.circuit_speed_m_s));
    let aerodrome = Vector2::new(model.aerodrome_east_m, model.aerodrome_north_m);
    let along = towards(model.runway_deg.to_radians());
    let across = towards(model.runway_deg.to_radians() - std::f64::consts::FRAC_PI_2);
    let (half_m, width_m, top_m) = (model.circuit_length_m / 2.0, model.circuit_width_m, model.circuit_agl_m);
    // Touch and go, upwind, crosswind, downwind, base, final.
    let corners = [
        (0.0, 0.0, FLARE_AGL_M),
        (half_m, 0.0, 0.6 * top_m),
        (half_m, width_m, top_m),
        (-half_m, width_m, top_m),
        (-half_m, 0.0, 0.4 * top_m),
    ]
    .map(|(forward, left, up)| (aerodrome + along * forward + across * left).push(up));
    let mut corner = stream.below(corners.len());
    let share = stream.within(Span::new(0.0, 0.7));
    let start = corners[corner].lerp(&corners[(corner + 1) % corners.len()], share);
    fly(
        &performance,
        steps,
        start,
        &mut |_| {
            corner = (corner + 1) % corners.len();
            corners[corner]
        },
        stream,
    )
}

/// Straight, level flight that meets the drone at its height, with a lateral miss distance, and climbs 10 s later.
pub fn conflict(model: &Crewed, drone: &FlightPath, steps: usize, stream: &mut RandomStream) -> FlightPath {
    let duration_s = (steps - 1) as f64 * STEP_S;
    let meets_s = duration_s * stream.within(model.meets_at);
    let speed_m_s = stream.within(model.helicopter_speed_m_s);
    let heading = stream.heading();
    let miss_m = stream.within(model.miss_m) * if stream.chance(0.5) { 1.0 } else { -1.0 };
    let side = towards(heading + std::f64::consts::FRAC_PI_2) * miss_m;
    let place = drone.at(meets_s).position + side.push(0.0);
    let samples = (0..steps).map(|step| {
        let since_s = step as f64 * STEP_S - meets_s;
        let climb_m_s = if since_s > 10.0 { model.climb_m_s.min(3.0) } else { 0.0 };
        let velocity = (towards(heading) * speed_m_s).push(climb_m_s);
        let position =
            place + (towards(heading) * speed_m_s * since_s).push(climb_m_s * (since_s - 10.0).max(0.0));
        KinematicState { position, velocity }
    });
    FlightPath(samples.collect())
}

/// Drive to and fro over the aerodrome's ground.
pub fn surface(model: &Crewed, steps: usize, stream: &mut RandomStream) -> FlightPath {
    let aerodrome = Vector2::new(model.aerodrome_east_m, model.aerodrome_north_m);
    let along = towards(model.runway_deg.to_radians());
    let across = towards(model.runway_deg.to_radians() + std::f64::consts::FRAC_PI_2);
    let mut next = move |stream: &mut RandomStream| {
        let forward_m = stream.within(Span::new(-700.0, 700.0));
        let right_m = stream.within(Span::new(60.0, 300.0));
        (aerodrome + along * forward_m + across * right_m).push(VEHICLE_AGL_M)
    };
    let performance = CrewedPerformance {
        speed_m_s: stream.within(VEHICLE_M_S),
        turn: VEHICLE_TURN_DEG_S.to_radians(),
        climb_m_s: 0.0,
    };
    let start = next(stream);
    fly(&performance, steps, start, &mut next, stream)
}

fn performance(model: &Crewed, speed_m_s: f64) -> CrewedPerformance {
    CrewedPerformance { speed_m_s, turn: model.turn_deg_s.to_radians(), climb_m_s: model.climb_m_s }
}

/// Flight at constant speed over the waypoints from `next`, with the turns and climbs that the motion allows.
fn fly(
    performance: &CrewedPerformance,
    steps: usize,
    start: Vector3<f64>,
    next: &mut dyn FnMut(&mut RandomStream) -> Vector3<f64>,
    stream: &mut RandomStream,
) -> FlightPath {
    let radius_m = performance.speed_m_s / performance.turn;
    let mut target = next(stream);
    let mut heading = {
        let to = target - start;
        to.x.atan2(to.y)
    };
    let (mut rate, mut climb, mut position) = (0.0, 0.0_f64, start);
    let mut samples = Vec::with_capacity(steps);
    for _ in 0..steps {
        let velocity = (towards(heading) * performance.speed_m_s).push(climb);
        samples.push(KinematicState { position, velocity });
        if (target - position).xy().norm() < radius_m {
            target = next(stream);
        }
        let to = target - position;
        let off = turn(heading, to.x.atan2(to.y));
        // A waypoint inside the turning circle would be circled for ever: fly straight on until it is outside.
        let inside = to.xy().norm() < 2.0 * radius_m && off.abs() > 1.2;
        let wanted = if inside { 0.0 } else { (off * 0.5).clamp(-performance.turn, performance.turn) };
        rate += (wanted - rate) * (STEP_S / ROLL_S);
        let left_s = (to.xy().norm() / performance.speed_m_s).max(5.0);
        let climb_wanted = (to.z / left_s).clamp(-performance.climb_m_s, performance.climb_m_s);
        climb += (climb_wanted - climb) * (STEP_S / PITCH_S);
        heading += rate * STEP_S;
        position += (velocity + (towards(heading) * performance.speed_m_s).push(climb)) * (0.5 * STEP_S);
    }
    FlightPath(samples)
}
