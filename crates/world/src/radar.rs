//! A radar's detections: times, track numbers and errors.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::ground::Ground;
use crate::motion::FlightPath;
pub use crate::radar_detection::{OTHERS, RadarDetection, RadarTarget, clock_s};
use crate::scenario::Radar;
use crate::streams::{Entity, RandomStream, RandomStreams, radar_target};
use crate::target_state::{TargetObservation, TargetState};

/// All detections of radar number `index` within `duration_s` seconds, in order of time.
pub fn detections(
    radar: &Radar,
    index: usize,
    targets: &[RadarTarget],
    ground: &Ground,
    duration_s: f64,
    streams: &RandomStreams,
) -> Vec<RadarDetection> {
    let antenna = ground.antenna(radar);
    let mut own = streams.of(Entity::Radar, index);
    let mut numbers = NumberAllocator::new(radar);
    let mut encounters = Encounters::default();
    let mut target_states: Vec<TargetState> = targets
        .iter()
        .map(|target| {
            let of = |entity| streams.of(entity, radar_target(index, target.number));
            TargetState::new(radar, target, of(Entity::Sight), of(Entity::Velocity))
        })
        .collect();
    let mut found = Vec::new();
    for turn in 0..(duration_s / radar.period_s) as usize {
        let begin_s = turn as f64 * radar.period_s;
        if radar.swap_share > 0.0 {
            encounters.swap(radar, targets, &mut target_states, begin_s, &mut own);
        }
        let first = found.len();
        for (target, state) in target_states.iter_mut().enumerate() {
            let Some(time_s) = passing(radar, &targets[target].path, begin_s) else { continue };
            if !targets[target].exists(time_s) {
                continue;
            }
            let observation =
                TargetObservation { radar, antenna: &antenna, ground, target: &targets[target], time_s };
            if time_s < duration_s
                && let Some(seen) = state.observe(&observation, || numbers.next())
            {
                found.push(RadarDetection { target, ..seen });
            }
        }
        target_states.iter_mut().filter_map(TargetState::take_ended).for_each(|number| numbers.free(number));
        found[first..].sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    found
}

/// Time at which the antenna passes the target in this turn; the antenna points north at `begin_s`. Computed on a flat
/// Earth, which is accurate enough for a time.
fn passing(radar: &Radar, path: &FlightPath, begin_s: f64) -> Option<f64> {
    let stands = Vector3::new(radar.east_m, radar.north_m, radar.antenna_agl_m);
    let to = path.at(begin_s).position - stands;
    let share = (to.x.atan2(to.y) / TAU).rem_euclid(1.0);
    let in_range = (radar.min_range_m..=radar.max_range_m).contains(&to.norm());
    in_range.then_some(begin_s + share * radar.period_s)
}

/// Allocator of track numbers: cyclic, skipping those in use.
struct NumberAllocator {
    last: u16,
    next: u16,
    used: BTreeSet<u16>,
}

impl NumberAllocator {
    fn new(radar: &Radar) -> Self {
        let last = radar.last_number as u16;
        Self { last, next: (radar.first_number as u16).min(last), used: BTreeSet::new() }
    }

    /// Returns the next free number, or `None` if all are in use.
    fn next(&mut self) -> Option<u16> {
        for _ in 0..=self.last {
            let number = self.next;
            self.next = if number >= self.last { 1 } else { number + 1 };
            if self.used.insert(number) {
                return Some(number);
            }
        }
        None
    }

    fn free(&mut self, number: u16) {
        self.used.remove(&number);
    }
}

/// Pairs of drones near each other, whose track numbers may be swapped once per encounter.
#[derive(Default)]
struct Encounters(BTreeSet<(usize, usize)>);

impl Encounters {
    fn swap(
        &mut self,
        radar: &Radar,
        targets: &[RadarTarget],
        target_states: &mut [TargetState],
        at_s: f64,
        stream: &mut RandomStream,
    ) {
        let mut drones: Vec<(f64, usize)> = (0..targets.len())
            .filter(|&target| targets[target].drone.is_some() && target_states[target].number().is_some())
            .map(|target| (targets[target].path.at(at_s).position.x, target))
            .collect();
        drones.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut near = BTreeSet::new();
        for (place, &(east, a)) in drones.iter().enumerate() {
            let beside =
                drones[place + 1..].iter().take_while(|(other, _)| other - east < radar.swap_distance_m);
            for &(_, b) in beside {
                let apart = targets[a].path.at(at_s).position - targets[b].path.at(at_s).position;
                if apart.norm() < radar.swap_distance_m {
                    near.insert((a.min(b), a.max(b)));
                }
            }
        }
        for &(a, b) in near.difference(&self.0) {
            if stream.chance(radar.swap_share) {
                let (number_a, number_b) = (target_states[a].number(), target_states[b].number());
                target_states[a].renumber(number_b);
                target_states[b].renumber(number_a);
            }
        }
        self.0 = near;
    }
}
