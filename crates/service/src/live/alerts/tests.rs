//! Alerts that begin, change and end.

mod areas;
mod conflicts;
mod operators;
mod rules;

use serde_json::{Value, json};

use super::*;
use fusion::integrity::{Concern, Reason, State};
use fusion::point::RadarPart;
use fusion::{Emission, Enu, Identity, Point, RadarTrackKey, SensorIndex, Source};
use picture::Resolved;
use picture::{Picture, PictureMaker};
use site::areas::Areas;
use site::config::{AlertArea, Area, AreaKind};

fn sensor(state: SensorState, reason: &str) -> SensorStatus {
    SensorStatus {
        id: "north".to_owned(),
        state,
        reasons: vec![reason.to_owned()],
        last_seen: None,
        accepted: 0,
        rate_hz: 0.0,
        clock_offset_s: None,
        refused: BTreeMap::new(),
        contested: Vec::new(),
        connected: false,
        said: input::normalise::Service::default(),
        registration: None,
        orientation: None,
        types: Vec::new(),
        lines: Vec::new(),
    }
}

/// Alert areas of a file with that text.
fn areas_of(text: &str, change: impl FnOnce(&mut AlertArea)) -> Areas {
    let mut settings = AlertArea::default();
    change(&mut settings);
    Areas::parse(text, Area { kind: AreaKind::Alert(settings), file: "field.geojson".into() }).unwrap()
}

#[test]
fn seeking_back_in_a_replay_removes_later_alerts() {
    let site = include_str!("../../../../../testdata/demo/site.toml");
    let config = site::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
    let pipeline = input::pipeline::Pipeline::new(&config, site::areas::Masks::default());
    let maker = PictureMaker::new(&config, pipeline.normaliser());
    let at = |second: i64| Time::from_nanos(second * SECOND);
    let picture = |second| Picture {
        slot: fusion::slots::Slot(4 * second),
        time: at(second),
        tracks: vec![],
        concerns: vec![],
        resolved: vec![],
    };
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(-10));
    assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(20)));
    assert!(!alerts.note_picture(&picture(20), &maker) && !alerts.note_picture(&picture(21), &maker));
    assert_eq!(alerts.all().len(), 1);
    assert!(alerts.note_picture(&picture(5), &maker));
    assert_eq!(alerts.all(), []);
    assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(7)), "anew");
}

#[test]
fn sensor_that_fails_and_recovers_is_one_alert() {
    let at = |second: i64| Time::from_nanos(second * SECOND);
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(-10));
    assert!(!alerts.note_sensors(&[sensor(SensorState::Outage, "not heard yet")], at(-6)));
    assert!(!alerts.note_sensors(&[sensor(SensorState::Operational, "")], at(1)));
    assert!(alerts.note_sensors(&[sensor(SensorState::Degraded, "late")], at(2)));
    assert!(
        !alerts.note_sensors(&[sensor(SensorState::Degraded, "later")], at(3)),
        "the same, in other words"
    );
    assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(4)), "worse");
    let told = alerts.all();
    assert_eq!((told.len(), told[0].severity, told[0].since), (1, Severity::Critical, at(2)));
    assert_eq!(told[0].text, "north outage: silent");
    assert!(alerts.note_sensors(&[sensor(SensorState::Operational, "")], at(5)));
    assert_eq!(alerts.all()[0].until, Some(at(5)));
    assert!(alerts.note_sensors(&[sensor(SensorState::Outage, "silent")], at(6)));
    assert_eq!(alerts.all().iter().map(|alert| alert.id).collect::<Vec<_>>(), [2, 1]);
}

#[test]
fn simultaneous_alerts_are_separate_changes() {
    let at = |second: i64| Time::from_nanos(second * SECOND);
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(-10));
    let south = |state| SensorStatus { id: "south".to_owned(), ..sensor(state, "silent") };
    let both = |state| [sensor(state, "silent"), south(state)];
    let mut changes = |state, second| {
        alerts.note_sensors(&both(state), at(second));
        let changes = alerts.take_changes();
        changes.into_iter().map(|(change, alert)| (change, alert.subject)).collect::<Vec<_>>()
    };
    for (state, second, change) in [
        (SensorState::Degraded, 1, AlertChange::Began),
        (SensorState::Outage, 2, AlertChange::Changed),
        (SensorState::Operational, 3, AlertChange::Ended),
    ] {
        let told = ["north", "south"].map(|id| (change, id.to_owned()));
        assert_eq!(changes(state, second), told);
        assert_eq!(changes(state, second), [], "told once");
    }
}

