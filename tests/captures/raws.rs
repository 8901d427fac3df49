//! Raw ASTERIX, and files in other formats.

use std::io::{self, Read};
use std::path::Path;

use proptest::prelude::*;
use utm_fusion::capture::{Capture, CaptureFormat, OpenError, PayloadKind};

use crate::{BLOCKS, open, open_in_steps, payloads, read};

#[test]
fn each_block_is_a_datagram_without_a_time() {
    let octets = BLOCKS.concat();
    let mut capture = open(&octets).unwrap();
    assert_eq!(
        (capture.format(), capture.format().to_string().as_str()),
        (&CaptureFormat::Raw, "raw ASTERIX")
    );
    assert_eq!((capture.name(), capture.size()), ("test", Some(25)));
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams), BLOCKS);
    assert_eq!(datagrams.iter().map(|datagram| datagram.origin).collect::<Vec<_>>(), [0, 8, 13]);
    assert!(datagrams.iter().all(|datagram| datagram.received.is_none() && datagram.endpoints.is_none()));
    assert_eq!(capture.consumed(), 25);
}

/// An FSPEC whose first octet announces only a second one.
#[test]
fn raw_file_whose_fspec_begins_with_01_is_read() {
    let block = [48, 0, 7, 0x01, 0x80, 1, 2];
    let octets = [block, block].concat();
    let mut capture = open(&octets).unwrap();
    assert_eq!(capture.format(), &CaptureFormat::Raw);
    assert_eq!(payloads(&read(&octets, &mut capture).0), [block, block]);
    // A record needs at least one item.
    for empty in [[0, 1, 0, 0], [1, 0, 1, 2], [1, 1, 1, 0], [1, 1, 1, 1]] {
        let block = [&[48, 0, 7], &empty[..]].concat();
        let error = open(&block.repeat(2)).unwrap_err().to_string();
        assert!(error.contains("would announce no items"), "{error}");
    }
}

#[test]
fn what_follows_the_last_whole_block_is_handed_out_as_it_is() {
    let tails: [&[u8]; 6] = [&[0], &[48, 0], &[0; 40], &[48, 0, 2, 1, 1], &[48, 0, 0], &[48, 0, 9, 0xFF]];
    for tail in tails {
        let octets = [BLOCKS[0], BLOCKS[1], tail].concat();
        let mut capture = open(&octets).unwrap();
        let (datagrams, error) = read(&octets, &mut capture);
        assert!(error.is_none());
        assert_eq!(payloads(&datagrams), [BLOCKS[0], BLOCKS[1], tail]);
        assert_eq!(capture.consumed(), capture.size().unwrap());
    }
    // After a single block, too, where the tail must be padding or a truncated block.
    for tail in [&[0][..], &[48, 0], &[0; 40], &[48, 0, 9, 0xFF]] {
        let octets = [BLOCKS[0], tail].concat();
        assert_eq!(payloads(&read(&octets, &mut open(&octets).unwrap()).0), [BLOCKS[0], tail]);
    }
    // Before a complete block at the end of the file it is not the end.
    let octets = [BLOCKS[0], BLOCKS[1], &[0, 0, 1], &[48, 0, 4, 0]].concat();
    let (datagrams, _) = read(&octets, &mut open(&octets).unwrap());
    assert_eq!(payloads(&datagrams), [BLOCKS[0], BLOCKS[1], &[0, 0, 1], &[48, 0, 4, 0]]);
    assert_eq!(datagrams[2].contents, PayloadKind::Unframed);
}

#[test]
fn the_rest_behind_damage_comes_in_parts() {
    let octets = [BLOCKS[0], BLOCKS[1], &[48, 0, 1], &[7; 200_000]].concat();
    let mut capture = open(&octets).unwrap();
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    assert_eq!(payloads(&datagrams).concat(), octets);
    assert!(
        datagrams[2..]
            .iter()
            .all(|rest| rest.contents == PayloadKind::Unframed && rest.payload.len() <= 65_535)
    );
    assert_eq!(capture.gaps().to_string(), "200003 octets in 1 place (at offset 13)");
}

