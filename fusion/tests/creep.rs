//! A host that steers a radar's registration by forged positions.

#![expect(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use utm_fusion_engine::integrity::State;
use utm_fusion_engine::report::Host;
use utm_fusion_engine::settings::{Radar, RadarErrors, Receiver, RegistrationMode};
use utm_fusion_engine::time::SECOND;
use utm_fusion_engine::{
    Engine, Enu, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, Settings, Time,
};

const START_S: i64 = 1_700_000_000;
const TICK_S: f64 = 0.25;
const RECEIVER: SensorIndex = SensorIndex(1);
const FORGER: Host = Host(66);

/// A flight of drones with and without transponder, a radar, and a forger.
#[derive(Clone, Copy, Debug)]
struct Flight {
    duration_s: f64,
    bias_deg: f64,
    /// Number of drones whose positions the forger reports, and number of drones that report their own.
    forged: usize,
    honest: usize,
    /// Growth of the forger's angle, degrees a second, and its start, seconds.
    growth_deg_s: f64,
    after_s: f64,
    /// Whether the forger uses the radar's plots; otherwise it knows the drones' positions.
    by_plots: bool,
    /// Whether the radar detects each drone all the time.
    always_seen: bool,
    /// Number of hosts that report the honest drones.
    hosts: usize,
    /// Rotation of the radar after 200 s, degrees.
    step_deg: f64,
}

const ATTACK: Flight = Flight {
    duration_s: 300.0,
    bias_deg: 0.0,
    forged: 10,
    honest: 0,
    growth_deg_s: 0.02,
    after_s: 0.0,
    by_plots: true,
    always_seen: true,
    hosts: 1,
    step_deg: 0.0,
};

const CLEAN: Flight = Flight { bias_deg: 1.0, forged: 0, honest: 10, ..ATTACK };

struct Drone {
    position: Vector3<f64>,
    speed: f64,
    course: f64,
    turning: f64,
    /// Radar: whether the drone is detected until `until_s`, its track, its persistent errors.
    seen: bool,
    until_s: f64,
    track: u16,
    azimuth: f64,
    range_m: f64,
    height_m: f64,
    gnss: Vector3<f64>,
    period_s: f64,
    next_s: f64,
    late_s: f64,
    /// The latest plot, as the forger knows it: azimuth error (radians) and range error (metres).
    known: (f64, f64),
}

fn time(seconds: f64) -> Time {
    Time::from_nanos(START_S * SECOND + (seconds * 1e9).round() as i64)
}

fn identity(drone: usize, is_forged: bool) -> Identity {
    let text = if is_forged { format!("FAKE{drone:08}") } else { format!("{drone:012}") };
    Identity::new(text.as_bytes(), None).unwrap()
}

