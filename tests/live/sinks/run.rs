//! The program itself: configured sinks get the picture, and failures are counted and logged.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::time::Duration;

use super::cot::{Event, events_of};
use super::{PATIENCE, configured, wait_for};
use crate::common::{Running, Scratch, ask, flight, on_own_ports, utm_fusion};

#[test]
fn sensor_reports_arrive_as_events() {
    let scratch = Scratch::new();
    let scenario = "name = \"two\"\nduration_s = 60\n[drones]\nmultirotors = 2\nequipped = 2\n";
    let host = UdpSocket::bind("127.0.0.1:0").unwrap();
    host.set_read_timeout(Some(PATIENCE)).unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let sinks = format!(
        "[[output.cot]]\nid = \"host\"\nurl = \"udp://127.0.0.1:{}\"\n\
         [[output.cot]]\nid = \"tak\"\nurl = \"tcp://127.0.0.1:{}\"\n\
         [[output.cot]]\nid = \"gone\"\nurl = \"tcp://127.0.0.1:{closed}\"\n",
        host.local_addr().unwrap().port(),
        listener.local_addr().unwrap().port()
    );
    let simulation = flight(scenario, 1, Some(utm_fusion::live::now()));
    let mut config = on_own_ports(&simulation.config, 24_600, &scratch, None);
    config.output.cot = configured(&sinks).output.cot;
    // Unicast, so that the datagrams stay on this machine.
    for sensor in &mut config.sensors {
        sensor.inputs[0].address = utm_fusion::config::Address::Unicast(std::net::Ipv4Addr::LOCALHOST);
    }
    let site = scratch.file("site.toml", config.to_string());
    let check = utm_fusion("check").arg("--config").arg(&site).arg("--network").output().unwrap();
    let told = String::from_utf8(check.stdout).unwrap();
    assert_eq!(check.status.code(), Some(1), "{told}{}", String::from_utf8_lossy(&check.stderr));
    assert!(told.contains("cot:host: ok\n") && told.contains("cot:tak: ok\n"), "{told}");
    assert!(told.contains("cot:gone: FAILED: Connection refused"), "{told}");
    // The connection of `check`.
    drop(listener.accept().unwrap());

    let mut service = Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("run.log"));
    service.says("running");
    service.says("the picture is not delivered: tried again sink=\"cot:gone\"");
    let events = events_of(listener.accept().unwrap().0);
    let from = UdpSocket::bind("127.0.0.1:0").unwrap();
    let inputs = config.sensors.iter().map(|sensor| sensor.inputs[0].port);
    let ports: Vec<u16> = inputs.collect();
    let began = utm_fusion::live::now();
    let first = simulation.datagrams[0].received;
    let sends = std::thread::spawn(move || {
        for datagram in simulation.datagrams {
            let due = datagram.received - first;
            let wait = due - (utm_fusion::live::now() - began);
            if due.as_secs() > 20 {
                return;
            }
            std::thread::sleep(Duration::try_from(wait).unwrap_or_default());
            let category = datagram.payload[0];
            let port = if category == 129 { ports[ports.len() - 1] } else { ports[0] };
            from.send_to(&datagram.payload, ("127.0.0.1", port)).unwrap();
        }
    });
    let mut octets = [0; 4096];
    let length = host.recv(&mut octets).unwrap();
    let by_udp = Event::parse(std::str::from_utf8(&octets[..length]).unwrap());
    let by_tcp = events.recv_timeout(PATIENCE).unwrap();
    assert_eq!(by_udp, by_tcp);
    assert!(by_udp.uid.starts_with(&format!("{}.U-", config.site.name)), "{by_udp:?}");
    let metric = |name: &str| {
        let wanted = format!("utm_fusion_{name} ");
        metrics(service.http_port()).lines().find_map(|line| line.strip_prefix(&*wanted)?.parse::<f64>().ok())
    };
    let sent = "sink_messages_sent_total{sink=\"cot:host\"}";
    wait_for("it is counted", || metric(sent).is_some_and(|sent| sent >= 2.0));
    assert_eq!(metric("sink_failing{sink=\"cot:gone\"}"), Some(1.0));
    assert_eq!(metric("sink_failing{sink=\"cot:tak\"}"), Some(0.0));
    wait_for("what does not arrive is counted", || {
        metric("sink_seconds_lost_total{sink=\"cot:gone\",reason=\"unreachable\"}") >= Some(1.0)
    });
    assert_eq!(ask(service.http_port(), "GET", "/readyz").0, 200, "a receiver that is gone stops nothing");
    sends.join().unwrap();
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
}

fn metrics(port: u16) -> String {
    let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
    write!(socket, "GET /metrics HTTP/1.0\r\nHost: localhost\r\n\r\n").unwrap();
    let mut text = String::new();
    socket.read_to_string(&mut text).unwrap();
    text
}
