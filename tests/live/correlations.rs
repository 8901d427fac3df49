//! Operators' decisions are recorded, and the recording replays to the data sent.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use asterix::cat048::{self, DetectionType, PolarPosition, TargetReport, TrackNumber};
use asterix::{DataSource, Explicit, TimeOfDay, cat129, encode_block};
use serde_json::Value;
use utm_fusion::config::{Profile, SensorKind};
use utm_fusion::live::now;
use utm_fusion::normalise::time_of_day_count;
use utm_fusion::state::parse_decisions;

use crate::common::{
    Running, Scratch, ask, ask_with, beside, complete_from, datagrams, files, only, replayed,
    replayed_datagrams, utm_fusion,
};
use crate::driver::{Fate, SCENARIO, record};
use crate::stage::Stage;

#[test]
fn recording_with_decisions_replays_to_the_sent_output() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    let fate = Fate { seed: 7, queue_ms: 300, tick_ms: 400, decide_s: vec![25, 35, 45], ..Fate::default() };
    let flown = record(SCENARIO, None, &fate, &dir, 256);
    assert!(flown.correlations >= 2, "{} decisions", flown.correlations);
    let input = only(&dir, "input-", ".pcap");
    let sent = fs::read(only(&dir, "output-", ".pcap")).unwrap();
    let file = beside(&input, "decisions.jsonl");
    let text = fs::read_to_string(&file).unwrap();
    assert_eq!(parse_decisions(&text).unwrap().len(), flown.correlations, "{text}");
    assert!(sent == replayed(&input), "with {text}");

    // By any other path to the state.
    let replay = |state: &Path| {
        let out = scratch.path("again.pcap");
        let mut replay = utm_fusion("replay");
        replay.arg(&input).arg("--config").arg(beside(&input, "site.toml")).arg("--state").arg(state);
        let output = replay.arg("-o").arg(&out).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        output.status.success().then(|| fs::read(out).unwrap()).ok_or((output.status.code(), said))
    };
    assert!(replay(&beside(&input, "numbers.json")) == Ok(sent.clone()));
    // Damage is reported with its file and line.
    fs::write(&file, format!("{text}{}", &text[..20])).unwrap();
    let (code, said) = replay(&input.with_extension("")).unwrap_err();
    let line = flown.correlations + 1;
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains(&format!("{}: line {line}: EOF", file.display())), "{said}");
    fs::remove_file(&file).unwrap();
    assert!(replay(&input.with_extension("")) != Ok(sent), "decisions change nothing");
}

#[test]
fn operator_decision_is_applied_published_and_recorded() {
    let scenario = "name = \"live\"\nduration_s = 30\n[drones]\nmultirotors = 2\nequipped = 2\n";
    let stage = Stage::new(scenario, 22_500, |config, _| config.fusion.profile = Profile::Operational);
    let service = stage.run("run.log");
    let port = service.http_port();
    // The radar part and the serial number of the first fused track.
    let fused = || {
        let picture = ask(port, "GET", "/api/v1/tracks?source=fused").1;
        let properties = &picture["features"].as_array()?.first()?["properties"];
        let radar =
            properties["contributors"].as_array()?.iter().find(|part| part["kind"] == "radar")?.clone();
        Some((radar, properties["uas_id"]["serial_number"].as_str()?.to_owned()))
    };
    let mut correlated = None;
    let mut at_s = 0.0;
    while at_s < 30.0 {
        stage.send(at_s, at_s + 1.0);
        at_s += 1.0;
        if correlated.is_none() && at_s > 16.0 {
            let Some((radar, serial)) = fused() else { continue };
            let sensor = radar["sensor"].as_str().unwrap();
            let pair = format!("sensor={sensor}&track={}&uas={serial}", radar["track_number"]);
            let post =
                |verdict: &str| ask(port, "POST", &format!("/api/v1/correlations?{pair}&verdict={verdict}"));
            let (status, answer) = post("decorrelated");
            assert_eq!(status, 200, "{answer}");
            let held = &answer["correlations"][0];
            assert_eq!(
                (&held["verdict"], &held["track_number"]),
                (&"decorrelated".into(), &radar["track_number"])
            );
            assert_eq!(held["uas_id"]["serial_number"], serial.as_str());
            correlated = Some((pair, serial, radar));
        }
    }
    let (pair, serial, radar) = correlated.expect("nothing was fused");
    let picture = ask(port, "GET", "/api/v1/tracks").1;
    let together = picture["features"].as_array().unwrap().iter().any(|feature| {
        let properties = &feature["properties"];
        let is_part = |part: &Value| part["kind"] == "radar" && part["track_number"] == radar["track_number"];
        properties["uas_id"]["serial_number"] == serial.as_str()
            && properties["contributors"].as_array().unwrap().iter().any(is_part)
    });
    assert!(!together, "{picture}");
    let (status, refused) = ask(port, "POST", &format!("/api/v1/correlations?{pair}0&verdict=correlated"));
    assert_eq!(status, 404, "{refused}");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(
        log.contains(&format!("and transponder {serial}: decorrelated, by somebody without a token")),
        "{log}"
    );

    let dir = stage.scratch.path("recordings");
    let input = only(&dir, "input-", ".pcap");
    let text = fs::read_to_string(beside(&input, "decisions.jsonl")).unwrap();
    assert_eq!(parse_decisions(&text).unwrap().len(), 1, "{text}");
    assert!(fs::read(only(&dir, "output-", ".pcap")).unwrap() == replayed(&input));
}

