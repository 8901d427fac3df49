//! Receivers that are slow, flood, close, or stall: they affect only themselves.

use std::io::Write;
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use socket2::{Domain, Socket, Type};
use utm_fusion::live::PublishedPicture;
use utm_fusion::sinks::SinkLoss;

use super::cot::{Event, events_of, track_event};
use super::{PATIENCE, Site, flown, tracks, wait_for};

fn sink(id: &str, url: &str) -> String {
    format!("[[output.cot]]\nid = \"{id}\"\nurl = \"{url}\"\n")
}

/// A second of a city: the buffer of a connection cannot hold a few such seconds.
fn crowded(frame: &PublishedPicture) -> PublishedPicture {
    let mut frame = frame.clone();
    let one = frame.picture.tracks[0].clone();
    frame.picture.tracks = vec![one; 4_000];
    frame
}

#[test]
fn stalled_receiver_delays_nothing_and_is_closed() {
    // With a small buffer, which is never read.
    let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
    socket.set_recv_buffer_size(4 << 10).unwrap();
    socket.bind(&"127.0.0.1:0".parse::<std::net::SocketAddr>().unwrap().into()).unwrap();
    socket.listen(8).unwrap();
    let stuck: TcpListener = socket.into();
    let stuck_port = stuck.local_addr().unwrap().port();
    let quick = UdpSocket::bind("127.0.0.1:0").unwrap();
    quick.set_read_timeout(Some(PATIENCE)).unwrap();
    let quick_port = quick.local_addr().unwrap().port();
    let mut site = Site::open(
        &(sink("stuck", &format!("tcp://127.0.0.1:{stuck_port}"))
            + &sink("quick", &format!("udp://127.0.0.1:{quick_port}"))),
    );
    let held = stuck.accept().unwrap();
    site.writer.publish(crowded(&flown().frames[0]));
    site.writer.publish(crowded(&flown().frames[1]));
    wait_for("all datagrams are sent", || site.counts("cot:quick").sent == 8_000);
    // Datagrams of the crowd are read and dropped.
    quick.set_nonblocking(true).unwrap();
    while quick.recv(&mut [0; 4096]).is_ok() {}
    quick.set_nonblocking(false).unwrap();
    let began = Instant::now();
    for _ in 0..12 {
        let published = Instant::now();
        let frame = site.publish();
        assert!(published.elapsed() < Duration::from_secs(1), "a slot waits");
        for track in tracks(frame) {
            let event = track_event(|| {
                let mut octets = [0; 4096];
                let length = quick.recv(&mut octets).unwrap();
                Event::parse(std::str::from_utf8(&octets[..length]).unwrap())
            });
            assert!(event.uid.ends_with(&flown().maker.track_id(track)));
        }
    }
    assert!(began.elapsed() < Duration::from_secs(5), "the quick one waits for the other");
    wait_for("the slow one loses the oldest", || site.lost("cot:stuck", SinkLoss::Slow) >= 3);
    let text = site.troubles().join("; ");
    assert!(text.contains("cot:stuck: the receiver is too slow"), "{text}");
    wait_for("it is given up", || site.counts("cot:stuck").failed >= 1);
    assert!(site.counts("cot:stuck").waiting <= 8);
    drop(held);
    let began = Instant::now();
    site.close();
    assert!(began.elapsed() < Duration::from_secs(3), "the end waits for it");
}

#[test]
fn receiver_that_sends_endlessly_is_still_served() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let mut site = Site::open(&sink("loud", &format!("tcp://127.0.0.1:{port}")));
    let stream = listener.accept().unwrap().0;
    let events = events_of(stream.try_clone().unwrap());
    let ends = Arc::new(AtomicBool::new(false));
    let ended = ends.clone();
    let talks = std::thread::spawn(move || talk(stream, &ended));
    for _ in 0..5 {
        let frame = site.publish();
        for track in tracks(frame) {
            let event = track_event(|| events.recv_timeout(PATIENCE).expect("an event arrives"));
            assert!(event.uid.ends_with(&flown().maker.track_id(track)));
        }
    }
    ends.store(true, Ordering::Relaxed);
    let said = talks.join().unwrap();
    assert!(said > 1 << 20, "{said} octets are read meanwhile");
    assert_eq!(site.counts("cot:loud").failed, 0);
}

/// Sends octets of no protocol, as many as are accepted.
fn talk(mut stream: TcpStream, ends: &AtomicBool) -> usize {
    let octets: Vec<u8> = (0..=255).cycle().take(64 << 10).collect();
    let mut said = 0;
    while !ends.load(Ordering::Relaxed) || said <= 1 << 20 {
        said += stream.write(&octets).unwrap();
    }
    said
}

#[test]
fn receiver_that_always_closes_is_tried_less_often() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let (came, connections) = mpsc::channel();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            drop(stream);
            if came.send(Instant::now()).is_err() {
                return;
            }
        }
    });
    let mut site = Site::open(&sink("shut", &format!("tcp://127.0.0.1:{port}")));
    let times: Vec<Instant> = (0..4)
        .map(|_| {
            site.publish();
            connections.recv_timeout(PATIENCE).unwrap()
        })
        .collect();
    // Pauses of 1, 2 and 4 s.
    let pauses: Vec<f64> = times.windows(2).map(|pair| (pair[1] - pair[0]).as_secs_f64()).collect();
    assert!(pauses[0] > 0.9 && pauses[1] > 1.9 && pauses[2] > 3.9 && pauses[2] < 10.0, "{pauses:?}");
    assert!(site.counts("cot:shut").failed >= 3);
    assert!(site.counts("cot:shut").is_failing);
}