#[test]
fn service_fault_is_an_alert_while_it_lasts() {
    let at = |second: i64| Time::from_nanos(second * SECOND);
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(0));
    let full =
        ServiceFault { about: "recorder".into(), severity: Severity::Warning, text: "full".to_owned() };
    assert!(!alerts.note_troubles(std::iter::empty(), at(1)));
    assert!(alerts.note_troubles([&full].into_iter(), at(2)));
    assert!(!alerts.note_troubles([&full].into_iter(), at(3)));
    let [alert] = &alerts.all()[..] else { panic!("{:?}", alerts.all()) };
    assert_eq!((alert.kind.name(), alert.subject.as_str(), alert.since), ("service", "recorder", at(2)));
    // The end is reported also after the clock stepped back.
    assert!(alerts.note_troubles(std::iter::empty(), at(-3600)));
    let (change, over) = alerts.take_changes().pop().unwrap();
    assert_eq!((change, over.until), (AlertChange::Ended, Some(at(-3600))));
}

/// A site, and pictures of a slot with concerns.
struct Slots {
    maker: PictureMaker,
    alerts: AlertMonitor,
}

impl Slots {
    fn new() -> Self {
        let site = include_str!("../../../../../testdata/demo/site.toml");
        let config = site::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        let pipeline = input::pipeline::Pipeline::new(&config, site::areas::Masks::default());
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        Self { maker, alerts: AlertMonitor::new(AlertSettings::default(), Time::default()) }
    }

    /// Changes in that second.
    fn pass(
        &mut self,
        second: i64,
        concerns: &[Concern],
        change: impl FnOnce(&mut Picture),
    ) -> Vec<(AlertChange, Value)> {
        let time = Time::from_nanos(second * SECOND);
        let part = RadarPart {
            track: RadarTrackKey { sensor: SensorIndex(0), number: 9 },
            time,
            height_measured: true,
            uav_probability: None,
        };
        let point =
            |number| Point::new(number, Enu::new(100.0, 200.0, 50.0), Time::default(), Source::Radar(part));
        let mut picture = self.maker.picture(Emission {
            now: None,
            slot: fusion::slots::Slot(4 * second),
            time,
            points: vec![point(7), point(8)],
            numbers: Vec::new(),
            newcomers: Vec::new(),
            jumping: Vec::new(),
            concerns: concerns.to_vec(),
        });
        picture::TrackNames::default().name(&mut picture);
        change(&mut picture);
        self.alerts.note_picture(&picture, &self.maker);
        let changes = self.alerts.take_changes();
        changes.iter().map(|(change, alert)| (*change, json!(AlertJson::from(alert)))).collect()
    }
}

fn alpha() -> Identity {
    Identity::new(b"ALPHA       ", Some(b"NO")).unwrap()
}

fn lies(state: State, reasons: &[Reason], twin: Option<u32>, offset_m: f64) -> Concern {
    let reasons = reasons.iter().copied().collect();
    Concern::Integrity { identity: alpha(), track: Some(7), twin, state, reasons, offset_m: Some(offset_m) }
}

