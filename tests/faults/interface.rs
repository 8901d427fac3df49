//! Interfaces that go and come back.

use std::net::Ipv4Addr;
use std::time::{Duration, Instant};

use utm_fusion::config::{Address, Config};
use utm_fusion::live::now;

use crate::common::{group, joined};
use crate::http::{address, lights, metric, troubled, until};
use crate::inside::{is_inside, must};
use crate::stage::Stage;
use crate::{quick, scenario};

const HERE: Ipv4Addr = Ipv4Addr::new(10, 77, 0, 1);
/// Command for a network namespace of this process, in which it may create interfaces.
const NETWORK: [&str; 2] = ["unshare", "-rn"];

/// Creates the interface.
fn plug_in() {
    must("ip link add left type veth peer name right");
    must(&format!("ip address add {HERE}/24 dev left"));
    must("ip link set left up");
    must("ip link set right up");
}

fn unplug() {
    must("ip link delete left");
}

fn has_veth() -> bool {
    must("ip link set lo up");
    let made =
        std::process::Command::new("ip").args("link add left type veth peer name right".split(' ')).status();
    let made = made.is_ok_and(|status| status.success());
    if made {
        unplug();
    } else {
        eprintln!("skipped: no pair of interfaces (veth) can be made here");
    }
    made
}

/// Moves all addresses to that interface, except for the HTTP API.
fn on_it(config: &mut Config) {
    quick(config);
    config.output.record = None;
    let move_there = |address: &mut Address| {
        if let Address::Multicast { interface, .. } = address {
            *interface = HERE;
        }
    };
    config.output.asterix.iter_mut().for_each(|sink| move_there(&mut sink.address));
    config
        .sensors
        .iter_mut()
        .flat_map(|sensor| &mut sensor.inputs)
        .for_each(|input| move_there(&mut input.address));
}

/// Sends from now on until `seconds` of the flight, with or without the interface.
fn send_for(stage: &Stage, seconds: f64) {
    let start = stage.start();
    let from = now();
    let to_come = stage.simulation.datagrams.iter().filter(|datagram| datagram.received >= from);
    let until = from.seconds_since(start) + seconds;
    let mut sender = None;
    for datagram in to_come.take_while(|datagram| datagram.received.seconds_since(start) < until) {
        if let Ok(early) = Duration::try_from(datagram.received - now()) {
            std::thread::sleep(early);
        }
        if sender.is_none() {
            sender = utm_fusion::net::send::socket(Some(HERE), 1).ok();
        }
        let to = stage.to(usize::from(datagram.payload[0] == 129));
        if sender.as_ref().is_none_or(|socket| socket.send_to(&datagram.payload, to).is_err()) {
            sender = None;
        }
    }
}

#[test]
fn lost_interface_is_an_outage_until_it_returns() {
    let test = "interface::lost_interface_is_an_outage_until_it_returns";
    if !is_inside(&NETWORK, test) || !has_veth() {
        return;
    }
    plug_in();
    let stage = Stage::new(&scenario(60), 23_200, |config, _| on_it(config));
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    std::thread::scope(|scope| {
        scope.spawn(|| send_for(&stage, 30.0));
        until("two green lights", Duration::from_secs(9), || lights(address) == ["operational"; 2]);
        until("output", Duration::from_secs(9), || metric(address, "utm_fusion_tracks", "") > 0.0);
        unplug();
        let dark = until("red lights", Duration::from_secs(12), || lights(address) == ["outage"; 2]);
        assert!(dark > Duration::from_secs(2), "not for nothing");
        // The remaining slots of the window cannot be sent.
        assert!(metric(address, "utm_fusion_failed_sends_total", "") > 0.0);
        // Within the silence after which lines join again.
        until("lines that do not open", Duration::from_secs(12), || {
            metric(address, "utm_fusion_line_joined", "") == 0.0
        });
        service.says("cannot be opened");
        plug_in();
        let back = Instant::now();
        until("two green lights again", Duration::from_secs(10), || lights(address) == ["operational"; 2]);
        let sink = &stage.config.output.asterix[0];
        let listener = joined(group(99), sink.port, HERE);
        let heard = || listener.recv(&mut [0; 2048]).is_ok();
        until("status", Duration::from_secs(5), heard);
        until("slots with tracks", Duration::from_secs(9), || metric(address, "utm_fusion_tracks", "") > 0.0);
        let failed = metric(address, "utm_fusion_failed_sends_total", "");
        std::thread::sleep(Duration::from_secs(2));
        assert_eq!(metric(address, "utm_fusion_failed_sends_total", ""), failed, "it is sent again");
        assert!(troubled(address).is_empty());
        assert!(back.elapsed() < Duration::from_secs(20));
    });
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert_eq!(log.matches("cannot be opened").count(), 2, "once a line:\n{log}");
    assert_eq!(log.matches("listening receive_buffer").count(), 4, "at first, and again:\n{log}");
}

#[test]
fn interface_lost_briefly_is_joined_again_after_silence() {
    let test = "interface::interface_lost_briefly_is_joined_again_after_silence";
    if !is_inside(&NETWORK, test) || !has_veth() {
        return;
    }
    plug_in();
    let stage = Stage::new(&scenario(60), 23_300, |config, _| on_it(config));
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    std::thread::scope(|scope| {
        scope.spawn(|| send_for(&stage, 26.0));
        until("two green lights", Duration::from_secs(9), || lights(address) == ["operational"; 2]);
        unplug();
        plug_in();
        // The socket is open but receives nothing: its membership belongs to the old interface.
        until("red lights", Duration::from_secs(12), || lights(address) == ["outage"; 2]);
        // Twice the silence, because the first may have begun before.
        until("two green lights again", Duration::from_secs(16), || lights(address) == ["operational"; 2]);
    });
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
}
