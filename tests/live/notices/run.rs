//! The program itself: a sensor falls silent, and a remote receiver is notified.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use utm_fusion::config::Config;

use super::broker::Broker;
use super::receiver::{Receiver, Say};
use super::{site, wait_for};
use crate::common::{Running, Scratch, flight, on_own_ports, utm_fusion};

#[test]
fn silent_sensor_is_sent_to_webhook_and_broker() {
    let scratch = Scratch::new();
    let scenario = "name = \"still\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
    let mut config: Config = on_own_ports(&flight(scenario, 1, None).config, 24_400, &scratch, None);
    let receiver = Receiver::start(&[]);
    let broker = Broker::start("");
    let mut alerts =
        format!("[[alerts.webhooks]]\nid = \"a\"\nurl = \"{}\"\nkinds = [\"sensor\"]\n", receiver.url());
    if let Some(broker) = &broker {
        alerts +=
            &format!("[alerts.mqtt]\nhost = \"127.0.0.1\"\nport = {}\nkinds = [\"sensor\"]\n", broker.port);
    }
    config.alerts = site(&alerts).alerts;
    scratch.file("site.toml", config.to_string());
    let mut service = Running::start(
        utm_fusion("run").arg("--config").arg(scratch.path("site.toml")),
        scratch.path("run.log"),
    );
    service.says("alert began");
    let notice = receiver.next().json();
    assert_eq!((&notice["change"], &notice["alert"]["kind"]), (&"began".into(), &"sensor".into()));
    wait_for("it is counted", || {
        metrics(&service).contains("\nutm_fusion_notices_sent_total{receiver=\"webhook:a\"} 2\n")
    });
    let Some(broker) = broker else {
        assert_eq!(service.stop().0, Some(0));
        return;
    };
    let status = "utm-fusion/status";
    wait_for("both sensors are retained", || broker.retained().len() == 1 + config.sensors.len());
    // The program is killed: the broker notifies its subscribers.
    service.signal("-KILL");
    service.wait(Duration::from_secs(5));
    wait_for("it is offline", || broker.retained()[status] == "offline");
    let retained = broker.retained().len();
    assert_eq!(retained, 1 + config.sensors.len(), "what it left stays until it is back");
    let mut service = Running::start(
        utm_fusion("run").arg("--config").arg(scratch.path("site.toml")),
        scratch.path("again.log"),
    );
    service.says("running");
    wait_for("it is online", || broker.retained()[status] == "online");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    broker.comes_to_retain(&[status]);
    assert_eq!(broker.retained()[status], "offline");
}

#[test]
fn second_signal_ends_the_service_at_once() {
    let scratch = Scratch::new();
    let scenario = "name = \"still\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
    let mut config = on_own_ports(&flight(scenario, 1, None).config, 24_410, &scratch, None);
    // A pending delivery keeps the service running for more than a second.
    let silent = Receiver::start(&[Say::Nothing]);
    let hook = format!("[[alerts.webhooks]]\nid = \"a\"\nurl = \"{}\"\nkinds = [\"sensor\"]\n", silent.url());
    config.alerts = site(&hook).alerts;
    scratch.file("site.toml", config.to_string());
    let mut service = Running::start(
        utm_fusion("run").arg("--config").arg(scratch.path("site.toml")),
        scratch.path("run.log"),
    );
    silent.next();
    service.signal("-TERM");
    service.says("stopping");
    service.signal("-TERM");
    let (code, log) = service.wait(Duration::from_secs(5));
    assert_eq!(code, Some(1), "{log}");
    assert!(log.contains("stopped at once; not all that was owed may have been sent"), "{log}");
}

/// Metrics of the service.
fn metrics(service: &Running) -> String {
    let log = service.log();
    let address = log.split("url=http://").nth(1).unwrap().split('/').next().unwrap();
    let mut socket = TcpStream::connect(address).unwrap();
    write!(socket, "GET /metrics HTTP/1.0\r\nHost: {address}\r\n\r\n").unwrap();
    let mut text = String::new();
    socket.read_to_string(&mut text).unwrap();
    text
}
