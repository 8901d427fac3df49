//! A camera beside a radar: its bearings give no distance, but an accurate direction.
#![expect(clippy::unwrap_used, reason = "a test that panics has failed")]

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use utm_fusion_engine::report::{Bearing, CameraTrackKey};
use utm_fusion_engine::settings::{Camera, Profile, Radar, RadarErrors, Receiver, RegistrationMode};
use utm_fusion_engine::time::{SECOND, Time};
use utm_fusion_engine::{
    Emission, Engine, Enu, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, Settings,
};

/// Standard deviation of the radar's azimuth (persistent) and of the camera's, degrees.
const RADAR_DEG: f64 = 0.86;
const CAMERA_DEG: f64 = 0.1;
const FLIGHT_S: f64 = 120.0;

fn at(seconds: f64) -> Time {
    Time::from_nanos(1_700_000_000 * SECOND + (seconds * SECOND as f64) as i64)
}

/// Position of a drone: straight past the site at a distance, to the east or to the west.
fn place(drone: usize, seconds: f64) -> Vector3<f64> {
    let (from, sign) = [(-700.0, 1.0), (700.0, -1.0)][drone];
    Vector3::new(from + sign * 12.0 * seconds, 1500.0 + 120.0 * drone as f64, 120.0 + 40.0 * drone as f64)
}

fn azimuth(place: &Vector3<f64>) -> f64 {
    place.x.atan2(place.y)
}

/// Reports of radar and camera on `drones` drones, by time of reception; `looks_at` is the drone of which the camera
/// sends bearings.
fn reports(seed: u64, drones: usize, looks_at: Option<usize>) -> Vec<(Time, Report)> {
    let (radar, camera) = (SensorIndex(0), SensorIndex(1));
    let mut reports = Vec::new();
    for drone in 0..drones {
        let mut draw = ChaCha8Rng::seed_from_u64(seed * 10 + drone as u64);
        let mut normal = |sigma: f64| -> f64 {
            sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut draw)
        };
        // A first-order Gauss–Markov process of 20 s, like a radar's error in azimuth.
        let mut slow = normal(RADAR_DEG.to_radians());
        for step in 0..(FLIGHT_S * 2.0) as usize {
            let seconds = step as f64 * 0.5;
            let kept = (-0.5_f64 / 20.0).exp();
            slow = slow * kept + normal(RADAR_DEG.to_radians() * (1.0 - kept * kept).sqrt());
            let true_place = place(drone, seconds);
            let (turned, range_m) = (azimuth(&true_place) + slow, true_place.xy().norm() + normal(2.5));
            let seen = Enu::new(range_m * turned.sin(), range_m * turned.cos(), true_place.z + normal(10.0));
            let track = RadarTrackKey { sensor: radar, number: 1 + drone as u16 };
            let mut plot = Plot::new(track, at(seconds), seen, range_m.hypot(true_place.z));
            plot.uav_probability = Some(0.95);
            reports.push((at(seconds + 0.1), Report::Plot(plot)));
        }
    }
    if let Some(drone) = looks_at {
        let mut draw = ChaCha8Rng::seed_from_u64(seed * 10 + 9);
        for step in 0..(FLIGHT_S * 5.0) as usize {
            let seconds = step as f64 * 0.2;
            let true_place = place(drone, seconds);
            let mut normal = |sigma: f64| -> f64 {
                sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut draw)
            };
            let bearing = Bearing {
                track: CameraTrackKey { sensor: camera, number: 7 },
                time: at(seconds),
                azimuth: azimuth(&true_place) + normal(CAMERA_DEG.to_radians()),
                elevation: Some(true_place.z.atan2(true_place.xy().norm()) + normal(CAMERA_DEG.to_radians())),
            };
            reports.push((at(seconds + 0.15), Report::Bearing(bearing)));
        }
    }
    reports.sort_by_key(|report| report.0);
    reports
}

fn fly(reports: &[(Time, Report)]) -> Vec<Emission> {
    let mut settings = Settings { profile: Profile::Operational(Default::default()), ..Settings::default() };
    settings.add_radar(Radar {
        errors: RadarErrors::of_data_sheet(2.5, RADAR_DEG, 10.0),
        registration: RegistrationMode::Off,
        period_s: 0.5,
        ..Radar::default()
    });
    settings.add_camera(Camera {
        position: Enu::new(0.0, 0.0, 0.0),
        azimuth: CAMERA_DEG.to_radians(),
        elevation: CAMERA_DEG.to_radians(),
        orientation: 0.0,
    });
    let mut engine = Engine::new(settings).unwrap();
    let mut emissions = Vec::new();
    for (received, report) in reports {
        emissions.extend(engine.advance(*received));
        engine.handle(*report).unwrap();
    }
    emissions.extend(engine.finish());
    emissions
}