#[test]
fn cut_at_every_length_after_the_first_block_nothing_is_lost() {
    let octets = BLOCKS.concat();
    for length in 0..octets.len() {
        match open(&octets[..length]) {
            Ok(mut capture) => {
                let (datagrams, error) = read(&octets, &mut capture);
                assert!(error.is_none() && length >= BLOCKS[0].len());
                assert_eq!(payloads(&datagrams).concat(), octets[..length]);
            }
            Err(_) => assert!(length < BLOCKS[0].len()),
        }
    }
}

#[test]
fn blocks_of_any_size_are_recognised_and_pass_the_window() {
    for length in [3_u16, 4, 255, 256, 2303, 2304, 2570, 3338, 8224, 25_187, 65_535] {
        let block: Vec<u8> = [48]
            .into_iter()
            .chain(length.to_be_bytes())
            .chain(128..=255)
            .chain(0..128)
            .cycle()
            .take(length.into())
            .collect();
        let octets = block.repeat(20);
        for step in [1, 0, 4096] {
            let (datagrams, error) = read(&octets, &mut open_in_steps(&octets, step).unwrap());
            assert!(error.is_none());
            assert_eq!(payloads(&datagrams), vec![block.as_slice(); 20], "{length}");
        }
    }
}

#[test]
fn large_blocks_are_believed_between_their_like_and_as_video() {
    let block = |category: u8, length: u16| {
        let length_octets = length.to_be_bytes();
        [&[category, length_octets[0], length_octets[1]][..], &vec![0x80; length.into()][3..]].concat()
    };
    let (large, small, video) = (block(48, 2304), block(34, 20), block(240, 9000));
    // All octets of the large block except LEN are neither text nor control characters, so some are replaced.
    let large = [&large[..20], &[0; 4], &large[24..]].concat();
    let video = [&video[..20], &[0; 4], &video[24..]].concat();
    for believed in [[&large, &large], [&small, &video], [&video, &small], [&video, &video]] {
        let octets = believed.map(Vec::as_slice).concat();
        assert_eq!(read(&octets, &mut open(&octets).unwrap()).0.len(), 2);
    }
    for refused in [[&large, &small], [&small, &large]] {
        assert!(refusal(&refused.map(Vec::as_slice).concat()).contains("no block follows it"));
    }
    assert_eq!(read(&large, &mut open(&large).unwrap()).0.len(), 1);
}

/// The window has a fixed size: a hundred megabytes that are not stored pass through it.
#[test]
fn a_long_file_is_streamed() {
    let block = [&[48, 1, 0][..], &[5; 253]].concat();
    let blocks = 400_000;
    let reader = EndlessBlocks { block: block.clone(), place: 0 }.take(256 * blocks);
    let mut capture = Capture::from_reader("long".to_owned(), Box::new(reader), None).unwrap();
    let mut count = 0;
    for datagram in capture.by_ref() {
        let datagram = datagram.unwrap();
        assert!(datagram.payload == block && datagram.origin == count * 256);
        count += 1;
    }
    assert_eq!((count, capture.consumed()), (blocks, 256 * blocks));
}

struct EndlessBlocks {
    block: Vec<u8>,
    place: usize,
}

impl Read for EndlessBlocks {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let next = &self.block[self.place..];
        let given = next.len().min(buffer.len());
        buffer[..given].copy_from_slice(&next[..given]);
        self.place = (self.place + given) % self.block.len();
        Ok(given)
    }
}

fn refusal(octets: &[u8]) -> String {
    let message = open(octets).expect_err("no capture").to_string();
    assert_eq!(open_in_steps(octets, 1).expect_err("no capture").to_string(), message);
    message
}

