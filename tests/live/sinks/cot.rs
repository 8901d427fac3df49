//! Cursor on Target: the events received over UDP, TCP and TLS match the picture.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::net::{Ipv4Addr, TcpListener, UdpSocket};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use fusion::time::Time;
use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair};
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{RootCertStore, ServerConfig, ServerConnection, StreamOwned};
use utm_fusion::live::PublishedPicture;
use utm_fusion::picture::PictureTrack;
use utm_fusion::sinks::SinkLoss;

use super::{PATIENCE, Site, flown, tracks, wait_for};
use crate::common::{Scratch, group, joined};

/// An event, as parsed from XML.
#[derive(Debug, PartialEq)]
pub(super) struct Event {
    pub(super) uid: String,
    kind: String,
    how: String,
    time: String,
    start: String,
    stale: String,
    place: [f64; 2],
    callsign: String,
    /// The uid whose symbol it deletes.
    deletes: Option<String>,
}

impl Event {
    pub(super) fn parse(text: &str) -> Self {
        let document = roxmltree::Document::parse(text).unwrap_or_else(|error| panic!("{error}: {text}"));
        let found = |name: &str| document.descendants().find(|node| node.has_tag_name(name));
        let element = |name: &str| found(name).unwrap();
        let of = |node: roxmltree::Node<'_, '_>, name: &str| node.attribute(name).unwrap().to_owned();
        let event = document.root_element();
        let metres = |name: &str| of(element("point"), name).parse::<f64>().unwrap();
        Self {
            uid: of(event, "uid"),
            kind: of(event, "type"),
            how: of(event, "how"),
            time: of(event, "time"),
            start: of(event, "start"),
            stale: of(event, "stale"),
            place: [metres("lat"), metres("lon")],
            callsign: found("contact").map_or_else(String::new, |contact| of(contact, "callsign")),
            deletes: found("link").map(|link| of(link, "uid")),
        }
    }

    /// Whether the event is of this track, sent at `due`.
    fn is_of(&self, track: &PictureTrack, due: Time) -> bool {
        let seconds = |time: Time| time.to_string();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        self.uid == format!("{}.{}", flown().config.site.name, flown().maker.track_id(track))
            && [&*self.time, &*self.start] == [&*seconds(due), &*seconds(track.time)]
            && self.stale == seconds(due + jiff::SignedDuration::from_secs(5))
            && near(self.place[0], track.position.latitude_deg())
            && near(self.place[1], track.position.longitude_deg())
    }
}

fn udp() -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    socket
}

fn text_of_one(socket: &UdpSocket) -> String {
    let mut octets = [0; 4096];
    let length = socket.recv(&mut octets).unwrap();
    String::from_utf8(octets[..length].to_vec()).unwrap()
}

/// The next event of a shown track.
pub(super) fn track_event(mut next: impl FnMut() -> Event) -> Event {
    loop {
        let event = next();
        if event.deletes.is_none() {
            return event;
        }
    }
}

/// A picture of the flight without this track.
fn without(frame: &PublishedPicture, id: &str) -> PublishedPicture {
    let mut frame = frame.clone();
    frame.picture.tracks.retain(|track| flown().maker.track_id(track) != id);
    frame
}

#[test]
fn ended_track_is_deleted_once() {
    let socket = udp();
    let port = socket.local_addr().unwrap().port();
    let mut site = Site::open(&format!("[[output.cot]]\nid = \"host\"\nurl = \"udp://127.0.0.1:{port}\"\n"));
    let frames = &flown().frames[..3];
    let ended = flown().maker.track_id(tracks(&frames[0])[0]);
    let uid = format!("{}.{ended}", flown().config.site.name);
    site.writer.publish(frames[0].clone());
    let mut shown = Vec::new();
    for _ in tracks(&frames[0]) {
        shown.push(Event::parse(&text_of_one(&socket)).uid);
    }
    assert!(shown.contains(&uid));
    for (frame, deleted) in frames[1..].iter().zip([1, 0]) {
        let frame = without(frame, &ended);
        site.writer.publish(frame.clone());
        for _ in tracks(&frame) {
            let event = Event::parse(&text_of_one(&socket));
            assert!(event.deletes.is_none() && event.uid != uid, "{event:?}");
        }
        for _ in 0..deleted {
            let event = Event::parse(&text_of_one(&socket));
            assert_eq!((&*event.kind, event.deletes.as_deref()), ("t-x-d-d", Some(&*uid)), "{event:?}");
        }
    }
    site.close();
    assert_eq!(
        socket
            .set_read_timeout(Some(Duration::from_millis(200)))
            .map(|()| socket.recv(&mut [0; 8]).is_err())
            .ok(),
        Some(true)
    );
}

