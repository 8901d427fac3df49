//! Scores of integrity flags, computed by hand.
//!
//! ALPHA and BRAVO carry transponders 7 and 8; CHARLIE carries none. They are 2 km apart in a row to the east, from 0
//! to 200 s. Transponders report every 2 s. A slot is published 6.25 s after it opens.

use std::collections::BTreeSet;

use fusion::integrity::{Reason, Reasons, State};
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use utm_fusion::evaluate::{
    AlertLine, Attack, AttackDetection, AttackKind, Covariance, GeodeticPlace, IntegrityFlight,
    IntegrityScore, Label, Labels, OutputPoint, PointFlags, PointSource, Scoring, Truth, integrity,
};

use super::common::{Scratch, assert_near, east, ran, utm_fusion};

fn at(second: f64) -> Time {
    Time::from_nanos((second * 1e9).round() as i64)
}

fn place(east_m: f64) -> GeodeticPlace {
    GeodeticPlace { latitude_deg: 0.0, longitude_deg: east(east_m), altitude_amsl_m: Some(0.0) }
}

/// Inputs of the score.
struct Scene {
    /// Speed of ALPHA to the north, metres per second.
    speed_m_s: f64,
    labels: Vec<Label>,
    reports: Vec<OutputPoint>,
    attacks: Vec<Attack>,
    output: Vec<OutputPoint>,
    alerts: Option<Vec<AlertLine>>,
}

impl Scene {
    /// Reports every 2 s from 0 to 198 s; those of transponder 7 are offset to the east of ALPHA.
    fn new(kind: AttackKind, offset_m: fn(f64) -> f64) -> Self {
        let mut scene = Self {
            speed_m_s: 0.0,
            labels: Vec::new(),
            reports: Vec::new(),
            attacks: vec![attack("ALPHA", 7, kind, 60.0)],
            output: Vec::new(),
            alerts: None,
        };
        for step in 0..100 {
            let second = f64::from(step) * 2.0;
            scene.report(second, 7, Some("ALPHA"), offset_m(second));
            scene.report(second, 8, Some("BRAVO"), 2000.0);
        }
        scene
    }

    fn report(&mut self, second: f64, number: u32, id: Option<&str>, east_m: f64) {
        self.label(second, "squitter", number, id, false);
        let point = point(second, PointSource::Transponder, number, east_m);
        self.reports.push(OutputPoint { transponder: Some(number), ..point });
    }

    fn label(&mut self, second: f64, sensor: &str, number: u32, id: Option<&str>, seduced: bool) {
        let (sensor, id) = (sensor.to_owned(), id.map(str::to_owned));
        self.labels.push(Label { time: at(second), sensor, number, id, seduced, identity: None });
    }

    /// Plots of radar track 11, which is ALPHA's.
    fn plots(&mut self, seconds: impl IntoIterator<Item = f64>) {
        seconds.into_iter().for_each(|second| self.label(second, "radar", 11, Some("ALPHA"), false));
    }

    /// A point of this transponder in each of these slots, with its integrity.
    fn flag(&mut self, number: u32, slots: impl IntoIterator<Item = i64>, state: State, reasons: &[Reason]) {
        let integrity = Some((state, reasons.iter().copied().collect::<Reasons>()));
        for slot in slots {
            let east_m = f64::from(number - 7) * 2000.0 + 120.0;
            let point = point(0.25 * slot as f64 + 0.125, PointSource::Transponder, number, east_m);
            let flags = PointFlags { integrity, is_uncooperative: false };
            self.output.push(OutputPoint { transponder: Some(number), flags, ..point });
        }
    }

