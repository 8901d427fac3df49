//! Properties of every layout of every profile.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

use std::collections::BTreeSet;

use proptest::prelude::*;
use utm_asterix::cat021::Edition;
use utm_asterix::{Contents, Field, Kind, Layout, Quantity, Subfield, octets_of, profile};

/// A list of fields with its place.
struct Together {
    place: String,
    fields: &'static [Field],
    /// Unit of which their total number of bits must be a multiple.
    unit: usize,
}

/// In place of a unit: the fields and FX together fill whole octets.
const FX: usize = 1;

/// Every list of fields in a layout, and every list of subfields.
fn walk(
    place: &str,
    layout: Layout,
    lists: &mut Vec<Together>,
    subfield_lists: &mut Vec<(String, &'static [Subfield])>,
) {
    let mut add = |place: &str, fields, unit| lists.push(Together { place: place.to_owned(), fields, unit });
    match layout {
        Layout::Fields(fields) | Layout::Repetitive(fields) | Layout::OneOrThree(fields) => {
            add(place, fields, 8);
        }
        Layout::Explicit(Contents::Known(forms)) => {
            // Forms with the same name are alternatives, each with its own fields.
            for (index, form) in forms.iter().enumerate() {
                add(&format!("{place}/{} form {index}", form.key), form.fields, 8);
            }
        }
        Layout::Extended(octets) => {
            for (index, &fields) in octets.iter().enumerate() {
                add(&format!("{place}[{index}]"), fields, 7);
            }
        }
        Layout::Parts(parts) => {
            for (index, &fields) in parts.iter().enumerate() {
                let extends = fields.iter().map(|field| field.bits).sum::<u16>() % 8 == 7;
                add(&format!("{place}[{index}]"), fields, if extends { FX } else { 8 });
            }
        }
        Layout::Chained(fields) => add(place, fields, FX),
        Layout::Compound(subfields) | Layout::Explicit(Contents::Expansion(subfields)) => {
            subfield_lists.push((place.to_owned(), subfields));
            for subfield in subfields.iter().filter(|subfield| !subfield.key.is_empty()) {
                walk(&format!("{place}/{}", subfield.key), subfield.layout, lists, subfield_lists);
            }
        }
        // No typed record has a sequence of items.
        Layout::Codes | Layout::Explicit(Contents::Opaque) | Layout::Sequence(_) => {}
    }
}

fn everything() -> (Vec<Together>, Vec<(String, &'static [Subfield])>) {
    let (mut lists, mut subfields) = (Vec::new(), Vec::new());
    for category in [15, 21, 34, 48, 62, 63, 65, 129] {
        for item in profile(category).unwrap() {
            walk(&format!("{category:03}/{}", item.item), item.layout, &mut lists, &mut subfields);
        }
    }
    for item in Edition::V2_1.profile().iter().filter(|item| item.item == "271") {
        walk("021 2.1/271", item.layout, &mut lists, &mut subfields);
    }
    (lists, subfields)
}

/// Every field with its place and the index of its first bit.
fn fields() -> Vec<(String, usize, Field)> {
    let mut all = Vec::new();
    for Together { place, fields, .. } in everything().0 {
        let mut at = 0;
        for &field in fields {
            all.push((format!("{place} {:?}", field.key), at, field));
            at += usize::from(field.bits);
        }
    }
    all
}

fn quantities() -> impl Iterator<Item = (String, usize, Quantity)> {
    fields().into_iter().filter_map(|(place, _, field)| match field.kind {
        Kind::Quantity(quantity) => Some((place, usize::from(field.bits), quantity)),
        _ => None,
    })
}

#[test]
fn the_walk_reaches_every_depth() {
    let places: BTreeSet<String> = everything().0.into_iter().map(|list| list.place).collect();
    for place in [
        "021/271[1]",
        "021 2.1/271[1]",
        "021/RE/sgv[0]",
        "062/380/met",
        "062/510",
        "062/RE/v3/cass",
        "034/050/mds",
        "048/020[5]",
        "048/120/rds",
        "048/250",
        "048/RE/m4e[0]",
        "048/RE/rtc/asi",
        "065/040",
        "129/120",
        "129/SP/uf form 0",
    ] {
        assert!(places.contains(place), "{place}");
    }
}

#[test]
fn fields_are_whole_octets() {
    for Together { place, fields, unit } in everything().0 {
        let bits: usize = fields.iter().map(|field| usize::from(field.bits)).sum();
        assert!(bits > 0 && bits % unit == 0, "{place}: {bits} bits");
        // Seven of eight bits: the eighth is FX.
        assert!(unit != 7 || bits == 7, "{place}: {bits} bits");
        assert!(unit != FX || bits % 8 == 7, "{place}: {bits} bits");
        if unit == 8 {
            assert_eq!(octets_of(fields) * 8, bits, "{place}");
        }
    }
}

fn is_key(key: &str) -> bool {
    key.bytes().all(|letter| matches!(letter, b'a'..=b'z' | b'0'..=b'9' | b'_'))
}

#[test]
fn keys_are_in_lower_case_and_unique() {
    let (lists, subfields) = everything();
    let mut seen = BTreeSet::new();
    for Together { place, fields, .. } in lists {
        // All octets of an extended item share one set of keys.
        let item = place.split('[').next().unwrap().to_owned();
        for field in fields {
            assert!(is_key(field.key), "{place}: {:?}", field.key);
            assert!(seen.insert((item.clone(), field.key)), "{place}: {:?} twice", field.key);
            assert!(!field.key.is_empty() || fields.len() == 1, "{place}: no key, but not alone");
            assert_eq!(field.kind == Kind::Spare, field.key.starts_with("spare"), "{place}: {:?}", field.key);
        }
    }
    for (place, subfields) in subfields {
        let mut seen = BTreeSet::new();
        for subfield in subfields {
            assert!(is_key(subfield.key), "{place}: {:?}", subfield.key);
            assert!(
                subfield.key.is_empty() || seen.insert(subfield.key),
                "{place}: {:?} twice",
                subfield.key
            );
            assert!(!subfield.key.is_empty() || subfield.layout == Layout::Fields(&[]), "{place}");
        }
    }
}

#[test]
fn kinds_fit_their_widths() {
    for (place, _, field) in fields() {
        let fits = |count: u64| field.bits >= 64 || count >> field.bits == 0;
        let good = match field.kind {
            Kind::Octal => field.bits % 3 == 0 && field.bits <= 12,
            Kind::Hex => field.bits % 4 == 0 && field.bits <= 64,
            Kind::Address => field.bits == 24,
            Kind::Ascii => field.bits % 8 == 0,
            Kind::Icao => field.bits % 6 == 0 && field.bits <= 64,
            Kind::Constant(count) | Kind::CountOr(count) => field.bits <= 64 && fits(count),
            Kind::Quantity(quantity) => field.bits <= 32 && quantity.unknown.is_none_or(fits),
            Kind::Spare | Kind::Count | Kind::CountFrom(_) => (1..=64).contains(&field.bits),
            _ => false,
        };
        assert!(good, "{place}: {field:?}");
    }
}

/// Counts of this width: all of them up to 16 bits, otherwise the limits and some between.
fn counts(width: usize) -> Vec<u64> {
    let end = 1_u64 << width;
    if width <= 16 {
        return (0..end).collect();
    }
    let ends = (0..5000).flat_map(|near| [near, end / 2 - 1 - near, end / 2 + near, end - 1 - near]);
    ends.chain((0..end).step_by(end as usize / 9973)).collect()
}

#[test]
fn printed_values_round_back_to_their_counts() {
    for (place, width, quantity) in quantities() {
        let decimals = usize::from(quantity.decimals);
        assert!(0.1_f64.powi(decimals as i32) <= quantity.lsb * (1.0 + 1e-12), "{place}: {quantity:?}");
        for count in counts(width) {
            let value = quantity.value(count, width);
            assert_eq!(quantity.count(value, width), Some(count), "{place}: {value}");
            let printed: f64 = format!("{value:.decimals$}").parse().unwrap();
            assert_eq!(quantity.count(printed, width), Some(count), "{place}: {printed} for {value}");
        }
    }
}

#[test]
fn values_out_of_range_have_no_count() {
    for (place, width, quantity) in quantities() {
        let counts = (1_u64 << width) as f64;
        let (low, high) =
            if quantity.signed { (-counts / 2.0, counts / 2.0 - 1.0) } else { (0.0, counts - 1.0) };
        for beyond in [low - 0.6, high + 0.6, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            assert_eq!(quantity.count(beyond * quantity.lsb, width), None, "{place}: {beyond}");
        }
        for within in [low - 0.4, high + 0.4] {
            assert!(quantity.count(within * quantity.lsb, width).is_some(), "{place}: {within}");
        }
    }
}

proptest! {
    #[test]
    fn written_item_is_read_back_and_others_are_unchanged(octets in any::<[u8; 32]>(), count in any::<u64>()) {
        for Together { place, fields, .. } in everything().0 {
            let starts = fields.iter().scan(0, |at, field| {
                let start = *at;
                *at += usize::from(field.bits);
                Some((start, field))
            });
            let starts: Vec<_> = starts.filter(|(_, field)| field.bits <= 64).collect();
            for &(at, field) in &starts {
                let mut changed = octets;
                field.set_count(&mut changed, at, count);
                let wanted = if field.bits == 64 { count } else { count & ((1 << field.bits) - 1) };
                prop_assert_eq!(field.count(&changed, at), wanted, "{} {}", &place, field.key);
                for &(other_at, other) in starts.iter().filter(|&&(other_at, _)| other_at != at) {
                    prop_assert_eq!(other.count(&changed, other_at), other.count(&octets, other_at));
                }
                field.set_count(&mut changed, at, field.count(&octets, at));
                prop_assert_eq!(changed, octets);
            }
        }
    }
}
