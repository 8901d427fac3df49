//! Sensors that have sent nothing since the start.

use super::*;
use crate::live::alerts::{AlertMonitor, Severity};
use fusion::point::JumpingTracks;

fn at(second: f64) -> Time {
    Time::from_nanos(1_800_000_000 * SECOND + (second * SECOND as f64) as i64)
}

/// The demo's radar reports every 0.25 s and its transponders every 2 s: the outage limits are 5 s and 6 s.
fn monitor() -> SensorMonitor {
    let site = include_str!("../../../../../testdata/demo/site.toml");
    SensorMonitor::new(&Config::parse(site, "site.toml", std::iter::empty()).unwrap(), at(0.0))
}

fn alerts_of(sensors: &[SensorStatus], now: Time) -> Vec<Severity> {
    let mut alerts = AlertMonitor::default();
    alerts.note_sensors(sensors, now);
    alerts.all().iter().map(|alert| alert.severity).collect()
}

#[test]
fn sensor_at_the_start_is_awaited_without_an_alert() {
    for second in [0.0, 1.0, 4.9] {
        let sensors = monitor().sensors(at(second), |_| Vec::new());
        assert!(sensors.len() == 2 && sensors.iter().all(SensorStatus::is_awaited), "{sensors:?}");
        assert!(
            sensors
                .iter()
                .all(|sensor| !sensor.connected && sensor.item().connection() == Connection::NotConnected)
        );
        assert_eq!(alerts_of(&sensors, at(second)), []);
    }
}

#[test]
fn sensor_silent_since_the_start_is_in_outage_at_its_limit() {
    let sensors = monitor().sensors(at(6.1), |_| Vec::new());
    assert_eq!(alerts_of(&sensors, at(6.1)), [Severity::Critical; 2]);
    for sensor in &sensors {
        assert_eq!(sensor.state, SensorState::Outage);
        assert_eq!(sensor.reasons, ["nothing received for 6 s since the start"]);
    }
}

/// The first data of a raw file may have no time of reception.
#[test]
fn recording_without_first_time_begins_at_its_first_known_one() {
    let site = include_str!("../../../../../testdata/demo/site.toml");
    let config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
    let mut monitor = SensorMonitor::new(&config, Time::default());
    [at(0.0), at(4.0)].into_iter().for_each(|now| monitor.begin(now));
    assert!(monitor.sensors(at(4.9), |_| Vec::new()).iter().all(SensorStatus::is_awaited));
    assert_eq!(alerts_of(&monitor.sensors(at(6.1), |_| Vec::new()), at(6.1)), [Severity::Critical; 2]);
}

#[test]
fn closed_line_at_the_start_is_an_outage_at_once() {
    let closed = |_| vec![LineStatus { name: "239.192.48.1:8048".to_owned(), ..LineStatus::default() }];
    let sensors = monitor().sensors(at(1.0), closed);
    assert_eq!(alerts_of(&sensors, at(1.0)), [Severity::Critical; 2]);
    assert!(sensors.iter().all(|sensor| sensor.state == SensorState::Outage), "{sensors:?}");
}

#[test]
fn radar_is_degraded_while_its_track_numbers_jump() {
    let mut monitor = monitor();
    let jumping = Event::JumpingTracks(JumpingTracks { sensor: SensorIndex(0), discarded: 3 });
    monitor.note(&jumping, at(2.0));
    for (second, is_degraded) in [(2.0, true), (11.9, true), (12.1, false)] {
        let radar = monitor.sensors(at(second), |_| Vec::new()).swap_remove(0);
        let is_named = radar.reasons.iter().any(|reason| reason.starts_with("its track numbers jump"));
        assert_eq!(is_named, is_degraded, "{second}: {:?}", radar.reasons);
    }
    let transponders = monitor.sensors(at(2.0), |_| Vec::new()).swap_remove(1);
    assert!(transponders.reasons.iter().all(|reason| !reason.contains("jump")), "{:?}", transponders.reasons);
}
