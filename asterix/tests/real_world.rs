//! What real data does: one test for each habit of radars, transponders and networks that a decoder has to survive.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use asterix::cat048::{self, Warnings};
use asterix::cat129;
use asterix::{Fault, FaultKind, blocks};
use common::{DRONE_PLOT, MINIMAL_UAS, block, encode, hex, read, read_block};

fn plot(contents: &str) -> (Vec<cat048::Record>, Option<Fault>) {
    read(&block(48, &hex(contents)))
}

/// The fault of a CAT048 block with these contents, as text: its offsets count from the CAT octet.
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
fn negative_flight_level_and_height() {
    let (records, _) = plot("05 01 08  3ffb ff00");
    assert_eq!(records[0].flight_level.unwrap().flight_level(), -1.25);
    assert_eq!(records[0].height_3d.unwrap().height_ft(), -6400.0);
}

#[test]
fn several_records_in_a_block() {
    let (records, fault) = plot("80 0101 80 0102 80 0103");
    let sics: Vec<u8> = records.iter().map(|record| record.data_source.unwrap().sic).collect();
    assert_eq!((sics.as_slice(), fault), (&[1, 2, 3][..], None));
    // The edition of CAT129 allows one; more are read.
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
    // The padding of a frame that a capture handed over by mistake: CAT 0 of LEN 0.
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
    // In a later block the offset still counts from the start of the datagram.
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
    // Nothing but the length octet is legal, and so are 255 octets.
    assert_eq!(plot("01010104 01").0[0].special_purpose.as_ref().unwrap().contents(), []);
    let longest = [hex("01010102 ff"), vec![7; 254]].concat();
    let (records, fault) = read::<cat048::Record>(&block(48, &longest));
    assert_eq!((fault, encode(&records[0])), (None, longest));
}

#[test]
fn repetition_count_of_zero_or_missing() {
    let (records, fault) = plot("0120 00");
    assert_eq!((records[0].bds_registers.as_ref().unwrap().octets(), fault), (&[0][..], None));
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
fn several_warnings_and_unknown_ones() {
    let (records, _) = plot("010140 27 fd 2e");
    assert_eq!(records[0].warnings, Warnings::new(&[19, 126, 23]));
}

#[test]
fn doppler_with_both_subfields() {
    let (records, fault) = plot("010104 c0 8005 02 000a00140bb8 000b00150bb9");
    assert_eq!((records.len(), fault), (1, None));
    assert_eq!(records[0].radial_doppler.as_ref().unwrap().octets().len(), 16);
}

#[test]
fn compound_items_have_one_octet_of_subfields() {
    let text = "the primary subfield announces a second octet, which does not exist";
    assert_eq!(complaint("02 8101"), format!("CAT048 item 130 at octet 4: {text}"));
    assert_eq!(complaint("010104 8180 0000"), format!("CAT048 item 120 at octet 6: {text}"));
}

#[test]
fn spare_bits_are_kept() {
    let contents = hex("01 11 08 f001 ff00");
    let (records, fault) = read::<cat048::Record>(&block(48, &contents));
    assert_eq!(fault, None);
    assert_eq!(encode(&records[0]), contents);
    let contents = hex("01 03 80 0012cfff6a ffff1f");
    let (records, _) = read::<cat129::Record>(&block(129, &contents));
    assert_eq!(records[0].vertical_velocity.unwrap().up_m_s(), -2.25);
    assert_eq!(encode(&records[0]), contents);
}

#[test]
fn unaligned_and_24_bit_numbers_keep_their_sign() {
    // 090, 185, 220: -1 count each, and the largest.
    let (records, _) = read::<cat129::Record>(&block(129, &hex("01 43 80 ffffff fffff80000 0fffff")));
    let record = &records[0];
    assert_eq!(record.altitude_amsl.unwrap().count(), -1);
    let velocity = record.horizontal_velocity.unwrap();
    assert_eq!((velocity.east(), velocity.north()), (-1, -524_288));
    assert_eq!(record.vertical_velocity.unwrap().up(), -1);
}

#[test]
fn time_of_day_past_the_end_of_the_day() {
    let (records, fault) = plot("40 a8c000 40 ffffff 40 000000");
    assert_eq!(fault, None);
    let times: Vec<_> = records.iter().map(|record| record.time_of_day.unwrap()).collect();
    assert_eq!(times[0].seconds(), 86_400.0);
    assert_eq!(times[1].seconds(), 131_071.992_187_5);
    let of_the_day: Vec<bool> = times.iter().map(|time| time.in_range()).collect();
    assert_eq!(of_the_day, [false, false, true]);
}

#[test]
fn position_off_the_earth() {
    let (records, fault) =
        read::<cat129::Record>(&block(129, &hex("0180 20000001 00000000 0180 20000000 c0000000")));
    assert_eq!(fault, None);
    let on_the_earth: Vec<bool> = records.iter().map(|record| record.position.unwrap().in_range()).collect();
    assert_eq!(on_the_earth, [false, true]);
}

#[test]
fn serial_number_that_is_no_text() {
    let contents = hex("08 00ff80c3 28000000 0000007f");
    let (records, fault) = read::<cat129::Record>(&block(129, &contents));
    assert_eq!(fault, None);
    assert_eq!(records[0].serial_number.unwrap()[..5], [0x00, 0xff, 0x80, 0xc3, 0x28]);
    assert_eq!(encode(&records[0]), contents);
}
