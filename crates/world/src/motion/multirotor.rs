//! Multirotors: straight legs, corners flown with limited acceleration, hover at some waypoints.

use nalgebra::Vector3;

use super::{FlightPath, KinematicState, STEP_S};
use crate::scenario::Multirotor;
use crate::streams::RandomStream;

/// Flight of `steps` samples from `start` over the waypoints from `next`.
pub(super) fn fly(
    model: &Multirotor,
    steps: usize,
    start: Vector3<f64>,
    mut next: impl FnMut(&mut RandomStream) -> Vector3<f64>,
    stream: &mut RandomStream,
) -> FlightPath {
    let cruise = stream.within(model.speed_m_s);
    let acceleration = stream.within(model.acceleration_m_s2);
    // A corner flown at cruise speed is about as wide as the circle that this acceleration allows.
    let corner_m = cruise * cruise / acceleration;
    let mut state = KinematicState { position: start, velocity: Vector3::zeros() };
    let mut samples = Vec::with_capacity(steps);
    let mut target = next(stream);
    let mut stops = stream.chance(model.hover_share);
    let mut hover_until: Option<usize> = None;
    for step in 0..steps {
        samples.push(state);
        if hover_until.is_some_and(|until| step >= until) {
            hover_until = None;
            (target, stops) = (next(stream), stream.chance(model.hover_share));
        }
        let to = target - state.position;
        let distance = to.xy().norm();
        let arrived = if stops { distance < 1.0 && state.velocity.norm() < 1.0 } else { distance < corner_m };
        if arrived && hover_until.is_none() {
            if stops {
                hover_until = Some(step + (stream.within(model.hover_s) / STEP_S) as usize);
            } else {
                (target, stops) = (next(stream), stream.chance(model.hover_share));
            }
        }
        let wanted = if hover_until.is_some() {
            // Hold the position.
            to * 0.5
        } else {
            // Slow enough to stop in time; the factor 0.7 is a margin for the time step.
            let speed = if stops { cruise.min((2.0 * 0.7 * acceleration * distance).sqrt()) } else { cruise };
            let along = to.xy().try_normalize(1e-9).unwrap_or_default() * speed;
            let left_s = (distance / speed.max(0.5)).max(1.0);
            Vector3::new(along.x, along.y, (to.z / left_s).clamp(-model.climb_m_s, model.climb_m_s))
        };
        let change = (wanted - state.velocity).cap_magnitude(acceleration * STEP_S);
        let velocity = state.velocity + change;
        state = KinematicState {
            position: state.position + (state.velocity + velocity) * (0.5 * STEP_S),
            velocity,
        };
    }
    FlightPath(samples)
}
