//! How fast the engine is, and how its time grows with the traffic.
//!
//! Throughput is in seconds of flight per second: `thrpt: 1.5 Kelem/s` is 1500 times real time, on one core.

#![allow(missing_docs, reason = "criterion's macro makes public items")]

use std::time::{Duration, Instant};

use asterix::{Record, TimeOfDay, cat048, cat129, encode_block};
use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion, Throughput, criterion_group};
use fusion::frames::TangentPlane;
use fusion::time::Time;
use fusion::{Engine, Enu, Plot, RadarTrackKey, Report, SensorIndex, Settings};
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, Profile};
use utm_fusion::normalise::{Normaliser, time_of_day_count};
use utm_fusion::pipeline::Pipeline;

#[path = "../tests/traffic/mod.rs"]
mod traffic;

use traffic::{SLOT_NS, Traffic, feed};

const FLIGHT_S: i64 = 120;

/// Reports in, points out.
fn dense(criterion: &mut Criterion) {
    let slots: Vec<Vec<Report>> =
        (0..seconds(FLIGHT_S)).map(|slot| Traffic::DENSE.reports(slot).collect()).collect();
    let fly = |settings: Settings| {
        let mut engine = Engine::new(settings).expect("the settings are right");
        (0..)
            .zip(&slots)
            .map(|(slot, reports)| feed(&mut engine, slot, reports.iter().copied()))
            .sum::<usize>()
    };
    let mut group = criterion.benchmark_group("50 drones and 60 birds, engine");
    group.throughput(Throughput::Elements(FLIGHT_S as u64)).sample_size(20);
    let profiles = [("reference", Traffic::DENSE.reference()), ("operational", Traffic::DENSE.operational())];
    for (profile, settings) in profiles {
        println!("{profile}: {} points in {FLIGHT_S} s", fly(settings.clone()));
        group.bench_function(profile, |bencher| bencher.iter(|| fly(settings.clone())));
    }
    group.finish();
}

/// Datagrams in, points out: decoder and normalisation included.
fn end_to_end(criterion: &mut Criterion) {
    let config = |profile| {
        let mut config = Config::parse(SITE, "site.toml", std::iter::empty()).expect("the site is valid");
        config.fusion.profile = profile;
        config
    };
    let profiles = [("reference", config(Profile::Reference)), ("operational", config(Profile::Operational))];
    let config = &profiles[0].1;
    let frame = Normaliser::new(config, Masks::default()).frame().clone();
    let datagrams: Vec<Reception> =
        (0..seconds(FLIGHT_S)).flat_map(|slot| receptions(slot, &frame)).collect();
    let fly = |config: &Config| {
        let mut pipeline = Pipeline::new(config, Masks::default());
        let mut points = 0;
        for datagram in &datagrams {
            pipeline.receive(datagram);
            points += pipeline.emissions().map(|emission| emission.points.len()).sum::<usize>();
        }
        points
    };
    let mut group = criterion.benchmark_group("50 drones and 60 birds, end to end");
    group.throughput(Throughput::Elements(FLIGHT_S as u64)).sample_size(20);
    for (profile, config) in &profiles {
        println!("{profile}: {} datagrams, {} points in {FLIGHT_S} s", datagrams.len(), fly(config));
        group.bench_function(*profile, |bencher| bencher.iter(|| fly(config)));
    }
    group.finish();
}

/// Time of a slot over the number of radar tracks, at constant density, half of them with a transponder; and of one with
/// 2,000 of both.
fn growth(criterion: &mut Criterion) {
    for profile in ["reference", "operational"] {
        let settings = |traffic: Traffic| match profile {
            "reference" => traffic.reference(),
            _ => traffic.operational(),
        };
        let mut group = criterion.benchmark_group(format!("slot, {profile}"));
        group.sample_size(20);
        let mut measured = Vec::new();
        for targets in [500, 1_000, 2_000, 4_000] {
            let traffic = Traffic { targets, drones: targets / 2 };
            let times = slots(&mut group, traffic, settings(traffic), format!("{targets} radar tracks"));
            measured.push((targets as f64, times));
        }
        let growth = exponent(&measured);
        println!("{profile}: time of a slot grows with the number of tracks to the power of {growth:.2}");
        let traffic = Traffic { targets: 2_000, drones: 2_000 };
        slots(&mut group, traffic, settings(traffic), "2,000 radar tracks and 2,000 transponders".to_owned());
        group.finish();
    }
}

