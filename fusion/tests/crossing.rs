//! Aircraft that only cameras see: two lines of sight that cross begin a target.
#![expect(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::num::NonZeroUsize;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use utm_fusion_engine::report::{Bearing, CameraTrackKey};
use utm_fusion_engine::settings::{
    Camera, OperationalRules, Profile, Radar, RadarErrors, Receiver, RegistrationMode,
};
use utm_fusion_engine::time::{SECOND, Time};
use utm_fusion_engine::{
    Emission, Engine, Enu, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, Settings, Source,
};

/// Standard deviations of a camera's errors: of each look and, correlated over 20 s, of all looks, degrees.
const WHITE_DEG: f64 = 0.1;
const LASTING_DEG: f64 = 0.07;
/// Time between two looks, seconds.
const LOOK_S: f64 = 0.2;

fn at(seconds: f64) -> Time {
    Time::from_nanos(1_700_000_000 * SECOND + (seconds * SECOND as f64) as i64)
}

/// Flight of a drone: positions every tenth of a second.
struct Flight(Vec<Vector3<f64>>);

impl Flight {
    /// A flight with random turns, climbs, and stops, about the middle of the cameras.
    fn random(draw: &mut ChaCha8Rng, duration_s: f64) -> Self {
        let mut place: Vector3<f64> = Vector3::new(
            draw.random_range(-350.0..350.0),
            draw.random_range(-350.0..350.0),
            draw.random_range(40.0..120.0),
        );
        let mut heading: f64 = draw.random_range(0.0..TAU);
        let (mut speed, mut wanted, mut rate, mut climb) = (8.0_f64, 8.0, 0.0, 0.0);
        let mut places = Vec::new();
        for step in 0..=(duration_s * 10.0) as usize {
            if step % 60 == 0 {
                wanted = if draw.random_bool(0.2) { 0.0 } else { draw.random_range(4.0..15.0) };
                rate = if draw.random_bool(0.5) { 0.0 } else { draw.random_range(-0.4..0.4) };
                climb = if draw.random_bool(0.6) { 0.0 } else { draw.random_range(-2.0..2.0) };
            }
            if place.xy().norm() > 450.0 {
                // Back to the middle.
                let home = (-place.x).atan2(-place.y);
                let off = (home - heading + 3.0 * PI).rem_euclid(TAU) - PI;
                rate = off.clamp(-0.4, 0.4);
            }
            if !(30.0..140.0).contains(&place.z) {
                climb = if place.z < 30.0 { 1.0 } else { -1.0 };
            }
            speed += (wanted - speed).clamp(-0.25, 0.25);
            heading += rate * 0.1;
            place += Vector3::new(heading.sin() * speed, heading.cos() * speed, climb) * 0.1;
            places.push(place);
        }
        Self(places)
    }

    fn at(&self, seconds: f64) -> Vector3<f64> {
        let step = (seconds * 10.0).clamp(0.0, (self.0.len() - 2) as f64);
        let before = step.floor() as usize;
        self.0[before].lerp(&self.0[before + 1], step - before as f64)
    }
}

/// Cameras that look at drones.
struct Scene {
    cameras: Vec<Vector3<f64>>,
    /// True turn of each camera from its stated orientation, and the stated deviation of that, degrees.
    turned: Vec<([f64; 3], f64)>,
    flights: Vec<Flight>,
    duration_s: f64,
    /// Whether a camera sees a drone at a time.
    sees: Box<dyn Fn(usize, usize, f64) -> bool>,
}

impl Scene {
    fn new(seed: u64, cameras: usize, drones: usize) -> Self {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let places = [
            Vector3::new(-600.0, -300.0, 5.0),
            Vector3::new(500.0, -500.0, 12.0),
            Vector3::new(100.0, 700.0, 0.0),
        ];
        let duration_s = 90.0;
        Self {
            cameras: places[..cameras].to_vec(),
            turned: vec![([0.0; 3], 0.05); cameras],
            flights: (0..drones).map(|_| Flight::random(&mut draw, duration_s)).collect(),
            duration_s,
            sees: Box::new(|_, _, _| true),
        }
    }

