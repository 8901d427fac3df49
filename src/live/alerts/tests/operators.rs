//! What operators do about alerts, and that a recording of it says the same.

use jiff::SignedDuration;
use proptest::prelude::*;

use super::*;
use crate::state::{AlertDecision, alert_line, parse_decisions};

fn at(second: i64) -> Time {
    Time::from_nanos(second * SECOND)
}

fn wish(id: &str, wanted: Wanted) -> AlertWish {
    AlertWish { id: id.to_owned(), wanted, by: "tower".to_owned(), note: Some("seen".to_owned()) }
}

fn minutes(minutes: i64) -> Wanted {
    Wanted::Shelve(SignedDuration::from_mins(minutes))
}

/// A sensor in that state at that second; what changed.
fn sensed(alerts: &mut Alerts, state: SensorState, second: i64) -> Vec<(Change, Value)> {
    alerts.note_sensors(&[sensor(state, "silent")], at(second));
    shown(alerts)
}

fn shown(alerts: &mut Alerts) -> Vec<(Change, Value)> {
    alerts.take_changes().iter().map(|(change, alert)| (*change, json!(AlertJson::from(alert)))).collect()
}

#[test]
fn what_is_acknowledged_stays_so_until_it_is_worse() {
    let mut alerts = Alerts::new(AlertSettings::default(), at(-10));
    sensed(&mut alerts, SensorState::Degraded, 1);
    let (_, alert) = alerts.decide(&wish("sensor-1", Wanted::Acknowledge), at(2)).unwrap();
    let known = json!({ "by": "tower", "at": "1970-01-01T00:00:02.000Z", "note": "seen" });
    assert_eq!(json!(AlertJson::from(&alert))["acknowledged"], known);
    let [(Change::Acknowledged, told)] = &shown(&mut alerts)[..] else { panic!() };
    assert_eq!(told["acknowledged"], known);
    assert_eq!(sensed(&mut alerts, SensorState::Degraded, 3), [], "no news");
    let worse = sensed(&mut alerts, SensorState::Outage, 4);
    assert!(worse[0].0 == Change::Changed && worse[0].1.get("acknowledged").is_none(), "{worse:?}");
    alerts.decide(&wish("sensor-1", Wanted::Acknowledge), at(5)).unwrap();
    shown(&mut alerts);
    let better = sensed(&mut alerts, SensorState::Degraded, 6);
    assert!(better[0].0 == Change::Changed && better[0].1.get("acknowledged").is_some(), "{better:?}");
    // What comes again is another one.
    sensed(&mut alerts, SensorState::Operational, 7);
    let again = sensed(&mut alerts, SensorState::Degraded, 8);
    assert!(again[0].1.get("acknowledged").is_none(), "{again:?}");
}

#[test]
fn what_is_shelved_stays_so_where_it_comes_again_until_its_time_is_over() {
    let mut alerts = Alerts::new(AlertSettings::default(), at(-10));
    sensed(&mut alerts, SensorState::Outage, 1);
    let (shelved, _) = alerts.decide(&wish("sensor-1", minutes(1)), at(10)).unwrap();
    let known = json!({ "by": "tower", "at": "1970-01-01T00:00:10.000Z", "until": "1970-01-01T00:01:10.000Z", "note": "seen" });
    assert_eq!(shown(&mut alerts)[0].1["shelved"], known);
    assert_eq!(alerts.take_shelves(), Some(alert_line(&shelved)));
    assert_eq!(alerts.take_shelves(), None);
    sensed(&mut alerts, SensorState::Operational, 11);
    let again = sensed(&mut alerts, SensorState::Outage, 12);
    assert_eq!(
        (again[0].0, &again[0].1["id"], &again[0].1["shelved"]),
        (Change::Began, &json!("sensor-2"), &known)
    );
    assert_eq!(sensed(&mut alerts, SensorState::Outage, 69), []);
    let over = sensed(&mut alerts, SensorState::Outage, 70);
    assert!(over[0].0 == Change::Unshelved && over[0].1.get("shelved").is_none(), "{over:?}");
    assert_eq!(alerts.take_shelves(), Some(String::new()));

    // Taken back, and over a restart.
    alerts.decide(&wish("sensor-2", minutes(480)), at(80)).unwrap();
    let lines = alerts.take_shelves().unwrap();
    alerts.decide(&wish("sensor-2", Wanted::Unshelve), at(90)).unwrap();
    assert_eq!(alerts.take_shelves(), Some(String::new()));
    assert_eq!(alerts.decide(&wish("sensor-2", Wanted::Unshelve), at(91)), Err(NotDone::NotShelved));
    let decisions = |lines: &str| {
        let site = include_str!("../../../../testdata/demo/site.toml");
        let config = crate::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        parse_decisions(lines).unwrap().plan(&config).alerts
    };
    for (restart_s, is_shelved) in [(100, true), (80 + 480 * 60, false)] {
        let mut later = Alerts::new(AlertSettings::default(), at(restart_s - 10));
        later.resume(&decisions(&lines), at(restart_s));
        let began = sensed(&mut later, SensorState::Outage, restart_s);
        assert_eq!(began[0].1.get("shelved").is_some(), is_shelved, "{began:?}");
    }
}

