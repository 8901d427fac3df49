//! Operators' trust settings are recorded, and the recording replays to the data sent.

use std::collections::BTreeSet;
use std::fs;

use asterix::blocks;
use asterix::cat129::{self, FusionReport, fusion_report::Flags};
use utm_fusion::capture::Capture;
use utm_fusion::state::parse_decisions;

use crate::common::{Scratch, beside, only, replayed};
use crate::driver::{Fate, SCENARIO, record};

/// Integrity flags of the transponders' points in a recording of the output.
fn flags(path: &std::path::Path) -> BTreeSet<u8> {
    let mut found = BTreeSet::new();
    for datagram in Capture::open(path).unwrap().map(Result::unwrap) {
        for block in blocks(&datagram.payload).flatten() {
            for located in block.records::<cat129::Record>() {
                let field = located.unwrap().record.special_purpose.unwrap();
                let report = FusionReport::read(&field).unwrap();
                found.insert(report.flags.0 & (Flags::INTEGRITY_SUSPECT.0 | Flags::INTEGRITY_FAILED.0));
            }
        }
    }
    found
}

#[test]
fn recording_with_trust_settings_replays_to_the_sent_output() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    let fate = Fate { seed: 7, queue_ms: 300, tick_ms: 400, say_s: vec![25, 35, 45], ..Fate::default() };
    let flown = record(SCENARIO, None, &fate, &dir, 256);
    assert_eq!(flown.words, 3);
    let input = only(&dir, "input-", ".pcap");
    let output = only(&dir, "output-", ".pcap");
    let text = fs::read_to_string(beside(&input, "decisions.jsonl")).unwrap();
    assert_eq!(parse_decisions(&text).unwrap().len(), 3, "{text}");
    assert!(fs::read(&output).unwrap() == replayed(&input), "with {text}");
    // Bits 3 and 4: a distrusted transponder is failed, and also suspect.
    assert_eq!(flags(&output), [0, 0x0c].into());
}
