//! Fixed wings: constant speed, turns with limited bank, loiter at some waypoints.

use nalgebra::Vector3;

use super::{Kinematics, Path, STEP_S, towards, turn};
use crate::scenario::FixedWing;
use crate::streams::Stream;

const GRAVITY_M_S2: f64 = 9.81;
/// Bank follows the autopilot with this time constant, seconds.
const ROLL_S: f64 = 1.0;

/// A flight of `steps` samples from `start` over the waypoints that `next` gives.
pub(super) fn fly(
    model: &FixedWing,
    steps: usize,
    start: Vector3<f64>,
    mut next: impl FnMut(&mut Stream) -> Vector3<f64>,
    stream: &mut Stream,
) -> Path {
    let speed = stream.within(model.speed_m_s);
    // Bank phi turns by g tan(phi) / v.
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
        samples.push(Kinematics { position, velocity });
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
        // In loiter: a circle at two thirds of the steepest turn.
        let wanted = match loiter_until {
            Some(_) => fastest * 2.0 / 3.0,
            None => {
                let off = turn(heading, to.x.atan2(to.y));
                // A waypoint inside the turning circle would be circled for ever: fly on until it is outside.
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
    Path(samples)
}
