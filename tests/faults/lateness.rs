//! A late picture, whatever the cause: all interfaces report the same.

use std::io::{BufRead, BufReader, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asterix::{DataSource, cat129, encode_block};
use serde_json::Value;
use utm_fusion::config::{AlertArea, Area, AreaKind, Config};
use utm_fusion::live::now;
use utm_fusion::normalise::time_of_day_count;

use crate::common::{Running, group, joined};
use crate::http::{address, get, json, metric, troubled, until};
use crate::recorded::pairs;
use crate::stage::Stage;
use crate::{quick, scenario};

const SOON: Duration = Duration::from_secs(30);

/// Counts the degraded CAT065 statuses sent to the stage's output, until stopped.
fn count_degraded(stage: &Stage) -> (Arc<AtomicBool>, std::thread::JoinHandle<usize>) {
    let socket = joined(group(99), stage.config.output.asterix[0].port, Ipv4Addr::LOCALHOST);
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = stop.clone();
    let counting = std::thread::spawn(move || {
        let (mut degraded, mut octets) = (0, [0; 65536]);
        loop {
            match socket.recv(&mut octets) {
                // NOGO is in the two highest bits of I065/040, the last item.
                Ok(11) if octets[0] == 65 => degraded += usize::from(octets[10] >> 6 == 1),
                Ok(_) => {}
                Err(_) if stopped.load(Ordering::Relaxed) => return degraded,
                Err(_) => {}
            }
        }
    });
    (stop, counting)
}

/// Greatest `late_s` of the stream's heartbeats.
fn latest_heartbeat(address: SocketAddr) -> Arc<Mutex<f64>> {
    let mut socket = TcpStream::connect(address).unwrap();
    socket.write_all(b"GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let worst = Arc::new(Mutex::new(0.0_f64));
    let told = worst.clone();
    std::thread::spawn(move || {
        let mut is_heartbeat = false;
        for line in BufReader::new(socket).lines().map_while(Result::ok) {
            if let Some(event) = line.strip_prefix("event: ") {
                is_heartbeat = event == "heartbeat";
            } else if let Some(data) = line.strip_prefix("data: ").filter(|_| is_heartbeat) {
                let data: Value = serde_json::from_str(data).unwrap();
                let late_s = data["late_s"].as_f64().unwrap_or(0.0);
                let mut worst = told.lock().unwrap();
                *worst = late_s.max(*worst);
            }
        }
    });
    worst
}

fn with_status(config: &mut Config) {
    quick(config);
    config.output.status = true;
}

fn lines<'a>(log: &'a str, text: &str) -> Vec<&'a str> {
    log.lines().filter(|line| line.contains(text)).collect()
}

fn is_healthy(address: SocketAddr) -> bool {
    get(address, "/readyz").0 == 200 && json(address, "/api/v1/status")["state"] == "ok"
}

fn freeze(service: &Running, pause: Duration) {
    service.signal("-STOP");
    std::thread::sleep(pause);
    service.signal("-CONT");
}

#[test]
fn paused_service_reports_lateness_until_on_time() {
    let stage = Stage::new(&scenario(60), 24_610, |config, _| with_status(config));
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    let (stop, degraded) = count_degraded(&stage);
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 30.0));
        until("good health", SOON, || is_healthy(address));
        let heartbeats = latest_heartbeat(address);
        assert!(metric(address, "utm_fusion_picture_late_seconds", "") < 1.0);
        assert_eq!(metric(address, "utm_fusion_condition", ""), 2.0);
        // Shorter than the window: the pending slots are published, late.
        freeze(&service, Duration::from_secs(4));

        let mut not_ready = (0, String::new());
        until("not ready", SOON, || {
            not_ready = get(address, "/readyz");
            not_ready.0 == 503
        });
        assert!(
            not_ready.1.contains("the picture is ") && not_ready.1.contains(" s late"),
            "{}",
            not_ready.1
        );
        let status = json(address, "/api/v1/status");
        assert!(status["state"] == "degraded" && status["ready"] == false, "{status}");
        assert!(status["late_s"].as_f64().unwrap() > 1.0, "{status}");
        assert!(status["reasons"].to_string().contains("the picture is "), "{status}");
        assert_eq!(metric(address, "utm_fusion_condition", ""), 0.0);
        assert!(metric(address, "utm_fusion_picture_late_seconds", "") > 1.0);

        until("good health again", SOON, || is_healthy(address) && troubled(address).is_empty());
        assert!(*heartbeats.lock().unwrap() > 1.0, "no heartbeat said that the picture was late");
        let ended = json(address, "/api/v1/alerts")["ended"].to_string();
        assert!(
            ended.contains("\"part\":\"picture\"") && ended.contains("\"severity\":\"critical\""),
            "{ended}"
        );
    });
    stop.store(true, Ordering::Relaxed);
    assert!(degraded.join().unwrap() > 0, "CAT065 called itself operational");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    let began = lines(&log, "alert began text=\"the picture is ");
    assert!(began.len() == 1 && began[0].contains("ERROR"), "{log}");
    assert_eq!(lines(&log, "alert ended").iter().filter(|line| line.contains("the picture")).count(), 1);
    for blamed in ["stepped back", "was set back", "did not keep up", "overloaded"] {
        assert!(!log.contains(blamed), "{blamed}\n{log}");
    }
}