    fn scored(&self) -> IntegrityScore {
        let drone = |(index, id): (usize, &str)| {
            let sample = |second: i32| {
                let north_m = if index == 0 { self.speed_m_s * f64::from(second) } else { 0.0 };
                let latitude_deg = super::common::north(north_m);
                (at(second.into()), GeodeticPlace { latitude_deg, ..place(2000.0 * index as f64) })
            };
            (id.to_owned(), (0..=200).map(sample).collect())
        };
        let truth = Truth::new(["ALPHA", "BRAVO", "CHARLIE"].into_iter().enumerate().map(drone));
        let labels = Labels::with_receivers(self.labels.clone(), &BTreeSet::from(["squitter".to_owned()]));
        integrity(&IntegrityFlight {
            truth: &truth,
            labels: &labels,
            reports: &self.reports,
            attacks: &self.attacks,
            output: &self.output,
            alerts: self.alerts.as_deref(),
            settings: &Scoring::default(),
        })
    }

    /// Detection of the only attack.
    fn detection(&self) -> AttackDetection {
        let mut attacks = self.scored().attacks;
        assert_eq!(attacks.len(), 1);
        attacks.remove(0)
    }
}

fn attack(id: &str, number: u32, kind: AttackKind, from_s: f64) -> Attack {
    Attack { id: id.to_owned(), number, kind, from: at(from_s), until: at(200.0) }
}

fn point(second: f64, source: PointSource, number: u32, east_m: f64) -> OutputPoint {
    OutputPoint {
        time: at(second),
        place: place(east_m),
        source,
        number,
        radar_track: None,
        sensor: None,
        transponder: None,
        identity: None,
        covariance: None,
        flags: PointFlags::default(),
    }
}

/// A point of a radar track alone.
fn radars(slot: i64, track: u16, east_m: f64) -> OutputPoint {
    let point = point(0.25 * slot as f64 + 0.125, PointSource::Radar, track.into(), east_m);
    OutputPoint { radar_track: Some(track), ..point }
}

/// 2 m/s from 60 s on: 20 m at 70 s, 40 m at 80 s.
fn drift() -> Scene {
    let mut scene = Scene::new(AttackKind::Drift, |second| 2.0 * (second - 60.0).max(0.0));
    // From 70 to 118.75 s: ten distinct seconds. The plots at 69.9 and 118.8 s are outside.
    scene.plots([69.9, 70.1, 70.6]);
    scene.plots((71..=78).map(f64::from));
    scene.plots([118.7, 118.8]);
    scene.label(90.0, "radar", 11, Some("ALPHA"), true);
    scene
}

fn near(found: Option<f64>, expected: f64) {
    assert!((found.unwrap() - expected).abs() < 1e-3, "{found:?} is not {expected}");
}

/// Another identity already has the number that equals the serial number of the attacked transponder.
#[test]
fn attacked_transponder_is_found_by_serial_number() {
    let mut scene = Scene::new(AttackKind::Jump, |second| if second < 60.0 { 0.0 } else { 120.0 });
    scene.flag(7, [300], State::Suspect, &[Reason::Jump]);
    scene.flag(8, [280], State::Suspect, &[Reason::Radar]);
    let expected = scene.scored();
    assert_eq!((expected.attacks[0].delay_s.is_some(), expected.clean.flags.len()), (true, 1));
    for point in scene.reports.iter_mut().chain(&mut scene.output) {
        let (number, identity) = match point.transponder {
            Some(7) => (429_496, "000000000007"),
            _ => (7, "SMTR70000008"),
        };
        (point.transponder, point.identity) = (Some(number), Some(identity.to_owned()));
    }
    for row in &mut scene.labels {
        let identity = if row.number == 7 { "000000000007" } else { "SMTR70000008" };
        row.identity = Some(identity.to_owned()).filter(|_| row.sensor == "squitter");
    }
    let told = scene.scored();
    assert_eq!(told.attacks, expected.attacks);
    assert_eq!(told.clean.identity_h, expected.clean.identity_h);
    assert_eq!(told.clean.flags.iter().map(|flag| flag.number).collect::<Vec<_>>(), [7]);
    assert_eq!(told.clean.flags[0].from, expected.clean.flags[0].from);
}