#[test]
fn each_track_is_one_datagram_per_second() {
    let socket = udp();
    let port = socket.local_addr().unwrap().port();
    let mut site = Site::open(&format!("[[output.cot]]\nid = \"host\"\nurl = \"udp://127.0.0.1:{port}\"\n"));
    let mut sent = 0;
    for _ in 0..5 {
        let frame = site.publish();
        for track in tracks(frame) {
            let event = track_event(|| Event::parse(&text_of_one(&socket)));
            assert!(event.is_of(track, frame.due), "{event:?} {track:?}");
            sent += 1;
        }
    }
    wait_for("it is counted", || site.counts("cot:host").sent >= sent);
    let between = &flown().frames[0];
    // A slot within a second is not sent.
    let mut within = between.clone();
    within.picture.slot.0 += 1;
    site.writer.publish(within);
    let frame = site.publish();
    let event = track_event(|| Event::parse(&text_of_one(&socket)));
    assert!(event.is_of(tracks(frame)[0], frame.due), "{event:?}");
    site.close();
}

#[test]
fn present_picture_is_sent_to_its_sinks_and_a_group() {
    let (there, port) = (group(77), 24_700);
    let socket = joined(there, port, Ipv4Addr::LOCALHOST);
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    let sink = format!(
        "[[output.cot]]\nid = \"group\"\nurl = \"udp://{there}:{port}\"\ninterface = \"127.0.0.1\"\nttl = 1\n\
         picture = \"now\"\nstale_s = 5.0\n"
    );
    let mut site = Site::open(&sink);
    // Its seconds begin in other slots than those of the lagged picture.
    let frame = &flown().of_now;
    site.publish();
    site.writer.publish(frame.clone());
    let now = frame.now.get().unwrap();
    for track in now.within(100.0) {
        let event = Event::parse(&text_of_one(&socket));
        assert!(event.is_of(track, frame.due) && event.how == "m-p", "{event:?}");
    }
    site.close();
}

/// Reads the events on a connection.
pub(super) fn events_of(stream: impl Read + Send + 'static) -> Receiver<Event> {
    let (seen, events) = channel();
    std::thread::spawn(move || {
        let mut stream = BufReader::new(stream);
        let mut text = Vec::new();
        while stream.read_until(b'\n', &mut text).is_ok_and(|count| count > 0) {
            if text.ends_with(b"</event>\n") {
                let event = Event::parse(std::str::from_utf8(&text).unwrap());
                text.clear();
                if seen.send(event).is_err() {
                    return;
                }
            }
        }
        assert!(text.is_empty(), "half an event: {}", String::from_utf8_lossy(&text));
    });
    events
}

#[test]
fn tcp_events_are_sequential_and_flushed_at_the_end() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let mut site = Site::open(&format!("[[output.cot]]\nid = \"tak\"\nurl = \"tcp://127.0.0.1:{port}\"\n"));
    let events = events_of(listener.accept().unwrap().0);
    let frames: Vec<_> = (0..6).map(|_| site.publish()).collect();
    site.close();
    let mut of_last = 0;
    for frame in frames {
        for track in tracks(frame) {
            let event = track_event(|| events.recv_timeout(PATIENCE).unwrap());
            assert!(event.is_of(track, frame.due), "{event:?}");
            of_last += 1;
        }
    }
    let deleted = std::iter::from_fn(|| events.recv_timeout(PATIENCE).ok());
    assert!(deleted.inspect(|_| of_last += 1).all(|event| event.deletes.is_some()), "the connection ends");
    assert!(site.counts("cot:tak").sent >= of_last);
}

#[test]
fn returning_receiver_gets_the_newest_and_losses_count() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let mut site = Site::open(&format!("[[output.cot]]\nid = \"tak\"\nurl = \"tcp://127.0.0.1:{port}\"\n"));
    wait_for("it fails", || site.counts("cot:tak").failed >= 1);
    assert!(site.counts("cot:tak").is_failing);
    let last = (0..4).map(|_| site.publish()).last().unwrap();
    wait_for("the newest alone waits", || site.lost("cot:tak", SinkLoss::Unreachable) == 3);
    let listener = TcpListener::bind(("127.0.0.1", port)).unwrap();
    let events = events_of(listener.accept().unwrap().0);
    for track in tracks(last) {
        let event = track_event(|| events.recv_timeout(PATIENCE).unwrap());
        assert!(event.is_of(track, last.due), "{event:?}");
    }
    // The sink counts as working once the connection has lasted.
    wait_for("it works again", || !site.counts("cot:tak").is_failing);
    assert_eq!(site.troubles(), [""; 0]);
}

/// Certificates of a server and a client, issued by the test's own authority.
struct Issued {
    ca: String,
    server: (String, String),
    client: (String, String),
}

