//! A broker of MQTT 5: its retained messages and events, also while it is unreachable.

use rcgen::{CertificateParams, KeyPair};
use serde_json::Value;
use utm_fusion::live::{Alert, AlertChange, Severity};
use utm_fusion::notices::{NoticeLoss, NoticeReceivers};

use super::broker::Broker;
use super::{Desk, alert, ended, site, wait_for};
use crate::common::Scratch;

fn mqtt(broker: &Broker, more: &str) -> String {
    format!(
        "[alerts.mqtt]\nhost = \"127.0.0.1\"\nport = {}\nprefix = \"north/fusion\"\n{more}\n",
        broker.port
    )
}

const STATUS: &str = "north/fusion/status";

fn topic(id: u64) -> String {
    format!("north/fusion/alerts/area/area-{id}")
}

#[test]
fn alert_is_retained_and_each_change_is_an_event() {
    let Some(broker) = Broker::start("") else { return };
    let mut listener = broker.listener().ready();
    let mut desk = Desk::open(&site(&mqtt(&broker, "")));
    let mut next = || {
        let (topic, text, _) = listener.next();
        (topic, text)
    };
    assert_eq!(next(), (STATUS.to_owned(), "online".to_owned()));
    desk.note(AlertChange::Began, &alert(1));
    let (state, text) = next();
    assert_eq!(state, topic(1));
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&json["id"], &json["severity"]), (&"area-1".into(), &"warning".into()));
    let (events, text) = next();
    assert_eq!(events, "north/fusion/alerts/events");
    let event: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&event["change"], &event["site"], &event["alert"]),
        (&"began".into(), &"north".into(), &json)
    );

    desk.note(AlertChange::Changed, &Alert { severity: Severity::Critical, ..alert(1) });
    let texts = [next().1, next().1];
    assert!(texts.iter().all(|text| text.contains("\"critical\"")), "{texts:?}");
    broker.comes_to_retain(&[&topic(1), STATUS]);
    assert_eq!(next().0, "mark");

    desk.note(AlertChange::Ended, &ended(1));
    assert_eq!(next(), (topic(1), String::new()));
    assert!(next().1.contains("\"ended\""));
    wait_for("three are sent", || desk.counts("mqtt").sent == 3);
    broker.comes_to_retain(&[STATUS]);
}

#[test]
fn stopped_service_leaves_only_its_offline_state() {
    let Some(broker) = Broker::start("") else { return };
    let mut desk = Desk::open(&site(&mqtt(&broker, "")));
    (1..=20).for_each(|id| desk.note(AlertChange::Began, &alert(id)));
    wait_for("all are sent", || desk.counts("mqtt").sent == 20);
    assert_eq!(broker.retained().len(), 21);
    desk.note(AlertChange::Changed, &alert(7));
    desk.close();
    assert_eq!(desk.counts("mqtt").sent, 21);
    let retained: Vec<_> = broker.retained().into_iter().collect();
    assert_eq!(retained, [(STATUS.to_owned(), "offline".to_owned())]);
}

#[test]
fn remains_of_a_crashed_run_are_cleared() {
    let Some(broker) = Broker::start("") else { return };
    let mut listener = broker.listener().ready();
    listener.retain(&topic(99), "{\"id\":\"area-99\"}");
    listener.retain(&topic(1), "{\"id\":\"area-1\"}");
    listener.retain("north/other/alerts/area/area-99", "somebody else's");
    let mut desk = Desk::open(&site(&mqtt(&broker, "")));
    desk.note(AlertChange::Began, &alert(1));
    broker.comes_to_retain(&[&topic(1), STATUS, "north/other/alerts/area/area-99"]);
    assert!(broker.retained()[&topic(1)].contains("Airfield"));
}

