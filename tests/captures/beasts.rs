//! What a 1090 MHz receiver sent, as a file.

use std::io::{Cursor, Read};

use utm_fusion::capture::{Capture, Contents};

use crate::Trickle;

/// Where octets that belong to no frame begin, and how many they are.
fn unframed(reader: Box<dyn Read + Send>) -> Vec<(u64, usize)> {
    let capture =
        Capture::from_reader("x.beast".to_owned(), reader, None).expect("it begins with four frames");
    let datagrams = capture.map(Result::unwrap).filter(|datagram| datagram.contents == Contents::Unframed);
    datagrams.map(|datagram| (datagram.origin, datagram.payload.len())).collect()
}

#[test]
fn what_is_between_frames_is_the_same_in_however_many_parts_it_is_read() {
    let frame = |stamp| [0x1a, b'1', 0, 0, 0, 0, 0, stamp, 0x80, 1, 2];
    let mut octets: Vec<u8> = (1..=4).flat_map(frame).collect();
    octets.extend([7; 5000]);
    octets.extend(frame(5));
    // Of two escapes the first belongs to no frame.
    octets.push(0x1a);
    octets.extend(frame(6));
    octets.extend([7; 10]);
    let pieces = vec![(44, 4096), (4140, 904), (5055, 1), (5067, 10)];
    assert_eq!(unframed(Box::new(Cursor::new(octets.clone()))), pieces);
    let in_parts = Trickle { octets: Cursor::new(octets), step: 1, calls: 0 };
    assert_eq!(unframed(Box::new(in_parts)), pieces);
}
