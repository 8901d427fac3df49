//! Categories without types: every edition, random records, damage, and comparison with the typed records.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;
#[path = "common/damage.rs"]
mod damaging;

use std::collections::BTreeSet;

use common::strategies::record_octets;
use common::{block, hex};
use damaging::{Random, damage};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use utm_asterix::all::{Category, Definition, categories, category};
use utm_asterix::cat021::{self, Edition};
use utm_asterix::{
    Block, Contents, DataSource, Fault, FaultKind, Field, Kind, Layout, Record, TimeOfDay, blocks, cat015,
    cat034, cat048, cat062, cat063, cat065, cat129,
};

/// Number of random records per edition.
const RECORDS: usize = 300;

/// Every edition with every reserved expansion field.
fn definitions() -> Vec<&'static Definition> {
    let mut all = Vec::new();
    for category in categories() {
        for edition in category.editions() {
            all.push(category.edition(edition).unwrap());
            for expansion in category.expansions() {
                all.push(category.edition(&format!("{edition}/{expansion}")).unwrap());
            }
        }
    }
    all
}

fn newest(number: u8) -> &'static Definition {
    category(number).unwrap().newest()
}

/// Random records of each profile, the same in every run.
fn records(definition: &'static Definition, count: usize) -> Vec<Vec<u8>> {
    let (mut runner, mut records) = (TestRunner::deterministic(), Vec::new());
    let strategies: Vec<_> = definition.profiles().map(record_octets).collect();
    while records.len() < count {
        for strategy in &strategies {
            let octets = strategy.new_tree(&mut runner).unwrap().current();
            // The record may state no profile or another one.
            if definition.record(&octets).is_ok_and(|record| record.octets() == octets) {
                records.push(octets);
            }
        }
    }
    records
}

#[test]
fn every_table_is_read() {
    let numbers: Vec<u8> = categories().map(Category::number).collect();
    assert!(numbers.is_sorted() && numbers.len() == 28, "{numbers:?}");
    let editions: usize = categories().map(|category| category.editions().len()).sum();
    let expansions: usize = categories().map(|category| category.expansions().len()).sum();
    assert_eq!((editions, expansions), (69, 7));
    for definition in definitions() {
        let items: BTreeSet<&str> = definition.items().iter().map(|item| item.item).collect();
        assert_eq!(items.len(), definition.items().len(), "{definition:?}");
        assert!(items.len() > 4);
        let whole = category(definition.category()).unwrap().edition(definition.name()).unwrap();
        assert!(std::ptr::eq(definition, whole), "an edition is made once");
    }
}

#[test]
fn editions_are_found_by_name() {
    let cat048 = category(48).unwrap();
    assert_eq!(cat048.newest().name(), "1.32");
    assert_eq!(cat048.edition("1.27").unwrap().name(), "1.27");
    assert_eq!(cat048.edition("1.27/1.13").unwrap().name(), "1.27");
    assert_eq!(cat048.edition("1.27/1.12").unwrap().name(), "1.27/1.12");
    for (number, edition) in [(48, "1.26"), (48, "1.32/1.10"), (48, ""), (10, "1.1/1.1"), (65, "1.6 ")] {
        let unknown = category(number).unwrap().edition(edition).unwrap_err();
        assert_eq!((unknown.category, unknown.given.as_str()), (number, edition));
    }
    assert_eq!(
        cat048.edition("2").unwrap_err().to_string(),
        "\"2\" is no edition of CAT048 that is known; known are 1.27, 1.28, 1.29, 1.30, 1.31, 1.32, each alone or with \
         /1.11 or /1.12 or /1.13"
    );
    assert!([0, 3, 30, 252].into_iter().all(|number| category(number).is_none()));
}

