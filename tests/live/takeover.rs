//! A radar that fails, and another host that takes over; and a service message from a host that does not.

use std::net::SocketAddr;

use asterix::{DataSource, cat034, encode_block};
use fusion::time::{SECOND, Time};
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{AlertKind, Config, Severity};
use utm_fusion::live::{Alert, AlertMonitor, AlertSettings, Driver, DriverEvent, SensorState, SensorStatus};
use utm_fusion::pipeline::Event;

const RADAR: &str = "10.0.0.1:4000";
const OTHER: &str = "10.0.0.2:5000";

/// A driver and its alerts with a virtual clock.
struct Watch {
    driver: Driver,
    alerts: AlertMonitor,
    source: DataSource,
    /// Reported takeovers and contests.
    reported: Vec<Event>,
}

fn at(second: f64) -> Time {
    Time::from_nanos(1_700_000_000 * SECOND + (second * 1e9) as i64)
}

impl Watch {
    fn new() -> Self {
        let site = include_str!("../../config/demo.toml");
        let config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        let source = DataSource { sac: config.sensors[0].sac, sic: config.sensors[0].sic };
        Self {
            driver: Driver::new(&config, Masks::default(), at(0.0), 1),
            alerts: AlertMonitor::new(AlertSettings::default(), at(0.0)),
            source,
            reported: Vec::new(),
        }
    }

    /// Sends a radar's service message.
    fn serve(&mut self, from: &str, second: f64, is_nogo: bool) {
        let common = cat034::CommonStatus::default().with_nogo(is_nogo);
        let record = cat034::Record {
            data_source: Some(self.source),
            message_type: Some(cat034::MessageType::default()),
            time_of_day: None,
            system_status: Some(cat034::SystemStatus { common: Some(common), ..Default::default() }),
            ..Default::default()
        };
        let mut payload = Vec::new();
        encode_block(&[record], &mut payload).unwrap();
        self.driver.receive(&Reception {
            received: Some(at(second)),
            input: 0,
            from: Some(from.parse::<SocketAddr>().unwrap()),
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: [payload, vec![240, 0, 4, (second * 10.0) as u64 as u8]].concat(),
        });
        while let Some(made) = self.driver.poll() {
            if let DriverEvent::Event(event @ (Event::TookOver(_) | Event::Contested(_))) = made {
                self.reported.push(event);
            }
        }
    }

    /// State of the radar, and its active alert.
    fn look(&mut self, second: f64) -> (SensorStatus, Option<Alert>) {
        let sensors = self.driver.sensors(at(second), |_| Vec::new());
        self.alerts.note_sensors(&sensors, at(second));
        let lasting = self.alerts.all().into_iter().find(|alert| {
            alert.kind == AlertKind::Sensor && alert.subject == sensors[0].id && alert.until.is_none()
        });
        (sensors[0].clone(), lasting.map(|alert| (*alert).clone()))
    }
}

#[test]
fn nogo_of_a_foreign_host_raises_no_outage_and_is_named() {
    let mut watch = Watch::new();
    for second in 0..12 {
        watch.serve(RADAR, f64::from(second), false);
        watch.serve(OTHER, f64::from(second) + 0.5, true);
    }
    let (status, alert) = watch.look(11.6);
    assert_eq!(status.state, SensorState::Degraded, "{status:?}");
    assert_eq!(status.said.nogo, Some(false));
    let alert = alert.unwrap();
    assert_eq!(alert.severity, Severity::Warning, "{alert:?}");
    assert!(alert.text.contains(OTHER) && alert.text.contains(RADAR), "{}", alert.text);
    assert_eq!(watch.reported.len(), 1, "{:?}", watch.reported);
}

#[test]
fn takeover_of_a_silent_radar_is_an_alert_naming_both() {
    let mut watch = Watch::new();
    for second in 0..8 {
        watch.serve(RADAR, f64::from(second), false);
    }
    assert_eq!(watch.look(8.0).1, None);
    assert!(watch.look(14.0).1.is_some_and(|alert| alert.severity == Severity::Critical), "it is dead");
    watch.serve(OTHER, 15.0, false);
    let (status, alert) = watch.look(15.1);
    assert_eq!(status.state, SensorState::Degraded, "{status:?}");
    let alert = alert.unwrap();
    assert!(alert.text.contains(&format!("{OTHER} speaks for it in place of {RADAR}")), "{}", alert.text);
    let [Event::TookOver(takeover)] = watch.reported[..] else { panic!("{:?}", watch.reported) };
    assert_eq!((takeover.before.to_string(), takeover.after.to_string()), (RADAR.into(), OTHER.into()));

    // Now its NOGO is accepted, and it is named; its state does not apply to the first radar when that returns.
    watch.serve(OTHER, 16.0, true);
    let (status, alert) = watch.look(16.1);
    assert_eq!(status.state, SensorState::Outage);
    assert!(alert.unwrap().text.contains(&format!("(NOGO in I034/050 from {OTHER})")));
    watch.serve(RADAR, 25.0, false);
    let (status, _) = watch.look(25.1);
    assert_eq!(status.state, SensorState::Degraded, "{status:?}");
    for second in 26..90 {
        watch.serve(RADAR, f64::from(second), false);
    }
    assert_eq!(watch.look(89.1).0.state, SensorState::Operational);
}

#[test]
fn refused_sender_is_no_sign_of_life_of_a_sensor() {
    let mut watch = Watch::new();
    for second in 0..8 {
        watch.serve(RADAR, f64::from(second), false);
        watch.serve(OTHER, f64::from(second) + 0.5, false);
    }
    let (status, _) = watch.look(8.0);
    assert_eq!(status.last_seen, Some(at(7.0)), "{status:?}");
    assert_eq!(status.refused.get("other_sender"), Some(&8));
}