/// All reports, with the time of reception in seconds.
fn reports(flight: &Flight, seed: u64) -> Vec<(f64, Report)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    fn normal(random: &mut ChaCha8Rng) -> f64 {
        StandardNormal.sample(random)
    }
    let exponential = |random: &mut ChaCha8Rng, mean: f64| -mean * (1.0 - random.random::<f64>()).ln();
    let mut next_track = 0;
    let mut drones: Vec<Drone> = (0..flight.forged + flight.honest)
        .map(|drone| {
            let (azimuth, ground_m) = (TAU * random.random::<f64>(), random.random_range(400.0..2500.0));
            let seen = random.random::<f64>() < 0.47;
            let until_s = exponential(&mut random, 18.0);
            Drone {
                position: Vector3::new(
                    ground_m * azimuth.sin(),
                    ground_m * azimuth.cos(),
                    random.random_range(30.0..120.0),
                ),
                speed: random.random_range(4.0..16.0),
                course: TAU * random.random::<f64>(),
                turning: 0.0,
                seen: flight.always_seen || seen,
                until_s: if flight.always_seen { f64::INFINITY } else { until_s },
                track: {
                    next_track += 1;
                    next_track
                },
                azimuth: 1.25_f64.to_radians() * normal(&mut random),
                range_m: 4.0 * normal(&mut random),
                height_m: 8.0 * normal(&mut random),
                gnss: Vector3::from_fn(|_, _| 1.8 * normal(&mut random)),
                period_s: if drone < flight.forged { 1.0 } else { random.random_range(2.0..4.0) },
                next_s: random.random::<f64>(),
                late_s: random.random_range(0.0..0.25),
                known: (0.0, 0.0),
            }
        })
        .collect();
    let mut all = Vec::new();
    let ticks = (flight.duration_s / TICK_S) as usize;
    for tick in 0..ticks {
        let now_s = tick as f64 * TICK_S;
        for (index, drone) in drones.iter_mut().enumerate() {
            if random.random::<f64>() < TICK_S / 15.0 {
                drone.turning = random.random_range(-0.15..0.15);
            }
            let ground_m = drone.position.xy().norm();
            if !(350.0..3000.0).contains(&ground_m) {
                // Back to where the radar detects it well.
                let inward = (-drone.position.x).atan2(-drone.position.y);
                let wanted = if ground_m < 350.0 { inward + TAU / 2.0 } else { inward };
                let off = (wanted - drone.course).sin().atan2((wanted - drone.course).cos());
                drone.turning = off.clamp(-0.2, 0.2);
            }
            drone.course += drone.turning * TICK_S;
            let velocity = Vector3::new(drone.course.sin(), drone.course.cos(), 0.0) * drone.speed;
            drone.position += velocity * TICK_S;
            let kept = (-TICK_S / 20.0_f64).exp();
            let new = (1.0 - kept * kept).sqrt();
            let turn = if drone.turning.abs() > 0.05 { 1.7 } else { 1.0 };
            drone.azimuth = drone.azimuth * kept + turn * 1.25_f64.to_radians() * new * normal(&mut random);
            drone.range_m = drone.range_m * kept + 4.0 * new * normal(&mut random);
            drone.height_m = drone.height_m * kept + 8.0 * new * normal(&mut random);
            let kept = (-TICK_S / 60.0_f64).exp();
            let new = (1.0 - kept * kept).sqrt();
            drone.gnss = drone.gnss * kept + Vector3::from_fn(|_, _| 1.8 * new * normal(&mut random));
            if now_s >= drone.until_s {
                drone.seen = !drone.seen;
                drone.until_s = now_s + exponential(&mut random, if drone.seen { 18.0 } else { 20.0 });
                if drone.seen {
                    next_track += 1;
                    drone.track = next_track;
                    drone.azimuth = 1.25_f64.to_radians() * normal(&mut random);
                    drone.range_m = 4.0 * normal(&mut random);
                    drone.height_m = 8.0 * normal(&mut random);
                }
            }
            let truth = drone.position;
            let (azimuth, ground_m) = (truth.x.atan2(truth.y), truth.xy().norm());
            if drone.seen && random.random::<f64>() < 0.95 {
                let turned = drone.azimuth + 0.18_f64.to_radians() * normal(&mut random);
                let farther_m = drone.range_m + 2.0 * normal(&mut random);
                let knocked_deg = if now_s >= 200.0 { flight.step_deg } else { 0.0 };
                let off = azimuth + turned + (flight.bias_deg + knocked_deg).to_radians();
                let up = truth.z + drone.height_m + 2.5 * normal(&mut random);
                let ground_m = ground_m + farther_m;
                let place = Enu::new(ground_m * off.sin(), ground_m * off.cos(), up);
                let track = RadarTrackKey { sensor: SensorIndex(0), number: drone.track };
                let mut plot = Plot::new(track, time(now_s), place, place.0.norm());
                plot.uav_probability = Some(0.8);
                all.push((now_s + 0.4, Report::Plot(plot)));
                drone.known = (turned, farther_m);
            }
            if now_s >= drone.next_s {
                drone.next_s += drone.period_s;
                let is_forged = index < flight.forged;
                let place = if is_forged {
                    let (turned, farther_m) = if flight.by_plots { drone.known } else { (0.0, 0.0) };
                    let growth = flight.growth_deg_s * (now_s - flight.after_s).max(0.0);
                    let off = azimuth + turned + growth.to_radians();
                    let ground_m = ground_m + farther_m;
                    Enu::new(ground_m * off.sin(), ground_m * off.cos(), truth.z)
                } else {
                    (truth + drone.gnss + Vector3::from_fn(|_, _| 0.5 * normal(&mut random))).into()
                };
                let late_s = if is_forged { 0.0 } else { drone.late_s };
                let mut fix = Fix::new(RECEIVER, identity(index, is_forged), time(now_s + late_s), place);
                fix.host = if is_forged { FORGER } else { Host(1 + (index % flight.hosts) as u64) };
                all.push((now_s + 0.8, Report::Fix(fix)));
            }
        }
    }
    all.sort_by(|one, other| one.0.total_cmp(&other.0));
    all
}

