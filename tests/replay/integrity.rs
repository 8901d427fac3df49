//! Untrusted transponders in the output of `replay`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{Scratch, ran, utm_fusion};

/// A flight of two drones; the operator distrusts one of them from the beginning.
const SCENARIO: &str = "name = \"distrust\"\nduration_s = 40\n[drones]\nmultirotors = 2\nequipped = 2\n";

fn text(path: &Path) -> String {
    String::from_utf8(fs::read(path).unwrap()).unwrap()
}

/// Simulates the flight. Returns the serial number of the distrusted drone.
fn distrust(scratch: &Scratch) -> String {
    let scenario = scratch.path("distrust.toml");
    fs::write(&scenario, SCENARIO).unwrap();
    let flown = ran(utm_fusion("simulate").arg(scenario).arg("--out").arg(scratch.path("flight")));
    assert_eq!(flown.code, 0, "{}", flown.stderr);
    let labels = text(&scratch.path("flight/labels.csv"));
    let report = labels.lines().find(|line| line.contains(",drone-it,")).unwrap();
    // The simulator's serial numbers count from 1.
    let serial = format!("{:0>12}", report.split(',').nth(2).unwrap());
    let line =
        format!("{{\"slot\":0,\"serial\":\"{serial}\",\"country\":\"GB\",\"verdict\":\"distrusted\"}}\n");
    fs::write(scratch.path("kept.decisions.jsonl"), line).unwrap();
    fs::write(scratch.path("kept.numbers.json"), "{\"version\":1,\"numbers\":[]}\n").unwrap();
    serial
}

/// Output of a replay as `out.EXTENSION`, and its alerts.
fn replayed(scratch: &Scratch, extension: &str, change: &[&str]) -> (String, String, String) {
    let (out, alerts) = (scratch.path(format!("out.{extension}")), scratch.path("alerts.ndjson"));
    let mut replay = utm_fusion("replay");
    replay.arg(scratch.path("flight/capture.pcap")).arg("--config").arg(scratch.path("flight/site.toml"));
    replay.arg("--state").arg(scratch.path("kept")).arg("-o").arg(&out).arg("--alerts").arg(&alerts);
    for variable in change.chunks_exact(2) {
        replay.env(variable[0], variable[1]);
    }
    let ran = ran(&mut replay);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    (text(&out), text(&alerts), ran.text().to_owned())
}

#[test]
fn untrusted_transponder_is_flagged_in_all_outputs() {
    let scratch = Scratch::new();
    let serial = distrust(&scratch);
    let (text, alerts, summary) = replayed(&scratch, "ndjson", &[]);
    let mut states = BTreeMap::<(bool, String), u32>::new();
    for line in text.lines() {
        let track: Value = serde_json::from_str(line).unwrap();
        let is_it = track["uas_id"]["serial_number"] == *serial;
        if track.get("uas_id").is_some() {
            *states.entry((is_it, track["integrity"].as_str().unwrap().to_owned())).or_default() += 1;
        } else {
            assert!(track.get("integrity").is_none(), "{track}");
        }
    }
    assert!(states.contains_key(&(true, "failed".to_owned())), "{states:?}");
    assert!(!states.contains_key(&(false, "failed".to_owned())), "{states:?}");
    assert!(summary.contains(&format!("flagged    {serial}")), "{summary}");

    let raised: Vec<Value> = alerts.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let its: Vec<&Value> = raised.iter().filter(|alert| alert["identity"] == *serial).collect();
    let [alert, ..] = its[..] else { panic!("{alerts}") };
    assert_eq!((&alert["kind"], &alert["severity"]), (&"integrity".into(), &"critical".into()), "{alerts}");
    assert!(alert["text"].as_str().unwrap().contains("an operator distrusts it"), "{alert}");

    let (table, again, _) = replayed(&scratch, "csv", &[]);
    assert_eq!(again, alerts);
    let columns = ",integrity,integrity_index,protection_level_m,offset_m,reasons,linked,uncooperative";
    assert!(table.lines().next().unwrap().contains(columns), "{table}");
    assert!(table.lines().any(|line| line.contains(",failed,")));
}

