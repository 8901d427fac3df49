//! The recordings of the project, from the folder that `UTM_FUSION_SHARED_DATA` names.

use std::path::PathBuf;

use utm_fusion::capture::{Capture, CapturedDatagram};

fn recording(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("UTM_FUSION_SHARED_DATA");
    if folder.is_none() {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set ({name})");
    }
    Some(PathBuf::from(folder?).join(name))
}

/// Reads a recording to its end, without damage and with every octet consumed.
fn whole(name: &str) -> Option<(Capture, Vec<CapturedDatagram>)> {
    let mut capture = Capture::open(&recording(name)?).expect(name);
    let datagrams: Vec<CapturedDatagram> = capture.by_ref().map(|item| item.expect(name)).collect();
    assert_eq!(Some(capture.consumed()), capture.size(), "{name}");
    Some((capture, datagrams))
}

/// Number of blocks in the payloads, if these consist of complete blocks.
fn blocks(datagrams: &[CapturedDatagram]) -> Option<usize> {
    let mut count = 0;
    for datagram in datagrams {
        let mut rest = datagram.payload.as_slice();
        while !rest.is_empty() {
            let length = u16::from_be_bytes([*rest.get(1)?, *rest.get(2)?]);
            rest = rest.get(length.max(3).into()..)?;
            count += 1;
        }
    }
    Some(count)
}

#[test]
fn captures_hold_the_datagrams_their_headers_say() {
    // Number of records in the file, and sum of their UDP lengths without headers, both counted by another program.
    let expected = [
        ("cat048-croatia/capture.pcap", 100, 6882),
        ("conformance/bias/capture.pcap", 1387, 177_731),
        ("conformance/crossing/capture.pcap", 1871, 364_083),
        ("conformance/hostile/capture.pcap", 2036, 133_960),
        ("drone-trial/2_1/capture.pcap", 1585, 59_477),
    ];
    for (name, count, octets) in expected {
        let Some((capture, datagrams)) = whole(name) else { return };
        assert_eq!(capture.format().to_string(), "pcap (Ethernet, microseconds)");
        assert_eq!(capture.skipped().to_string(), "none", "{name}");
        assert!(datagrams.iter().all(|datagram| datagram.received.is_some()));
        assert_eq!(datagrams.len(), count, "{name}");
        let sum: usize = datagrams.iter().map(|datagram| datagram.payload.len()).sum();
        assert_eq!(sum, octets, "{name}");
        // Only the hostile feed does not consist of complete blocks: padding in a payload would be detected.
        assert_eq!(blocks(&datagrams).is_some(), !name.contains("hostile"), "{name}");
    }
}

#[test]
fn raw_files_are_read_to_the_last_octet() {
    let expected = [
        ("cat048-barcelona/capture.ast", 44_085),
        ("cat048-small/croatia_cat048.raw", 1),
        ("cat048-small/goasterix_sample.ast", 7),
        ("cat048-small/jasterix_cat048ed1.23.bin", 1),
        ("cat048-small/psr3d_nonminimal_fspec.raw", 92),
        ("drone-trial/2_1/radar.ast", 459),
        ("drone-trial/2_1/transponder.ast", 1126),
    ];
    for (name, count) in expected {
        let Some((capture, datagrams)) = whole(name) else { return };
        assert_eq!(capture.format().to_string(), "raw ASTERIX");
        assert_eq!((datagrams.len(), blocks(&datagrams)), (count, Some(count)), "{name}");
    }
}

#[test]
fn what_is_no_capture_is_refused() {
    let expected = [
        ("cat048-barcelona/decoded.ndjson.gz", "looks like JSON, gzip-compressed"),
        ("cat048-croatia/expected.txt", "looks like text"),
        ("conformance/crossing/truth.csv", "looks like text"),
        ("conformance/crossing/site.toml", "looks like text"),
        ("cat048-small", "is a directory"),
    ];
    for (name, words) in expected {
        let Some(path) = recording(name) else { return };
        let message = Capture::open(&path).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}
