//! Items as JSON: writes the values that a layout finds in octets.

use asterix::{Contents, Field, Form, Kind, Layout, Subfield, octets_of};

use super::characters;
use super::tree::Tree;

/// Writes the item with these octets, which its layout has measured.
pub fn write_item(out: &mut impl Tree, layout: &Layout, octets: &[u8]) {
    match *layout {
        Layout::Fields(fields) => write_fields(out, fields, octets),
        Layout::OneOrThree(fields) => {
            out.open_object();
            write_members(out, fields, octets, 0);
            if octets.len() > 1 {
                out.key("undescribed");
                out.hex(&octets[1..]);
            }
            out.close_object();
        }
        Layout::Extended(parts) => {
            out.open_object();
            for (index, (fields, _)) in parts.iter().zip(octets).enumerate() {
                write_members(out, fields, octets, index * 8);
            }
            if let Some(more) = octets.get(parts.len()..).filter(|more| !more.is_empty()) {
                out.key("more");
                out.hex(more);
            }
            out.close_object();
        }
        Layout::Parts(parts) => {
            out.open_object();
            let mut at = 0;
            for fields in parts {
                if at < octets.len() {
                    write_members(out, fields, octets, at * 8);
                }
                at += part_octets(fields);
            }
            out.close_object();
        }
        Layout::Chained(fields) => {
            write_array(out, octets.chunks(part_octets(fields)), |out, part| write_fields(out, fields, part));
        }
        Layout::Codes => {
            write_array(out, octets.iter(), |out, octet| out.integer(u64::from(octet >> 1)));
        }
        Layout::Repetitive(fields) => {
            write_array(out, octets[1..].chunks(octets_of(fields)), |out, part| {
                write_fields(out, fields, part);
            });
        }
        Layout::Sequence(items) => {
            out.open_array();
            let mut rest = &octets[1..];
            while let [frn, after @ ..] = rest {
                // The whole item has been measured.
                let Some(item) = items.iter().find(|item| item.frn == *frn) else { break };
                let Ok(length) = item.measure(after) else { break };
                out.element();
                out.open_object();
                out.joined(item.item, item.joined());
                write_item(out, &item.layout, &after[..length]);
                out.close_object();
                rest = &after[length..];
            }
            out.close_array();
        }
        Layout::Compound(subfields) => {
            let primary = octets.iter().position(|octet| octet & 1 == 0).map_or(0, |last| last + 1);
            let (primary, rest) = octets.split_at(primary);
            out.open_object();
            if is_padded(primary) {
                out.key(PRIMARY);
                out.hex(primary);
            }
            write_subfields(out, subfields, |index| announced(primary, 7, index), rest);
            out.close_object();
        }
        Layout::Explicit(contents) if is_known(contents, &octets[1..]) => {
            write_contents(out, contents, &octets[1..]);
        }
        Layout::Explicit(_) => out.hex(octets),
    }
}

/// Whether the primary subfield announces subfield `index`; each octet announces `each` of them.
pub fn announced(primary: &[u8], each: usize, index: usize) -> bool {
    primary.get(index / each).is_some_and(|octet| octet << (index % each) & 0x80 != 0)
}

/// Whether the contents after the length octet follow the layout.
pub fn is_known(contents: Contents, octets: &[u8]) -> bool {
    match contents {
        Contents::Opaque => false,
        Contents::Known(forms) => form_of(forms, octets).is_some(),
        Contents::Expansion(subfields) => octets
            .split_first()
            .is_some_and(|(_, rest)| measures(subfields, |index| announced(octets, 8, index), rest)),
    }
}

/// Form of the octets after the length octet, with its index.
pub fn form_of(forms: &[Form], octets: &[u8]) -> Option<(usize, Form)> {
    let has = |form: &Form| octets_of(form.fields) == octets.len() && constants_agree(form.fields, octets);
    forms.iter().copied().enumerate().find(|(_, form)| has(form))
}

/// Writes the contents after the length octet, which follow the layout.
fn write_contents(out: &mut impl Tree, contents: Contents, octets: &[u8]) {
    out.open_object();
    match contents {
        Contents::Opaque => {}
        Contents::Known(forms) => {
            if let Some((_, Form { key, fields })) = form_of(forms, octets) {
                out.key(key);
                write_fields(out, fields, octets);
            }
        }
        Contents::Expansion(subfields) => {
            let (primary, rest) = octets.split_at(1);
            write_subfields(out, subfields, |index| announced(primary, 8, index), rest);
        }
    }
    out.close_object();
}

/// Whether these subfields are defined and take exactly these octets.
fn measures(subfields: &[Subfield], announces: impl Fn(usize) -> bool, octets: &[u8]) -> bool {
    let mut offset = 0;
    for (_, subfield) in subfields.iter().enumerate().filter(|(index, _)| announces(*index)) {
        if subfield.key.is_empty() {
            return false;
        }
        let Ok(length) = subfield.measure(&octets[offset..]) else { return false };
        offset += length;
    }
    offset == octets.len()
}

/// Key of the primary subfield of a compound item, used if it is longer than necessary.
pub(super) const PRIMARY: &str = "primary";