/// Root mean square error of the azimuth of the points nearest to a drone, degrees, and the number of these points.
fn azimuth_error_deg(emissions: &[Emission], drone: usize) -> (f64, usize) {
    let mut squares = Vec::new();
    for emission in emissions {
        let seconds = (emission.time.nanos() - at(0.0).nanos()) as f64 / SECOND as f64;
        let true_place = place(drone, seconds);
        let away = |place: &Vector3<f64>| (place - true_place).xy().norm();
        let nearest =
            emission.points.iter().min_by(|a, b| away(&a.position.0).total_cmp(&away(&b.position.0)));
        if let Some(point) =
            nearest.filter(|point| away(&point.position.0) < 100.0).filter(|_| seconds > 20.0)
        {
            squares.push((azimuth(&point.position.0) - azimuth(&true_place)).to_degrees().powi(2));
        }
    }
    ((squares.iter().sum::<f64>() / squares.len() as f64).sqrt(), squares.len())
}

#[test]
fn with_a_camera_the_direction_is_far_better_known() {
    let (mut alone, mut both) = (0.0, 0.0);
    for seed in 1001..1009 {
        let (radar_deg, slots) = azimuth_error_deg(&fly(&reports(seed, 1, None)), 0);
        let (camera_deg, with_camera) = azimuth_error_deg(&fly(&reports(seed, 1, Some(0))), 0);
        assert!(slots > 300 && with_camera >= slots, "{slots} {with_camera}");
        (alone, both) = (alone + radar_deg * radar_deg, both + camera_deg * camera_deg);
    }
    let ratio = (both / alone).sqrt();
    println!("azimuth error with the camera over that without: {ratio:.3}");
    assert!(ratio <= 0.4, "{ratio}");
}

#[test]
fn bearing_improves_only_the_observed_drone() {
    let (mut looked_at, mut other) = ([0.0; 2], [0.0; 2]);
    for seed in 1001..1007 {
        for (which, camera) in [None, Some(1)].into_iter().enumerate() {
            let emissions = fly(&reports(seed, 2, camera));
            looked_at[which] += azimuth_error_deg(&emissions, 1).0;
            other[which] += azimuth_error_deg(&emissions, 0).0;
        }
    }
    assert!(looked_at[1] < 0.5 * looked_at[0], "{looked_at:?}");
    assert!(other[1] < 1.15 * other[0], "{other:?}");
}

/// The latest look up to the end of the slot: looks in use are half a second apart.
#[test]
fn observed_drone_names_its_camera_and_time() {
    let (mut with, mut without) = (0, 0);
    for point_and_time in fly(&reports(1001, 2, Some(1)))
        .iter()
        .flat_map(|emission| emission.points.iter().map(|point| (point, emission.time)).collect::<Vec<_>>())
    {
        let (point, time) = point_and_time;
        let seconds = (time.nanos() - at(0.0).nanos()) as f64 / SECOND as f64;
        let away = |drone| (place(drone, seconds) - point.position.0).xy().norm();
        if away(1) > away(0) {
            assert!(point.cameras.is_empty(), "{seconds} s: nobody looks at this one");
            continue;
        }
        match point.cameras[..] {
            [] => without += 1,
            [part] => {
                assert_eq!((part.track.sensor.0, part.track.number), (1, 7));
                let age_s = time.seconds_since(part.time);
                assert!((-0.25..0.75).contains(&age_s), "{seconds} s: {age_s}");
                with += 1;
            }
            _ => panic!("one camera has one track"),
        }
    }
    assert!(with > 400 && without < 40, "{with} {without}");
    // Without the camera no point names one.
    let alone = fly(&reports(1001, 2, None));
    assert!(alone.iter().flat_map(|emission| &emission.points).all(|point| point.cameras.is_empty()));
}

#[test]
fn a_camera_alone_shows_nothing() {
    let bearings = reports(1001, 0, Some(0));
    assert!(fly(&bearings).iter().all(|emission| emission.points.is_empty()));
}

#[test]
fn lost_radar_track_is_not_kept_alive_by_a_bearing() {
    let all = reports(1001, 1, Some(0));
    let lost = |report: &&(Time, Report)| !matches!(report.1, Report::Plot(plot) if plot.time > at(60.0));
    let emissions = fly(&all.iter().filter(lost).copied().collect::<Vec<_>>());
    let last = emissions.iter().rfind(|emission| !emission.points.is_empty()).unwrap().time;
    assert!(last < at(63.0), "{last}");
}

#[test]
fn bearings_come_in_any_order() {
    let all = reports(1001, 1, Some(0));
    let mut shuffled = all.clone();
    let mut draw = ChaCha8Rng::seed_from_u64(5);
    // Among the reports received between two slots.
    for pair in shuffled.chunks_mut(2) {
        if draw.random::<bool>() {
            let received = pair.last().unwrap().0;
            pair.reverse();
            pair.iter_mut().for_each(|report| report.0 = received);
        }
    }
    let in_order: Vec<_> = shuffled
        .chunks(2)
        .flat_map(|pair| {
            let mut pair = pair.to_vec();
            pair.sort_by_key(|report| report.1.time());
            pair
        })
        .collect();
    assert_eq!(fly(&shuffled), fly(&in_order));
}

