//! Inputs without a usable record: the exit code is 1, and the message states the reason.

use std::path::Path;

use fusion::time::{SECOND, Time};

use super::common::{Scratch, demo, pcap, ran, utm_fusion};

fn capture_of(payload: &[u8]) -> Vec<u8> {
    let at = |second: i64| Time::from_nanos((1_782_000_000 + second) * SECOND);
    pcap((0..5).map(|second| (at(3 * second), payload)))
}

#[test]
fn replay_without_a_record_fails_with_the_reason() {
    let flight = demo();
    let scratch = Scratch::new();
    let mut tcp = capture_of(&[48, 0, 5, 0x80, 0]);
    // The protocol field of each IP header.
    for at in 0..tcp.len() - 20 {
        if tcp[at..at + 2] == [0x45, 0] && tcp[at + 9] == 17 {
            tcp[at + 9] = 6;
        }
    }
    for (name, octets, reason) in [
        ("empty.pcap", capture_of(&[])[..24].to_vec(), "it holds nothing; did the recording start?"),
        ("tcp.pcap", tcp, "frames hold no UDP datagram or message (5 not UDP)"),
        (
            "unreadable.pcap",
            capture_of(&[48, 0, 5, 0xff, 0xff]),
            "5 blocks, records or messages cannot be read (CAT048 ",
        ),
        (
            "category.pcap",
            capture_of(&[30, 0, 5, 0x80, 0]),
            "5 blocks are of categories that are not used (CAT030)",
        ),
    ] {
        let input = scratch.file(name, octets);
        for output in [&[][..], &["-o", "-", "--output-format", "csv"]] {
            let ran = ran(flight.replay(&[&input]).args(output));
            assert_eq!(ran.code, 1, "{name}: {}", ran.stderr);
            let told = ran.stderr.lines().last().unwrap();
            assert!(told.contains(reason) && told.contains("no record could be used"), "{name}: {told}");
            assert!(told.contains(&format!("utm-fusion info {}", input.display())), "{name}: {told}");
        }
    }
    // One good input is sufficient.
    let empty = scratch.file("none.pcap", &capture_of(&[])[..24]);
    assert_eq!(ran(&mut flight.replay(&[&empty, &flight.capture()])).code, 0);
    // An end before the first reception is a valid request.
    let early = ran(flight.replay(&[&flight.capture()]).args(["--end", "2026-06-20T00:00:00Z"]));
    assert_eq!(early.code, 0, "{}", early.stderr);
}

#[test]
fn field_cases_without_a_record_fail_with_the_reason() {
    let Some(root) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let folder = Path::new(&root).join("field-cases/23-nothing-readable");
    for (name, reason) in [
        ("empty", "it holds nothing"),
        ("tcp", "20 not UDP"),
        ("unreadable", "cannot be read (CAT048 "),
        ("wrongcat", "CAT030"),
        ("othersensor", "none of the 20 records is from a sensor of "),
    ] {
        let input = folder.join(name).with_extension("pcap");
        let ran = ran(utm_fusion("replay").arg(input).arg("--config").arg(demo().site()));
        assert_eq!(ran.code, 1, "{name}: {}", ran.stderr);
        assert!(ran.stderr.lines().last().unwrap().contains(reason), "{name}: {}", ran.stderr);
    }
}
