//! A radar whose configured position is wrong: found, moved by an operator, recorded and replayed.

use std::fs;

use fusion::operational::Relocation;
use fusion::time::Time;
use utm_fusion::config::{Config, Profile, Record, SensorKind};
use utm_fusion::record::{RecordedContents, Recorder};

use crate::common::{Scratch, beside, flight, only, replayed, utm_fusion};
use crate::driver::{Fate, Flown, fly};

const SCENARIO: &str = "name = \"misplaced\"\nduration_s = 150\n[drones]\nmultirotors = 12\nequipped = 12\n";
/// Error of the configured position, metres east and north.
const OFF_M: [f64; 2] = [24.0, -32.0];

/// The flight with the radar configured elsewhere, recorded below `scratch`.
fn recorded(seed: u64, off_m: [f64; 2], until_s: Option<i64>, scratch: &Scratch) -> (Config, Flown) {
    let simulation = flight(SCENARIO, seed, None);
    let mut config = simulation.config.clone();
    config.fusion.profile = Profile::Operational;
    let radar = config.sensors.iter_mut().find_map(|sensor| match &mut sensor.kind {
        SensorKind::Radar(radar) => Some(radar),
        _ => None,
    });
    let radar = radar.unwrap();
    radar.longitude_deg += off_m[0] / (111_320.0 * radar.latitude_deg.to_radians().cos());
    radar.latitude_deg += off_m[1] / 111_200.0;
    let record =
        Record { dir: scratch.path("recorded"), rotate_mib: 256, keep: 9, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) = Recorder::start(&config, &record, Vec::new(), RecordedContents::Service).unwrap();
    let fate = Fate { seed, queue_ms: 300, tick_ms: 400, relocate_until_s: until_s, ..Fate::default() };
    let flown = fly(&config, &simulation.datagrams, &fate, &queue);
    drop(queue);
    assert_eq!(recorder.join().unwritten, 0);
    (config, flown)
}

#[test]
fn misplaced_radar_is_moved_and_its_recording_replays() {
    let scratch = Scratch::new();
    let (_, flown) = recorded(1, OFF_M, Some(120), &scratch);
    let [(applied, Some(to)), (revoked, None)] = flown.relocations[..] else {
        panic!("{:?}", flown.relocations);
    };
    assert!(applied < revoked);
    // It stands where it was before its position was mistyped.
    let Relocation { east_m, north_m, .. } = to;
    assert!((east_m + OFF_M[0]).hypot(north_m + OFF_M[1]) < 15.0, "{to:?}");

    let dir = scratch.path("recorded");
    let input = only(&dir, "input-", ".pcap");
    let sent = fs::read(only(&dir, "output-", ".pcap")).unwrap();
    assert!(sent == replayed(&input));
    // Without the decisions the output is another, and the summary says why.
    fs::remove_file(beside(&input, "decisions.jsonl")).unwrap();
    assert!(sent != replayed(&input));
    let output =
        utm_fusion("replay").arg(&input).arg("--config").arg(beside(&input, "site.toml")).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("contradicted: it stands "), "{text}");
}

#[test]
fn correctly_placed_radar_is_not_contradicted() {
    for seed in [2, 3] {
        let (_, flown) = recorded(seed, [0.0, 0.0], Some(i64::MAX / 2_000_000_000), &Scratch::new());
        assert_eq!(flown.relocations, [], "{seed}");
    }
}

#[test]
fn relocation_survives_a_restart_unless_the_position_was_changed() {
    use utm_fusion::state::{parse_decisions, relocation_lines};

    let scratch = Scratch::new();
    let (mut config, _) = recorded(4, [0.0, 0.0], None, &scratch);
    let active = fusion::operational::ActiveRelocation {
        radar: fusion::SensorIndex(0),
        to: Relocation { east_m: 12.5, north_m: -3.25, bearing: 0.01 },
        since: fusion::slots::SlotGrid::new(config.fusion.slot)
            .of(Time::from_nanos(1_800_000_000_000_000_000)),
    };
    let text = relocation_lines(&[active], &config);
    let planned = |config: &Config| parse_decisions(&text).unwrap().plan(config).relocations;
    let [(since, decided)] = planned(&config)[..] else { panic!("{text}") };
    assert_eq!((since, decided.radar), (active.since, active.radar));
    let to = decided.to.unwrap();
    assert!((to.east_m, to.north_m) == (12.5, -3.25) && (to.bearing - 0.01).abs() < 1e-12);
    if let SensorKind::Radar(radar) = &mut config.sensors[0].kind {
        radar.latitude_deg += 1e-5;
    }
    assert_eq!(planned(&config), []);
    let far = text.replace("12.5", "1e9");
    assert!(parse_decisions(&far).unwrap_err().contains("at most 10 km"));
}
