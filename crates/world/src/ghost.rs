//! Multipath ghosts: echoes of a drone by way of a wall or the ground, which arrive from farther away.

use std::f64::consts::FRAC_PI_3;

use nalgebra::Vector2;

use crate::motion::{FlightPath, KinematicState, RATE_HZ};
use crate::radar::RadarTarget;
use crate::scenario::{Radar, Span};
use crate::streams::{Entity, RandomStream, RandomStreams, radar_target};
use crate::transponder::episodes;

/// Number of the first ghost in the random streams; the drone's number is added.
const GHOSTS: usize = 1 << 25;

/// Path of an echo.
enum EchoPath {
    /// Reflection near the drone, in its direction; the value is the additional range, metres.
    Longer(f64),
    /// Reflection by a wall behind the drone, towards the drone's mirror image: a point on the wall and its unit
    /// normal.
    Mirrored(Vector2<f64>, Vector2<f64>),
}

/// Ghosts of the drones among `targets`, as radar number `index` sees them.
pub fn ghosts(
    radar: &Radar,
    index: usize,
    targets: &[RadarTarget],
    duration_s: f64,
    streams: &RandomStreams,
) -> Vec<RadarTarget> {
    if radar.ghost_share == 0.0 {
        return Vec::new();
    }
    let ghost = |target: &RadarTarget| {
        target.drone?;
        let mut stream = streams.of(Entity::Ghost, radar_target(index, target.number));
        let has_ghosts = stream.chance(radar.ghost_share);
        has_ghosts.then(|| of_drone(radar, target, duration_s, &mut stream))
    };
    targets.iter().filter_map(ghost).collect()
}

fn of_drone(radar: &Radar, target: &RadarTarget, duration_s: f64, stream: &mut RandomStream) -> RadarTarget {
    let uav_probability = stream.within(radar.drone_probability);
    let mut spans = episodes(radar.ghost_every_s, radar.ghost_s, duration_s, stream);
    let antenna = Vector2::new(radar.east_m, radar.north_m);
    let mut samples = target.path.samples().to_vec();
    let last = samples.len() - 1;
    for span in &mut spans {
        let step = |time_s: f64| ((time_s * RATE_HZ as f64) as usize).min(last);
        // Positions between two samples are interpolated, so the ghost needs one more sample.
        let (first, end) = (step(span.low), step(span.high) + 2);
        let echo_path = echo_path(radar, antenna, &samples[first], stream);
        for (step, sample) in samples.iter_mut().enumerate().take(end).skip(first) {
            match echo_path.echo(antenna, sample) {
                Some(echo) => *sample = echo,
                None => {
                    // The drone has reached the wall.
                    span.high = step.saturating_sub(1) as f64 / RATE_HZ as f64;
                    break;
                }
            }
        }
    }
    RadarTarget {
        number: GHOSTS + target.number,
        path: FlightPath::new(samples),
        drone: None,
        uav_probability,
        exists_s: Some(spans),
    }
}

fn echo_path(
    radar: &Radar,
    antenna: Vector2<f64>,
    drone: &KinematicState,
    stream: &mut RandomStream,
) -> EchoPath {
    let is_mirrored = stream.chance(0.5);
    let behind_m = stream.within(radar.ghost_m);
    let angle = stream.within(Span::new(-FRAC_PI_3, FRAC_PI_3));
    let sight = (drone.position.xy() - antenna).try_normalize(1e-9).unwrap_or_else(Vector2::y);
    if !is_mirrored {
        return EchoPath::Longer(behind_m);
    }
    let normal = nalgebra::Rotation2::new(angle) * sight;
    // The image is as far behind the wall as the drone is in front of it.
    EchoPath::Mirrored(drone.position.xy() + normal * (behind_m / 2.0), normal)
}

impl EchoPath {
    /// Position and velocity of the echo; `None` once the drone has passed the wall.
    fn echo(&self, antenna: Vector2<f64>, drone: &KinematicState) -> Option<KinematicState> {
        let (position, velocity) = (drone.position.xy(), drone.velocity.xy());
        let (position, velocity) = match *self {
            Self::Longer(by_m) => {
                let sight = position - antenna;
                let (range_m, direction) = (sight.norm(), sight.try_normalize(1e-9)?);
                let radial = direction * velocity.dot(&direction);
                let across = (velocity - radial) * ((range_m + by_m) / range_m);
                (position + direction * by_m, radial + across)
            }
            Self::Mirrored(wall, normal) => {
                let before_m = (wall - position).dot(&normal);
                let towards_m_s = velocity.dot(&normal);
                (before_m > 0.0).then(|| {
                    (position + normal * (2.0 * before_m), velocity - normal * (2.0 * towards_m_s))
                })?
            }
        };
        Some(KinematicState {
            position: position.push(drone.position.z),
            velocity: velocity.push(drone.velocity.z),
        })
    }
}
