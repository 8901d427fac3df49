//! `[[output.sapient]]` through `run`, with a fusion node that decodes protocol buffers itself.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use utm_fusion::config::{Config, SensorKind};

use crate::common::{Scratch, datagrams, only, replayed};
use crate::stage::Stage;

const SCENARIO: &str =
    "name = \"live\"\nduration_s = 26\n[drones]\nmultirotors = 2\nequipped = 2\n[birds]\ncount = 3\n";
const NODE: &str = "a8654cdf-4328-47de-81fa-c495589e30c9";

// Fields of SapientMessage.
const REGISTRATION: u64 = 4;
const STATUS: u64 = 6;
const DETECTION: u64 = 7;
const TASK_ACK: u64 = 9;

/// A message as a list of fields: number and octets. The octets of a number begin with the lowest.
type Fields = Vec<(u64, Vec<u8>)>;

fn varint(octets: &mut &[u8]) -> u64 {
    let mut number = 0;
    for shift in (0..).step_by(7) {
        let (&first, rest) = octets.split_first().unwrap();
        *octets = rest;
        number |= u64::from(first & 0x7f) << shift;
        if first & 0x80 == 0 {
            break;
        }
    }
    number
}

fn fields(mut octets: &[u8]) -> Fields {
    let mut fields = Vec::new();
    while !octets.is_empty() {
        let tag = varint(&mut octets);
        let length = match tag & 7 {
            0 => {
                fields.push((tag >> 3, varint(&mut octets).to_le_bytes().to_vec()));
                continue;
            }
            1 => 8,
            2 => varint(&mut octets) as usize,
            5 => 4,
            other => panic!("wire type {other}"),
        };
        let (value, rest) = octets.split_at(length);
        octets = rest;
        fields.push((tag >> 3, value.to_vec()));
    }
    fields
}

fn one(fields: &Fields, number: u64) -> Option<&[u8]> {
    fields.iter().find(|field| field.0 == number).map(|field| &*field.1)
}

fn text(fields: &Fields, number: u64) -> String {
    String::from_utf8(one(fields, number).unwrap_or_default().to_vec()).unwrap()
}

fn double(fields: &Fields, number: u64) -> Option<f64> {
    one(fields, number).map(|octets| f64::from_le_bytes(octets.try_into().unwrap()))
}

fn code(fields: &Fields, number: u64) -> u64 {
    one(fields, number).map_or(0, |octets| u64::from_le_bytes(octets.try_into().unwrap()))
}

/// The fusion node of this test.
struct Node {
    socket: TcpStream,
    read: Vec<u8>,
}

