//! Paths of all drones, which keep the minimum separation from each other.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::animal::{anywhere, middle};
use super::formation::Formation;
use super::{FlightPath, fixed_wing, multirotor, towards};
use crate::scenario::{Airspace, Drones, Pattern, Scenario, Span};
use crate::streams::{Entity, RandomStream, RandomStreams};

/// No path was found for a drone that keeps the separation.
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

/// Maximum number of flights tried per drone.
const TRIES: u32 = 500;

/// Number of the first fixed wing in the random streams.
const WINGS: usize = 1 << 15;

/// Flights of all drones, `steps` samples each: multirotors first, then fixed wings.
///
/// Drones are placed one after another. A flight that comes too close to an earlier one is drawn again.
///
/// # Errors
/// [`Crowded`] if a drone finds no free path in 500 tries.
pub fn fleet(scenario: &Scenario, steps: usize, streams: &RandomStreams) -> Result<Vec<FlightPath>, Crowded> {
    let count = scenario.drone_count() as usize;
    let separation = scenario.drones.separation_m;
    let mut occupied = OccupiedSpace::new(separation);
    let formations = formations(scenario, steps, streams);
    let mut paths = Vec::with_capacity(count);
    for drone in 0..count {
        let mut stream = streams.of(Entity::Drone, number(&scenario.drones, drone));
        let path = (0..TRIES)
            .map(|_| match &formations {
                Some(formations) => member(&scenario.drones, formations, drone, &mut stream),
                None => fly(scenario, drone, steps, &mut stream),
            })
            .find(|path| separation == 0.0 || occupied.is_clear(path))
            .ok_or(Crowded { drone: drone + 1, before: drone, tries: TRIES })?;
        if separation > 0.0 {
            occupied.add(&path);
        }
        paths.push(path);
    }
    Ok(paths)
}

/// The formations of the multirotors and of the fixed wings; `None` for other patterns.
fn formations(scenario: &Scenario, steps: usize, streams: &RandomStreams) -> Option<[Formation; 2]> {
    let drones = &scenario.drones;
    (drones.pattern == Pattern::Formation).then(|| {
        let of = |kind: usize, first: u32, count: u32| {
            let mut stream = streams.of(Entity::Formation, kind);
            let leader = fly(scenario, first as usize, steps, &mut stream);
            Formation::new(leader, count as usize, drones.formation_m, &mut stream)
        };
        [of(0, 0, drones.multirotors), of(1, drones.multirotors, drones.fixed_wings)]
    })
}

/// Flight of one drone of a formation.
fn member(
    drones: &Drones,
    [multirotors, wings]: &[Formation; 2],
    drone: usize,
    stream: &mut RandomStream,
) -> FlightPath {
    match drone.checked_sub(drones.multirotors as usize) {
        None => multirotors.member(drone, stream),
        Some(wing) => wings.member(wing, stream),
    }
}

/// Number of a drone in the random streams. Each kind is counted separately, so that adding a drone leaves the others
/// unchanged.
pub fn number(drones: &Drones, drone: usize) -> usize {
    drone.checked_sub(drones.multirotors as usize).map_or(drone, |wing| WINGS + wing)
}

/// Flight of a fictitious multirotor, at random within this airspace.
pub fn seeming(
    scenario: &Scenario,
    airspace: &Airspace,
    steps: usize,
    stream: &mut RandomStream,
) -> FlightPath {
    let waypoints = |stream: &mut RandomStream| anywhere(airspace, airspace.height_agl_m, stream);
    let start = waypoints(stream);
    multirotor::fly(&scenario.multirotor, steps, start, waypoints, stream)
}

/// Generator of waypoints.
type WaypointSource = dyn FnMut(&mut RandomStream) -> Vector3<f64>;

fn fly(scenario: &Scenario, drone: usize, steps: usize, stream: &mut RandomStream) -> FlightPath {
    let airspace = scenario.airspace.clone();
    let mut waypoints: Box<WaypointSource> = match scenario.drones.pattern {
        Pattern::Free | Pattern::Formation => {
            Box::new(move |stream| anywhere(&airspace, airspace.height_agl_m, stream))
        }
        Pattern::Crossing => Box::new(there_and_back(airspace, stream)),
    };
    let start = waypoints(stream);
    if drone >= scenario.drones.multirotors as usize {
        fixed_wing::fly(&scenario.fixed_wing, steps, start, waypoints, stream)
    } else {
        multirotor::fly(&scenario.multirotor, steps, start, waypoints, stream)
    }
}

/// The two ends of a line through the airspace's centre, alternating; the first leg begins at a random point on it.
fn there_and_back(
    airspace: Airspace,
    stream: &mut RandomStream,
) -> impl FnMut(&mut RandomStream) -> Vector3<f64> + use<> {
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

/// Positions by time step and by cell; a cell is as wide as the separation.
struct OccupiedSpace {
    separation: f64,
    places: HashMap<(u32, i32, i32), Vec<Vector3<f64>>>,
}

impl OccupiedSpace {
    fn new(separation: f64) -> Self {
        Self { separation, places: HashMap::new() }
    }

    fn cell(&self, position: &Vector3<f64>) -> (i32, i32) {
        let index = |metres: f64| (metres / self.separation).floor() as i32;
        (index(position.x), index(position.y))
    }

    fn add(&mut self, path: &FlightPath) {
        for (step, state) in path.samples().iter().enumerate() {
            let (x, y) = self.cell(&state.position);
            self.places.entry((step as u32, x, y)).or_default().push(state.position);
        }
    }

    /// Whether every sample of the path keeps the separation from all earlier paths.
    fn is_clear(&self, path: &FlightPath) -> bool {
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