/// Whether the last octet of a primary subfield or FSPEC announces nothing and is not the only one.
fn is_padded(primary: &[u8]) -> bool {
    matches!(primary, [.., _, 0])
}

/// Number of octets of fields whose last bit may be FX.
pub fn part_octets(fields: &[Field]) -> usize {
    fields.iter().map(|field| usize::from(field.bits)).sum::<usize>().div_ceil(8)
}

/// Adds these subfields to the members of an object.
fn write_subfields(
    out: &mut impl Tree,
    subfields: &[Subfield],
    announces: impl Fn(usize) -> bool,
    octets: &[u8],
) {
    let mut rest = octets;
    for (_, subfield) in subfields.iter().enumerate().filter(|(index, _)| announces(*index)) {
        // The whole item has been measured.
        let Ok(length) = subfield.measure(rest) else { break };
        out.joined(subfield.key, subfield.joined());
        write_item(out, &subfield.layout, &rest[..length]);
        rest = &rest[length..];
    }
}

/// Writes fields as an object, and the only field of an item as its value.
fn write_fields(out: &mut impl Tree, fields: &[Field], octets: &[u8]) {
    if let [field] = fields
        && field.key.is_empty()
    {
        return write_value(out, field, octets, 0);
    }
    out.open_object();
    write_members(out, fields, octets, 0);
    out.close_object();
}

/// Adds the fields from bit `at` on to the members of an object: spare bits if they are not zero, constants never.
fn write_members(out: &mut impl Tree, fields: &[Field], octets: &[u8], mut at: usize) {
    let first = at;
    for field in fields {
        let here = at;
        at += usize::from(field.bits);
        let field = meant(field, fields, octets, first);
        match field.kind {
            Kind::Spare if field.count(octets, here) == 0 => {}
            Kind::Constant(_) => {}
            _ => {
                out.joined(field.key, field.joined());
                write_value(out, field, octets, here);
            }
        }
    }
}

/// The field itself, or the meaning that another field selects. `fields` start at bit `first`.
pub fn meant<'a>(field: &'a Field, fields: &[Field], octets: &[u8], first: usize) -> &'a Field {
    match field.kind {
        Kind::Depends(dependence) => dependence.case(fields, octets, first).unwrap_or(field),
        _ => field,
    }
}

fn constants_agree(fields: &[Field], octets: &[u8]) -> bool {
    let mut at = 0;
    fields.iter().all(|field| {
        let here = at;
        at += usize::from(field.bits);
        !matches!(field.kind, Kind::Constant(value) if field.count(octets, here) != value)
    })
}

/// Writes the field at bit `at`.
pub fn write_value(out: &mut impl Tree, field: &Field, octets: &[u8], at: usize) {
    let width = usize::from(field.bits);
    match field.kind {
        Kind::Hex if width > 64 => out.hex(&octets[at / 8..(at + width) / 8]),
        Kind::Ascii => {
            let octets = &octets[at / 8..(at + width) / 8];
            let is_printable = octets.iter().all(|octet| matches!(octet, b' '..=b'~'));
            write_text(out, Some(octets).filter(|_| is_printable), octets);
        }
        Kind::Icao => {
            let octets = &octets[at / 8..(at + width) / 8];
            write_text(out, characters::decode(octets).as_deref(), octets);
        }
        kind => write_number(out, kind, field.count(octets, at), width),
    }
}

fn write_number(out: &mut impl Tree, kind: Kind, count: u64, width: usize) {
    match kind {
        Kind::CountOr(unknown) if count == unknown => out.null(),
        Kind::Quantity(quantity) if quantity.unknown == Some(count) => out.null(),
        Kind::Quantity(quantity) => out.decimal(quantity.value(count, width), quantity.decimals),
        Kind::CountFrom(first) => out.integer(count + first),
        Kind::Octal => write_digits(out, count, width, 3, b"01234567"),
        Kind::Hex => write_digits(out, count, width, 4, b"0123456789abcdef"),
        Kind::Address => write_digits(out, count, width, 4, b"0123456789ABCDEF"),
        _ => out.integer(count),
    }
}

/// Writes `width` bits, at most 64, as digits of `bits` bits each.
fn write_digits(out: &mut impl Tree, count: u64, width: usize, bits: usize, digits: &[u8]) {
    let mut text = [b'0'; 22];
    let text = &mut text[..width / bits];
    for (octet, place) in text.iter_mut().zip((0..width / bits).rev()) {
        *octet = digits[(count >> (place * bits)) as usize & ((1 << bits) - 1)];
    }
    write_text(out, Some(text), &[]);
}

/// Writes an ASCII text, or the octets in its place.
fn write_text(out: &mut impl Tree, text: Option<&[u8]>, octets: &[u8]) {
    match text.and_then(|text| str::from_utf8(text).ok()) {
        Some(text) => out.text(text),
        None => {
            out.open_object();
            out.key("hex");
            out.hex(octets);
            out.close_object();
        }
    }
}

fn write_array<O: Tree, T>(out: &mut O, parts: impl Iterator<Item = T>, write: impl Fn(&mut O, T)) {
    out.open_array();
    for part in parts {
        out.element();
        write(out, part);
    }
    out.close_array();
}
