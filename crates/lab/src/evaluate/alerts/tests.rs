//! Scores computed by hand: ALPHA flies past BRAVO at 10 m/s, 20 m beside it, and is beside it at 100 s. Both report once a
//! second for 200 s. CHARLIE, 5 km away, has no transponder.

use super::*;
use crate::evaluate::integrity::AttackKind;
use crate::evaluate::labels::Label;
use crate::evaluate::place::GeodeticPlace;
use crate::evaluate::types::{PointFlags, PointSource};
use fusion::slots::SlotGrid;
use jiff::SignedDuration;

fn at(second: i64) -> Time {
    Time::from_nanos(second * SECOND)
}

fn place(east_m: f64, north_m: f64, altitude_m: f64) -> GeodeticPlace {
    // A degree on the equator.
    let [longitude_deg, latitude_deg] = [east_m / 111_319.5, north_m / 110_574.3];
    GeodeticPlace { latitude_deg, longitude_deg, altitude_amsl_m: Some(altitude_m) }
}

/// A flight, and the alerts of it.
struct Scene {
    /// Height of BRAVO above ALPHA, metres.
    above_m: f64,
    reporting: bool,
    /// Whether the output knows BRAVO's height.
    has_height: bool,
    attacks: Vec<Attack>,
    alerts: Vec<AlertLine>,
}

impl Scene {
    fn new() -> Self {
        Self { above_m: 0.0, reporting: true, has_height: true, attacks: Vec::new(), alerts: Vec::new() }
    }

    /// An alert of a kind about these tracks from one second until another.
    fn alert(mut self, id: &str, severity: &str, tracks: &[&str], [since, until]: [i64; 2]) -> Self {
        let line = AlertLine {
            id: id.to_owned(),
            kind: id.rsplit_once('-').unwrap().0.to_owned(),
            since: at(since),
            until: None,
            is_critical: severity == "critical",
            tracks: tracks.iter().map(|&track| track.to_owned()).collect(),
            identity: None,
            area: None,
            text: String::new(),
        };
        self.alerts.extend([line.clone(), AlertLine { until: Some(at(until)), ..line }]);
        self
    }

    fn scored(&self) -> AlertScore {
        let paths = |second: i64| {
            let along_m = 10.0 * (second - 100) as f64;
            [
                ("ALPHA", along_m, 0.0, 100.0),
                ("BRAVO", 0.0, 20.0, 100.0 + self.above_m),
                ("CHARLIE", 0.0, 5000.0, 100.0),
            ]
        };
        let mut tracks: BTreeMap<&str, Vec<(Time, GeodeticPlace)>> = BTreeMap::new();
        let (mut rows, mut output) = (Vec::new(), Vec::new());
        for second in 0..=200 {
            for (number, (id, east_m, north_m, altitude_m)) in (1..).zip(paths(second)) {
                let place = place(east_m, north_m, altitude_m);
                tracks.entry(id).or_default().push((at(second), place));
                let is_heard = id == "ALPHA" || (id == "BRAVO" && self.reporting);
                let sensor = if is_heard { "squitter" } else { "radar" };
                rows.push(Label {
                    time: at(second),
                    sensor: sensor.to_owned(),
                    number,
                    id: Some(id.to_owned()),
                    seduced: false,
                    identity: is_heard.then(|| id.to_owned()),
                });
                let altitude_amsl_m = place.altitude_amsl_m.filter(|_| id != "BRAVO" || self.has_height);
                output.push(OutputPoint {
                    time: at(second),
                    place: GeodeticPlace { altitude_amsl_m, ..place },
                    source: if is_heard { PointSource::Transponder } else { PointSource::Radar },
                    number,
                    radar_track: (!is_heard).then_some(number as u16),
                    sensor: None,
                    transponder: is_heard.then_some(number),
                    identity: is_heard.then(|| id.to_owned()),
                    covariance: None,
                    flags: PointFlags::default(),
                });
            }
        }
        let truth = Truth::new(tracks.into_iter().map(|(id, samples)| (id.to_owned(), samples)));
        let settings = Scoring {
            grid: SlotGrid::new(SignedDuration::from_millis(250)),
            site: None,
            latency: SignedDuration::from_secs(6),
        };
        score_alerts(&AlertFlight {
            truth: &truth,
            labels: &Labels::new(rows),
            crewed: &BTreeSet::new(),
            output: &output,
            alerts: &self.alerts,
            attacks: &self.attacks,
            areas: (&AlertAreas::default(), 0.0),
            volumes: [Some((50.0, 15.0)), None],
            settings: &settings,
        })
    }
}

fn events(score: &AlertScore, kind: &str) -> (usize, usize) {
    score.events.get(kind).map_or((0, 0), |events| (events.events, events.raised))
}

#[test]
fn track_number_is_read_from_every_kind_of_id() {
    let ids = ["U-10004", "U-67-1795748484.125", "R-north-17-1795748484", "R-a-b-17-3", "F-5", "X-1"];
    assert_eq!(ids.map(number), [Some(10_004), Some(67), Some(17), Some(17), Some(5), None]);
}