#[derive(Debug, Default)]
struct Led {
    /// Bearing applied, degrees, by second of reception.
    applied_deg: Vec<f64>,
    alarm: Option<(f64, f64)>,
    verified: BTreeMap<Identity, f64>,
}

fn fly(flight: &Flight, seed: u64) -> Led {
    let mut settings = Settings::default();
    settings.add_radar(Radar {
        errors: RadarErrors::of_data_sheet(5.0, 1.0, 10.0),
        registration: RegistrationMode::Apply,
        learns_accuracy: true,
        period_s: TICK_S,
        ..Radar::default()
    });
    settings.add_receiver(Receiver {
        horizontal_m: 3.0,
        vertical_m: 5.0,
        period_s: 3.0,
        ..Receiver::default()
    });
    let mut engine = Engine::new(settings).unwrap();
    let mut led = Led::default();
    for (received_s, report) in reports(flight, seed) {
        let slots = engine.advance(time(received_s)).count();
        engine.handle(report).unwrap();
        if slots == 0 || received_s < led.applied_deg.len() as f64 {
            continue;
        }
        let Some((_, registered)) = engine.registered().next() else { continue };
        let bearing = registered.estimate.bearing;
        led.applied_deg.push(if bearing.observable { bearing.value.to_degrees() } else { 0.0 });
        if let (None, Some(creep)) = (led.alarm, registered.creep()) {
            led.alarm = Some((received_s, creep.window_s));
        }
        for known in engine.assessments() {
            if known.integrity.state == State::Verified {
                led.verified.insert(known.identity, received_s);
            }
        }
    }
    led
}

impl Led {
    /// The largest bearing applied, degrees.
    fn most_deg(&self) -> f64 {
        self.applied_deg.iter().fold(0.0, |most, value| value.abs().max(most))
    }

    /// Time from which the bearing applied stayed within `limit_deg` of the truth, seconds.
    fn within_s(&self, truth_deg: f64, limit_deg: f64) -> usize {
        let is_off = |value: &f64| (value - truth_deg).abs() > limit_deg;
        self.applied_deg.iter().rposition(is_off).map_or(0, |last| last + 1)
    }
}

/// Asserts that at most `most_deg` was applied, with an alarm within a minute of the first turn, and nothing verified
/// after it.
fn assert_unsteered(flight: &Flight, seeds: std::ops::RangeInclusive<u64>, most_deg: f64) {
    for seed in seeds {
        let led = fly(flight, seed);
        assert!(led.most_deg() <= most_deg, "{seed}: {:?}", led.applied_deg);
        let (alarm_s, _) = led.alarm.unwrap();
        assert!(alarm_s <= flight.after_s + 60.0, "{seed}: {alarm_s}");
        let latest = led.verified.iter().filter(|(who, _)| who.name().starts_with(b"FAKE"));
        let latest_s = latest.map(|(_, &at)| at).fold(0.0, f64::max);
        assert!(latest_s <= alarm_s + 2.0, "{seed}: verified at {latest_s}, alarm at {alarm_s}");
    }
}