    fn settings(&self) -> Settings {
        let mut settings =
            Settings { profile: Profile::Operational(Default::default()), ..Settings::default() };
        for (place, (_, deviation_deg)) in self.cameras.iter().zip(&self.turned) {
            settings.add_camera(Camera {
                position: Enu::from(*place),
                azimuth: WHITE_DEG.to_radians(),
                elevation: WHITE_DEG.to_radians(),
                orientation: deviation_deg.to_radians(),
            });
        }
        settings
    }

    /// Bearings by time of reception.
    fn bearings(&self, seed: u64) -> Vec<(Time, Report)> {
        let mut reports = Vec::new();
        for (index, place) in self.cameras.iter().enumerate() {
            let [heading, east, north] = self.turned[index].0.map(f64::to_radians);
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(east, north, -heading));
            for (drone, flight) in self.flights.iter().enumerate() {
                let mut draw = ChaCha8Rng::seed_from_u64(seed * 100 + index as u64 * 10 + drone as u64);
                let mut normal = |sigma: f64| -> f64 {
                    sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut draw)
                };
                let kept = (-LOOK_S / 20.0).exp();
                let lasting = LASTING_DEG.to_radians();
                let mut slow = [normal(lasting), normal(lasting)];
                let mut number = 1 + drone as u16;
                let mut was_seen = true;
                for step in 0..(self.duration_s / LOOK_S) as usize {
                    let seconds = step as f64 * LOOK_S + 0.03 * index as f64;
                    slow = slow.map(|slow| slow * kept + normal(lasting * (1.0 - kept * kept).sqrt()));
                    let is_seen = (self.sees)(index, drone, seconds);
                    if is_seen && !was_seen {
                        number += 100;
                    }
                    was_seen = is_seen;
                    if !is_seen {
                        continue;
                    }
                    let seen = turn * (flight.at(seconds) - place);
                    let bearing = Bearing {
                        track: CameraTrackKey { sensor: SensorIndex(index as u16), number },
                        time: at(seconds),
                        azimuth: seen.x.atan2(seen.y) + slow[0] + normal(WHITE_DEG.to_radians()),
                        elevation: Some(
                            seen.z.atan2(seen.xy().norm()) + slow[1] + normal(WHITE_DEG.to_radians()),
                        ),
                    };
                    reports.push((at(seconds + 0.15), Report::Bearing(bearing)));
                }
            }
        }
        reports.sort_by_key(|report| report.0);
        reports
    }

    fn fly(&self, seed: u64) -> Vec<Emission> {
        fly(self.settings(), &self.bearings(seed))
    }

    /// Judges the points of cameras alone.
    fn score(&self, emissions: &[Emission], score: &mut Score) {
        let mut first: Vec<Option<f64>> = vec![None; self.flights.len()];
        for emission in emissions {
            let seconds = emission.time.seconds_since(at(0.0));
            let mut shown = vec![0; self.flights.len()];
            for point in emission.points.iter().filter(|point| point.source == Source::Cameras) {
                let off = |drone: &usize| (self.flights[*drone].at(seconds) - point.position.0).norm();
                let nearest = (0..self.flights.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
                let estimate = point.estimate.unwrap();
                let error = point.position.0 - self.flights[nearest].at(seconds);
                let over_ground = error.xy();
                let nees =
                    (over_ground.transpose() * estimate.horizontal.try_inverse().unwrap() * over_ground).x;
                let nees_height = error.z * error.z / estimate.vertical_m2;
                score.points += 1;
                score.nees += nees / 2.0;
                score.nees_height += nees_height;
                score.errors_m.push(error.norm());
                score.sigmas_m.push((estimate.horizontal.trace() + estimate.vertical_m2).sqrt());
                if error.norm() > 15.0 && nees > 25.0 {
                    score.wrong += 1;
                    println!(
                        "{seconds:.2} s, drone {nearest}: off by {:.1?} m, stated {:.1?} and {:.1} m, {:?}",
                        error.as_slice(),
                        [estimate.horizontal.m11.sqrt(), estimate.horizontal.m22.sqrt()],
                        estimate.vertical_m2.sqrt(),
                        estimate.basis,
                    );
                }
                shown[nearest] += 1;
                first[nearest].get_or_insert(seconds);
            }
            score.twice += shown.iter().filter(|&&count| count > 1).count();
            score.slots += self.flights.len();
        }
        score.found += first.iter().flatten().count();
        score.drones += self.flights.len();
        score.first_s.extend(first.into_iter().flatten());
    }
}

