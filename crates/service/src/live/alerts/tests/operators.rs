//! Operators' decisions about alerts, and their replay from a recording.

use jiff::SignedDuration;
use proptest::prelude::*;

use super::*;
use crate::state::{AlertDecision, alert_line, parse_decisions};

fn at(second: i64) -> Time {
    Time::from_nanos(second * SECOND)
}

fn request(id: &str, action: AlertAction) -> AlertRequest {
    AlertRequest { id: id.to_owned(), action, by: "tower".to_owned(), note: Some("seen".to_owned()) }
}

fn minutes(minutes: i64) -> AlertAction {
    AlertAction::Shelve(SignedDuration::from_mins(minutes))
}

/// A sensor in that state at that second. Returns the changes.
fn sensed(alerts: &mut AlertMonitor, state: SensorState, second: i64) -> Vec<(AlertChange, Value)> {
    alerts.note_sensors(&[sensor(state, "silent")], at(second));
    shown(alerts)
}

fn shown(alerts: &mut AlertMonitor) -> Vec<(AlertChange, Value)> {
    alerts.take_changes().iter().map(|(change, alert)| (*change, json!(AlertJson::from(alert)))).collect()
}

#[test]
fn acknowledgement_lasts_until_the_alert_gets_worse() {
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(-10));
    sensed(&mut alerts, SensorState::Degraded, 1);
    let (_, alert) = alerts.decide(&request("sensor-1", AlertAction::Acknowledge), at(2)).unwrap();
    let known = json!({ "by": "tower", "at": "1970-01-01T00:00:02.000Z", "note": "seen" });
    assert_eq!(json!(AlertJson::from(&alert))["acknowledged"], known);
    let [(AlertChange::Acknowledged, told)] = &shown(&mut alerts)[..] else { panic!() };
    assert_eq!(told["acknowledged"], known);
    assert_eq!(sensed(&mut alerts, SensorState::Degraded, 3), [], "no news");
    let worse = sensed(&mut alerts, SensorState::Outage, 4);
    assert!(worse[0].0 == AlertChange::Changed && worse[0].1.get("acknowledged").is_none(), "{worse:?}");
    alerts.decide(&request("sensor-1", AlertAction::Acknowledge), at(5)).unwrap();
    shown(&mut alerts);
    let better = sensed(&mut alerts, SensorState::Degraded, 6);
    assert!(better[0].0 == AlertChange::Changed && better[0].1.get("acknowledged").is_some(), "{better:?}");
    // A new alert is not acknowledged.
    sensed(&mut alerts, SensorState::Operational, 7);
    let again = sensed(&mut alerts, SensorState::Degraded, 8);
    assert!(again[0].1.get("acknowledged").is_none(), "{again:?}");
}

#[test]
fn shelving_applies_to_recurrences_until_it_expires() {
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(-10));
    sensed(&mut alerts, SensorState::Outage, 1);
    let (shelved, _) = alerts.decide(&request("sensor-1", minutes(1)), at(10)).unwrap();
    let known = json!({ "by": "tower", "at": "1970-01-01T00:00:10.000Z", "until": "1970-01-01T00:01:10.000Z", "note": "seen" });
    assert_eq!(shown(&mut alerts)[0].1["shelved"], known);
    assert_eq!(alerts.take_shelves(), Some(alert_line(&shelved)));
    assert_eq!(alerts.take_shelves(), None);
    sensed(&mut alerts, SensorState::Operational, 11);
    let again = sensed(&mut alerts, SensorState::Outage, 12);
    assert_eq!(
        (again[0].0, &again[0].1["id"], &again[0].1["shelved"]),
        (AlertChange::Began, &json!("sensor-2"), &known)
    );
    assert_eq!(sensed(&mut alerts, SensorState::Outage, 69), []);
    let over = sensed(&mut alerts, SensorState::Outage, 70);
    assert!(over[0].0 == AlertChange::Unshelved && over[0].1.get("shelved").is_none(), "{over:?}");
    assert_eq!(alerts.take_shelves(), Some(String::new()));

    // Unshelving, and shelving over a restart.
    alerts.decide(&request("sensor-2", minutes(480)), at(80)).unwrap();
    let lines = alerts.take_shelves().unwrap();
    alerts.decide(&request("sensor-2", AlertAction::Unshelve), at(90)).unwrap();
    assert_eq!(alerts.take_shelves(), Some(String::new()));
    assert_eq!(
        alerts.decide(&request("sensor-2", AlertAction::Unshelve), at(91)),
        Err(AlertRequestError::NotShelved)
    );
    let decisions = |lines: &str| {
        let site = include_str!("../../../../../../testdata/demo/site.toml");
        let config = site::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        parse_decisions(lines).unwrap().plan(&config).alerts
    };
    for (restart_s, is_shelved) in [(100, true), (80 + 480 * 60, false)] {
        let mut later = AlertMonitor::new(AlertSettings::default(), at(restart_s - 10));
        later.resume(&decisions(&lines), at(restart_s));
        let began = sensed(&mut later, SensorState::Outage, restart_s);
        assert_eq!(began[0].1.get("shelved").is_some(), is_shelved, "{began:?}");
    }
}