/// Time of a slot while numbers of one radar jump by kilometres with each plot.
fn jumping(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("slot with jumping numbers, operational");
    group.sample_size(20);
    for numbers in [0, 750, 1_500, 3_000] {
        let mut engine = Engine::new(Traffic::DENSE.operational()).expect("the settings are right");
        let reports = |slot: i64| Traffic::DENSE.reports(slot).chain(jumps(slot, numbers));
        let warm = seconds(40);
        for slot in 0..warm {
            feed(&mut engine, slot, reports(slot));
        }
        let mut slots = warm..;
        group.bench_function(format!("{numbers} numbers"), |bencher| {
            let next = || slots.next().map(|slot| (slot, reports(slot).collect::<Vec<_>>()));
            bencher.iter_batched(
                next,
                |batch| batch.map(|(slot, reports)| feed(&mut engine, slot, reports)),
                BatchSize::PerIteration,
            );
        });
        println!("{numbers} numbers: the state has {:.2} MB", 1e-6 * engine.checkpoint().len() as f64);
    }
    group.finish();
}

/// Plots of a slot, each kilometres from the one before under its number.
fn jumps(slot: i64, numbers: u16) -> impl Iterator<Item = Report> {
    (0..numbers).map(move |number| {
        let track = RadarTrackKey { sensor: SensorIndex(0), number: 1000 + number };
        let away = |step: i64| 9_000.0 + ((slot * step + i64::from(number) * 61) % 97) as f64 * 200.0;
        let place = Enu::new(away(31), away(53), 100.0);
        Report::Plot(Plot::new(track, Time::from_nanos(slot * SLOT_NS), place, place.0.norm()))
    })
}

/// The state as octets, and back.
fn checkpoints(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("checkpoint, operational");
    group.sample_size(20);
    for targets in [110, 1_000, 2_000] {
        let traffic = Traffic { targets, drones: targets / 2 };
        let settings = traffic.operational();
        let mut engine = Engine::new(settings.clone()).expect("the settings are right");
        for slot in 0..seconds(40) {
            feed(&mut engine, slot, traffic.reports(slot));
        }
        let octets = engine.checkpoint();
        println!("{targets} radar tracks: {:.2} MB", 1e-6 * octets.len() as f64);
        group.bench_function(format!("{targets} radar tracks, written"), |bencher| {
            bencher.iter(|| engine.checkpoint());
        });
        group.bench_function(format!("{targets} radar tracks, read"), |bencher| {
            bencher.iter(|| Engine::restored(settings.clone(), &octets).expect("it is whole"));
        });
    }
    group.finish();
}

/// Measures slots of this traffic once it has settled, and prints quantiles of their durations. Returns the shortest, seconds.
fn slots(
    group: &mut BenchmarkGroup<'_, WallTime>,
    traffic: Traffic,
    settings: Settings,
    name: String,
) -> f64 {
    let mut engine = Engine::new(settings).expect("the settings are right");
    let warm = seconds(40);
    for slot in 0..warm {
        feed(&mut engine, slot, traffic.reports(slot));
    }
    let mut slots = warm..;
    let mut times = Vec::new();
    group.bench_function(name, |bencher| {
        let next = || slots.next().map(|slot| (slot, traffic.reports(slot).collect::<Vec<_>>()));
        bencher.iter_batched(
            next,
            |batch| {
                let start = now();
                let points = batch.map(|(slot, reports)| feed(&mut engine, slot, reports));
                times.push(start.elapsed());
                points
            },
            BatchSize::PerIteration,
        );
    });
    times.sort_unstable();
    let at =
        |share: f64| times.get((share * times.len() as f64) as usize).map_or(f64::NAN, Duration::as_secs_f64);
    let [least, median, most] = [0.0, 0.5, 0.999].map(at);
    println!("of {} slots: median {:.1} ms, p99.9 {:.1} ms", times.len(), 1e3 * median, 1e3 * most);
    least
}