#[test]
fn drift_delay_counts_from_40_m_offset() {
    let mut scene = drift();
    // Opens at 115 s, published at 121.25 s.
    scene.flag(7, 460..463, State::Suspect, &[Reason::Radar]);
    scene.flag(7, 463..=470, State::Failed, &[Reason::Radar, Reason::Velocity]);
    let found = scene.detection();
    near(found.begin.map(Time::as_seconds), 80.0);
    near(found.delay_s, 41.25);
    near(found.delay_by_s(Reason::Radar), 41.25);
    near(found.delay_by_s(Reason::Velocity), 42.0);
    assert_eq!((found.delay_by_s(Reason::Jump), found.named_delay_s()), (None, found.delay_s));
    assert_eq!((found.seen_s, found.is_observable, found.is_silent), (10, true, false));
    scene.labels.retain(|label| label.time != at(118.7));
    let found = scene.detection();
    assert_eq!(
        (found.seen_s, found.is_observable),
        (9, false),
        "118.8 s is too late, at 90 s it had walked off"
    );
}

#[test]
fn drift_flagged_before_40_m_has_negative_delay() {
    let mut scene = drift();
    // Published at 68.25 s, with an offset of 16.5 m.
    scene.flag(7, [248], State::Suspect, &[Reason::Radar]);
    near(scene.detection().delay_s, -11.75);
    assert_eq!(scene.scored().clean.flags, []);
    scene.attacks[0].until = at(70.0);
    assert_eq!((scene.detection().begin, scene.detection().delay_s), (None, None), "it never comes to 40 m");
}

#[test]
fn flag_before_the_attack_is_false_even_if_it_lasts() {
    let mut scene = drift();
    // Published at 59.75, 60 and 60.25 s.
    scene.flag(7, 214..=216, State::Suspect, &[Reason::Radar]);
    assert_eq!(scene.scored().clean.flags.len(), 1);
    near(scene.detection().delay_s, 60.0 - 80.0);
}

#[test]
fn honest_hours_are_summed_and_near_flags_merged() {
    let mut scene = drift();
    scene.flag(8, 100..=104, State::Suspect, &[Reason::Jump]);
    scene.flag(8, 105..=110, State::Verified, &[]);
    scene.flag(8, [123], State::Failed, &[Reason::Replay]); // 4.75 s after the last: the same flag
    scene.flag(8, [143], State::Suspect, &[Reason::Jump]); // 5 s after that: another flag
    let clean = scene.scored().clean;
    // ALPHA until the attack; BRAVO from the first report to the last.
    near(Some(clean.identity_h), (60.0 + 198.0) / 3600.0);
    let spans: Vec<_> = clean.flags.iter().map(|flag| (flag.number, flag.from, flag.until)).collect();
    assert_eq!(spans, [(8, at(31.25), at(37.0)), (8, at(42.0), at(42.0))]);
    assert_eq!(clean.flags[0].reasons, [Reason::Jump, Reason::Replay].into_iter().collect());
}

#[test]
fn flagged_drone_coverage_is_scored() {
    let mut scene = drift();
    scene.flag(7, [460, 488], State::Suspect, &[Reason::Radar]); // 7 s apart: two flags
    scene.flag(7, [474], State::Suspect, &[Reason::Radar]); // now one flag
    // Seen in slots 464, 472, 476, and, through drift(), in 474 and 475 at 118.7 and 118.8 s.
    scene.plots([116.0, 118.0, 119.1]);
    scene.output.extend([radars(464, 11, 59.9), radars(472, 11, 60.1), radars(480, 11, 0.0)]);
    let covariance =
        Some(Covariance { east_m2: 900.0, north_m2: 900.0, east_north_m2: 0.0, vertical_m2: 1.0 });
    scene.output[0] = OutputPoint { place: place(30.0), covariance, ..scene.output[0].clone() };
    scene.output[1] = OutputPoint { place: place(60.0), covariance, ..scene.output[1].clone() };
    let shown = scene.detection().shown;
    // In slot 474 the transponder itself is 120 m off. Errors of one and of two standard deviations: 1 / 2 and 4 / 2.
    assert_eq!((shown.seen_slots, shown.near_slots, shown.points), (5, 1, 2));
    near(shown.near_share(), 0.2);
    near(shown.nees(), 1.25);
}

