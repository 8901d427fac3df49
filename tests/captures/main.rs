//! Captures built in memory, and the recordings of the project, read through the public reader.

mod beasts;
mod corpus;
mod damage;
mod field_cases;
mod finals;
mod fragments;
mod framed;
mod packed;
mod pcapng_damage;
mod pcapngs;
mod pcaps;
mod raws;
mod recordings;
mod tlogs;
mod tunnels;
mod writer;

use std::io::{self, Read};

use utm_fusion::capture::{Capture, CapturedDatagram, Endpoints, OpenError, ReadError};

/// Two blocks like CAT048 and one like CAT129: the reader uses only CAT and LEN.
const BLOCKS: [&[u8]; 3] =
    [&[48, 0, 8, 0xFF, 1, 2, 3, 4], &[48, 0, 5, 0x80, 0], &[129, 0, 12, 9, 8, 7, 6, 5, 4, 3, 2, 1]];

/// A reader that returns `step` octets at a time, or an increasing number if `step` is 0, and is interrupted before each read.
struct Trickle {
    octets: io::Cursor<Vec<u8>>,
    step: usize,
    calls: usize,
}

impl Read for Trickle {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.calls += 1;
        if self.calls % 2 == 1 {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let most = if self.step == 0 { self.calls / 2 } else { self.step };
        let most = most.min(buffer.len());
        self.octets.read(&mut buffer[..most])
    }
}

fn open_in_steps(octets: &[u8], step: usize) -> Result<Capture, OpenError> {
    let reader = Trickle { octets: io::Cursor::new(octets.to_vec()), step, calls: 0 };
    Capture::from_reader("test".to_owned(), Box::new(reader), None)
}

fn open(octets: &[u8]) -> Result<Capture, OpenError> {
    let reader = io::Cursor::new(octets.to_vec());
    Capture::from_reader("test".to_owned(), Box::new(reader), Some(octets.len() as u64))
}

/// All datagrams, and the error that ended them. Checks two properties of every capture: an unfragmented payload is at its origin
/// in the (decompressed) octets, and nothing follows the end.
fn read(octets: &[u8], capture: &mut Capture) -> (Vec<CapturedDatagram>, Option<ReadError>) {
    let mut datagrams = Vec::new();
    let mut error = None;
    for item in capture.by_ref() {
        match item {
            Ok(datagram) => datagrams.push(datagram),
            Err(damage) => {
                assert!(error.replace(damage).is_none(), "a second error");
            }
        }
    }
    assert!(capture.next().is_none());
    for datagram in datagrams.iter().filter(|datagram| datagram.fragments == 0) {
        assert!(octets[datagram.origin as usize..].starts_with(&datagram.payload));
    }
    if error.is_none() {
        assert!(capture.consumed() <= capture.size().unwrap_or(u64::MAX));
    }
    (datagrams, error)
}

/// The endpoints of every frame of `writer.rs`.
fn endpoints(version: u8) -> Option<Endpoints> {
    let (source, destination) = if version == 4 {
        ("127.0.0.1:8048", "239.192.48.1:8049")
    } else {
        ("[::1]:8048", "[ff02::30]:8049")
    };
    let address = |text: &str| text.parse().expect("an address and a port");
    Some(Endpoints { source: address(source), destination: address(destination) })
}

fn payloads(datagrams: &[CapturedDatagram]) -> Vec<&[u8]> {
    datagrams.iter().map(|datagram| datagram.payload.as_slice()).collect()
}