/// Simulates a drone that flies straight, west of the radar, until stopped. Plots are sent four times a second under one
/// track number, and its transponder reports once a second.
fn fly_straight(stage: &Stage, stop: &AtomicBool) {
    const PERIOD: Duration = Duration::from_millis(250);
    let sender = stage.sender();
    let SensorKind::Radar(radar) = &stage.config.sensors[0].kind else {
        panic!("the first sensor is a radar")
    };
    let began = now();
    for count in 0.. {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        let time = now();
        let time_of_day = TimeOfDay::from_count(time_of_day_count(time));
        let range_m = 800.0 + 5.0 * time.seconds_since(began);
        let source = |index: usize| {
            let sensor = &stage.config.sensors[index];
            DataSource { sac: sensor.sac, sic: sensor.sic }
        };
        let detection = TargetReport::new(DetectionType::Primary);
        let plot = cat048::Record::builder(source(0), time_of_day, detection)
            .polar_position(PolarPosition::new(range_m, 270.0))
            .track_number(TrackNumber::new(NUMBER))
            .special_purpose(Explicit::new(&[250]));
        let mut octets = Vec::new();
        encode_block(&[plot.build().unwrap()], &mut octets).unwrap();
        sender.send_to(&octets, stage.to(0)).unwrap();
        if count % 4 == 0 {
            let longitude_deg =
                radar.longitude_deg - range_m / (111_320.0 * radar.latitude_deg.to_radians().cos());
            let place = cat129::Position::new(radar.latitude_deg, longitude_deg);
            let report = cat129::Record::builder(source(1), *b"NO", time_of_day, place)
                .serial_number(*b"STRAIGHT    ")
                .altitude_amsl(cat129::Altitude::from_metres(radar.assumed_height_amsl_m));
            octets.clear();
            encode_block(&[report.build().unwrap()], &mut octets).unwrap();
            sender.send_to(&octets, stage.to(1)).unwrap();
        }
        std::thread::sleep(PERIOD);
    }
}

/// Track number of that drone.
const NUMBER: u16 = 77;

#[test]
fn decision_survives_only_a_short_restart() {
    let scenario = "name = \"live\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
    let stage = Stage::new(scenario, 22_600, |config, _| {
        config.fusion.profile = Profile::Operational;
        config.sensors.truncate(2);
        // Tests the state files alone, without checkpoints.
        config.state.checkpoint_s = 0.0;
    });
    let port = Running::http_port;
    let held = |port: u16| ask(port, "GET", "/api/v1/correlations").1["correlations"].clone();
    let until = |what: &str, is_so: &mut dyn FnMut() -> bool| {
        let end = Instant::now() + Duration::from_secs(60);
        while !is_so() {
            assert!(Instant::now() < end, "not within 60 s: {what}");
            std::thread::sleep(Duration::from_millis(200));
        }
    };
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| fly_straight(&stage, &stop));
        let ended = Ended(&stop);
        let service = stage.run("first.log");
        let first = port(&service);
        let sensor = &stage.config.sensors[0].id;
        let wish =
            format!("/api/v1/correlations?sensor={sensor}&track={NUMBER}&uas=STRAIGHT&verdict=decorrelated");
        until("the track is there", &mut || ask(first, "POST", &wish).0 == 200);
        // The transponder is distrusted, too.
        let word = r#"{"verdict": "distrusted"}"#;
        until("it is heard", &mut || ask_with(first, "POST", "/api/v1/integrity/STRAIGHT", word).0 == 200);
        let said = |port: u16| ask(port, "GET", "/api/v1/integrity").1["identities"][0]["verdict"].clone();
        assert_eq!(said(first), "distrusted");
        let correlated = held(first);
        assert_eq!(correlated.as_array().unwrap().len(), 1, "{correlated}");
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{log}");

        // After a short restart the decision is restored.
        let service = stage.run("second.log");
        let second = port(&service);
        until("it holds again", &mut || held(second) == correlated && said(second) == "distrusted");
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{log}");
        let told = format!(
            "{sensor}\" track={NUMBER} transponder=\"STRAIGHT\" verdict=\"decorrelated\"}}: decision holds again"
        );
        assert!(log.contains(&told), "{log}");

        // After a restart longer than the radar keeps a number, the decision ends, and this is logged.
        std::thread::sleep(Duration::from_secs(8));
        let mut service = stage.run("third.log");
        service.says("decision ended with the restart");
        assert_eq!(held(port(&service)).as_array().unwrap().len(), 0);
        let third = port(&service);
        until("what was said lasts", &mut || said(third) == "distrusted");
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{log}");
        drop(ended);
    });
    // Each recording replays to the data sent, with the decisions that it began with. The slots before a restart were
    // published by the earlier run.
    let dir = stage.scratch.path("recordings");
    let (inputs, outputs) = (files(&dir, "input-", ".pcap"), files(&dir, "output-", ".pcap"));
    assert_eq!(inputs.len(), 3);
    for (input, output) in inputs.iter().zip(&outputs) {
        let from = complete_from(input) + stage.config.fusion.latency();
        let [sent, replayed] = [datagrams(output), replayed_datagrams(input)]
            .map(|all| all.into_iter().filter(|(due, _)| *due >= from).collect::<Vec<_>>());
        assert!(sent == replayed, "{}", input.display());
        assert_eq!(
            sent.len(),
            datagrams(output).len(),
            "{}: all that was sent is of slots of its own",
            input.display()
        );
    }
    let begun = fs::read_to_string(beside(&inputs[1], "decisions.jsonl")).unwrap();
    assert!(begun.contains("last_heard_ns") && begun.contains("distrusted"), "{begun}");
}

/// Ends the flight, even if the test fails.
struct Ended<'a>(&'a AtomicBool);

impl Drop for Ended<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
