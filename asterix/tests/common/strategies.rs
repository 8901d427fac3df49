//! Strategies for octets of items and records, random within their layout.

use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;
use utm_asterix::{Chain, Contents, Field, Fspec, Kind, Layout, Subfield, UapItem, octets_of};

/// Octets of these fields; only constants are fixed.
fn field_octets(fields: &'static [Field]) -> impl Strategy<Value = Vec<u8>> {
    vec(any::<u8>(), octets_of(fields)).prop_map(move |mut octets| {
        let mut at = 0;
        for field in fields {
            if let Kind::Constant(count) = field.kind {
                field.set_count(&mut octets, at, count);
            }
            at += usize::from(field.bits);
        }
        octets
    })
}

/// The length octet and these contents.
fn explicit(contents: &[u8]) -> Vec<u8> {
    [&[contents.len() as u8 + 1], contents].concat()
}

/// Octets of these parts, as many as FX states: see [`Layout::Parts`].
fn part_octets(parts: &'static [&'static [Field]]) -> impl Strategy<Value = Vec<u8>> {
    let octets = |part: &[Field]| part.iter().map(|field| usize::from(field.bits)).sum::<usize>().div_ceil(8);
    let lengths: Vec<usize> = parts.iter().map(|part| octets(part)).collect();
    let extends = |part: &[Field]| part.iter().map(|field| field.bits).sum::<u16>() % 8 == 7;
    let extending: Vec<bool> = parts.iter().map(|part| extends(part)).collect();
    (vec(any::<u8>(), lengths.iter().sum::<usize>()), 0..parts.len()).prop_map(move |(mut octets, last)| {
        let mut end = 0;
        for (index, length) in lengths[..=last].iter().enumerate() {
            end += length;
            if extending[index] {
                octets[end - 1] = octets[end - 1] & !1 | u8::from(index < last);
            }
        }
        octets.truncate(end);
        octets
    })
}

/// Superfluous octets of a primary subfield.
fn padded(octets: impl Strategy<Value = Vec<u8>>, most: usize) -> impl Strategy<Value = Vec<u8>> {
    (octets, 0..most).prop_map(move |(mut octets, padding)| {
        let last = octets.iter().position(|octet| octet & 1 == 0).expect("a primary subfield ends");
        for end in last + 1..(last + 1 + padding).min(most) {
            octets[end - 1] |= 1;
            octets.insert(end, 0);
        }
        octets
    })
}

/// A primary subfield with `per_octet` bits per octet, and the subfields it announces, without undefined ones.
fn subfield_octets(subfields: &'static [Subfield], per_octet: usize) -> impl Strategy<Value = Vec<u8>> {
    let defined: Vec<(usize, _)> = (subfields.iter().enumerate())
        .filter(|(_, subfield)| !subfield.key.is_empty())
        .map(|(index, subfield)| (index, of(item_octets(subfield.layout))))
        .collect();
    let (indices, strategies): (Vec<usize>, Vec<_>) = defined.into_iter().unzip();
    strategies.prop_map(move |parts| {
        let mut primary = vec![0_u8];
        for (&index, part) in indices.iter().zip(&parts) {
            if part.is_some() {
                while primary.len() <= index / per_octet {
                    *primary.last_mut().expect("one octet at least") |= 1;
                    primary.push(0);
                }
                primary[index / per_octet] |= 0x80 >> (index % per_octet);
            }
        }
        primary.extend(parts.into_iter().flatten().flatten());
        primary
    })
}

/// One to `most` octets of seven bits and FX.
fn extended_octets(most: usize) -> impl Strategy<Value = Vec<u8>> {
    vec(any::<u8>(), 1..=most).prop_map(|mut octets| {
        octets.iter_mut().for_each(|octet| *octet |= 1);
        *octets.last_mut().expect("one octet at least") &= !1;
        octets
    })
}

/// Octets of an item with this layout.
pub fn item_octets(layout: Layout) -> BoxedStrategy<Vec<u8>> {
    let anything = vec(any::<u8>(), 0..60).prop_map(|contents| explicit(&contents));
    match layout {
        Layout::Fields(fields) => field_octets(fields).boxed(),
        Layout::OneOrThree(_) => prop_oneof![vec(any::<u8>(), 1), vec(any::<u8>(), 3)].boxed(),
        Layout::Extended(_) => extended_octets(Chain::MAX_OCTETS).boxed(),
        Layout::Codes => extended_octets(3 * Chain::MAX_OCTETS).boxed(),
        Layout::Repetitive(fields) => vec(field_octets(fields), 0..8)
            .prop_map(|parts| [&[parts.len() as u8], parts.concat().as_slice()].concat())
            .boxed(),
        Layout::Parts(parts) => part_octets(parts).boxed(),
        Layout::Chained(fields) => {
            let octets = fields.iter().map(|field| usize::from(field.bits)).sum::<usize>().div_ceil(8);
            vec(vec(any::<u8>(), octets), 1..=3 * Chain::MAX_OCTETS)
                .prop_map(|mut parts| {
                    let last = parts.len() - 1;
                    for (index, part) in parts.iter_mut().enumerate() {
                        let end = part.last_mut().expect("a part has octets");
                        *end = *end & !1 | u8::from(index < last);
                    }
                    parts.concat()
                })
                .boxed()
        }
        Layout::Compound(subfields) => subfield_octets(subfields, 7).boxed(),
        Layout::Sequence(items) => {
            let item = prop::sample::select(items).prop_flat_map(|item| {
                item_octets(item.layout).prop_map(move |octets| [&[item.frn], octets.as_slice()].concat())
            });
            vec(item, 0..4)
                .prop_map(|items| [&[items.len() as u8], items.concat().as_slice()].concat())
                .boxed()
        }
        Layout::Explicit(Contents::Opaque) => anything.boxed(),
        Layout::Explicit(Contents::Known(forms)) => {
            let form = prop::sample::select(forms).prop_flat_map(|form| field_octets(form.fields));
            prop_oneof![anything, form.prop_map(|contents| explicit(&contents))].boxed()
        }
        Layout::Explicit(Contents::Expansion(subfields)) => {
            prop_oneof![anything, expansion_octets(subfields)].boxed()
        }
    }
}

/// Octets of a reserved expansion field with these subfields.
pub fn expansion_octets(subfields: &'static [Subfield]) -> impl Strategy<Value = Vec<u8>> {
    subfield_octets(subfields, 8)
        .prop_filter("it has at most 254 octets", |contents| contents.len() <= 254)
        .prop_map(|contents| explicit(&contents))
}

/// Octets of a complete record with random items of this profile.
pub fn record_octets(uap: &'static [UapItem]) -> impl Strategy<Value = Vec<u8>> {
    let octets = |item: &UapItem| match item.layout {
        Layout::Compound(subfields) => {
            padded(subfield_octets(subfields, 7), subfields.len().div_ceil(7)).boxed()
        }
        layout => item_octets(layout),
    };
    let items: Vec<_> = uap.iter().map(|item| of(octets(item))).collect();
    (items, 0..4_u8).prop_map(|(items, padding)| {
        let mut present = [false; 7 * Fspec::MAX_OCTETS];
        for (item, octets) in uap.iter().zip(&items) {
            present[usize::from(item.frn) - 1] = octets.is_some();
        }
        let mut octets = Vec::new();
        Fspec::of(present, padding).encode_into(&mut octets);
        octets.extend(items.into_iter().flatten().flatten());
        octets
    })
}