fn fly(settings: Settings, reports: &[(Time, Report)]) -> Vec<Emission> {
    let mut engine = Engine::new(settings).unwrap();
    let mut emissions = Vec::new();
    for (received, report) in reports {
        emissions.extend(engine.advance(*received));
        engine.handle(*report).unwrap();
    }
    emissions.extend(engine.finish());
    emissions
}

#[derive(Debug, Default)]
struct Score {
    slots: usize,
    points: usize,
    /// Points far from every drone, with a deviation that does not say so.
    wrong: usize,
    /// Slots in which a drone has two points.
    twice: usize,
    found: usize,
    drones: usize,
    nees: f64,
    nees_height: f64,
    errors_m: Vec<f64>,
    sigmas_m: Vec<f64>,
    first_s: Vec<f64>,
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

impl std::fmt::Display for Score {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let count = self.points as f64;
        write!(
            f,
            "{} of {} drones, {:.2} of their slots, first at {:.1} s; {} points wrong, {} twice; error {:.2} m, stated {:.2} m; NEES {:.2}, height {:.2}",
            self.found,
            self.drones,
            count / self.slots as f64,
            median(&self.first_s),
            self.wrong,
            self.twice,
            median(&self.errors_m),
            median(&self.sigmas_m),
            self.nees / count,
            self.nees_height / count,
        )
    }
}

/// First and last seed of the simulated flights, `UTM_FUSION_FIRST` and `UTM_FUSION_LAST`.
fn seeds() -> std::ops::RangeInclusive<u64> {
    let number = |name: &str, otherwise| std::env::var(name).map_or(otherwise, |text| text.parse().unwrap());
    number("UTM_FUSION_FIRST", 1)..=number("UTM_FUSION_LAST", 3)
}

fn scored(cameras: usize, drones: usize) -> Score {
    let mut score = Score::default();
    for seed in seeds() {
        let scene = Scene::new(seed, cameras, drones);
        let before = score.wrong;
        scene.score(&scene.fly(seed), &mut score);
        if score.wrong > before {
            println!("seed {seed}: {} wrong", score.wrong - before);
        }
    }
    println!("{cameras} cameras, {drones} drones: {score}");
    score
}

#[test]
fn lone_drone_is_begun_by_two_cameras() {
    let score = scored(2, 1);
    assert_eq!((score.found, score.wrong, score.twice), (score.drones, 0, 0), "{score}");
    assert!(score.points as f64 > 0.7 * score.slots as f64, "{score}");
    assert!(score.nees < 1.5 * score.points as f64, "{score}");
}

#[test]
fn several_drones_have_no_ghosts() {
    for (cameras, drones) in [(2, 2), (2, 3), (3, 2), (3, 3)] {
        let score = scored(cameras, drones);
        assert_eq!((score.wrong, score.twice), (0, 0), "{score}");
        assert!(score.points as f64 > 0.6 * score.slots as f64, "{score}");
    }
}