/// Three drones with Remote ID, birds, and twenty fake identities sent from among them.
const FAKES: &str = "name = \"fakes\"\nduration_s = 150\n[airspace]\nradius_m = 400\n[drones]\nmultirotors = 3\n[birds]\ncount = 5\n\
    [remote_id]\ndrones = 3\nfakes = 20\nfakes_east_m = 1100\nfakes_north_m = 1050\nfakes_after_s = [10, 20]\n";

/// Identities in the replay of a flight, by class, each with its number of points and of verified points.
fn verified(scratch: &Scratch, seed: u32) -> BTreeMap<String, BTreeMap<String, (u32, u32)>> {
    let (scenario, flight) = (scratch.path("fakes.toml"), scratch.path(format!("fakes-{seed}")));
    fs::write(&scenario, FAKES).unwrap();
    let mut simulate = utm_fusion("simulate");
    simulate.arg(scenario).arg("--out").arg(&flight).args(["--seed", &seed.to_string()]);
    let flown = ran(&mut simulate);
    assert_eq!(flown.code, 0, "{}", flown.stderr);
    let classes = text(&flight.join("classes.csv"));
    let classes: BTreeMap<&str, &str> = classes
        .lines()
        .map(|line| line.split(',').collect::<Vec<_>>())
        .map(|columns| (columns[3], columns[1]))
        .collect();
    let out = flight.join("out.ndjson");
    let mut replay = utm_fusion("replay");
    replay.arg(flight.join("capture.pcap")).arg("--config").arg(flight.join("site.toml")).arg("-o").arg(&out);
    let ran = ran(&mut replay);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let mut found = BTreeMap::<String, BTreeMap<String, (u32, u32)>>::new();
    for line in text(&out).lines() {
        let track: Value = serde_json::from_str(line).unwrap();
        let Some(serial) = track["uas_id"]["serial_number"].as_str() else { continue };
        let of_class = found.entry(classes[serial].to_owned()).or_default();
        let (points, verified) = of_class.entry(serial.to_owned()).or_default();
        *points += 1;
        *verified += u32::from(track["integrity"] == "verified");
    }
    found
}

#[test]
fn invented_identities_are_never_verified_real_drones_are() {
    let scratch = Scratch::new();
    let (mut real, mut of_real) = (0, (0, 0));
    for seed in [41, 42, 43, 44] {
        let found = verified(&scratch, seed);
        let (fakes, drones) = (&found["fake"], &found["unmanned"]);
        assert_eq!((fakes.len(), drones.len()), (20, 3), "{seed}");
        assert!(fakes.values().all(|&(points, verified)| points > 200 && verified == 0), "{seed} {fakes:?}");
        real += drones.values().filter(|drone| drone.1 > 0).count();
        of_real = drones.values().fold(of_real, |all, drone| (all.0 + drone.0, all.1 + drone.1));
    }
    assert!(real >= 9 && of_real.1 * 10 > of_real.0, "{real} of 12 drones, {of_real:?} points");
}

#[test]
fn integrity_off_adds_no_fields() {
    let scratch = Scratch::new();
    distrust(&scratch);
    let off = ["UTM_FUSION__INTEGRITY__ACTION", "off"];
    let reference = ["UTM_FUSION__FUSION__PROFILE", "reference", "UTM_FUSION__FUSION__NOW", "false"];
    for change in [&off[..], &reference[..]] {
        let (text, alerts, summary) = replayed(&scratch, "ndjson", change);
        assert!(!text.is_empty() && !text.contains("integrity") && !text.contains("uncooperative"));
        assert!(alerts.is_empty() && !summary.contains("flagged"), "{alerts}{summary}");
        let (table, ..) = replayed(&scratch, "csv", change);
        let states = ["unverified", "verified", "suspect", "failed"];
        assert!(!states.iter().any(|state| table.contains(&format!(",{state},"))), "{table}");
        if change == reference {
            assert!(table.lines().next().unwrap().ends_with(",alt_msl,flags"), "{table}");
        }
    }
}

/// Two drones that the radar sees all the time; the transponder of one jumps 100 m away and stays there.
const JUMP: &str = "name = \"twin\"\nduration_s = 120\n[drones]\nmultirotors = 2\nequipped = 2\nspoofed = 1\n\
    [[radars]]\nseen_s = 1000.0\nunseen_s = 1.0\nseduction_every_s = 0\n\
    [transponder]\nattack = \"jump\"\ngap_every_s = 0\nspoof_after_s = [30.0, 40.0]\n";