impl Issued {
    fn new() -> Self {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params.distinguished_name.push(DnType::CommonName, "an authority");
        let ca = params.self_signed(&key).unwrap().pem();
        let issuer = Issuer::new(params, key);
        let issue = |name: &str| {
            let key = KeyPair::generate().unwrap();
            let certificate = CertificateParams::new(vec![name.to_owned()]).unwrap().signed_by(&key, &issuer);
            (certificate.unwrap().pem(), key.serialize_pem())
        };
        Self { ca, server: issue("takserver"), client: issue("utm-fusion") }
    }

    /// A server that accepts clients with a certificate of the authority.
    fn server(&self) -> Arc<ServerConfig> {
        let mut roots = RootCertStore::empty();
        roots.add(CertificateDer::from_pem_slice(self.ca.as_bytes()).unwrap()).unwrap();
        let provider = Arc::new(ring::default_provider());
        let clients = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider.clone());
        let chain = vec![CertificateDer::from_pem_slice(self.server.0.as_bytes()).unwrap()];
        let key = PrivateKeyDer::from_pem_slice(self.server.1.as_bytes()).unwrap();
        let config = ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions();
        let config = config.unwrap().with_client_cert_verifier(clients.build().unwrap());
        Arc::new(config.with_single_cert(chain, key).unwrap())
    }
}

#[test]
fn tls_authenticates_both_sides() {
    let (scratch, issued, other) = (Scratch::new(), Issued::new(), Issued::new());
    let file = |name: &str, text: &str| scratch.file(name, text).display().to_string();
    let ca = file("ca.pem", &issued.ca);
    let other_ca = file("other.pem", &other.ca);
    let (certificate, key) = (file("client.pem", &issued.client.0), file("client.key", &issued.client.1));
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let sink = |id: &str, ca: &str, name: &str, own: bool| {
        let own =
            if own { format!("certificate = \"{certificate}\"\nkey = \"{key}\"\n") } else { String::new() };
        format!(
            "[[output.cot]]\nid = \"{id}\"\nurl = \"tls://127.0.0.1:{port}\"\nca = \"{ca}\"\n\
             server_name = \"{name}\"\n{own}"
        )
    };
    let (seen, streams) = channel();
    let config = issued.server();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let stream = stream.unwrap();
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
            let mut stream = StreamOwned::new(ServerConnection::new(config.clone()).unwrap(), stream);
            let events = {
                // Completes the handshake, which decides whether the client is accepted.
                let mut first = [0];
                if stream.read_exact(&mut first).is_err() {
                    continue;
                }
                events_of(std::io::Cursor::new(first).chain(stream))
            };
            if seen.send(events).is_err() {
                return;
            }
        }
    });
    let mut site = Site::open(
        &(sink("known", &ca, "takserver", true)
            + &sink("stranger", &ca, "takserver", false)
            + &sink("elsewhere", &ca, "another", true)
            + &sink("impostor", &other_ca, "takserver", true)),
    );
    let frame = site.publish();
    let events = streams.recv_timeout(PATIENCE).expect("one is let in");
    for track in tracks(frame) {
        let event = track_event(|| events.recv_timeout(PATIENCE).unwrap());
        assert!(event.is_of(track, frame.due), "{event:?}");
    }
    for sink in ["cot:stranger", "cot:elsewhere", "cot:impostor"] {
        wait_for(sink, || site.counts(sink).failed > 0);
    }
    assert_eq!(site.counts("cot:known").failed, 0);
    assert!(streams.recv_timeout(Duration::from_millis(200)).is_err(), "somebody else is let in");
}

/// Schema of the events (Event data model 2.0 of 2003), if it and a validator are available.
#[test]
fn every_event_is_valid_by_the_schema() {
    let Some(folder) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        return println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    };
    let schema = Path::new(&folder).join("cot/cot_event.xsd");
    if !schema.exists() || Command::new("xmllint").arg("--version").output().is_err() {
        return println!("skipped: no {} or no xmllint", schema.display());
    }
    let socket = udp();
    let port = socket.local_addr().unwrap().port();
    let mut site = Site::open(&format!("[[output.cot]]\nid = \"host\"\nurl = \"udp://127.0.0.1:{port}\"\n"));
    let (scratch, mut files) = (Scratch::new(), Vec::new());
    for _ in 0..flown().frames.len() {
        let frame = site.publish();
        for _ in tracks(frame) {
            files.push(scratch.file(&format!("{}.xml", files.len()), text_of_one(&socket)));
        }
    }
    let output =
        Command::new("xmllint").args(["--noout", "--schema"]).arg(&schema).args(&files).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
    assert_eq!(told.matches(" validates").count(), files.len());
    assert!(files.len() > 20 && fs::read_to_string(&files[0]).unwrap().starts_with("<?xml"));
}
