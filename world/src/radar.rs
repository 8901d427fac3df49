//! A radar: which targets it detects when, under which track numbers, and with which errors.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::ground::Ground;
use crate::motion::Path;
use crate::scenario::Radar;
use crate::sight::{Look, Sight};
use crate::streams::{Entity, Stream, Streams, sight};

/// A radar's report of a target, errors included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Time of detection since take-off, s.
    pub time_s: f64,
    /// Index of the target.
    pub target: usize,
    /// Track number.
    pub number: u16,
    /// Slant range, metres.
    pub range_m: f64,
    /// Azimuth, degrees, 0 to 360.
    pub azimuth_deg: f64,
    /// Height above mean sea level, metres.
    pub altitude_amsl_m: f64,
    /// Probability that it is a UAV.
    pub uav_probability: f64,
    /// Velocity east and north, m/s.
    pub velocity: (f64, f64),
    /// Whether the track has walked off its target.
    pub seduced: bool,
}

/// What a radar may detect.
#[derive(Clone, Debug)]
pub struct Target {
    /// Its number in the random streams; from [`OTHERS`] on for what is no drone.
    pub number: usize,
    /// Its path.
    pub path: Path,
    /// The drone's number, where it is one.
    pub drone: Option<usize>,
    /// Its mean UAV probability, if it is no drone; 0: always 0.
    pub uav_probability: f64,
}

/// The first number of a target that is no drone: another drone changes nothing for a bird.
pub const OTHERS: usize = 1 << 16;

/// All reports of radar number `index` within `duration_s` seconds, in order of time.
pub fn detections(
    radar: &Radar,
    index: usize,
    targets: &[Target],
    ground: &Ground,
    duration_s: f64,
    streams: &Streams,
) -> Vec<Detection> {
    let antenna = ground.antenna(radar);
    let mut own = streams.of(Entity::Radar, index);
    let mut numbers = Numbers::new(radar);
    let mut encounters = Encounters::default();
    let mut sights: Vec<Sight> = targets
        .iter()
        .map(|target| {
            let of = |entity| streams.of(entity, sight(index, target.number));
            Sight::new(radar, target, of(Entity::Sight), of(Entity::Velocity))
        })
        .collect();
    let mut found = Vec::new();
    for turn in 0..(duration_s / radar.period_s) as usize {
        let begin_s = turn as f64 * radar.period_s;
        if radar.swap_share > 0.0 {
            encounters.swap(radar, targets, &mut sights, begin_s, &mut own);
        }
        let first = found.len();
        for (target, sight) in sights.iter_mut().enumerate() {
            let Some(time_s) = passing(radar, &targets[target].path, begin_s) else { continue };
            let look = Look { radar, antenna: &antenna, ground, target: &targets[target], time_s };
            if time_s < duration_s
                && let Some(seen) = sight.look(&look, || numbers.next())
            {
                found.push(Detection { target, ..seen });
            }
        }
        sights.iter_mut().filter_map(Sight::take_ended).for_each(|number| numbers.free(number));
        found[first..].sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    found
}

/// When the antenna, pointing north at `begin_s`, passes the target in this turn; on a flat Earth, which is exact enough for
/// a time.
fn passing(radar: &Radar, path: &Path, begin_s: f64) -> Option<f64> {
    let stands = Vector3::new(radar.east_m, radar.north_m, radar.antenna_agl_m);
    let to = path.at(begin_s).position - stands;
    let share = (to.x.atan2(to.y) / TAU).rem_euclid(1.0);
    let in_range = (radar.min_range_m..=radar.max_range_m).contains(&to.norm());
    in_range.then_some(begin_s + share * radar.period_s)
}

/// Track numbers: cyclic, skipping those in use.
struct Numbers {
    last: u16,
    next: u16,
    used: BTreeSet<u16>,
}

impl Numbers {
    fn new(radar: &Radar) -> Self {
        let last = radar.last_number as u16;
        Self { last, next: (radar.first_number as u16).min(last), used: BTreeSet::new() }
    }

    /// The next free number; `None` where all are used.
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
        targets: &[Target],
        sights: &mut [Sight],
        at_s: f64,
        stream: &mut Stream,
    ) {
        let mut drones: Vec<(f64, usize)> = (0..targets.len())
            .filter(|&target| targets[target].drone.is_some() && sights[target].number().is_some())
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
                let (number_a, number_b) = (sights[a].number(), sights[b].number());
                sights[a].renumber(number_b);
                sights[b].renumber(number_a);
            }
        }
        self.0 = near;
    }
}