/// Each camera sees a different drone: their lines cross nowhere for long.
#[test]
fn drones_seen_by_one_camera_each_begin_nothing() {
    let mut score = Score::default();
    for seed in seeds() {
        let mut scene = Scene::new(seed, 2, 2);
        scene.sees = Box::new(|camera, drone, _| camera == drone);
        let before = score.points;
        scene.score(&scene.fly(seed), &mut score);
        println!("seed {seed}: {} points", score.points - before);
    }
    println!("one drone each: {score}");
    assert!(score.points * 50 <= score.slots, "{score}");
}

/// Drones come into the view of each camera at other times, and leave it.
#[test]
fn drones_that_come_and_go_have_no_ghosts() {
    let mut score = Score::default();
    for seed in seeds() {
        let mut scene = Scene::new(seed, 3, 3);
        scene.sees = Box::new(move |camera, drone, seconds| {
            let phase = (camera as u64 * 7 + drone as u64 * 11 + seed * 5) % 40;
            (seconds + phase as f64) % 40.0 < 28.0
        });
        let before = score.wrong;
        scene.score(&scene.fly(seed), &mut score);
        println!("seed {seed}: {} wrong", score.wrong - before);
    }
    println!("coming and going: {score}");
    assert_eq!((score.wrong, score.twice), (0, 0), "{score}");
}

/// The orientation of one camera is stated wrongly, and not known well: it begins nothing.
#[test]
fn unknown_orientation_begins_nothing() {
    let mut scene = Scene::new(1, 2, 1);
    scene.turned[1] = ([4.0, 1.0, -1.0], 3.0);
    assert!(scene.fly(1).iter().all(|emission| emission.points.is_empty()));
}

/// The orientation of one camera is off by as much as its stated deviation permits.
#[test]
fn stated_deviation_of_orientation_is_part_of_the_covariance() {
    let mut score = Score::default();
    for seed in seeds() {
        let mut scene = Scene::new(seed, 2, 2);
        let sign = if seed % 2 == 0 { 1.0 } else { -1.0 };
        scene.turned = vec![([0.4 * sign, 0.3, -0.3 * sign], 0.4), ([-0.3, 0.2 * sign, 0.2], 0.3)];
        scene.score(&scene.fly(seed), &mut score);
    }
    println!("turned: {score}");
    assert_eq!(score.twice, 0, "{score}");
    assert!(score.nees < 2.0 * score.points as f64, "{score}");
}

/// Numbers shown between two times, by source.
fn numbers(emissions: &[Emission], from_s: f64, to_s: f64) -> BTreeSet<(&'static str, u32)> {
    let is_within = |emission: &&Emission| {
        let seconds = emission.time.seconds_since(at(0.0));
        (from_s..to_s).contains(&seconds)
    };
    let name = |source: &Source| match source {
        Source::Fused(..) => "fused",
        Source::Radar(_) => "radar",
        Source::Transponder(_) => "transponder",
        Source::Cameras => "cameras",
    };
    let points = emissions.iter().filter(is_within).flat_map(|emission| &emission.points);
    points.map(|point| (name(&point.source), point.number)).collect()
}

/// Adds reports to those of the cameras, by time of reception.
fn with(mut bearings: Vec<(Time, Report)>, more: Vec<(Time, Report)>) -> Vec<(Time, Report)> {
    bearings.extend(more);
    bearings.sort_by_key(|report| report.0);
    bearings
}