#[test]
fn bearing_that_one_host_turns_is_not_followed() {
    assert_unsteered(&ATTACK, 201..=205, 0.25);
}

#[test]
fn bearing_that_turns_faster_is_not_followed() {
    assert_unsteered(&Flight { growth_deg_s: 0.05, ..ATTACK }, 201..=203, 0.5);
}

#[test]
fn bearing_that_turns_after_two_minutes_is_not_followed() {
    assert_unsteered(&Flight { after_s: 120.0, ..ATTACK }, 201..=203, 0.25);
}

#[test]
fn bearing_of_honest_drones_is_applied_without_an_alarm() {
    for (always_seen, hosts) in [(true, 1), (true, 4), (false, 1)] {
        for seed in 201..=203 {
            let led = fly(&Flight { always_seen, hosts, ..CLEAN }, seed);
            assert_eq!(led.alarm, None, "{seed}");
            let first_s = led.applied_deg.iter().position(|value| *value != 0.0).unwrap();
            assert!(first_s <= 60, "{seed}: {first_s}");
            assert!(led.within_s(1.0, 0.7) < 290, "{seed}: {:?}", led.applied_deg);
        }
    }
}

/// Figures of an attack or of a clean flight: `UTM_FUSION_FIRST` and `UTM_FUSION_LAST` are its seeds, and each field of
/// the flight has such a variable, too.
#[test]
#[ignore = "prints figures"]
fn figures_of_flights() {
    let var = |name: &str, default: f64| {
        std::env::var(format!("UTM_FUSION_{name}")).map_or(default, |text| text.parse().unwrap())
    };
    let flight = Flight {
        duration_s: var("DURATION", 300.0),
        bias_deg: var("BIAS", 0.0),
        forged: var("FORGED", 10.0) as usize,
        honest: var("HONEST", 0.0) as usize,
        growth_deg_s: var("GROWTH", 0.02),
        after_s: var("AFTER", 0.0),
        by_plots: var("PLOTS", 1.0) > 0.0,
        always_seen: var("SEEN", 1.0) > 0.0,
        hosts: var("HOSTS", 1.0) as usize,
        step_deg: var("STEP", 0.0),
    };
    let truth = flight.bias_deg + flight.step_deg;
    let mut all = Vec::new();
    for seed in var("FIRST", 201.0) as u64..=var("LAST", 203.0) as u64 {
        let led = fly(&flight, seed);
        let first = led.applied_deg.iter().position(|value| *value != 0.0).unwrap_or(9999);
        let within = led.within_s(truth, 0.3);
        let off = |value: &f64| (value - truth).abs();
        let mean = led.applied_deg.iter().map(off).sum::<f64>() / led.applied_deg.len() as f64;
        let late = led.verified.values().filter(|at| **at > 200.0).count();
        let (most, end) = (led.most_deg(), led.applied_deg.last().map_or(9.9, off));
        let alarm = led.alarm.map_or(9999, |alarm| alarm.0 as usize);
        if var("ALL", 0.0) > 0.0 {
            println!(
                "{seed}: most {most:.2} first {first} within {within} mean {mean:.3} end {end:.2} alarm {:?} verified {late}",
                led.alarm
            );
        }
        all.push([most, first as f64, within as f64, mean, end, alarm as f64, late as f64]);
    }
    for (column, name) in
        ["most", "first", "within0.3", "mean off", "end off", "alarm", "verified"].iter().enumerate()
    {
        let mut values: Vec<f64> = all.iter().map(|row| row[column]).collect();
        values.sort_by(f64::total_cmp);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        println!(
            "{name:>10}: min {:.2} median {:.2} max {:.2} mean {mean:.3}  {:?}",
            values[0],
            values[values.len() / 2],
            values[values.len() - 1],
            values.iter().map(|v| (v * 100.0).round() / 100.0).collect::<Vec<_>>()
        );
    }
}