/// `[integrity] action = "flag"` without its three further options.
const MARKED: [&str; 6] = [
    "UTM_FUSION__INTEGRITY__ACCURACY",
    "false",
    "UTM_FUSION__INTEGRITY__SHOW_TWIN",
    "false",
    "UTM_FUSION__INTEGRITY__PROTECT",
    "false",
];

fn jump(scratch: &Scratch) {
    let scenario = scratch.file("jump.toml", JUMP);
    let mut simulate = utm_fusion("simulate");
    simulate.arg(scenario).args(["--seed", "2", "--out"]).arg(scratch.path("flight"));
    let flown = ran(&mut simulate);
    assert_eq!(flown.code, 0, "{}", flown.stderr);
    scratch.file("kept.numbers.json", "{\"version\":1,\"numbers\":[]}\n");
}

/// Points of a replay for which `holds` is true.
fn points(scratch: &Scratch, change: &[&str], holds: fn(&Value) -> bool) -> Vec<Value> {
    let (text, ..) = replayed(scratch, "ndjson", change);
    text.lines().map(|line| serde_json::from_str(line).unwrap()).filter(holds).collect()
}

/// Without these options, a flag is only a mark: no point is added, removed, moved or renumbered.
#[test]
fn a_flag_moves_no_point() {
    let scratch = Scratch::new();
    jump(&scratch);
    let table = |change: &[&str]| replayed(&scratch, "csv", change).0;
    let what_and_where = |table: &str| -> Vec<String> {
        table.lines().map(|line| line.split(',').take(9).collect::<Vec<_>>().join(",")).collect()
    };
    let (marked, off) = (table(&MARKED), table(&["UTM_FUSION__INTEGRITY__ACTION", "off"]));
    assert!(marked.contains(",suspect,"), "one is flagged");
    let off = what_and_where(&off);
    assert!(off.len() > 500 && what_and_where(&marked) == off);
    // With the options, the output differs.
    assert!(what_and_where(&table(&[])) != off);
}

#[test]
fn suspect_has_large_radius_and_separate_radar_aircraft() {
    let scratch = Scratch::new();
    jump(&scratch);
    let is_suspect = |point: &Value| point["integrity"] == "suspect";
    let is_poor = |point: &&Value| point["accuracy_h_m"].as_f64().unwrap() > 100.0;
    let (marked, flagged) = (points(&scratch, &MARKED, is_suspect), points(&scratch, &[], is_suspect));
    let poor = |points: &[Value]| points.iter().filter(is_poor).count();
    assert!(marked.len() > 100 && poor(&marked) == 0, "{}", poor(&marked));
    assert!(poor(&flagged) > flagged.len() * 9 / 10, "{} of {}", poor(&flagged), flagged.len());

    // The two tracks refer to each other.
    let is_disputed = |point: &Value| point["linked"][0]["relation"] == "disputed";
    assert!(points(&scratch, &MARKED, is_disputed).is_empty());
    let linked: BTreeMap<(String, String), String> = points(&scratch, &[], is_disputed)
        .into_iter()
        .map(|point| {
            let text = |value: &Value| value.as_str().unwrap().to_owned();
            assert_ne!(point["uncooperative"], true, "{point}");
            ((text(&point["time"]), text(&point["id"])), text(&point["linked"][0]["id"]))
        })
        .collect();
    assert!(linked.len() > 200, "{}", linked.len());
    for ((time, id), other) in &linked {
        assert_eq!(linked.get(&(time.clone(), other.clone())), Some(id));
    }
}

#[test]
fn split_transponder_is_never_fused() {
    let scratch = Scratch::new();
    distrust(&scratch);
    let is_fused = |point: &Value| point["integrity"] == "failed" && point["source"] == "fused";
    let is_failed = |point: &Value| point["integrity"] == "failed" && point["source"] == "transponder";
    let split = ["UTM_FUSION__INTEGRITY__ACTION", "split"];
    assert!(points(&scratch, &[], is_fused).len() > 10);
    assert!(points(&scratch, &split, is_fused).is_empty());
    assert!(points(&scratch, &split, is_failed).len() > 50);
}