/// Rotation of a camera from what is configured: heading clockwise, tilts about east and north, degrees.
type Turn = [f64; 3];

/// Orientation that an engine learns in four minutes from two drones with transponders that fly about a camera: the values
/// of the misalignment, radians, the true ones, and the deviations; and the time at which it was found turned, seconds. From `later.0` seconds on the camera is turned by `later.1` instead.
fn learnt(seed: u64, first: Turn, later: (f64, Turn)) -> ([[f64; 3]; 3], Option<f64>) {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |sigma: f64| -> f64 {
        sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut draw)
    };
    let rotation = |turn: Turn| {
        let [heading, east, north] = turn.map(f64::to_radians);
        UnitQuaternion::from_scaled_axis(Vector3::new(east, north, -heading))
    };
    let mut settings = Settings { profile: Profile::Operational(Default::default()), ..Settings::default() };
    settings.add_receiver(Receiver {
        horizontal_m: 2.0,
        vertical_m: 3.0,
        delay_s: Some(0.0),
        period_s: 1.0,
        max_new_per_s: 50,
    });
    let position = Enu::new(300.0, -200.0, 5.0);
    let sigma = CAMERA_DEG.to_radians();
    settings.add_camera(Camera {
        position,
        azimuth: sigma,
        elevation: sigma,
        orientation: 5.0_f64.to_radians(),
    });
    let mut engine = Engine::new(settings).unwrap();
    let path = |drone: usize, seconds: f64| {
        let angle = [0.04, -0.03][drone] * seconds + 2.0 * drone as f64;
        let radius_m = [250.0, 400.0][drone];
        position.0 + Vector3::new(radius_m * angle.sin(), radius_m * angle.cos(), 60.0 + 40.0 * drone as f64)
    };
    for step in 0..1200 {
        let seconds = f64::from(step) * 0.2;
        let _ = engine.advance(at(seconds)).count();
        let turn = rotation(if seconds < later.0 { first } else { later.1 });
        for drone in 0..2 {
            let place = path(drone, seconds);
            if step % 5 == 0 {
                let reported = place + Vector3::new(normal(1.0), normal(1.0), normal(2.0));
                let identity = Identity::new(format!("DRONE{drone}").as_bytes(), None).unwrap();
                let fix = Fix::new(SensorIndex(0), identity, at(seconds), Enu::from(reported));
                engine.handle(Report::Fix(fix)).unwrap();
            }
            let seen = turn * (place - position.0);
            let bearing = Bearing {
                track: CameraTrackKey { sensor: SensorIndex(1), number: 1 + drone as u16 },
                time: at(seconds),
                azimuth: azimuth(&seen) + normal(sigma),
                elevation: Some(seen.z.atan2(seen.xy().norm()) + normal(sigma)),
            };
            engine.handle(Report::Bearing(bearing)).unwrap();
        }
    }
    let (_, oriented) = engine.oriented_cameras().next().unwrap();
    let found = oriented.orientation.misalignment();
    let axis = rotation(later.1).scaled_axis();
    let values = [found.bearing, found.tilt_east, found.tilt_north];
    let turned = oriented.turned.map(|time| time.seconds_since(at(0.0)));
    (
        [values.map(|value| value.value), [-axis.z, axis.x, axis.y], values.map(|value| value.deviation)],
        turned,
    )
}

#[test]
fn orientation_is_learnt_from_transponders() {
    let mut squares = 0.0;
    for seed in 2001..2021_u32 {
        let angle = |axis: u32| f64::from((seed * 37 + axis * 53) % 17) - 8.0;
        let turn = [angle(0), angle(1) / 2.0, angle(2) / 2.0];
        let ([found, right, deviations], turned) = learnt(seed.into(), turn, (0.0, turn));
        assert_eq!(turned, None, "{seed}");
        for ((found, right), deviation) in found.iter().zip(right).zip(deviations) {
            assert!((found - right).abs().to_degrees() < 0.1, "{seed} {turn:?}: {found} {right}");
            squares += ((found - right) / deviation).powi(2);
        }
    }
    let mean = squares / 60.0;
    println!("normalised squared error: {mean:.2}");
    assert!(mean < 1.6, "{mean}");
}

#[test]
fn turned_camera_is_learnt_anew() {
    for (seed, first, later) in
        [(1, [2.0, 0.5, -0.5], [5.0, 0.5, -0.5]), (2, [-3.0, 1.0, 0.0], [-3.0, -2.0, 0.0])]
    {
        let ([found, right, _], turned) = learnt(seed, first, (100.0, later));
        let turned_s = turned.unwrap();
        assert!((100.0..150.0).contains(&turned_s), "{turned_s}");
        for (found, right) in found.iter().zip(right) {
            assert!((found - right).abs().to_degrees() < 0.15, "{later:?}: {found} {right}");
        }
    }
}
