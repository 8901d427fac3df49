//! Structure of real data: one test for each peculiarity of radars, transponders and networks that a decoder must tolerate.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{DRONE_PLOT, MINIMAL_UAS, block, encode, hex, read, read_block};
use utm_asterix::cat048::{self, RadialDoppler};
use utm_asterix::{Explicit, Fault, FaultKind, blocks, cat034, cat065, cat129};

fn plot(contents: &str) -> (Vec<cat048::Record>, Option<Fault>) {
    read(&block(48, &hex(contents)))
}

/// The fault of a CAT048 block with these contents, as text; its offsets are relative to the CAT octet.
fn complaint(contents: &str) -> String {
    let (records, fault) = plot(contents);
    assert!(records.is_empty());
    fault.unwrap().to_string()
}

#[test]
fn fspec_longer_than_needed() {
    let octets = hex("f1 11 09 00 1907 546000 20 0100 4000 0007 3ffe");
    let (records, fault) = read::<cat048::Record>(&block(48, &octets));
    assert_eq!((fault, records[0].fspec_padding), (None, 1));
    assert_eq!(encode(&records[0]), octets);
    let mut anew = records[0].clone();
    anew.fspec_padding = 0;
    assert_eq!(encode(&anew)[..3], [0xf1, 0x11, 0x08]);
    assert_eq!(encode(&anew)[3..], octets[4..]);
}

#[test]
fn fspec_of_zeros_is_an_empty_record() {
    let (records, fault) = plot("0100 00");
    assert_eq!((records.len(), fault), (2, None));
    assert_eq!(records[0], cat048::Record { fspec_padding: 1, ..cat048::Record::default() });
    assert_eq!(records[1], cat048::Record::default());
}

#[test]
fn fspec_has_a_limit() {
    assert_eq!(plot("01010101010101 00").1, None);
    assert_eq!(
        complaint("0101010101010101 00"),
        "CAT048 at octet 3: the FSPEC is longer than any record needs"
    );
}

#[test]
fn fspec_to_the_end_of_the_block() {
    assert_eq!(complaint("ffffff"), "CAT048 at octet 3: the FSPEC runs past the end of its block");
    assert_eq!(complaint("ffffffffffffffff"), "CAT048 at octet 3: the FSPEC runs past the end of its block");
}

#[test]
fn reserved_frn() {
    let text = "the FSPEC announces an item that the category does not define";
    assert_eq!(complaint("01010101 80 00"), format!("CAT048 at octet 7: {text}"));
    for octets in ["0101 40 00", "0101 02 00", "0101 01 80 00"] {
        let (records, fault) = read::<cat129::Record>(&block(129, &hex(octets)));
        assert!(records.is_empty());
        assert_eq!(fault.unwrap().kind, FaultKind::ReservedFrn);
    }
}

#[test]
fn several_records_in_a_block() {
    let (records, fault) = plot("80 0101 80 0102 80 0103");
    let sics: Vec<u8> = records.iter().map(|record| record.data_source.unwrap().sic).collect();
    assert_eq!((sics.as_slice(), fault), (&[1, 2, 3][..], None));
    // The edition of CAT129 allows one record; several are decoded.
    let (records, fault) = read::<cat129::Record>(&block(129, &hex("80 0101 80 0102")));
    assert_eq!((records.len(), fault), (2, None));
}

#[test]
fn several_categories_in_a_datagram() {
    let mut datagram = hex(DRONE_PLOT);
    let cat034 = block(34, &hex("f0 1907 02 546000 40"));
    datagram.extend_from_slice(&cat034);
    let uas_offset = datagram.len();
    datagram.extend_from_slice(&hex(MINIMAL_UAS));
    let walked: Vec<_> = blocks(&datagram).map(Result::unwrap).collect();
    assert_eq!(walked.iter().map(|block| block.category).collect::<Vec<_>>(), [48, 34, 129]);
    assert_eq!(walked[2].offset, uas_offset);
    assert_eq!(walked[1].octets, cat034);
    let uas = walked[2].records::<cat129::Record>().next().unwrap().unwrap();
    assert_eq!((uas.offset, uas.length), (uas_offset + 3, 20));
}

#[test]
fn octets_after_the_last_block() {
    // Padding of a frame that a capture includes by mistake: CAT 0 with LEN 0.
    for (rest, category, kind) in [
        (&[0][..], None, FaultKind::BlockPastEnd),
        (&[0, 0][..], None, FaultKind::BlockPastEnd),
        (&[0, 0, 0][..], Some(0), FaultKind::BlockTooShort),
        (&[0; 6][..], Some(0), FaultKind::BlockTooShort),
    ] {
        let datagram = [&hex(DRONE_PLOT), rest].concat();
        let walked: Vec<_> = blocks(&datagram).collect();
        assert!(walked[0].is_ok());
        let fault = Fault { category, item: None, offset: 25, kind };
        assert_eq!(walked[1..], [Err(fault)]);
    }
}

#[test]
fn unknown_categories_are_stepped_over() {
    let datagram = [block(240, &[1, 2, 3]), hex(DRONE_PLOT), block(8, &[])].concat();
    let categories: Vec<u8> = blocks(&datagram).map(|block| block.unwrap().category).collect();
    assert_eq!(categories, [240, 48, 8]);
}