#[test]
fn untrusted_transponder_is_one_alert_with_each_change_once() {
    let mut slots = Slots::new();
    let [(AlertChange::Began, began)] =
        &slots.pass(3600, &[lies(State::Suspect, &[Reason::Radar], None, 41.2)], |_| {})[..]
    else {
        panic!("it begins")
    };
    let told = json!({
        "id": "integrity-1", "kind": "integrity", "severity": "warning", "since": "1970-01-01T01:00:00.000Z",
        "text": "transponder ALPHA is suspect since 01:00:00 UTC, because radar sees the aircraft 41 m from \
                 where it says it is; its position may be false: do not rely on it until that is cleared up",
        "identity": "ALPHA", "track_id": "R-halfmoon-7-0", "state": "suspect", "reasons": ["radar"], "offset_m": 41.0,
    });
    assert_eq!(*began, told);
    // A change of the offset alone is not reported.
    assert_eq!(slots.pass(3601, &[lies(State::Suspect, &[Reason::Radar], None, 43.0)], |_| {}), []);
    let changes =
        slots.pass(3602, &[lies(State::Suspect, &[Reason::Radar, Reason::Jump], Some(8), 44.0)], |_| {});
    assert_eq!((changes[0].0, &changes[0].1["reasons"]), (AlertChange::Amended, &json!(["radar", "jump"])));
    assert!(changes[0].1["twin_id"].is_string(), "{changes:?}");
    let changes =
        slots.pass(3603, &[lies(State::Failed, &[Reason::Radar, Reason::Jump], Some(8), 44.0)], |_| {});
    let [(AlertChange::Changed, failed)] = &changes[..] else { panic!("{changes:?}") };
    assert_eq!(
        (&failed["severity"], &failed["since"]),
        (&json!("critical"), &json!("1970-01-01T01:00:00.000Z"))
    );
    assert!(failed["text"].as_str().unwrap().contains("is not to be trusted since 01:00:00 UTC"), "{failed}");
    // A twin without a point in this slot is still reported as the twin.
    assert_eq!(
        slots.pass(3604, &[lies(State::Failed, &[Reason::Radar, Reason::Jump], Some(8), 44.0)], |picture| {
            picture.tracks.clear();
        }),
        []
    );
    // An alert that ends states the worst that was.
    slots.pass(3605, &[lies(State::Suspect, &[Reason::Radar], None, 44.0)], |_| {});
    let changes = slots.pass(3606, &[], |_| {});
    let [(AlertChange::Ended, over)] = &changes[..] else { panic!("{changes:?}") };
    assert_eq!((&over["until"], &over["id"]), (&json!("1970-01-01T01:00:06.000Z"), &json!("integrity-1")));
    let text = "transponder ALPHA was not to be trusted from 01:00:00 UTC on; over since 01:00:05 UTC";
    assert_eq!((&over["text"], &over["latched"]), (&json!(text), &json!(true)));
}

#[test]
fn lie_covers_silence_heights_and_the_twin() {
    for (state, kinds) in [
        (State::Failed, &["integrity"][..]),
        (State::Suspect, &["height", "integrity", "silent", "uncooperative"]),
    ] {
        let mut slots = Slots::new();
        let silent = Concern::Silent { identity: alpha(), track: Some(7), heard: Time::default() };
        let height = Concern::Height { identity: alpha(), track: Some(7), offset_m: 30.0, deviation_m: 5.0 };
        let concerns = [lies(state, &[Reason::Radar], Some(8), 44.0), silent, height];
        let changes = slots.pass(3600, &concerns, |picture| picture.tracks[1].is_uncooperative = true);
        let mut raised: Vec<&str> = changes.iter().filter_map(|(_, alert)| alert["kind"].as_str()).collect();
        raised.sort_unstable();
        assert_eq!(raised, kinds, "{state:?}");
    }
}