#[test]
fn what_cannot_be_done_changes_nothing() {
    let mut alerts = Alerts::new(AlertSettings::default(), at(-10));
    sensed(&mut alerts, SensorState::Outage, 1);
    assert_eq!(alerts.decide(&wish("sensor-7", Wanted::Acknowledge), at(2)), Err(NotDone::Unknown));
    assert_eq!(alerts.decide(&wish("area-1", Wanted::Acknowledge), at(2)), Err(NotDone::Unknown));
    sensed(&mut alerts, SensorState::Operational, 3);
    assert_eq!(alerts.decide(&wish("sensor-1", minutes(1)), at(4)), Err(NotDone::Ended));
    assert!(shown(&mut alerts).is_empty() && alerts.take_shelves().is_none());
}

#[test]
fn thousands_that_ended_are_remembered_and_no_more() {
    let mut alerts = Alerts::new(AlertSettings::default(), at(-10));
    for second in 0..12_000 {
        let state = if second % 2 == 0 { SensorState::Outage } else { SensorState::Operational };
        sensed(&mut alerts, state, second);
    }
    let all = alerts.all();
    assert_eq!((all.len(), all[0].id, all[4_999].id), (5_000, 6_000, 1_001));
}

/// What an operator does while slots pass: at which of them, about which transponder, what.
type Deeds = Vec<(usize, usize, u8)>;

/// Forty slots in which transponders are silent by turns; with what operators do, or with what is recorded of it.
fn night(silences: &[u8], deeds: &Deeds, recorded: Option<Vec<AlertDecision>>) -> (Vec<Value>, String) {
    let mut slots = Slots::new();
    let is_live = recorded.is_none();
    slots.alerts.plan(recorded.unwrap_or_default());
    let (mut told, mut lines) = (Vec::new(), String::new());
    for (slot, silent) in silences.iter().enumerate() {
        let concerns: Vec<Concern> = (0..3)
            .filter(|which| silent >> which & 1 == 1)
            .map(|which| {
                let serial = *b"TRANSPONDER0";
                let mut serial = serial;
                serial[11] += which;
                let identity = Identity::new(&serial, None).unwrap();
                Concern::Integrity {
                    identity,
                    track: None,
                    twin: None,
                    state: if silent >> 4 & 1 == 1 { State::Failed } else { State::Suspect },
                    reasons: Default::default(),
                    offset_m: None,
                }
            })
            .collect();
        let changes = slots.pass(10 * slot as i64, &concerns, |_| {});
        told.extend(changes.into_iter().map(|(_, alert)| alert));
        for (_, which, what) in deeds.iter().filter(|(when, ..)| is_live && *when == slot) {
            let wanted = [Wanted::Acknowledge, minutes(1), Wanted::Unshelve][usize::from(*what) % 3];
            let Some(alert) = slots.alerts.all().get(*which).cloned() else { continue };
            // Seconds later, as a picture is some seconds old.
            let now = Time::from_nanos((10 * slot as i64 + 7) * SECOND + 123_456_789);
            if let Ok((decision, _)) = slots.alerts.decide(&wish(&alert.name(), wanted), now) {
                lines += &alert_line(&decision);
            }
            told.extend(shown(&mut slots.alerts).into_iter().map(|(_, alert)| alert));
        }
    }
    // What was decided behind the last slot comes before the next one.
    told.extend(slots.pass(10 * silences.len() as i64, &[], |_| {}).into_iter().map(|(_, alert)| alert));
    (told, lines)
}

proptest! {
    /// Whatever operators do, its recording gives the same alerts, line by line.
    #[test]
    fn what_is_recorded_replays(
        silences in prop::collection::vec(0..32u8, 40),
        deeds in prop::collection::vec((0..40usize, 0..3usize, 0..3u8), 0..30),
    ) {
        let (told, lines) = night(&silences, &deeds, None);
        let site = include_str!("../../../../testdata/demo/site.toml");
        let config = crate::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        let recorded = parse_decisions(&lines).unwrap();
        let mut twice = recorded.clone();
        twice.join(recorded);
        let (again, _) = night(&silences, &deeds, Some(twice.plan(&config).alerts));
        prop_assert_eq!(told, again);
    }
}