#[test]
fn len_below_three() {
    for length in 0..3 {
        let datagram = [48, 0, length, 0x80, 1, 2];
        let walked: Vec<_> = blocks(&datagram).collect();
        let fault = Fault { category: Some(48), item: None, offset: 0, kind: FaultKind::BlockTooShort };
        assert_eq!(walked, [Err(fault)]);
    }
}

#[test]
fn len_past_the_end_refuses_the_block_whole() {
    let mut datagram = hex(DRONE_PLOT);
    datagram.extend_from_slice(&[48, 0, 9, 0x80, 1, 2, 0x80, 1]);
    let walked: Vec<_> = blocks(&datagram).collect();
    assert_eq!(walked.len(), 2);
    let fault = walked[1].unwrap_err();
    assert_eq!(fault.to_string(), "CAT048 at octet 25: the block runs past the end of the datagram");
    assert_eq!(blocks(&[]).count(), 0);
}

#[test]
fn empty_block() {
    assert_eq!(plot(""), (vec![], None));
}

#[test]
fn bad_record_costs_neither_those_before_it_nor_the_next_block() {
    let datagram = [block(48, &hex("80 0101 80 01")), hex(DRONE_PLOT)].concat();
    let walked: Vec<_> = blocks(&datagram).map(Result::unwrap).collect();
    let (records, fault) = read_block::<cat048::Record>(&walked[0]);
    assert_eq!(records.len(), 1);
    assert_eq!(
        fault.unwrap().to_string(),
        "CAT048 item 010 at octet 7: the item runs past the end of its block"
    );
    let (records, fault) = read_block::<cat048::Record>(&walked[1]);
    assert_eq!((records.len(), fault), (1, None));
    // In a later block the offset is still relative to the start of the datagram.
    let datagram = [hex(DRONE_PLOT), block(48, &hex("c0 0101 ffff"))].concat();
    let second = blocks(&datagram).nth(1).unwrap().unwrap();
    assert_eq!(read_block::<cat048::Record>(&second).1.unwrap().offset, 25 + 3 + 1 + 2);
}

#[test]
fn sp_and_re_of_length_zero_or_past_the_end() {
    let text = "the length octet is 0, although it counts itself";
    assert_eq!(complaint("01010104 00"), format!("CAT048 item SP at octet 7: {text}"));
    assert_eq!(complaint("01010102 00"), format!("CAT048 item RE at octet 7: {text}"));
    let text = "the item runs past the end of its block";
    assert_eq!(complaint("01010104"), format!("CAT048 item SP at octet 7: {text}"));
    assert_eq!(complaint("01010106 03aabb 0401"), format!("CAT048 item RE at octet 10: {text}"));
    let (_, fault) = read::<cat129::Record>(&block(129, &hex("0104 00")));
    assert_eq!(
        fault.unwrap().to_string(),
        "CAT129 item SP at octet 5: the length octet is 0, although it counts itself"
    );
    // A length octet alone is legal, and so are 255 octets.
    assert_eq!(plot("01010104 01").0[0].special_purpose.as_ref().unwrap().contents(), []);
    let longest = [hex("01010102 ff"), vec![7; 254]].concat();
    let (records, fault) = read::<cat048::Record>(&block(48, &longest));
    assert_eq!((fault, encode(&records[0])), (None, longest));
}

#[test]
fn repetition_count_of_zero_or_missing() {
    let (records, fault) = plot("0120 00");
    assert_eq!((records[0].bds_registers.as_ref().unwrap().len(), fault), (0, None));
    assert_eq!(encode(&records[0]), hex("0120 00"));
    assert_eq!(
        complaint("0120"),
        "CAT048 item 250 at octet 5: the block ends before the item's repetition count"
    );
    assert_eq!(
        complaint("0120 01 00"),
        "CAT048 item 250 at octet 5: the item runs past the end of its block"
    );
    let most = [hex("0120 ff"), vec![9; 255 * 8]].concat();
    let (records, fault) = read::<cat048::Record>(&block(48, &most));
    assert_eq!((fault, encode(&records[0])), (None, most));
}

#[test]
fn target_report_with_any_number_of_extensions() {
    for extensions in 0..15 {
        let mut contents = vec![0x20, 0x21];
        contents.resize(2 + extensions, 0x41);
        contents.push(0x80);
        let (records, fault) = read::<cat048::Record>(&block(48, &contents));
        assert_eq!(fault, None);
        let report = records[0].target_report.unwrap();
        assert_eq!(report.chain().octets().len(), 2 + extensions);
        assert_eq!(report.is_test(), extensions == 0);
        assert_eq!(encode(&records[0]), contents);
    }
    let contents = [vec![0x20], vec![0x21; 16], vec![0x80]].concat();
    let (_, fault) = read::<cat048::Record>(&block(48, &contents));
    assert_eq!(
        fault.unwrap().to_string(),
        "CAT048 item 020 at octet 4: the item has more extensions than any edition defines"
    );
    assert_eq!(complaint("20 2121"), "CAT048 item 020 at octet 4: the item runs past the end of its block");
}