#[test]
fn attack_begins_with_first_false_report_unless_silent() {
    let mut scene = Scene::new(AttackKind::Frozen, |_| 0.0);
    // Published at 70.25 and 85.25 s.
    scene.flag(7, 256..300, State::Suspect, &[Reason::Radar]);
    scene.flag(7, 316..400, State::Suspect, &[Reason::Frozen]);
    let found = scene.detection();
    near(found.begin.map(Time::as_seconds), 60.0);
    near(found.delay_s, 10.25);
    near(found.named_delay_s(), 25.25);
    let is_silent = |from: f64, until: f64| {
        let mut scene = Scene::new(AttackKind::Frozen, |_| 0.0);
        scene.reports.retain(|report| report.time <= at(from) || report.time >= at(until));
        scene.detection().is_silent
    };
    assert!(!is_silent(70.0, 78.0), "8 s are none");
    assert!(is_silent(70.0, 80.0) && is_silent(88.0, 98.0), "before the limit of 30 s");
    assert!(!is_silent(90.0, 100.0), "behind it");
    assert!(is_silent(50.0, 60.0) && !is_silent(48.0, 58.0), "ended by the first lie, or before it");
    assert!(is_silent(80.0, 300.0) && !is_silent(90.0, 300.0), "the last report");
}

#[test]
fn first_report_of_another_sender_begins_the_attack() {
    let mut replayed = Scene::new(AttackKind::Replay, |_| 0.0);
    replayed.report(61.5, 7, None, 40.0);
    near(replayed.detection().begin.map(Time::as_seconds), 61.5);
    let mut swapped = Scene::new(AttackKind::Swapped, |_| 0.0);
    swapped.report(63.5, 7, Some("BRAVO"), 2000.0);
    swapped.attacks.push(attack("BRAVO", 8, AttackKind::Swapped, 60.0));
    let begins = swapped.scored().attacks.into_iter().map(|attack| attack.begin.unwrap().as_seconds());
    let begins: Vec<f64> = begins.collect();
    assert_eq!(begins, [63.5, 60.0]);
}

#[test]
fn time_shift_is_visible_in_fast_flight() {
    let mut scene = Scene::new(AttackKind::Time, |_| 0.0);
    scene.plots((130..=143).map(f64::from));
    scene.plots([143.7, 143.8]);
    let seen_s = |scene: &mut Scene, speed_m_s: f64| {
        scene.speed_m_s = speed_m_s;
        scene.detection().seen_s
    };
    // Until 83.75 s after 60 s.
    assert_eq!([7.9, 8.1].map(|speed_m_s| seen_s(&mut scene, speed_m_s)), [0, 14]);
    scene.plots([144.5]);
    assert_eq!(seen_s(&mut scene, 8.1), 14);
}

#[test]
fn jamming_is_three_at_a_time() {
    let alert = |id: &str, kind: &str, since_s: f64| AlertLine {
        id: id.to_owned(),
        kind: kind.to_owned(),
        since: at(since_s),
        until: None,
        is_critical: false,
        tracks: Vec::new(),
        identity: None,
        area: None,
        text: String::new(),
    };
    let mut scene = Scene::new(AttackKind::Jammed, |_| 0.0);
    assert_eq!(scene.scored().jamming, None, "alerts are not known");
    scene.alerts = Some(vec![
        alert("jamming-1", "jamming", 30.125),
        alert("integrity-2", "integrity", 70.125),
        alert("jamming-3", "jamming", 80.125), // published at 86.25 s
        alert("jamming-3", "jamming", 80.125), // the alert ends
    ]);
    let jamming = scene.scored().jamming.unwrap();
    assert_eq!((jamming.jammed, jamming.delay_s, jamming.false_alerts), (1, None, 2));
    scene.attacks.push(attack("BRAVO", 8, AttackKind::Jammed, 65.0));
    scene.attacks.push(attack("CHARLIE", 9, AttackKind::Jammed, 70.0));
    let scored = scene.scored();
    let jamming = scored.jamming.unwrap();
    assert_eq!((jamming.jammed, jamming.delay_s, jamming.false_alerts), (3, Some(16.25), 1));
    assert!(scored.attacks.is_empty(), "who is jammed does not lie");
    near(Some(scored.clean.identity_h), 2.0 * 198.0 / 3600.0);
}

