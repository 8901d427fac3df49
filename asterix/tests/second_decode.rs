//! Datagrams of seven radars with CAT034 and CAT048, compared with the text output of another decoder: every item with its
//! octets, and the counts of its fields.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use std::collections::BTreeMap;

use common::hex;
use common::recordings::{datagrams, shared_data};
use utm_asterix::{Field, Kind, Layout, Quantity, blocks, items, profile};

/// The counts of these fields, without spare ones.
fn field_counts(fields: &[Field], octets: &[u8]) -> Vec<i64> {
    let mut at = 0;
    let count = |field: &Field| {
        let width = usize::from(field.bits);
        let count = field.count(octets, at);
        at += width;
        match field.kind {
            Kind::Quantity(Quantity { signed: true, .. }) if count >> (width - 1) == 1 => {
                count as i64 - (1 << width)
            }
            _ => count as i64,
        }
    };
    let all: Vec<i64> = fields.iter().map(count).collect();
    all.into_iter()
        .zip(fields)
        .filter(|(_, field)| field.kind != Kind::Spare)
        .map(|(count, _)| count)
        .collect()
}

/// The counts of all fields of an item, without FX and primary subfields.
fn counts(layout: Layout, octets: &[u8]) -> Vec<i64> {
    match layout {
        Layout::Fields(fields) => field_counts(fields, octets),
        Layout::Extended(parts) => {
            parts.iter().zip(octets).flat_map(|(fields, &octet)| field_counts(fields, &[octet])).collect()
        }
        Layout::Compound(subfields) => {
            let (&primary, mut rest) = octets.split_first().unwrap();
            let announced = |index: usize| primary & (0x80 >> index) != 0;
            let mut all = Vec::new();
            for (_, subfield) in subfields.iter().enumerate().filter(|&(index, _)| announced(index)) {
                let (octets, after) = rest.split_at(subfield.layout.measure(rest).unwrap());
                all.extend(counts(subfield.layout, octets));
                rest = after;
            }
            all
        }
        other => panic!("{other:?} does not occur here"),
    }
}

/// An item in the text: its number, its octets, and its counts.
struct TextItem<'a> {
    number: &'a str,
    octets: Vec<u8>,
    counts: Vec<i64>,
}

/// The items of a record in the text.
fn text_items(record: &str) -> Vec<TextItem<'_>> {
    let item = |part| {
        let mut lines = str::lines(part);
        let number = &lines.next().unwrap()[..3];
        let octets = hex(lines.next().unwrap());
        let fields = lines.map_while(|line| line.strip_prefix('\t'));
        let fields = fields.filter(|line| !line.starts_with("FX:") && !line.starts_with("spare"));
        let count = |line: &str| line.rsplit_once(": ")?.1.split(' ').next()?.parse().ok();
        TextItem { number, octets, counts: fields.filter_map(count).collect() }
    };
    record.split("\nItem ").skip(1).map(item).collect()
}

#[test]
fn every_item_has_the_octets_and_counts_of_another_decoder() {
    let Some(folder) = shared_data() else { return };
    let folder = folder.join("cat048-croatia");
    let text = String::from_utf8(std::fs::read(folder.join("expected.txt")).unwrap()).unwrap();
    let mut theirs = text.split("\nData Record ").skip(1).map(text_items);
    let pcap = std::fs::read(folder.join("capture.pcap")).unwrap();
    let mut compared: BTreeMap<(u8, &str), usize> = BTreeMap::new();
    let mut records = 0;
    for (_, datagram) in datagrams(&pcap) {
        for block in blocks(datagram) {
            let block = block.unwrap();
            let uap = profile(block.category).unwrap();
            let ends = common::record_ends(&block);
            let starts = [3].into_iter().chain(ends.iter().copied());
            for (start, &end) in starts.zip(&ends) {
                let theirs = theirs.next().unwrap();
                let ours: Vec<_> = items(uap, &block.octets[start..end]).collect();
                assert_eq!(ours.len(), theirs.len(), "record {records}");
                // The text is sorted by item number.
                for TextItem { number, octets, counts: their_counts } in theirs {
                    let &(item, our_octets) = ours.iter().find(|(item, _)| item.item == number).unwrap();
                    let place = format!("I{:03}/{number} of record {records}", block.category);
                    assert_eq!(our_octets, octets, "{place}");
                    // The other decoder does not show these four as counts.
                    if !["070", "220", "240", "250"].contains(&number) {
                        assert_eq!(counts(item.layout, our_octets), their_counts, "{place}");
                        *compared.entry((block.category, item.item)).or_default() += 1;
                    }
                }
                records += 1;
            }
        }
    }
    assert_eq!((records, theirs.count()), (162, 0));
    eprintln!("{records} records, compared: {compared:?}");
    assert_eq!((compared[&(34, "050")], compared[&(34, "120")], compared[&(48, "110")]), (10, 2, 48));
    assert_eq!(compared.len(), 20);
}