#[test]
fn alerts_go_into_a_file_of_their_own() {
    let scratch = Scratch::new();
    distrust(&scratch);
    let capture = scratch.path("flight/capture.pcap");
    let usage = |arguments: &[&str]| {
        let mut replay = utm_fusion("replay");
        replay.arg(&capture).arg("--config").arg(scratch.path("flight/site.toml")).args(arguments);
        let ran = ran(&mut replay);
        assert_eq!(ran.code, 2, "{arguments:?}: {}", ran.stderr);
        ran.stderr
    };
    assert!(usage(&["--alerts", "-"]).contains("--alerts needs a file"));
    assert!(usage(&["--alerts", capture.to_str().unwrap()]).contains("is also an input"));
    assert!(usage(&["--alerts", "x.ndjson", "-o", "x.ndjson"]).contains("the same file"));
    assert!(usage(&["--alerts", "x.ndjson", "--udp", "--loop"]).contains("grow without end"));
}

/// Four of five drones have no transponder; the coverage of the receiver is a square of about ten kilometres around the
/// radar.
#[test]
fn drone_without_transponder_in_coverage_is_uncooperative() {
    let scratch = Scratch::new();
    let scenario = "name = \"alone\"\nduration_s = 120\n[drones]\nmultirotors = 5\nequipped = 1\n";
    let scenario = scratch.file("alone.toml", scenario);
    let flown = ran(utm_fusion("simulate").arg(scenario).arg("--out").arg(scratch.path("flight")));
    assert_eq!(flown.code, 0, "{}", flown.stderr);
    scratch.file("kept.numbers.json", "{\"version\":1,\"numbers\":[]}\n");
    let (_, alerts, _) = replayed(&scratch, "ndjson", &[]);
    assert!(!alerts.contains("uncooperative"), "nowhere without an area: {alerts}");

    let corners = "[-0.62,52.46],[-0.54,52.46],[-0.54,52.56],[-0.62,52.56],[-0.62,52.46]";
    let polygon = format!("{{\"type\":\"Polygon\",\"coordinates\":[[{corners}]]}}");
    scratch.file("flight/heard.geojson", polygon);
    let site = scratch.path("flight/site.toml");
    let area = "\n[[areas]]\nkind = \"coverage\"\nfile = \"heard.geojson\"\nsensor = \"drone-it\"\n";
    fs::write(&site, text(&site) + area).unwrap();
    let (tracks, alerts, summary) = replayed(&scratch, "ndjson", &[]);
    assert!(summary.contains("tracks without a transponder (uncooperative)"), "{summary}");
    let marked = |line: &&str| line.contains("\"uncooperative\":true");
    assert!(tracks.lines().any(|line| marked(&line)));
    assert!(tracks.lines().filter(marked).all(|line| !line.contains("uas_id")));
    let raised = alerts.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let alert = raised.into_iter().find(|alert| alert["kind"] == "uncooperative").unwrap();
    assert_eq!(alert["severity"], "warning");
    assert!(alert["text"].as_str().unwrap().contains("without a transponder"), "{alert}");
}

/// Short gaps are normal for transponders; a longer silence raises an alert.
#[test]
fn short_gap_raises_no_alert_and_a_silence_does() {
    let silences = |gap_s: &str| -> Vec<Value> {
        let scratch = Scratch::new();
        let scenario = format!(
            "name = \"gaps\"\nduration_s = 240\n[drones]\nmultirotors = 6\nequipped = 6\n\
             [transponder]\ngap_every_s = 90\ngap_s = {gap_s}\n"
        );
        let scenario = scratch.file("gaps.toml", scenario);
        let flown = ran(utm_fusion("simulate").arg(scenario).arg("--out").arg(scratch.path("flight")));
        assert_eq!(flown.code, 0, "{}", flown.stderr);
        scratch.file("kept.numbers.json", "{\"version\":1,\"numbers\":[]}\n");
        let (_, alerts, _) = replayed(&scratch, "ndjson", &[]);
        let alerts = alerts.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        alerts.filter(|alert| alert["kind"] == "silent" && alert.get("until").is_none()).collect()
    };
    assert_eq!(silences("[12, 20]"), [] as [Value; 0]);
    assert!(!silences("[50, 60]").is_empty());
}
