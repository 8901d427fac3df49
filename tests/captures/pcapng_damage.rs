//! Truncated and damaged pcapng.

use proptest::prelude::*;
use utm_fusion::capture::Damage;

use crate::writer::{PcapngWriter, WRAPPINGS};
use crate::{BLOCKS, open, open_in_steps, payloads, read};

/// Message of the error that ends a file.
fn damage(octets: &[u8]) -> String {
    let (_, error) = read(octets, &mut open(octets).expect("a capture"));
    error.expect("damage").to_string()
}

/// Three datagrams on one Ethernet interface, and the end of each block.
fn three_datagrams(big_endian: bool) -> (Vec<u8>, Vec<usize>) {
    let mut file = PcapngWriter::new(big_endian);
    let mut ends = vec![0, file.octets.len()];
    file.interface(1, 0, &[(9, &[9]), (0, &[])]);
    ends.push(file.octets.len());
    for (time, block) in (1_700_000_000_000_000_000..).zip(BLOCKS) {
        file.packet(0, time, &WRAPPINGS[0].frame(4, block));
        ends.push(file.octets.len());
    }
    (file.octets, ends)
}

#[test]
fn file_cut_anywhere_gives_whole_datagrams_and_names_the_cut() {
    let (octets, ends) = three_datagrams(true);
    for length in 4..=octets.len() {
        let cut = &octets[..length];
        let mut capture = open(cut).unwrap();
        let (datagrams, error) = read(cut, &mut capture);
        let whole = ends.iter().filter(|end| **end <= length).count() - 1;
        assert_eq!(payloads(&datagrams), BLOCKS[..whole.saturating_sub(2)]);
        assert_eq!(error.is_some(), ends[whole] != length, "{length}");
        if let Some(error) = error {
            assert_eq!(error.offset, ends[whole] as u64);
            assert!(matches!(error.damage, Damage::Cut { present, .. } if present == length - ends[whole]));
        }
    }
    let (mut octets, ends) = three_datagrams(false);
    let mut long = PcapngWriter::new(false);
    long.block(77, &[1; 1_000_000]);
    octets.extend(&long.octets[28..500_000]);
    let message = damage(&octets);
    let place = ends[5];
    assert!(
        message.starts_with(&format!(
            "test: at offset {place}: the file ends in the middle of a pcapng block (499972 of 1000012 octets)"
        )),
        "{message}"
    );
}

#[test]
fn a_damaged_length_ends_the_capture_and_says_where() {
    for big_endian in [false, true] {
        let (octets, ends) = three_datagrams(big_endian);
        let with = |place: usize, number: u32| {
            let mut octets = octets.clone();
            let number = if big_endian { number.to_be_bytes() } else { number.to_le_bytes() };
            octets[place..place + 4].copy_from_slice(&number);
            octets
        };
        let second = ends[3];
        let cases = [
            (with(second + 4, 0), second, "claims 0 octets; 12 is the least"),
            (with(second + 4, 11), second, "claims 11 octets; 12 is the least"),
            (with(second + 4, 524_289), second, "claims 524289 octets (at most 524288 are possible)"),
            (with(second + 4, u32::MAX), second, "claims 4294967295 octets (at most 524288"),
            (with(second + 4, 60), second, "claims 60 octets at its beginning and "),
            (with(ends[4] - 4, 1000), second, "and 1000 at its end"),
            ([with(second, 99), vec![0; 99]].concat(), ends[5], "claims 0 octets"),
            (with(ends[1] + 4, 16_777_217), ends[1], "at most 524288"),
            (with(8, 0), 0, "begins a section without a byte order (00 00 00 00)"),
            (with(12, 0x0002_0002), 0, "begins a section of version 2.2, not 1"),
        ];
        for (octets, offset, words) in cases {
            let message = damage(&octets);
            assert!(message.starts_with(&format!("test: at offset {offset}: a pcapng block ")), "{message}");
            assert!(message.contains(words), "{message}");
        }
        let mut other = PcapngWriter::new(big_endian);
        other.block(99, &[0; 100]);
        let length = if big_endian { 16_777_220_u32.to_be_bytes() } else { 16_777_220_u32.to_le_bytes() };
        other.octets[32..36].copy_from_slice(&length);
        assert!(damage(&other.octets).contains("claims 16777220 octets (at most 16777216 are possible)"));
        other.octets.copy_within(4..8, 32);
        assert!(damage(&other.octets).contains("at offset 28: a pcapng block has another length at its end"));
    }
}

#[test]
fn a_section_has_no_more_interfaces_than_memory_allows() {
    let mut file = PcapngWriter::new(false);
    let place = file.octets.len() + 65_536 * 20;
    for _ in 0..65_537 {
        file.interface(1, 0, &[]);
    }
    assert!(
        damage(&file.octets)
            .starts_with(&format!("test: at offset {place}: a pcapng block describes one more"))
    );
}

#[test]
fn any_octet_may_be_wrong() {
    for big_endian in [false, true] {
        let (octets, _) = three_datagrams(big_endian);
        for place in 0..octets.len() {
            for flip in [0x01, 0x80, 0xFF] {
                let mut wrong = octets.clone();
                wrong[place] ^= flip;
                if let Ok(mut capture) = open(&wrong) {
                    assert!(read(&wrong, &mut capture).0.len() <= 3);
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn mutations_split_anywhere_never_panic_and_change_nothing(
        big_endian in any::<bool>(),
        step in 0_usize..80,
        blocks in prop::collection::vec(
            (prop::sample::select(vec![1_u32, 2, 3, 6, 5, 0x0A0D_0D0A]), prop::collection::vec(any::<u8>(), 0..60)),
            0..6,
        ),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..3),
        cut in 0_usize..40,
    ) {
        let mut octets = three_datagrams(big_endian).0;
        let mut noise = PcapngWriter::new(big_endian);
        for (kind, body) in &blocks {
            noise.block(*kind, body);
        }
        octets.extend(noise.octets);
        octets.truncate(octets.len() - cut);
        for (place, octet) in changes {
            let place = 4 + place.index(octets.len() - 4);
            octets[place] = octet;
        }
        let (mut at_once, mut in_steps) = (open(&octets).unwrap(), open_in_steps(&octets, step).unwrap());
        let (expected, damage) = read(&octets, &mut at_once);
        let (datagrams, same_damage) = read(&octets, &mut in_steps);
        prop_assert_eq!(datagrams, expected);
        prop_assert_eq!(damage.map(|error| error.to_string()), same_damage.map(|error| error.to_string()));
        prop_assert_eq!(at_once.skipped(), in_steps.skipped());
        prop_assert_eq!(at_once.consumed(), in_steps.consumed());
    }
}