#[test]
fn transponder_that_appears_is_the_same_aircraft() {
    for seed in 1..4 {
        let scene = Scene::new(seed, 2, 1);
        let mut settings = scene.settings();
        let sensor = settings.add_receiver(Receiver {
            horizontal_m: 2.0,
            vertical_m: 3.0,
            delay_s: Some(0.0),
            period_s: 1.0,
            ..Receiver::default()
        });
        let identity = Identity::new(b"DRONE0", None).unwrap();
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let fixes = (45..85).map(|second| {
            let seconds = f64::from(second);
            let off = Vector3::from([0; 3].map(|_| draw.random_range(-2.0..2.0)));
            let place = Enu::from(scene.flights[0].at(seconds) + off);
            (at(seconds + 0.2), Report::Fix(Fix::new(sensor, identity, at(seconds), place)))
        });
        let emissions = fly(settings, &with(scene.bearings(seed), fixes.collect()));
        let before = numbers(&emissions, 20.0, 40.0);
        let after = numbers(&emissions, 55.0, 80.0);
        println!("seed {seed}: {before:?}, {after:?}");
        assert_eq!(before.len(), 1, "{before:?}");
        assert_eq!(after.len(), 1, "{after:?}");
        assert_eq!(after.first().unwrap().0, "transponder");
    }
}

#[test]
fn radar_track_that_begins_is_the_same_aircraft() {
    for seed in 1..4 {
        let scene = Scene::new(seed, 2, 1);
        let mut settings = scene.settings();
        let sensor = settings.add_radar(Radar {
            errors: RadarErrors::of_data_sheet(2.5, 0.86, 10.0),
            registration: RegistrationMode::Off,
            period_s: 0.5,
            ..Radar::default()
        });
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let plots = (90..150).map(|half| {
            let seconds = f64::from(half) / 2.0;
            let off = Vector3::from([0; 3].map(|_| draw.random_range(-5.0..5.0)));
            let place = scene.flights[0].at(seconds) + off;
            let track = RadarTrackKey { sensor, number: 7 };
            let mut plot = Plot::new(track, at(seconds), Enu::from(place), place.norm());
            plot.uav_probability = Some(0.95);
            (at(seconds + 0.1), Report::Plot(plot))
        });
        let emissions = fly(settings, &with(scene.bearings(seed), plots.collect()));
        let [before, during, after] =
            [(20.0, 40.0), (55.0, 70.0), (79.0, 85.0)].map(|(from, to)| numbers(&emissions, from, to));
        println!("seed {seed}: {before:?}, {during:?}, {after:?}");
        assert_eq!(before.len(), 1, "{before:?}");
        let number = before.first().unwrap().1;
        assert_eq!(during, BTreeSet::from([("radar", number)]));
        assert_eq!(after, BTreeSet::from([("cameras", number)]));
    }
}

#[test]
fn target_ends_when_one_camera_is_left() {
    let mut scene = Scene::new(2, 2, 1);
    scene.sees = Box::new(|camera, _, seconds| camera == 0 || seconds < 50.0);
    let emissions = scene.fly(2);
    assert_eq!(numbers(&emissions, 20.0, 48.0).len(), 1);
    assert!(numbers(&emissions, 53.0, 90.0).is_empty());
}

#[test]
fn output_is_the_same_for_threads_and_after_a_checkpoint() {
    let scene = Scene::new(3, 3, 3);
    let bearings = scene.bearings(3);
    let with_threads = |threads: usize| {
        let rules =
            OperationalRules { threads: NonZeroUsize::new(threads).unwrap(), ..OperationalRules::default() };
        Settings { profile: Profile::Operational(rules), ..scene.settings() }
    };
    let kept = fly(with_threads(1), &bearings);
    assert!(kept.iter().any(|emission| emission.points.len() == 3));
    for threads in [2, 8] {
        assert!(fly(with_threads(threads), &bearings) == kept, "{threads} threads");
    }
    let mut engine = Engine::new(with_threads(1)).unwrap();
    let mut emissions: Vec<Emission> = Vec::new();
    for (index, (received, report)) in bearings.iter().enumerate() {
        emissions.extend(engine.advance(*received));
        engine.handle(*report).unwrap();
        if index % 300 == 0 {
            engine = Engine::restored(with_threads(1), &engine.checkpoint()).unwrap();
        }
    }
    emissions.extend(engine.finish());
    assert!(emissions == kept, "another output after a checkpoint");
}
