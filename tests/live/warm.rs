//! A service that is restarted at once continues as if it had not stopped.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use bytes::Bytes;
use fusion::time::Time;
use jiff::SignedDuration;
use proptest::prelude::*;
use serde_json::Value;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, Profile};
use utm_fusion::live::{Driver, DriverEvent, PublishedPicture, now};
use utm_fusion::simulate::Simulation;
use utm_fusion::state::WarmState;

use crate::common::{Running, ask, flight};
use crate::driver::SCENARIO;
use crate::stage::Stage;

fn reception(simulation: &Simulation, index: usize) -> Reception {
    let datagram = &simulation.datagrams[index];
    Reception {
        received: Some(datagram.received),
        input: usize::from(datagram.payload[0] == 129),
        from: Some("127.0.0.1:40000".parse().unwrap()),
        kind: ReceptionKind::Datagram,
        origin: 0,
        payload: datagram.payload.clone(),
    }
}

/// Published slots by their centres.
type Slots = BTreeMap<Time, String>;

fn take(driver: &mut Driver, slots: &mut Slots) {
    while let Some(made) = driver.poll() {
        if let DriverEvent::Slot(PublishedPicture { picture, now, .. }) = made {
            assert!(slots.insert(picture.time, format!("{picture:?} {now:?}")).is_none(), "published twice");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Compared with a service that never stopped, and did not receive the datagrams that the other one missed.
    #[test]
    fn restart_at_any_time_continues_the_output(
        seed in 1..50_u64,
        written in 0.1..0.9_f64,
        more in 0..200_usize,
        away_s in 0..20_i64,
        is_operational in any::<bool>(),
    ) {
        let simulation = flight(SCENARIO, seed, None);
        let mut config: Config = simulation.config.clone();
        config.fusion.profile = if is_operational { Profile::Operational } else { Profile::Reference };
        let count = simulation.datagrams.len();
        let start = simulation.datagrams[0].received;
        let written = (written * count as f64) as usize;
        let stopped = (written + more).min(count - 1);
        let back = simulation.datagrams[stopped].received + SignedDuration::from_secs(away_s);
        let heard = |index: &usize| *index <= stopped || simulation.datagrams[*index].received > back;

        let mut always = Driver::new(&config, Masks::default(), start, 2);
        let mut expected = Slots::new();
        for index in (0..count).filter(heard) {
            always.receive(&reception(&simulation, index));
            take(&mut always, &mut expected);
        }

        let mut driver = Driver::new(&config, Masks::default(), start, 2);
        let mut slots = Slots::new();
        let mut warm = WarmState { engine: Bytes::new(), encoders: Bytes::new(), inputs: Vec::new(), published: None, until: start };
        for index in 0..=stopped {
            let received = reception(&simulation, index);
            driver.receive(&received);
            take(&mut driver, &mut slots);
            if index == written {
                warm.engine = driver.checkpoint(&config);
            } else if index > written {
                warm.inputs.push(received);
            }
        }
        let mut driver = Driver::new(&config, Masks::default(), back, 2);
        driver.resume(&config, Masks::default(), &warm, back).unwrap();
        for index in (stopped + 1..count).filter(heard) {
            driver.receive(&reception(&simulation, index));
            take(&mut driver, &mut slots);
        }
        // Only slots that were due during the stop are missing.
        for (time, slot) in &expected {
            match slots.get(time) {
                Some(published) => prop_assert_eq!(published, slot, "{}", time),
                None => {
                    let due = *time + config.fusion.latency();
                    let away = simulation.datagrams[stopped].received..=back + SignedDuration::from_millis(250);
                    prop_assert!(away.contains(&due), "{} is missing", time);
                }
            }
        }
    }
}

/// Ids of the tracks in the picture, with their first times.
fn shown(port: u16) -> BTreeMap<String, Value> {
    let picture = ask(port, "GET", "/api/v1/tracks").1;
    let features = picture["features"].as_array().cloned().unwrap_or_default();
    let of = |feature: &Value| {
        let properties = &feature["properties"];
        (properties["id"].as_str().unwrap().to_owned(), properties["first_seen"].clone())
    };
    features.iter().map(of).collect()
}

fn soon(service: &Running) -> BTreeMap<String, Value> {
    let asked = Instant::now();
    loop {
        let shown = shown(service.http_port());
        if !shown.is_empty() || asked.elapsed() > Duration::from_secs(3) {
            return shown;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Centre of the first slot that the service shows.
fn first_shown(port: u16) -> Time {
    let asked = Instant::now();
    loop {
        let picture = ask(port, "GET", "/api/v1/tracks").1;
        if let Some(time) = picture["time"].as_str() {
            let time: jiff::Timestamp = time.parse().unwrap();
            return Time::from_nanos(time.as_nanosecond() as i64);
        }
        assert!(asked.elapsed() < Duration::from_secs(12), "no slot");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// At a regular stop, a service publishes its remaining slots early. If the next run does not know up to which slot, it
/// publishes no slot that may have been published. Without an earlier run it begins at once.
#[test]
fn start_without_the_published_mark_repeats_no_slot() {
    let scenario = "name = \"live\"\nduration_s = 30\n[drones]\nmultirotors = 2\nequipped = 2\n";
    let stage = Stage::new(scenario, 24_900, |_, _| {});
    let shown = |log: &str, from_s: f64, until_s: f64| {
        let started = now();
        let service = stage.run(log);
        let shown = std::thread::scope(|scope| {
            let shown = scope.spawn(|| first_shown(service.http_port()));
            stage.send(from_s, until_s);
            shown.join().unwrap()
        });
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{log}");
        (started, shown, log)
    };
    let (started, first, log) = shown("first.log", 0.0, 8.0);
    assert!(first < started && !log.contains("an earlier service was here"), "{first} {started} {log}");
    std::fs::remove_file(stage.config.state.dir.join("engine.warm")).unwrap();
    let (started, first, log) = shown("second.log", 10.0, 20.0);
    assert!(first > started && log.contains("an earlier service was here"), "{first} {started} {log}");
}

/// Killed, and stopped as by systemd: the same aircraft are shown again with the next slot.
#[test]
fn killed_service_shows_the_same_aircraft_after_restart() {
    let scenario = "name = \"live\"\nduration_s = 40\n[drones]\nmultirotors = 3\nequipped = 2\n";
    let stage = Stage::new(scenario, 23_900, |config, _| config.state.checkpoint_s = 2.0);
    let mut service = stage.run("first.log");
    stage.send(0.0, 22.0);
    let before = shown(service.http_port());
    assert!(!before.is_empty(), "nobody is there");
    service.signal("-KILL");
    let (_, log) = service.wait(Duration::from_secs(5));
    assert!(!log.contains("the engine goes on"), "{log}");

    let service = stage.run("second.log");
    let after = soon(&service);
    for (id, first_seen) in &before {
        assert_eq!(after.get(id), Some(first_seen), "{id} of {before:?} in {after:?}");
    }
    stage.send(24.0, 31.0);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("engine state restored"), "{log}");

    let service = stage.run("third.log");
    stage.send(32.0, 40.0);
    let third = soon(&service);
    for (id, first_seen) in &before {
        assert_eq!(third.get(id), Some(first_seen), "{id} of {before:?} in {third:?}");
    }
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("engine state restored"), "{log}");
}