impl Node {
    fn accept(listener: &TcpListener) -> Self {
        listener.set_nonblocking(true).unwrap();
        let until = Instant::now() + Duration::from_secs(20);
        loop {
            match listener.accept() {
                Ok((socket, _)) => {
                    socket.set_nonblocking(false).unwrap();
                    socket.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
                    return Self { socket, read: Vec::new() };
                }
                Err(error) => {
                    assert!(error.kind() == ErrorKind::WouldBlock && Instant::now() < until, "{error}");
                }
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Number and fields of the content of the next message; `None` at the end of the connection, or after the timeout.
    fn hear(&mut self, patience: Duration) -> Option<(u64, Fields)> {
        let until = Instant::now() + patience;
        let mut octets = [0; 4096];
        loop {
            if let Some((header, rest)) = self.read.split_first_chunk::<4>() {
                let length = u32::from_le_bytes(*header) as usize;
                if rest.len() >= length {
                    let message = fields(&rest[..length]);
                    self.read.drain(..4 + length);
                    assert_eq!(text(&message, 2), NODE);
                    assert!(one(&message, 1).is_some(), "no timestamp");
                    let content = message.iter().find(|field| (4..=12).contains(&field.0)).unwrap();
                    return Some((content.0, fields(&content.1)));
                }
            }
            match self.socket.read(&mut octets) {
                Ok(0) => return None,
                Ok(count) => self.read.extend(&octets[..count]),
                Err(_) if Instant::now() < until => {}
                Err(_) => return None,
            }
        }
    }

    /// Sends a message with content of this number.
    fn say(&mut self, number: u8, content: &[u8]) {
        let length = u32::try_from(content.len() + 2).unwrap();
        let mut octets = length.to_le_bytes().to_vec();
        octets.extend([number << 3 | 2, content.len() as u8]);
        octets.extend(content);
        self.socket.write_all(&octets).unwrap();
    }
}

#[test]
fn accepting_node_gets_each_track_once_a_second() {
    let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = listener.local_addr().unwrap().port();
    let change = |config: &mut Config, _: &Scratch| {
        let text = format!(
            "{config}\n[[output.sapient]]\nid = \"c2\"\nurl = \"tcp://127.0.0.1:{port}\"\nnode_id = \"{NODE}\"\n\
             status_interval_s = 2\n"
        );
        *config = Config::parse(&without_sapient(&text), "site.toml", std::iter::empty()).unwrap();
    };
    let stage = Stage::new(SCENARIO, 23_400, change);
    let service = stage.run("run.log");

    // The node rejects the first registration, receives another one, and answers late.
    let mut node = Node::accept(&listener);
    let (number, registration) = node.hear(Duration::from_secs(5)).unwrap();
    assert_eq!((number, text(&registration, 2)), (REGISTRATION, "BSI Flex 335 v2.0".to_owned()));
    node.say(5, b"\x08\x00\x1a\x04full");
    assert!(node.hear(Duration::from_secs(5)).is_none(), "it went on");
    let mut node = Node::accept(&listener);
    let (number, again) = node.hear(Duration::from_secs(5)).unwrap();
    assert_eq!((number, &again), (REGISTRATION, &registration));
    let feeder = std::thread::scope(|scope| {
        let feed = scope.spawn(|| stage.send(0.0, 22.0));
        assert!(node.hear(Duration::from_secs(3)).is_none(), "nothing before it agrees");
        node.say(5, b"\x08\x01");
        let mut heard = Vec::new();
        while !feed.is_finished() {
            heard.extend(node.hear(Duration::from_millis(500)));
            if heard.len() == 20 {
                // A task, which is rejected.
                node.say(8, b"\x0a\x1a01H4R63D7NVN8444Z5M77WEBY7");
            }
        }
        heard
    });
    let (code_, log) = service.stop();
    assert_eq!(code_, Some(0), "{log}");
    let mut heard = feeder;
    while let Some(message) = node.hear(Duration::from_secs(1)) {
        heard.push(message);
    }
    assert!(log.contains("the registration is refused: full"), "{log}");

    let of = |number: u64| heard.iter().filter(move |message| message.0 == number).map(|message| &message.1);
    // A goodbye at the end, and before it a report every other second.
    let systems: Vec<u64> = of(STATUS).map(|status| code(status, 2)).collect();
    assert_eq!((systems.last(), heard.last().map(|last| last.0)), (Some(&5), Some(STATUS)));
    assert!((6..=20).contains(&systems.len()) && heard[0].0 == STATUS, "{systems:?}");
    let acknowledged: Vec<_> = of(TASK_ACK).map(|ack| (text(ack, 1), code(ack, 2))).collect();
    assert_eq!(acknowledged, [("01H4R63D7NVN8444Z5M77WEBY7".to_owned(), 2)]);

    let (mut reports, mut tracks) = (BTreeSet::new(), BTreeMap::<String, Vec<Fields>>::new());
    for detection in of(DETECTION) {
        assert!(reports.insert(text(detection, 1)), "a report twice");
        tracks.entry(text(detection, 2)).or_default().push(detection.clone());
    }
    let named: BTreeSet<String> = tracks.values().flatten().map(|detection| text(detection, 23)).collect();
    assert!(named.is_superset(&["000000000001", "000000000002"].map(str::to_owned).into()), "{named:?}");
    let site = stage.config.sensors.iter().find_map(|sensor| match &sensor.kind {
        SensorKind::Radar(radar) => Some(radar),
        _ => None,
    });
    let site = site.unwrap();
    let longest = tracks.values().map(Vec::len).max().unwrap();
    assert!((8..=26).contains(&longest), "{longest} reports of one object");
    for detection in tracks.values().flatten() {
        let location = fields(one(detection, 6).unwrap());
        let place = |number| double(&location, number).unwrap();
        assert_eq!((code(&location, 7), code(&location, 8)), (1, 1), "degrees and metres, ellipsoid");
        // Within 20 km of the site: the coordinates are not swapped.
        assert!((place(1) - site.longitude_deg).abs() < 0.4 && (place(2) - site.latitude_deg).abs() < 0.2);
        assert!(place(4) > 0.0 && place(5) > 0.0);
    }

    // The other outputs are not affected.
    let directory = stage.scratch.path("recordings");
    let (input, output) = (only(&directory, "input-", ".pcap"), only(&directory, "output-", ".pcap"));
    assert!(datagrams(&output).len() > 20 && fs::read(&output).unwrap() == replayed(&input));
}

/// Removes the empty list from a displayed configuration, because a table of the same name replaces it.
fn without_sapient(text: &str) -> String {
    text.replace("sapient = []\n", "")
}