#[test]
fn uncooperative_mark_counts_within_20_s() {
    let mut scene = Scene::new(AttackKind::Drift, |_| 0.0);
    let mark = |slot: i64, track: u16, east_m: f64, is_uncooperative: bool| OutputPoint {
        flags: PointFlags { integrity: None, is_uncooperative },
        ..radars(slot, track, east_m)
    };
    for (track, id) in [(12, "CHARLIE"), (13, "CHARLIE"), (14, "CHARLIE"), (15, "ALPHA"), (16, "BRAVO")] {
        (100..=300).for_each(|slot| scene.label(0.25 * slot as f64, "radar", track, Some(id), false));
    }
    let grid = SlotGrid::default();
    assert_eq!(grid.of(at(25.0)), Slot(100));
    // 80 slots are 20 s. Number 12 is marked in the eightieth slot, number 13 in the next; number 14 is not published
    // for 20 s.
    scene.output.extend((100..220).map(|slot| mark(slot, 12, 4000.0, slot >= 179)));
    scene.output.extend((100..220).map(|slot| mark(slot, 13, 4000.0, slot >= 180)));
    scene.output.extend((100..179).map(|slot| mark(slot, 14, 4000.0, true)));
    scene.output.extend((100..110).map(|slot| mark(slot, 15, 0.0, slot == 105)));
    scene.output.extend((100..110).map(|slot| mark(slot, 16, 2000.0, false)));
    // ALPHA sends false positions from 50 s on; a mark before that is false.
    let found = scene.scored().uncooperative;
    assert_eq!((found.aircraft, found.marked, found.false_marks, found.marked_liars), (2, 1, 1, 0));
    let lied_s: f64 = scene.attacks.iter().map(|lie| lie.until.min(at(200.0)).seconds_since(lie.from)).sum();
    near(Some(found.equipped_h), (2.0 * 200.0 - lied_s) / 3600.0);
    // A mark that moves to an equipped drone with its number does not count.
    (301..=400).for_each(|slot| scene.label(0.25 * slot as f64, "radar", 12, Some("BRAVO"), false));
    scene.output.extend((301..400).map(|slot| mark(slot, 12, 2000.0, true)));
    // A new mark on a drone whose transponder sends false positions is correct.
    (301..=400).for_each(|slot| scene.label(0.25 * slot as f64, "radar", 17, Some("ALPHA"), false));
    scene.output.extend((301..400).map(|slot| mark(slot, 17, 0.0, slot > 350)));
    let found = scene.scored().uncooperative;
    assert_eq!((found.aircraft, found.marked, found.false_marks, found.marked_liars), (2, 1, 1, 1));
}

/// Simulates and replays a flight with an attack on a transponder.
fn flight(scratch: &Scratch) {
    let scenario = "name = \"lie\"\nduration_s = 60\n[drones]\nmultirotors = 2\nequipped = 2\nspoofed = 1\n\
                    [transponder]\nattack = \"jump\"\nspoof_after_s = [20, 20]\n";
    let scenario = scratch.file("lie.toml", scenario);
    let flown =
        ran(utm_fusion("simulate").arg(scenario).args(["--seed", "2", "--out"]).arg(scratch.path("flight")));
    assert_eq!(flown.code, 0, "{}", flown.stderr);
    replay(scratch, "out.csv");
}

fn replay(scratch: &Scratch, output: &str) {
    let of = |name: &str| scratch.path("flight").join(name);
    let mut replay = utm_fusion("replay");
    replay.arg(of("capture.pcap")).arg("--config").arg(of("site.toml"));
    replay.arg("--alerts").arg(scratch.path("alerts.ndjson"));
    let replayed = ran(replay.arg("-o").arg(scratch.path(output)));
    assert_eq!(replayed.code, 0, "{}", replayed.stderr);
}

fn evaluate(scratch: &Scratch) -> std::process::Command {
    evaluate_this(scratch, "out.csv")
}

