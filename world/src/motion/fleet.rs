//! The drones of a scenario, never closer to each other than the separation.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::animal::{anywhere, middle};
use super::{Path, fixed_wing, multirotor, towards};
use crate::scenario::{Airspace, Drones, Pattern, Scenario, Span};
use crate::streams::{Entity, Stream, Streams};

/// A drone for which no path keeps the separation.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no way was found for drone {drone} that stays clear of the {before} before it, in {tries} tries: use fewer drones, \
     a larger airspace or a smaller drones.separation_m"
)]
pub struct Crowded {
    drone: usize,
    before: usize,
    tries: u32,
}

/// Flights tried per drone.
const TRIES: u32 = 500;

/// The first number of a fixed wing in the random streams.
const WINGS: usize = 1 << 15;

/// The flights of all drones, multirotors first, then fixed wings, `steps` samples each.
///
/// One after another: a flight that would come too close to an earlier one is flown anew.
///
/// # Errors
/// The airspace is too crowded.
pub fn fleet(scenario: &Scenario, steps: usize, streams: &Streams) -> Result<Vec<Path>, Crowded> {
    let count = scenario.drone_count() as usize;
    let separation = scenario.drones.separation_m;
    let mut sky = Sky::new(separation);
    let mut paths = Vec::with_capacity(count);
    for drone in 0..count {
        let mut stream = streams.of(Entity::Drone, number(&scenario.drones, drone));
        let path = (0..TRIES)
            .map(|_| fly(scenario, drone, steps, &mut stream))
            .find(|path| separation == 0.0 || sky.is_clear(path))
            .ok_or(Crowded { drone: drone + 1, before: drone, tries: TRIES })?;
        if separation > 0.0 {
            sky.add(&path);
        }
        paths.push(path);
    }
    Ok(paths)
}

/// The drone's number in the random streams: each kind counts apart, so that another drone changes nothing for the rest.
pub fn number(drones: &Drones, drone: usize) -> usize {
    drone.checked_sub(drones.multirotors as usize).map_or(drone, |wing| WINGS + wing)
}

/// The flight of a multirotor that does not exist, anywhere in this airspace.
pub fn seeming(scenario: &Scenario, airspace: &Airspace, steps: usize, stream: &mut Stream) -> Path {
    let way = |stream: &mut Stream| anywhere(airspace, airspace.height_agl_m, stream);
    let start = way(stream);
    multirotor::fly(&scenario.multirotor, steps, start, way, stream)
}

/// Gives one waypoint after another.
type Way = dyn FnMut(&mut Stream) -> Vector3<f64>;

fn fly(scenario: &Scenario, drone: usize, steps: usize, stream: &mut Stream) -> Path {
    let airspace = scenario.airspace.clone();
    let mut way: Box<Way> = match scenario.drones.pattern {
        Pattern::Free => Box::new(move |stream| anywhere(&airspace, airspace.height_agl_m, stream)),
        Pattern::Crossing => Box::new(there_and_back(airspace, stream)),
    };
    let start = way(stream);
    if drone >= scenario.drones.multirotors as usize {
        fixed_wing::fly(&scenario.fixed_wing, steps, start, way, stream)
    } else {
        multirotor::fly(&scenario.multirotor, steps, start, way, stream)
    }
}

/// The two ends of a line through the airspace's centre, alternating; the first leg begins somewhere on it.
fn there_and_back(
    airspace: Airspace,
    stream: &mut Stream,
) -> impl FnMut(&mut Stream) -> Vector3<f64> + use<> {
    let direction = towards(stream.heading());
    let mut side = 1.0;
    let mut first = true;
    move |stream| {
        let share = if first { stream.within(Span::new(0.3, 1.0)) } else { 1.0 };
        first = false;
        side = -side;
        let place = middle(&airspace) + direction * (side * share * airspace.radius_m);
        place.push(stream.within(airspace.height_agl_m))
    }
}

/// Positions by time and by cell as wide as the separation.
struct Sky {
    separation: f64,
    places: HashMap<(u32, i32, i32), Vec<Vector3<f64>>>,
}

impl Sky {
    fn new(separation: f64) -> Self {
        Self { separation, places: HashMap::new() }
    }

    fn cell(&self, position: &Vector3<f64>) -> (i32, i32) {
        let index = |metres: f64| (metres / self.separation).floor() as i32;
        (index(position.x), index(position.y))
    }

    fn add(&mut self, path: &Path) {
        for (step, state) in path.samples().iter().enumerate() {
            let (x, y) = self.cell(&state.position);
            self.places.entry((step as u32, x, y)).or_default().push(state.position);
        }
    }

    /// Whether every sample of the path keeps the separation from all others.
    fn is_clear(&self, path: &Path) -> bool {
        path.samples().iter().enumerate().all(|(step, state)| {
            let (x, y) = self.cell(&state.position);
            let near =
                |dx: i32, dy: i32| self.places.get(&(step as u32, x + dx, y + dy)).into_iter().flatten();
            (-1..=1).all(|dx| {
                (-1..=1)
                    .all(|dy| near(dx, dy).all(|other| (other - state.position).norm() >= self.separation))
            })
        })
    }
}