/// A new transponder, somewhere over the site.
fn stranger(number: u32) -> Vec<u8> {
    let serial: [u8; 12] = format!("FLOOD{number:07}").as_bytes().try_into().unwrap();
    let position = cat129::Position::new(52.4 + f64::from(number % 1000) * 1e-4, -0.6).unwrap();
    let time = asterix::TimeOfDay::from_count(time_of_day_count(now()));
    let record = cat129::Record::builder(DataSource { sac: 0, sic: 0 }, *b"GB", time, position)
        .serial_number(serial)
        .altitude_amsl(cat129::Altitude::from_metres(50.0))
        .build()
        .unwrap();
    let mut block = Vec::new();
    encode_block(&[record], &mut block).unwrap();
    block
}

/// Lateness of the shown picture, as computed by a reader from its time.
fn seen_late_s(address: SocketAddr, config: &Config) -> f64 {
    let picture = json(address, "/api/v1/tracks?limit=1");
    let Some(time) = picture["time"].as_str() else { return 0.0 };
    let time: jiff::Timestamp = time.parse().unwrap();
    let due_after_s = (config.fusion.latency() - config.fusion.slot / 2).as_secs_f64();
    let next_due_s = time.as_nanosecond() as f64 * 1e-9 + due_after_s + config.fusion.slot.as_secs_f64();
    now().as_seconds() - next_due_s
}

#[test]
fn transponder_flood_never_hides_lateness() {
    let stage = Stage::new(&scenario(40), 24_620, |config, _| with_status(config));
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    let (mut worst_s, mut told_late, mut passed_off) = (0.0_f64, false, Vec::new());
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 30.0));
        until("good health", SOON, || is_healthy(address));
        let flood = scope.spawn(|| {
            let sender = stage.sender();
            let start = Instant::now();
            for number in 0..20_000_u32 {
                if number % 20 == 0 {
                    let due = start + Duration::from_millis(u64::from(number / 2));
                    std::thread::sleep(due.saturating_duration_since(Instant::now()));
                }
                sender.send_to(&stranger(number), stage.to(1)).unwrap();
            }
        });
        // Until the picture has been on time for a while after the flood; a slow machine takes minutes.
        let (end, mut on_time) = (Instant::now() + Duration::from_secs(240), 0);
        while on_time < 20 {
            assert!(Instant::now() < end, "{worst_s} s at worst; still late");
            // The answer was correct at some time between these two.
            let before_s = seen_late_s(address, &stage.config);
            let asked = Instant::now();
            let (ready, _) = get(address, "/readyz");
            let took = asked.elapsed();
            let late_s = before_s.min(seen_late_s(address, &stage.config) - took.as_secs_f64());
            worst_s = worst_s.max(late_s);
            told_late |= ready == 503;
            if late_s > 1.5 && ready == 200 {
                passed_off.push(late_s);
            }
            on_time = if late_s < 0.5 && ready == 200 && flood.is_finished() { on_time + 1 } else { 0 };
            std::thread::sleep(Duration::from_millis(100));
        }
    });
    eprintln!("{worst_s:.1} s late at worst, told: {told_late}");
    assert!(passed_off.is_empty(), "ready, with a picture so many seconds late: {passed_off:?}");

    let lost = metric(address, "utm_fusion_recorder_lost_total", "");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    for blamed in ["stepped back", "was set back", "disk is too slow"] {
        assert!(!log.contains(blamed), "{blamed}\n{log}");
    }
    let lost_by_log = lines(&log, "the recorder did not keep up")
        .last()
        .map_or(0.0, |line| line.split_once("since_start=").unwrap().1.trim().parse().unwrap());
    assert_eq!(lost, lost_by_log, "the metric and the log disagree\n{log}");
    // Each loss costs a pair of files, not a pair for each datagram that fits in between.
    let pairs = pairs(&stage.scratch.path("recordings"));
    assert!(!pairs.is_empty() && pairs.len() < 4, "{pairs:?}\n{log}");
}

#[test]
fn each_new_alert_is_logged_with_its_area_name() {
    let polygon = r#"{"type":"Feature","properties":{"name":"Runway 27"},"geometry":{"type":"Polygon",
        "coordinates":[[[-2,51],[1,51],[1,54],[-2,54],[-2,51]]]}}"#;
    let stage = Stage::new(&scenario(60), 24_630, |config, scratch| {
        quick(config);
        config.areas = vec![Area {
            kind: AreaKind::Alert(AlertArea::default()),
            file: scratch.file("field.geojson", polygon),
        }];
    });
    // No data is sent yet: both sensors fall silent in the same second.
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    service.says("alert began");
    until("both alerts", SOON, || json(address, "/api/v1/alerts")["alerts"].as_array().unwrap().len() == 2);
    let log = service.log();
    for sensor in &stage.config.sensors {
        let began = lines(&log, &format!("alert began text=\"{} outage", sensor.id));
        assert!(began.len() == 1 && began[0].contains("ERROR"), "{log}");
    }
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 20.0));
        service.says("is inside Runway 27");
        until("two aircraft inside", SOON, || lines(&service.log(), "is inside Runway 27").len() > 1);
    });
    let told = json(address, "/api/v1/alerts").to_string();
    let tracks = json(address, "/api/v1/tracks");
    let known = tracks["features"].as_array().unwrap().iter().map(|track| &track["properties"]);
    let equipped = known.filter(|properties| properties["uas_id"].is_object()).count();
    assert!(equipped > 0, "{tracks}");
    let log = service.log();
    let inside = lines(&log, "is inside Runway 27");
    let names = |line: &&&str| line.contains(" subject=\"") && line.contains("WARN");
    assert!(inside.iter().filter(names).count() > 0, "{log}");
    assert!(!log.contains("is inside field") && told.contains("is inside Runway 27"), "{told}");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
}