#[test]
fn doppler_with_both_subfields() {
    let (records, fault) = plot("010104 c0 8005 02 000a00140bb8 000b00150bb9");
    assert_eq!((records.len(), fault), (1, None));
    let doppler = records[0].radial_doppler.as_ref().unwrap();
    let calculated = doppler.calculated.unwrap();
    assert_eq!((calculated.is_doubtful(), calculated.speed_m_s()), (true, 5.0));
    let raw: Vec<_> = doppler.raw.as_ref().unwrap().iter().map(|raw| raw.frequency_mhz()).collect();
    assert_eq!(raw, [3000, 3001]);
}

#[test]
fn compound_items_have_one_octet_of_subfields() {
    let text = "the primary subfield announces another octet, which does not exist";
    assert_eq!(complaint("02 8101"), format!("CAT048 item 130 at octet 4: {text}"));
    assert_eq!(complaint("010104 8180 0000"), format!("CAT048 item 120 at octet 6: {text}"));
}

#[test]
fn subfields_that_the_edition_does_not_define() {
    let text = "the primary subfield announces a subfield that the item does not define";
    for bit in ["20", "10", "08", "04", "02"] {
        let contents = format!("010104 {bit} 0000");
        assert_eq!(complaint(&contents), format!("CAT048 item 120 at octet 6: {text}"));
    }
    for (item, fspec) in [("050", "04"), ("060", "02")] {
        for bit in ["40", "20", "02"] {
            let (records, fault) = read::<cat034::Record>(&block(34, &hex(&format!("{fspec} {bit} 0000"))));
            let fault = fault.unwrap();
            assert!(records.is_empty());
            assert_eq!((fault.item, fault.kind), (Some(item), FaultKind::ReservedSubfield));
            assert_eq!((fault.offset, fault.kind.name()), (4, "reserved_subfield"));
        }
    }
    // Without such a bit an empty primary subfield is valid.
    assert_eq!(plot("010104 00").0[0].radial_doppler, Some(RadialDoppler::default()));
}

#[test]
fn reserved_frns_of_the_service_categories() {
    for frn_8_to_12 in ["80", "40", "20", "10", "08"] {
        let (records, fault) = read::<cat065::Record>(&block(65, &hex(&format!("01 {frn_8_to_12} 00"))));
        let fault = fault.unwrap();
        assert!(records.is_empty());
        assert_eq!((fault.item, fault.offset, fault.kind), (None, 4, FaultKind::ReservedFrn));
    }
    let (_, fault) = read::<cat065::Record>(&block(65, &hex("0101 80 00")));
    assert_eq!(fault.unwrap().kind, FaultKind::ReservedFrn);
    let (_, fault) = read::<cat034::Record>(&block(34, &hex("0101 80 00")));
    assert_eq!(fault.unwrap().kind, FaultKind::ReservedFrn);
    // Items before the reserved bit are examined first.
    let (_, fault) = read::<cat065::Record>(&block(65, &hex("81 80 19")));
    assert_eq!(fault.unwrap().item, Some("010"));
}

/// The order is the reverse of that of CAT048.
#[test]
fn re_before_sp_in_the_service_categories() {
    let contents = hex("01 06 03aabb 02cc");
    let (records, fault) = read::<cat034::Record>(&block(34, &contents));
    assert_eq!(fault, None);
    assert_eq!(records[0].reserved_expansion, Explicit::new(&[0xaa, 0xbb]));
    assert_eq!(records[0].special_purpose, Explicit::new(&[0xcc]));
    let (records, fault) = read::<cat065::Record>(&block(65, &contents));
    assert_eq!(fault, None);
    assert_eq!(records[0].reserved_expansion, Explicit::new(&[0xaa, 0xbb]));
    assert_eq!(records[0].special_purpose, Explicit::new(&[0xcc]));
    let (records, fault) = plot("01010106 03aabb 02cc");
    assert_eq!(fault, None);
    assert_eq!(records[0].special_purpose, Explicit::new(&[0xaa, 0xbb]));
    assert_eq!(records[0].reserved_expansion, Explicit::new(&[0xcc]));
}

/// An Ethernet frame has at least 46 octets after its header. Octets beyond the length of UDP are not part of the datagram, but a
/// capture may include them.
#[test]
fn padding_of_a_short_frame_costs_no_record() {
    let north_marker = block(34, &hex("e0 1907 01 546000"));
    for padding in 1..=46 - 20 - 8 - north_marker.len() {
        let datagram = [north_marker.as_slice(), &vec![0; padding]].concat();
        let walked: Vec<_> = blocks(&datagram).collect();
        assert_eq!(walked.len(), 2);
        assert_eq!(read_block::<cat034::Record>(&walked[0].unwrap()).0.len(), 1);
        let fault = walked[1].unwrap_err();
        assert_eq!(fault.offset, north_marker.len());
        let kind = if padding < 3 { FaultKind::BlockPastEnd } else { FaultKind::BlockTooShort };
        assert_eq!(fault.kind, kind);
    }
}
