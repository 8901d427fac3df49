//! Two radars that align each other.

use nalgebra::{Matrix2, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{ERRORS, seconds};
use crate::frames::Enu;
use crate::registration::mutual::{MutualAlignment, OverGround, SharedComparison, SharedLook};
use crate::report::SensorIndex;

const RADARS: [[f64; 2]; 3] = [[0.0, 0.0], [2200.0, -100.0], [1500.0, 2600.0]];
/// Standard deviations of the true misalignment: bearing, range, time.
const MISALIGNED: [f64; 3] = [0.026, 5.0, 0.1];

/// Radars with these misalignments, and the aircraft that they see.
struct Site {
    random: ChaCha8Rng,
    bias: Vec<Vector3<f64>>,
    /// Where tracks begin: bounds to the east and north.
    area: [[f64; 2]; 2],
    now_s: f64,
}

impl Site {
    fn new(seed: u64, radars: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let bias = (0..radars).map(|_| Vector3::from(MISALIGNED).map(|sigma| sigma * normal())).collect();
        Self { random, bias, area: [[400.0, 1900.0], [500.0, 2000.0]], now_s: 0.0 }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// Lets two radars see an aircraft for a minute. `apart`: distance between the aircraft that each of them sees.
    fn fly(&mut self, alignment: &mut MutualAlignment, pair: [usize; 2], apart: Vector2<f64>) {
        let [[west, east], [south, north]] = self.area;
        let mut place =
            Vector2::new(self.random.random_range(west..east), self.random.random_range(south..north));
        let mut course = self.random.random_range(0.0..std::f64::consts::TAU);
        let turn = 0.15 * self.normal();
        let mut comparison = SharedComparison::new([ERRORS; 2]);
        let learnt = alignment.solve(|_| None);
        let applied = pair.map(|radar| {
            let known = learnt.get(&SensorIndex(radar as u16));
            known.map_or_else(Vector2::zeros, |learnt| learnt.with(&OverGround::unknown()).mean.xy())
        });
        let kept: f64 = (-1.0 / ERRORS.correlation_s).exp();
        let mut lasting: [[f64; 2]; 2] = [[0.0_f64; 2]; 2].map(|radar| radar.map(|_| self.normal()));
        for _ in 0..60 {
            let velocity = Vector2::new(f64::sin(course), f64::cos(course)) * 12.0;
            let mut plots = [Vector2::zeros(); 2];
            for (radar, plot) in plots.iter_mut().enumerate() {
                let [east, north] = RADARS[pair[radar]];
                let bias = self.bias[pair[radar]];
                let there = place + velocity * bias[2] + if radar == 1 { apart } else { Vector2::zeros() };
                let away = there - Vector2::new(east, north);
                lasting[radar] =
                    lasting[radar].map(|error| kept * error + (1.0 - kept * kept).sqrt() * self.normal());
                let azimuth = away.x.atan2(away.y)
                    + bias[0]
                    + lasting[radar][0] * ERRORS.bias_azimuth
                    + ERRORS.noise_azimuth * self.normal()
                    - applied[radar].x;
                let range_m = away.norm()
                    + bias[1]
                    + lasting[radar][1] * ERRORS.bias_range_m
                    + ERRORS.noise_range_m * self.normal()
                    - applied[radar].y;
                *plot = Vector2::new(east + range_m * azimuth.sin(), north + range_m * azimuth.cos());
            }
            let enu = |place: Vector2<f64>| Enu::new(place.x, place.y, 0.0);
            comparison.add(&SharedLook {
                time: seconds(self.now_s),
                radars: pair.map(|radar| enu(RADARS[radar].into())),
                plots: plots.map(enu),
                corrected: applied,
                place: enu(place),
                velocity,
                between_m: 0.0,
            });
            if comparison.gathered_s() >= 10.0 {
                let sensors = pair.map(|radar| SensorIndex(radar as u16));
                alignment.add((sensors[0], sensors[1]), comparison.take_sample().unwrap());
            }
            place += velocity;
            course += turn;
            self.now_s += 1.0;
        }
    }

    /// Errors of the solution, and their squares in variances, of each radar: bearing and range.
    fn solve(&self, alignment: &mut MutualAlignment) -> Vec<(Vector2<f64>, f64)> {
        let learnt = alignment.solve(|_| None);
        let own = OverGround::unknown();
        let of = |(radar, bias): (usize, &Vector3<f64>)| {
            let solved = learnt[&SensorIndex(radar as u16)].with(&own);
            let off = (solved.mean - bias).xy();
            let covariance: Matrix2<f64> = solved.covariance.fixed_view::<2, 2>(0, 0).into();
            (off, off.dot(&(covariance.try_inverse().unwrap() * off)) / 2.0)
        };
        self.bias.iter().enumerate().map(of).collect()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Absolute errors of the bearings, degrees, and the mean squared error in variances, of this number of sites.
fn bearings(sites: u64, radars: usize, fly: impl Fn(&mut Site, &mut MutualAlignment)) -> (Vec<f64>, f64) {
    let (mut off_deg, mut squares) = (Vec::new(), 0.0);
    for seed in 1..=sites {
        let (mut site, mut alignment) = (Site::new(seed, radars), MutualAlignment::default());
        fly(&mut site, &mut alignment);
        for (off, square) in site.solve(&mut alignment) {
            off_deg.push(off.x.to_degrees().abs());
            squares += square;
        }
    }
    let mean = squares / off_deg.len() as f64;
    (off_deg, mean)
}

#[test]
fn two_radars_align_each_other_within_30_drone_minutes() {
    let (off_deg, squares) = bearings(60, 2, |site, alignment| {
        (0..30).for_each(|_| site.fly(alignment, [0, 1], Vector2::zeros()));
    });
    println!("bearing: median {:.3} deg; normalised squared error {squares:.2}", median(off_deg.clone()));
    assert!(median(off_deg) < 0.3);
    assert!((0.6..1.5).contains(&squares), "{squares}");
}

#[test]
fn a_small_area_tells_less_and_says_so() {
    let (off_deg, squares) = bearings(60, 2, |site, alignment| {
        site.area = [[800.0, 1400.0], [800.0, 1400.0]];
        (0..30).for_each(|_| site.fly(alignment, [0, 1], Vector2::zeros()));
    });
    println!("bearing: median {:.3} deg; normalised squared error {squares:.2}", median(off_deg));
    assert!((0.6..1.5).contains(&squares), "{squares}");
}

#[test]
fn pairs_of_two_drones_do_not_turn_the_radars() {
    let (off_deg, squares) = bearings(60, 2, |site, alignment| {
        for number in 0..30 {
            let angle = site.random.random_range(0.0..std::f64::consts::TAU);
            let apart = Vector2::new(f64::sin(angle), f64::cos(angle)) * 90.0;
            site.fly(alignment, [0, 1], if number % 10 == 9 { apart } else { Vector2::zeros() });
        }
    });
    println!("bearing: median {:.3} deg; normalised squared error {squares:.2}", median(off_deg.clone()));
    assert!(median(off_deg) < 0.35);
    assert!(squares < 2.0, "{squares}");
}

#[test]
fn three_radars_are_aligned_together() {
    let (off_deg, squares) = bearings(40, 3, |site, alignment| {
        (0..30).for_each(|number| {
            let pair = [[0, 1], [1, 2], [0, 2]][number % 3];
            site.fly(alignment, pair, Vector2::zeros());
        });
    });
    println!("bearing: median {:.3} deg; normalised squared error {squares:.2}", median(off_deg.clone()));
    assert!(median(off_deg) < 0.3);
    assert!((0.6..1.5).contains(&squares), "{squares}");
}

#[test]
fn a_turned_radar_is_aligned_anew() {
    let (off_deg, _) = bearings(20, 2, |site, alignment| {
        (0..30).for_each(|_| site.fly(alignment, [0, 1], Vector2::zeros()));
        site.bias[1][0] += 0.09;
        for _ in 0..10 {
            site.fly(alignment, [0, 1], Vector2::zeros());
            alignment.solve(|_| None);
        }
    });
    println!("bearing: median {:.3} deg", median(off_deg.clone()));
    assert!(median(off_deg) < 0.6);
}

#[test]
fn radars_without_common_aircraft_learn_nothing() {
    assert!(MutualAlignment::default().solve(|_| None).is_empty());
}

#[test]
fn forgotten_radar_leaves_the_others_aligned() {
    let (mut site, mut alignment) = (Site::new(1, 3), MutualAlignment::default());
    for number in 0..12 {
        site.fly(&mut alignment, [[0, 1], [1, 2], [0, 2]][number % 3], Vector2::zeros());
    }
    alignment.solve(|_| None);
    alignment.forget(SensorIndex(2));
    assert!(alignment.is_changed(), "the others have to be solved again");
    let left: Vec<SensorIndex> = alignment.solve(|_| None).into_keys().collect();
    assert_eq!(left, [SensorIndex(0), SensorIndex(1)]);
    assert!(!alignment.is_changed());
}