fn evaluate_this(scratch: &Scratch, output: &str) -> std::process::Command {
    let of = |name: &str| scratch.path("flight").join(name);
    let mut command = utm_fusion("evaluate");
    command.arg(scratch.path(output)).arg("--truth").arg(of("truth.csv"));
    command.arg("--labels").arg(of("labels.csv")).arg("--config").arg(of("site.toml"));
    command.arg("--capture").arg(of("capture.pcap"));
    command
}

#[test]
fn missing_attacks_file_is_reported() {
    let scratch = Scratch::new();
    flight(&scratch);
    let known = ran(evaluate(&scratch).args(["--integrity", "--json"])).json();
    assert_eq!(known["integrity"]["attacks_known"], true);
    let [attack] = &known["integrity"]["attacks"].as_array().unwrap()[..] else { panic!("{known}") };
    assert_eq!(attack["kind"], "jump");
    let clean_h = known["integrity"]["clean"]["identity_h"].as_f64().unwrap();
    assert!(
        ran(evaluate(&scratch).arg("--json")).json().get("integrity").is_none(),
        "only where it is asked for"
    );

    let aside = scratch.path("aside.csv");
    std::fs::rename(scratch.path("flight").join("attacks.csv"), &aside).unwrap();
    let unknown = ran(evaluate(&scratch).arg("--integrity"));
    assert_eq!(unknown.code, 0, "{}", unknown.stderr);
    assert!(unknown.stderr.contains("no attacks.csv beside the truth"), "{}", unknown.stderr);
    assert!(unknown.stdout.contains("it is not known whether any does"), "{}", unknown.stdout);
    let unknown = ran(evaluate(&scratch).args(["--integrity", "--json"])).json();
    assert_eq!(unknown["integrity"]["attacks_known"], false);
    assert!(unknown["integrity"]["clean"]["identity_h"].as_f64().unwrap() > clean_h, "nobody is attacked");

    let named = ran(evaluate(&scratch).args(["--integrity", "--json", "--attacks"]).arg(&aside)).json();
    assert_eq!(named["integrity"], known["integrity"]);
    assert_near(&named, "integrity.clean.identity_h", clean_h);
    let missing = ran(evaluate(&scratch).args(["--integrity", "--attacks"]).arg(scratch.path("none.csv")));
    assert_eq!(missing.code, 1, "{}", missing.stderr);
}

#[test]
fn every_format_has_the_flags() {
    let scratch = Scratch::new();
    flight(&scratch);
    let scored = |output: &str| {
        replay(&scratch, output);
        let mut evaluate = evaluate_this(&scratch, output);
        evaluate.args(["--integrity", "--json", "--alerts"]).arg(scratch.path("alerts.ndjson"));
        let mut scored = ran(&mut evaluate).json()["integrity"].take();
        assert!(scored["attacks"][0]["delay_s"].as_f64().unwrap() < 15.0, "{scored}");
        assert_eq!(scored["jamming"], serde_json::json!({ "jammed": 0, "false_alerts": 0 }));
        // CAT129 has no field for reasons.
        let reasons = scored["attacks"][0]["reasons"].take();
        (scored, reasons)
    };
    let (csv, reasons) = scored("out.csv");
    assert!(reasons["jump"].is_number(), "{reasons}");
    for output in ["out.ndjson", "out.geojson", "out.ast", "out.pcap"] {
        let (same, said) = scored(output);
        assert_eq!(same, csv, "{output}");
        let has_reasons = output.ends_with("json");
        assert_eq!(said == reasons, has_reasons, "{output}: {said}");
    }
}

#[test]
fn integrity_scoring_requires_its_inputs() {
    let scratch = Scratch::new();
    let mut command = utm_fusion("evaluate");
    command.arg(scratch.path("out.csv")).arg("--truth").arg(scratch.path("truth.csv")).arg("--integrity");
    let refused = ran(&mut command);
    assert_eq!(refused.code, 2);
    assert!(
        refused.stderr.contains("--capture") && refused.stderr.contains("--labels"),
        "{}",
        refused.stderr
    );
}
