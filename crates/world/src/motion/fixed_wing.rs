//! Fixed wings: constant speed, turns with limited bank, loiter at some waypoints.

use nalgebra::Vector3;

use super::{FlightPath, KinematicState, STEP_S, towards, turn};
use crate::scenario::FixedWing;
use crate::streams::RandomStream;

const GRAVITY_M_S2: f64 = 9.81;
/// Time constant with which the bank follows the autopilot, seconds.
const ROLL_S: f64 = 1.0;

/// Flight of `steps` samples from `start` over the waypoints from `next`.
pub(super) fn fly(
    model: &FixedWing,
    steps: usize,
    start: Vector3<f64>,
    mut next: impl FnMut(&mut RandomStream) -> Vector3<f64>,
    stream: &mut RandomStream,
) -> FlightPath {
    let speed = stream.within(model.speed_m_s);
    // Rate of turn at bank phi: g tan(phi) / v.
    let fastest = GRAVITY_M_S2 * model.bank_deg.to_radians().tan() / speed;
    let radius_m = speed / fastest;
    let mut target = next(stream);
    let mut heading = {
        let to = target - start;
        to.x.atan2(to.y)
    };
    let mut rate = 0.0;
    let mut climb = 0.0_f64;
    let mut loiter_until: Option<usize> = None;
    let mut position = start;
    let mut samples = Vec::with_capacity(steps);
    for step in 0..steps {
        let velocity = (towards(heading) * speed).push(climb);
        samples.push(KinematicState { position, velocity });
        if loiter_until.is_some_and(|until| step >= until) {
            loiter_until = None;
            target = next(stream);
        }
        let to = target - position;
        if loiter_until.is_none() && to.xy().norm() < radius_m {
            if stream.chance(model.loiter_share) {
                loiter_until = Some(step + (stream.within(model.loiter_s) / STEP_S) as usize);
            } else {
                target = next(stream);
            }
        }
        // A loiter is a circle at two thirds of the maximum rate of turn.
        let wanted = match loiter_until {
            Some(_) => fastest * 2.0 / 3.0,
            None => {
                let off = turn(heading, to.x.atan2(to.y));
                // A waypoint inside the turning circle would be circled for ever: fly straight on until it is outside.
                let inside = to.xy().norm() < 2.0 * radius_m && off.abs() > 1.2;
                if inside { 0.0 } else { (off * 0.8).clamp(-fastest, fastest) }
            }
        };
        rate += (wanted - rate) * (STEP_S / ROLL_S);
        let climb_wanted = (to.z / 8.0).clamp(-model.climb_m_s, model.climb_m_s);
        climb += (climb_wanted - climb) * STEP_S;
        heading += rate * STEP_S;
        position += (velocity + (towards(heading) * speed).push(climb)) * (0.5 * STEP_S);
    }
    FlightPath(samples)
}