#[test]
fn violation_without_an_alert_is_missed() {
    let score = Scene::new().scored();
    assert_eq!(events(&score, "conflict"), (1, 0));
    // Within 50 m over ground from 4.58 s before on.
    let begin = "1970-01-01T00:01:35.500Z";
    assert_eq!(score.missed.len(), 1);
    assert_eq!(
        (score.missed[0].begin.as_str(), &score.missed[0].aircraft[..]),
        (begin, &["ALPHA".to_owned(), "BRAVO".to_owned()][..])
    );
    // 16 m above, the volume is never entered.
    let score = Scene { above_m: 16.0, ..Scene::new() }.scored();
    assert_eq!(score.events, BTreeMap::new());
}

#[test]
fn alert_about_the_pair_raises_it_if_it_is_timely() {
    for (span, raised, delay_s) in [
        ([80, 105], 1, Some(-15.5)),
        ([98, 105], 1, Some(2.5)),
        // It has ended long before, and begins long after.
        ([50, 80], 0, None),
        ([130, 150], 0, None),
    ] {
        let score = Scene::new().alert("conflict-1", "critical", &["T-1", "T-2"], span).scored();
        assert_eq!(events(&score, "conflict"), (1, raised), "{span:?}");
        assert_eq!(score.events["conflict"].mean_delay_s, delay_s, "{span:?}");
    }
    let other = Scene::new().alert("conflict-1", "critical", &["T-1", "T-3"], [80, 105]).scored();
    assert_eq!(events(&other, "conflict"), (1, 0));
}

#[test]
fn item_has_a_cause_if_the_pair_comes_near_meanwhile() {
    let unfounded = |above_m: f64, severity: &str, tracks: &[&str], span| {
        let scene = Scene { above_m, ..Scene::new() };
        let score = scene.alert("conflict-1", severity, tracks, span).scored();
        (score.unfounded, score.unfounded_critical)
    };
    assert_eq!(unfounded(0.0, "critical", &["T-1", "T-2"], [90, 110]), (0, 0));
    assert_eq!(unfounded(0.0, "critical", &["T-1", "T-2"], [20, 30]), (1, 1), "they come near much later");
    assert_eq!(unfounded(0.0, "warning", &["T-1", "T-2"], [60, 65]), (0, 0), "it is foreseen");
    assert_eq!(unfounded(0.0, "critical", &["T-1", "T-3"], [90, 110]), (1, 1), "another pair");
    assert_eq!(unfounded(0.0, "critical", &["T-1", "T-9"], [90, 110]), (1, 1), "a track that is no aircraft");
    // 28 m above is within twice the volume, and not within 1.5 times.
    assert_eq!(unfounded(28.0, "warning", &["T-1", "T-2"], [90, 110]), (0, 0));
    assert_eq!(unfounded(28.0, "critical", &["T-1", "T-2"], [90, 110]), (1, 1));
}

#[test]
fn second_item_about_the_same_is_a_duplicate() {
    let twice = |tracks: &[&str], since| {
        let scene = Scene::new().alert("conflict-1", "critical", &["T-1", "T-2"], [90, 110]);
        let score = scene.alert("conflict-2", "warning", tracks, [since, since + 10]).scored();
        (score.items, score.critical, score.duplicates)
    };
    assert_eq!(twice(&["T-2", "T-1"], 120), (2, 1, 1));
    assert_eq!(twice(&["T-2", "T-1"], 180), (2, 1, 0), "a minute later it is another");
    assert_eq!(twice(&["T-2", "T-3"], 120), (2, 1, 0), "another pair");

    // A situation of its own that becomes part of an earlier one.
    let mut scene = Scene::new().alert("conflict-1", "critical", &["T-1", "T-2"], [90, 110]);
    scene = scene.alert("conflict-2", "warning", &["T-3", "T-4"], [95, 100]);
    scene.alerts.push(AlertLine {
        tracks: ["T-1", "T-2", "T-3", "T-4"].map(str::to_owned).to_vec(),
        ..scene.alerts[1].clone()
    });
    assert_eq!(scene.scored().duplicates, 0);
}

#[test]
fn violation_of_an_aircraft_that_does_not_report_counts_apart() {
    let score = Scene { has_height: false, ..Scene::new() }.scored();
    assert_eq!((events(&score, "conflict"), events(&score, "conflict-unreported")), ((0, 0), (1, 0)));
    let score = Scene { reporting: false, ..Scene::new() }.scored();
    assert_eq!((events(&score, "conflict"), events(&score, "conflict-unreported")), ((0, 0), (1, 0)));
    let attack =
        Attack { id: "ALPHA".to_owned(), number: 1, kind: AttackKind::Drift, from: at(20), until: at(200) };
    let score = Scene { attacks: vec![attack.clone()], ..Scene::new() }.scored();
    assert_eq!((events(&score, "conflict"), events(&score, "conflict-unreported")), ((0, 0), (1, 0)));
    assert_eq!(events(&score, "integrity"), (1, 0));

    let mut scene =
        Scene { attacks: vec![attack], ..Scene::new() }.alert("integrity-1", "warning", &[], [60, 150]);
    scene.alerts.iter_mut().for_each(|line| line.identity = Some("ALPHA".to_owned()));
    let score = scene.scored();
    assert_eq!((events(&score, "integrity"), score.unfounded), ((1, 1), 0));
    assert_eq!(score.events["integrity"].mean_delay_s, Some(40.0));
    scene.attacks.clear();
    assert_eq!(scene.scored().unfounded, 1, "it told the truth");
}