#[test]
fn foreign_files_are_refused_with_what_they_look_like() {
    let long_text = "Callsign,time,lat\nDRONE-ALPHA,10:00:00,52.5\n".repeat(20_000);
    let cases: Vec<(&[u8], &str)> = vec![
        (b"abc", "text"),
        (b"# Title\n", "text"),
        (b"a\n\nb\n", "text"),
        (b"0", "text"),
        (long_text.as_bytes(), "text"),
        ("Überflüge über München\n".as_bytes(), "text"),
        (b"\xEF\xBB\xBF{\"time\": 1}", "JSON"),
        (b"{\n  \"items\": {}\n}\n", "JSON"),
        (b"[{\"cat\":48}]", "JSON"),
        (b"[\n  {\"cat\":48}\n]\n", "JSON"),
        (b"[site]\nname = \"deenethorpe\"\n", "text"),
        (b"<?xml version=\"1.0\"?><kml/>", "XML or HTML"),
        (b"\xFF\xFEa\0b\0c\0d\0", "UTF-16"),
        (b"\x89PNG\r\n\x1A\n\0\0\0\rIHDR", "PNG"),
        (b"\x7FELF\x02\x01\x01\0\0\0", "ELF"),
        (b"PK\x03\x04\x14\0\0\0", "ZIP"),
        (b"BZh91AY&SY", "bunzip2"),
        (b"\x34\xCD\xB2\xA1\x02\0\x04\0", "editcap -F pcap"),
        (b"SQLite format 3\0\x10\0", "SQLite"),
        (b"\0\0\0\0\0\0", "00 00 00 00 00 00; they are not the header"),
        (b"\x30\0\x02\xFF", "30 00 02 ff; they are not the header"),
        (b"\x30\0", "30 00; they are not the header"),
        (b"\x30\0\x09\xFF\x01", "a block of category 48 and 9 octets, but the file ends after 5"),
        (b"\x30\0\x04\xFF\0\x01\x02\x03", "no block follows it (00 01 02 at offset 4)"),
        (b"\x30\0\x05\x01\0\x30\0\x04", "first record would announce no items"),
        (b"\x30\0\x04\xFF\x31\x09\0\xFF", "no block follows it (31 09 00 at offset 4)"),
        (b"\x30\0\x04\xFF\x30\0\x02", "no block follows it (30 00 02 at offset 4)"),
    ];
    for (octets, words) in cases {
        let message = refusal(octets);
        assert!(message.starts_with("test: is not a capture: it looks like "), "{message}");
        assert!(message.contains(words), "{message}");
    }
    // Text of any length, with any alignment of a supposed second block.
    for length in (1..long_text.len()).step_by(997) {
        assert!(refusal(&long_text.as_bytes()[length..]).contains("text"));
    }
    assert_eq!(refusal(b""), "test: is empty; did the recording start, was the disk full?");
}

#[test]
fn a_path_that_is_no_file_is_an_error_with_its_name() {
    let missing = Capture::open(Path::new("no/such/capture.pcap")).unwrap_err();
    assert!(missing.to_string().starts_with("no/such/capture.pcap: cannot be opened: "), "{missing}");
    assert!(matches!(Capture::open(Path::new(".")), Err(OpenError::Directory { .. })));
}

#[test]
fn a_source_file_opened_by_its_path_is_text() {
    let error = Capture::open(Path::new(file!())).unwrap_err();
    assert!(error.to_string().contains("looks like text"), "{error}");
}

proptest! {
    #[test]
    fn noise_never_panics_and_how_it_arrives_changes_nothing(
        noise in prop::collection::vec(any::<u8>(), 0..300),
        first in prop::sample::select(vec![vec![], BLOCKS[0].to_vec(), BLOCKS.concat(), vec![0xA1, 0xB2, 0xC3, 0xD4]]),
        step in 0_usize..50,
    ) {
        let octets = [first, noise].concat();
        match (open(&octets), open_in_steps(&octets, step)) {
            (Ok(mut at_once), Ok(mut in_steps)) => {
                let (expected, _) = read(&octets, &mut at_once);
                prop_assert_eq!(read(&octets, &mut in_steps).0, expected);
            }
            (Err(error), Err(same)) => prop_assert_eq!(error.to_string(), same.to_string()),
            _ => prop_assert!(false, "recognised in one way only"),
        }
    }
}