#[test]
fn returning_broker_gets_the_present_alerts() {
    let Some(mut broker) = Broker::start("") else { return };
    let mut desk = Desk::open(&site(&mqtt(&broker, "")));
    desk.note(AlertChange::Began, &alert(1));
    desk.note(AlertChange::Began, &alert(2));
    wait_for("both are sent", || desk.counts("mqtt").sent == 2);
    broker.stop();
    wait_for("it is missed", || desk.counts("mqtt").is_failing);
    desk.note(AlertChange::Ended, &ended(1));
    desk.note(AlertChange::Began, &alert(3));
    desk.note(AlertChange::Acknowledged, &alert(3));
    broker.start_again();
    broker.comes_to_retain(&[&topic(2), &topic(3), STATUS]);
    // The end of the first alert, and one notice of the third that covers both changes.
    wait_for("what happened is sent", || desk.counts("mqtt").sent == 4);
    let counts = desk.counts("mqtt");
    assert_eq!((counts.waiting, NoticeLoss::ALL.map(|loss| counts.lost(loss))), (0, [0; 3]));
}

#[test]
fn refused_login_is_reported_and_a_password_accepted() {
    let scratch = Scratch::new();
    let passwords = scratch.path("passwords");
    let made = std::process::Command::new("mosquitto_passwd")
        .args(["-b", "-c"])
        .arg(&passwords)
        .args(["fusion", "right"])
        .output();
    if made.is_err() {
        return eprintln!("skipped: mosquitto is not installed");
    }
    let [right, wrong] =
        [("right", "right\n"), ("wrong", "wrong\n")].map(|(name, text)| scratch.file(name, text));
    let more = format!("allow_anonymous false\npassword_file {}\nuser root\n", passwords.display());
    let Some(broker) = Broker::start_in(scratch, &more) else { return };
    let answer = |password: &std::path::Path| {
        let login = format!("username = \"fusion\"\npassword_file = \"{}\"", password.display());
        let receivers = NoticeReceivers::open(&site(&mqtt(&broker, &login))).unwrap();
        utm_fusion::app::runtime(1).unwrap().block_on(receivers.test()).remove(0).1
    };
    assert_eq!(answer(&right), Ok("published on north/fusion/alerts/events".to_owned()));
    assert_eq!(answer(&wrong), Err("the broker refuses the connection: NotAuthorized".to_owned()));
}

#[test]
fn oversized_message_is_lost_and_others_are_sent() {
    let Some(broker) = Broker::start("max_packet_size 1000\n") else { return };
    let mut desk = Desk::open(&site(&mqtt(&broker, "")));
    desk.note(AlertChange::Began, &Alert { text: "x".repeat(2_000), ..alert(1) });
    desk.note(AlertChange::Began, &alert(2));
    wait_for("the second is sent", || desk.counts("mqtt").sent == 1);
    assert_eq!(desk.counts("mqtt").lost(NoticeLoss::Refused), 1);
    broker.comes_to_retain(&[&topic(2), STATUS]);
}

#[test]
fn tls_broker_needs_a_valid_certificate() {
    let scratch = Scratch::new();
    let key = KeyPair::generate().unwrap();
    let certificate =
        CertificateParams::new(vec!["localhost".to_owned()]).unwrap().self_signed(&key).unwrap();
    let ca = scratch.file("certificate.pem", certificate.pem());
    let key = scratch.file("key.pem", key.serialize_pem());
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let more = format!(
        "listener {port} 127.0.0.1\ncertfile {}\nkeyfile {}\nuser root\n",
        ca.display(),
        key.display()
    );
    let Some(_broker) = Broker::start_in(scratch, &more) else { return };
    let answer = |more: &str| {
        let text = format!("[alerts.mqtt]\nhost = \"localhost\"\nport = {port}\n{more}");
        let receivers = NoticeReceivers::open(&site(&text)).unwrap();
        utm_fusion::app::runtime(1).unwrap().block_on(receivers.test()).remove(0).1
    };
    let known = answer(&format!("tls = true\nca = \"{}\"", ca.display()));
    assert_eq!(known, Ok("published on utm-fusion/alerts/events".to_owned()));
    assert!(answer("").is_err(), "it is no plain broker");
}