#[test]
fn jamming_alert_has_a_hull_and_silence_alert_a_track() {
    let mut slots = Slots::new();
    let place = |east_m: f64, north_m: f64| Enu::new(east_m, north_m, 30.0);
    let places = [place(0.0, 0.0), place(1000.0, 0.0), place(0.0, 1000.0)];
    let jamming = Concern::Jamming {
        identities: vec![alpha()],
        places: places.to_vec(),
        since: Time::from_nanos(90 * SECOND),
    };
    let silent = Concern::Silent { identity: alpha(), track: Some(8), heard: Time::from_nanos(91 * SECOND) };
    let changes = slots.pass(100, &[jamming, silent], |_| {});
    let kinds: Vec<&Value> = changes.iter().map(|(_, alert)| &alert["kind"]).collect();
    assert_eq!(kinds, [&json!("jamming"), &json!("silent")]);
    let (jamming, silent) = (&changes[0].1, &changes[1].1);
    assert_eq!((&jamming["severity"], &jamming["identities"]), (&json!("warning"), &json!(["ALPHA"])));
    assert_eq!((&silent["severity"], &silent["identity"]), (&json!("warning"), &json!("ALPHA")));
    assert!(silent["text"].as_str().unwrap().contains("silent since 00:01:31 UTC"), "{silent}");

    let ring: Vec<(f64, f64)> = serde_json::from_value(jamming["hull"]["coordinates"][0].clone()).unwrap();
    assert!(ring.len() > 20 && ring.first() == ring.last());
    let polygon = geo::Polygon::new(ring.clone().into(), vec![]);
    // Twice the signed area; positive means counterclockwise.
    let area: f64 = ring.windows(2).map(|pair| pair[0].0 * pair[1].1 - pair[1].0 * pair[0].1).sum();
    assert!(area > 0.0);
    for (corner, is_inside) in [
        (place(-99.0, 0.0), true),
        (place(-101.5, 0.0), false),
        (place(0.0, 1099.0), true),
        (place(0.0, 1102.0), false),
        (place(500.0, 500.0), true),
        // 141 m from the line between the two.
        (place(650.0, 550.0), false),
        (place(565.0, 565.0), true),
    ] {
        let on_earth = slots.maker.place(corner);
        let point = geo::Point::new(on_earth.longitude_deg(), on_earth.latitude_deg());
        assert_eq!(geo::Contains::contains(&polygon, &point), is_inside, "{corner:?}");
    }
    let ended = |changes: Vec<(AlertChange, Value)>| {
        let kinds = changes.into_iter().map(|(change, alert)| (change, alert["kind"].clone()));
        kinds.collect::<Vec<_>>()
    };
    assert_eq!(ended(slots.pass(101, &[], |_| {})), [(AlertChange::Ended, json!("jamming"))]);
    assert_eq!(ended(slots.pass(111, &[], |_| {})), [(AlertChange::Ended, json!("silent"))], "it was held");
}

#[test]
fn contradicted_height_is_alerted_with_its_bound() {
    let mut slots = Slots::new();
    let height = |offset_m| Concern::Height { identity: alpha(), track: None, offset_m, deviation_m: 5.4 };
    let changes = slots.pass(100, &[height(29.6)], |_| {});
    let [(AlertChange::Began, alert)] = &changes[..] else { panic!("{changes:?}") };
    assert_eq!((&alert["kind"], &alert["severity"]), (&json!("height"), &json!("warning")));
    assert_eq!((&alert["identity"], &alert["height_offset_m"]), (&json!("ALPHA"), &json!(30.0)));
    assert!(alert["text"].as_str().unwrap().contains("30 m (±6 m) above"), "{alert}");
    assert_eq!(slots.pass(101, &[height(31.0)], |_| {}), [], "it goes on");
    assert_eq!(slots.pass(105, &[], |_| {}), [], "it is held");
    let changes = slots.pass(112, &[], |_| {});
    assert!(matches!(&changes[..], [(AlertChange::Ended, _)]), "{changes:?}");
}

#[test]
fn uncooperative_alert_ends_resolved_or_after_ten_seconds() {
    let mark = |picture: &mut Picture| picture.tracks[0].is_uncooperative = true;
    for identity in [Some(alpha()), None] {
        let mut slots = Slots::new();
        let changes = slots.pass(60, &[], mark);
        let [(AlertChange::Began, began)] = &changes[..] else { panic!("{changes:?}") };
        assert_eq!((&began["kind"], &began["severity"]), (&json!("uncooperative"), &json!("warning")));
        assert!(
            began["text"].as_str().unwrap().contains("since 00:01:00 UTC without a transponder"),
            "{began}"
        );
        let id = began["track"].as_str().unwrap().to_owned();
        assert_eq!(slots.pass(65, &[], |_| {}), []);
        let changes = slots.pass(66, &[], |picture| picture.resolved = vec![Resolved { id, identity }]);
        let [(AlertChange::Ended, over)] = &changes[..] else { panic!("{changes:?}") };
        assert_eq!(over["resolved"], json!(true));
        assert!(over["text"].as_str().unwrap().contains("is resolved"), "{over}");
    }
    let mut slots = Slots::new();
    slots.pass(60, &[], mark);
    assert_eq!(slots.pass(70, &[], |_| {}), []);
    let changes = slots.pass(71, &[], |_| {});
    assert!(changes[0].0 == AlertChange::Ended && changes[0].1.get("resolved").is_none(), "{changes:?}");
}