/// Every list of fields in a layout, and the unit of bits in which it must end.
fn lists(layout: Layout, found: &mut Vec<(&'static [Field], usize)>) {
    match layout {
        Layout::Fields(fields) | Layout::Repetitive(fields) | Layout::OneOrThree(fields) => {
            found.push((fields, 0));
        }
        Layout::Extended(parts) => found.extend(parts.iter().map(|&fields| (fields, 7))),
        Layout::Parts(parts) => {
            let (last, others) = parts.split_last().unwrap();
            found.extend(others.iter().map(|&fields| (fields, 7)));
            let bits: u16 = last.iter().map(|field| field.bits).sum();
            found.push((last, if bits % 8 == 0 { 0 } else { 7 }));
        }
        Layout::Chained(fields) => found.push((fields, 7)),
        Layout::Compound(subfields) | Layout::Explicit(Contents::Expansion(subfields)) => {
            let keys: BTreeSet<&str> = subfields.iter().map(|subfield| subfield.key).collect();
            let defined = subfields.iter().filter(|subfield| !subfield.key.is_empty());
            assert_eq!(keys.iter().filter(|key| !key.is_empty()).count(), defined.clone().count());
            defined.for_each(|subfield| lists(subfield.layout, found));
        }
        Layout::Sequence(items) => items.iter().for_each(|item| lists(item.layout, found)),
        Layout::Codes | Layout::Explicit(_) => {}
    }
}

/// Properties of every layout that `decode` and `encode` rely on.
#[test]
fn layouts_hold_together() {
    for definition in definitions() {
        for item in definition.items() {
            let (mut found, place) = (Vec::new(), format!("{:03} {}", definition.category(), item.item));
            lists(item.layout, &mut found);
            for &(fields, end) in &found {
                assert_eq!(
                    fields.iter().map(|field| usize::from(field.bits)).sum::<usize>() % 8,
                    end,
                    "{place}"
                );
                let keys: BTreeSet<&str> = fields.iter().map(|field| field.key).collect();
                assert_eq!(keys.len(), fields.len(), "{place}: {keys:?}");
                assert!(keys.len() == 1 || !keys.contains(""), "{place}");
                let mut at = 0;
                for field in fields {
                    check_field(field, at, fields, &place);
                    at += usize::from(field.bits);
                }
            }
            if let Layout::Extended(parts) | Layout::Parts(parts) = item.layout {
                let keys = || parts.iter().copied().flatten().map(|field| field.key);
                assert_eq!(keys().collect::<BTreeSet<_>>().len(), keys().count(), "{place}");
                // The presence of a part must be visible.
                assert!(
                    parts.iter().all(|fields| fields.iter().any(|field| field.kind != Kind::Spare)),
                    "{place}"
                );
            }
        }
    }
}

fn check_field(field: &Field, at: usize, fields: &[Field], place: &str) {
    let place = format!("{place} {:?}", field.key);
    assert!(field.key.chars().all(|letter| matches!(letter, 'a'..='z' | '0'..='9' | '_')), "{place}");
    let is_reserved = matches!(field.key, "more" | "primary" | "hex" | "undescribed");
    assert!(!is_reserved && (field.kind == Kind::Spare) == field.key.starts_with("spare"), "{place}");
    match field.kind {
        Kind::Octal => assert_eq!(field.bits % 3, 0, "{place}"),
        Kind::Address => assert_eq!(field.bits, 24, "{place}"),
        Kind::Hex if field.bits > 64 => assert_eq!((field.bits % 8, at % 8), (0, 0), "{place}"),
        Kind::Hex => assert_eq!(field.bits % 4, 0, "{place}"),
        Kind::Ascii | Kind::Icao => {
            assert_eq!((field.bits % 8, at % 8), (0, 0), "{place}");
            assert!(field.kind == Kind::Ascii || field.bits == 48, "{place}");
        }
        Kind::Quantity(quantity) => {
            assert!(field.bits <= 32 && quantity.lsb > 0.0 && quantity.unknown.is_none(), "{place}");
            assert!(10_f64.powi(-i32::from(quantity.decimals)) <= quantity.lsb, "{place}");
        }
        Kind::Depends(dependence) => {
            let (before, _) =
                fields.split_at(fields.iter().position(|other| other.key == field.key).unwrap());
            let on = before.iter().find(|other| other.key == dependence.on).unwrap();
            for (value, case) in dependence.cases {
                assert!(value >> on.bits == 0 && case.bits == field.bits && case.key != field.key, "{place}");
                check_field(case, at, fields, &place);
            }
        }
        _ => assert!(field.bits <= 64, "{place}"),
    }
}

/// Records are contiguous, their items are complete, and no valid record is refused.
#[test]
fn random_records_of_every_edition_are_read() {
    for definition in definitions() {
        let category = definition.category();
        let records = records(definition, RECORDS);
        let mut seen = BTreeSet::new();
        for chunk in records.chunks(3) {
            let octets = block(category, &chunk.concat());
            let block = blocks(&octets).next().unwrap().unwrap();
            if category == cat129::Record::CATEGORY {
                // In a block of several records the length of I129/120 is ambiguous.
                continue;
            }
            let read: Vec<_> = definition.records(block).map(Result::unwrap).collect();
            assert_eq!(read.len(), chunk.len());
            for (located, octets) in read.iter().zip(chunk) {
                let record = &located.record;
                assert_eq!((located.length, record.octets()), (octets.len(), octets.as_slice()));
                let fspec = utm_asterix::Fspec::read(octets).unwrap().length();
                let of_items: Vec<u8> = record.items().flat_map(|(_, octets)| octets).copied().collect();
                assert_eq!(of_items, octets[fspec..], "{} {}", category, definition.name());
                seen.extend(record.items().map(|(item, _)| item.item));
            }
        }
        let is_seen = definition.items().iter().all(|item| seen.contains(item.item));
        assert!(
            is_seen || category == cat129::Record::CATEGORY,
            "{category} {}: {seen:?}",
            definition.name()
        );
    }
}

/// Checks properties that hold for any contents of a block.
fn check(definition: &'static Definition, octets: &[u8]) -> Result<Vec<usize>, Fault> {
    let block = Block { category: definition.category(), offset: 7, octets };
    let (mut next, mut lengths) = (7 + 3, Vec::new());
    for located in definition.records(block) {
        let located = match located {
            Ok(located) => located,
            Err(fault) => {
                assert_eq!(fault.category, Some(definition.category()));
                assert!((next..=7 + octets.len()).contains(&fault.offset), "{fault}");
                return Err(fault);
            }
        };
        assert_eq!(located.offset, next);
        next += located.length;
        let fspec = utm_asterix::Fspec::read(located.record.octets()).unwrap().length();
        let of_items: usize = located.record.items().map(|(_, octets)| octets.len()).sum();
        assert_eq!(fspec + of_items, located.length);
        let _ = (located.record.data_source(), located.record.time_of_day());
        lengths.push(located.length);
    }
    assert_eq!(next, 7 + octets.len());
    Ok(lengths)
}

/// Damaged records and random octets: a fault with its place, or contiguous records.
#[test]
fn no_octets_do_harm() {
    let mut random = Random(0x6861_726d_6c65_7373);
    let (mut read, mut refused) = (0, BTreeSet::new());
    for definition in definitions() {
        let sound = records(definition, 60);
        for index in 0..2_000 {
            let octets = if index % 4 == 0 {
                (0..random.below(60)).map(|_| random.octet()).collect()
            } else {
                let mut octets = [&sound[index % 60][..], &sound[random.below(60)]].concat();
                for _ in 0..=random.below(3) {
                    damage(&mut octets, &sound[random.below(60)], &mut random);
                }
                octets
            };
            match check(definition, &block(definition.category(), &octets)) {
                Ok(_) => read += 1,
                Err(fault) => drop(refused.insert(fault.kind.name())),
            }
        }
    }
    assert!(read > 20_000, "{read}");
    // Faults of blocks do not occur in records.
    let kinds = FaultKind::ALL.iter().map(|kind| kind.name()).filter(|name| !name.starts_with("block_"));
    assert_eq!(refused, kinds.collect::<BTreeSet<_>>());
}

/// Typed and untyped decoding find the same records, and the same fault at the end.
fn agrees_with<R: Record>(definition: &'static Definition, edition: R::Edition, random: &mut Random) {
    let sound = records(definition, 100);
    for index in 0..3_000 {
        let mut octets = sound[index % 100].clone();
        octets.extend(&sound[random.below(100)]);
        for _ in 0..random.below(4) {
            damage(&mut octets, &sound[random.below(100)], random);
        }
        let octets = block(definition.category(), &octets);
        let typed = Block { category: definition.category(), offset: 7, octets: &octets };
        let typed: Result<Vec<usize>, Fault> =
            typed.records_in::<R>(edition).map(|located| Ok(located?.length)).collect();
        let untyped = check(definition, &octets);
        // If an item has two faults, either may be reported.
        let place = |read: Result<Vec<usize>, Fault>| read.map_err(|fault| (fault.item, fault.offset));
        assert_eq!(place(untyped), place(typed), "{} {octets:02x?}", definition.name());
    }
}

#[test]
fn typed_records_are_the_same_records() {
    let mut random = Random(0x7361_6d65_7361_6d65);
    agrees_with::<cat015::Record>(newest(15), (), &mut random);
    agrees_with::<cat034::Record>(newest(34), (), &mut random);
    agrees_with::<cat048::Record>(newest(48), (), &mut random);
    agrees_with::<cat062::Record>(newest(62), (), &mut random);
    agrees_with::<cat063::Record>(newest(63), (), &mut random);
    agrees_with::<cat065::Record>(newest(65), (), &mut random);
    agrees_with::<cat129::Record>(newest(129), (), &mut random);
    for edition in Edition::ALL {
        let definition = category(21).unwrap().edition(edition.name()).unwrap();
        agrees_with::<cat021::Record>(definition, edition, &mut random);
    }
}

/// Numbers, order and lengths of the items are those of the typed records; names of fields may differ.
#[test]
fn typed_records_have_the_same_items() {
    for (number, uap) in
        [(15, cat015::UAP), (34, cat034::UAP), (48, cat048::UAP), (62, cat062::UAP), (63, cat063::UAP)]
    {
        let numbers =
            |uap: &[utm_asterix::UapItem]| uap.iter().map(|item| (item.frn, item.item)).collect::<Vec<_>>();
        assert_eq!(numbers(newest(number).items()), numbers(uap), "{number}");
    }
}

/// The value of a field in an item of the record with these octets.
fn value(definition: &'static Definition, record: &str, item: &str, key: &str) -> f64 {
    let octets = hex(record);
    let record = definition.record(&octets).unwrap();
    assert_eq!(record.octets(), octets);
    let (found, octets) = record.items().find(|(found, _)| found.item == item).unwrap();
    let Layout::Fields(fields) = found.layout else { panic!("{:?}", found.layout) };
    let mut at = 0;
    for field in fields {
        let field = match field.kind {
            Kind::Depends(dependence) => dependence.case(fields, octets, 0).unwrap_or(field),
            _ => field,
        };
        if field.key == key {
            let count = field.count(octets, at);
            return match field.kind {
                Kind::Quantity(quantity) => quantity.value(count, field.bits.into()),
                _ => count as f64,
            };
        }
        at += usize::from(field.bits);
    }
    panic!("{item} has no {key}: {fields:?}")
}

#[test]
fn values_by_hand() {
    // A plot and a track of CAT001: the items after 020 depend on its first bit.
    let cat001 = newest(1);
    assert_eq!(value(cat001, "f0 1907 20 0500 4000 0fff", "040", "rho_m"), 1280.0 * 1852.0 / 128.0);
    assert_eq!(value(cat001, "f0 1907 20 0500 4000 0fff", "070", "mode3a"), 0o7777 as f64);
    assert_eq!(value(cat001, "e8 1907 a0 0123 0040ffc0", "042", "x_m"), 1852.0);
    assert_eq!(value(cat001, "e8 1907 a0 0123 0040ffc0", "042", "y_m"), -1852.0);
    assert_eq!(value(newest(10), "c0 1907 01", "000", ""), 1.0);
    // The bit before the value distinguishes air speed and Mach number.
    let cat021 = category(21).unwrap().edition("0.26").unwrap();
    let air_speed = cat021.items().iter().find(|item| item.item == "150").unwrap().frn;
    let fspec = fspec_of(air_speed);
    assert_eq!(value(cat021, &format!("{fspec} 4000"), "150", "as_m_s"), 1852.0);
    assert_eq!(value(cat021, &format!("{fspec} 8320"), "150", "as_mach"), 0.8);
}

/// The shortest FSPEC of a record with one item.
fn fspec_of(frn: u8) -> String {
    let mut present = [false; 56];
    present[usize::from(frn) - 1] = true;
    let mut octets = Vec::new();
    utm_asterix::Fspec::of(present, 0).encode_into(&mut octets);
    octets.iter().map(|octet| format!("{octet:02x}")).collect()
}

#[test]
fn sensor_and_time_are_decoded() {
    let read = |number: u8, record: &str| {
        let octets = hex(record);
        let record = newest(number).record(&octets).unwrap();
        (record.data_source(), record.time_of_day().map(TimeOfDay::seconds))
    };
    let source = Some(DataSource { sac: 25, sic: 7 });
    assert_eq!(read(2, "d0 1907 01 5460 40"), (source, Some(43_200.5)));
    assert_eq!(read(18, "80 1907"), (source, None));
    assert_eq!(read(1, "c0 1907 20"), (source, None));
    // CAT150 numbers its centres differently.
    for category in categories().filter(|category| category.number() != 150) {
        let names: Vec<&str> = category.newest().items().iter().map(|item| item.name).collect();
        assert!(names.iter().any(|name| name.starts_with("Data Source")), "{names:?}");
    }
}

#[test]
fn record_without_profile_is_rejected() {
    let refused = |number: u8, record: &str| {
        let octets = hex(record);
        let fault = newest(number).record(&octets).unwrap_err();
        (fault.item, fault.offset, fault.kind)
    };
    assert_eq!(refused(1, "80 1907"), (None, 0, FaultKind::NoProfile));
    assert_eq!(refused(1, "c0 19"), (Some("010"), 1, FaultKind::ItemPastEnd));
    assert_eq!(refused(1, "c0 1907"), (Some("020"), 3, FaultKind::ItemPastEnd));
    assert_eq!(refused(1, "01"), (None, 0, FaultKind::FspecPastEnd));
    assert_eq!(refused(7, "a0 1907 09"), (Some("410"), 3, FaultKind::NoProfile));
    // Random field sequencing with two items, the second of which the category does not define.
    assert_eq!(refused(2, "8102 1907 02 02 01 0d"), (Some("RFS"), 4, FaultKind::ItemPastEnd));
    assert_eq!(refused(2, "8102 1907 02 02 01 0c 00"), (Some("RFS"), 4, FaultKind::ReservedFrn));
}