/// Slope of the straight line through the logarithms, by least squares.
fn exponent(measured: &[(f64, f64)]) -> f64 {
    let logs = || measured.iter().map(|&(x, y)| (x.ln(), y.ln()));
    let count = measured.len() as f64;
    let (mean_x, mean_y) = logs().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x / count, sy + y / count));
    let (sxy, sxx) = logs().fold((0.0, 0.0), |(sxy, sxx), (x, y)| {
        (sxy + (x - mean_x) * (y - mean_y), sxx + (x - mean_x).powi(2))
    });
    sxy / sxx
}

#[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
fn now() -> Instant {
    Instant::now()
}

fn seconds(count: i64) -> i64 {
    count * 1_000_000_000 / SLOT_NS
}

/// One datagram for the radar's plots of a slot, one for each transponder report.
fn receptions(slot: i64, frame: &TangentPlane) -> Vec<Reception> {
    let mut plots = Vec::new();
    let mut payloads = Vec::new();
    for report in Traffic::DENSE.reports(slot) {
        let time_of_day = TimeOfDay::from_count(time_of_day_count(report.time()));
        match report {
            Report::Plot(plot) => plots.push(cat048::Record {
                data_source: Some(RADAR),
                time_of_day,
                polar_position: cat048::PolarPosition::new(
                    plot.slant_range_m,
                    plot.position.east().atan2(plot.position.north()).to_degrees(),
                ),
                track_number: cat048::TrackNumber::new(plot.track.number),
                height_3d: cat048::Height3D::from_metres(frame.to_geodetic(plot.position).height_m),
                ..cat048::Record::default()
            }),
            Report::Bearing(_) => unreachable!("the traffic has no camera"),
            Report::Fix(fix) => {
                let place = frame.to_geodetic(fix.position);
                payloads.push(block(&[cat129::Record {
                    data_source: Some(TRANSPONDER),
                    serial_number: Some(fix.items.serial_number),
                    time_of_day,
                    position: cat129::Position::new(place.latitude_deg(), place.longitude_deg()),
                    altitude_amsl: cat129::Altitude::from_metres(place.height_m),
                    ..cat129::Record::default()
                }]));
            }
        }
    }
    payloads.push(block(&plots));
    let reception = |payload| Reception {
        received: Some(Traffic::received(slot)),
        input: 0,
        from: None,
        kind: ReceptionKind::Datagram,
        origin: 0,
        payload,
    };
    payloads.into_iter().map(reception).collect()
}

fn block<R: Record>(records: &[R]) -> Vec<u8> {
    let mut octets = Vec::new();
    encode_block(records, &mut octets).expect("the records fit into a block");
    octets
}

const RADAR: asterix::DataSource = asterix::DataSource { sac: 1, sic: 2 };
const TRANSPONDER: asterix::DataSource = asterix::DataSource { sac: 1, sic: 3 };
const SITE: &str = r#"
[site]
name = "bench"
sac = 1
sic = 1
geoid_undulation_m = 0.0

[[sensors]]
kind = "radar"
id = "radar"
sac = 1
sic = 2
latitude_deg = 53.0
longitude_deg = 10.0
height_amsl_m = 0.0

[[sensors]]
kind = "transponder"
id = "transponder"
sac = 1
sic = 3
"#;

criterion_group!(benches, dense, end_to_end, growth, jumping, checkpoints);
criterion::criterion_main!(benches);
