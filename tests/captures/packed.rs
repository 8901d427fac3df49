//! Captures compressed with gzip.

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;
use utm_fusion::capture::{Capture, CapturedDatagram, Damage, GzipError, OpenError};

use crate::writer::{PcapWriter, PcapngWriter, WRAPPINGS, final_record};
use crate::{BLOCKS, open, open_in_steps, payloads, read};

fn gzip(octets: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(octets).expect("memory takes it");
    encoder.finish().expect("memory takes it")
}

/// The three blocks in each format.
fn formats() -> [Vec<u8>; 4] {
    let frame = |block| WRAPPINGS[0].frame(4, block);
    let mut pcap = PcapWriter::new(false, true, 1);
    let mut pcapng = PcapngWriter::new(true);
    pcapng.interface(1, 0, &[]);
    for block in BLOCKS {
        pcap.record(1, 2, &frame(block));
        pcapng.packet(0, 3, &frame(block));
    }
    let recording = BLOCKS.iter().flat_map(|block| final_record(4_320_000, block)).collect();
    [BLOCKS.concat(), pcap.octets, pcapng.octets, recording]
}

fn whole(octets: &[u8]) -> Vec<CapturedDatagram> {
    let (datagrams, error) = read(octets, &mut open(octets).expect("a capture"));
    assert!(error.is_none());
    datagrams
}

#[test]
fn every_format_is_read_as_if_it_were_not_compressed() {
    for octets in formats() {
        let plain = whole(&octets);
        assert_eq!(payloads(&plain), BLOCKS);
        let packed = gzip(&octets);
        let mut capture = open(&packed).unwrap();
        assert!(capture.is_compressed() && !open(&octets).unwrap().is_compressed());
        assert_eq!(capture.format(), open(&octets).unwrap().format());
        let (datagrams, error) = read(&octets, &mut capture);
        assert!(error.is_none());
        assert_eq!(datagrams, plain);
        assert_eq!(Some(capture.consumed()), capture.size());
        for step in [0, 1, 7] {
            let mut capture = open_in_steps(&packed, step).unwrap();
            let (datagrams, error) = read(&octets, &mut capture);
            assert!(error.is_none());
            assert_eq!((datagrams, capture.consumed()), (plain.clone(), packed.len() as u64));
        }
    }
}

#[test]
fn compressed_files_one_after_the_other_are_one() {
    for octets in formats() {
        for cut in [0, 1, 20, octets.len()] {
            let packed = [gzip(&octets[..cut]), gzip(&[]), gzip(&octets[cut..])].concat();
            assert_eq!(payloads(&read(&octets, &mut open(&packed).unwrap()).0), BLOCKS);
        }
    }
}

#[test]
fn cut_anywhere_it_gives_what_is_whole_and_says_that_it_was_cut() {
    for octets in formats() {
        let packed = gzip(&octets);
        let mut most = 0;
        for length in 3..packed.len() {
            let cut = &packed[..length];
            match open(cut) {
                Ok(mut capture) => {
                    let (datagrams, error) = read(&octets, &mut capture);
                    let error = error.expect("an error");
                    assert!(matches!(error.damage, Damage::Gzip(GzipError::Cut)), "{error}");
                    assert!(error.to_string().starts_with("test, unpacked: at offset "), "{error}");
                    most = most.max(datagrams.len());
                }
                Err(error) => {
                    assert!(matches!(error, OpenError::Read { .. }), "{error}");
                    let words = "test: cannot be read: the gzip-compressed file ends too early";
                    assert!(error.to_string().starts_with(words), "{error}");
                }
            }
        }
        // Only the checksum is missing.
        assert_eq!(most, 3);
    }
}

#[test]
fn what_is_damaged_or_follows_is_told_after_what_is_sound() {
    for octets in formats() {
        let sound = gzip(&octets);
        let mut wrong_sum = sound.clone();
        let place = sound.len() - 8;
        wrong_sum[place] ^= 1;
        for packed in [wrong_sum, [&sound[..], b"something else"].concat(), [&sound[..], &[0; 512]].concat()]
        {
            let mut capture = open(&packed).unwrap();
            let (datagrams, error) = read(&octets, &mut capture);
            assert_eq!(payloads(&datagrams), BLOCKS);
            let error = error.unwrap();
            assert!(matches!(error.damage, Damage::Gzip(GzipError::Corrupt(_))), "{error}");
            assert_eq!(error.offset, octets.len() as u64);
            assert!(error.to_string().contains("gzip -t"), "{error}");
        }
    }
}

#[test]
fn what_is_no_capture_unpacked_is_refused() {
    let refusal = |octets: &[u8]| open(octets).unwrap_err().to_string();
    assert_eq!(refusal(&gzip(&gzip(BLOCKS[0]))), "test: is gzip-compressed twice; unpack it once: gunzip");
    assert_eq!(refusal(&gzip(&[])), "test: is empty; did the recording start, was the disk full?");
    assert!(
        refusal(&gzip(b"{\"cat\":48}")).contains("it looks like JSON, gzip-compressed; this program reads")
    );
    assert!(
        refusal(&gzip(b"\x30\0\x02\xFF")).contains("not the header of an ASTERIX block), gzip-compressed;")
    );
}

#[test]
fn an_error_of_the_system_stays_one() {
    struct Broken;
    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::from_raw_os_error(5))
        }
    }
    let octets = BLOCKS.concat();
    let packed = gzip(&octets);
    let reader = io::Cursor::new(packed[..packed.len() - 9].to_vec()).chain(Broken);
    let mut capture = Capture::from_reader("disk".to_owned(), Box::new(reader), None).unwrap();
    let (_, error) = read(&octets, &mut capture);
    assert!(matches!(error.unwrap().damage, Damage::Io(_)));
}

proptest! {
    #[test]
    fn mutations_never_panic_and_sound_records_stay_the_same(
        format in 0_usize..4,
        step in 0_usize..80,
        place in any::<prop::sample::Index>(),
        octet in any::<u8>(),
    ) {
        let octets = &formats()[format];
        let mut packed = gzip(octets);
        let place = place.index(packed.len());
        packed[place] = octet;
        // The amount decompressed before damage is found depends on the size of the pieces.
        let all = |capture: Result<Capture, OpenError>| capture.ok()?.collect::<Result<Vec<_>, _>>().ok();
        prop_assert_eq!(all(open(&packed)), all(open_in_steps(&packed, step)));
    }
}