#[test]
fn rejected_request_changes_nothing() {
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(-10));
    sensed(&mut alerts, SensorState::Outage, 1);
    assert_eq!(
        alerts.decide(&request("sensor-7", AlertAction::Acknowledge), at(2)),
        Err(AlertRequestError::Unknown)
    );
    assert_eq!(
        alerts.decide(&request("area-1", AlertAction::Acknowledge), at(2)),
        Err(AlertRequestError::Unknown)
    );
    sensed(&mut alerts, SensorState::Operational, 3);
    assert_eq!(alerts.decide(&request("sensor-1", minutes(1)), at(4)), Err(AlertRequestError::Ended));
    assert!(shown(&mut alerts).is_empty() && alerts.take_shelves().is_none());
}

#[test]
fn ended_alerts_are_kept_up_to_a_limit() {
    let mut alerts = AlertMonitor::new(AlertSettings::default(), at(-10));
    for second in 0..12_000 {
        let state = if second % 2 == 0 { SensorState::Outage } else { SensorState::Operational };
        sensed(&mut alerts, state, second);
    }
    let all = alerts.all();
    assert_eq!((all.len(), all[0].id, all[4_999].id), (5_000, 6_000, 1_001));
}

/// An operator's actions: the slot, the index of the alert, and the action.
type Deeds = Vec<(usize, usize, u8)>;

/// Forty slots in which transponders fall silent in turn, with an operator's actions or their recording.
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
            let action =
                [AlertAction::Acknowledge, minutes(1), AlertAction::Unshelve][usize::from(*what) % 3];
            let Some(alert) = slots.alerts.all().get(*which).cloned() else { continue };
            // Seconds after the picture's time, because a picture is some seconds old.
            let now = Time::from_nanos((10 * slot as i64 + 7) * SECOND + 123_456_789);
            if let Ok((decision, _)) = slots.alerts.decide(&request(&alert.name(), action), now) {
                lines += &alert_line(&decision);
            }
            told.extend(shown(&mut slots.alerts).into_iter().map(|(_, alert)| alert));
        }
    }
    // A decision after the last slot precedes the next one.
    told.extend(slots.pass(10 * silences.len() as i64, &[], |_| {}).into_iter().map(|(_, alert)| alert));
    (told, lines)
}

proptest! {
    /// A recording of any operators' actions gives the same alerts, line by line.
    #[test]
    fn recorded_decisions_replay_to_the_same_alerts(
        silences in prop::collection::vec(0..32u8, 40),
        deeds in prop::collection::vec((0..40usize, 0..3usize, 0..3u8), 0..30),
    ) {
        let (told, lines) = night(&silences, &deeds, None);
        let site = include_str!("../../../../../../testdata/demo/site.toml");
        let config = site::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        let recorded = parse_decisions(&lines).unwrap();
        let mut twice = recorded.clone();
        twice.join(recorded);
        let (again, _) = night(&silences, &deeds, Some(twice.plan(&config).alerts));
        prop_assert_eq!(told, again);
    }
}
