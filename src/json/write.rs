//! Items as JSON: the walk over a layout that prints what the bits say.

use asterix::{Contents, Field, Kind, Layout, Subfield, octets_of};

use super::characters;
use super::values::{write_decimal, write_hex, write_integer};

/// Prints the item with these octets, which are those that its layout measures.
pub(super) fn write_item(out: &mut Vec<u8>, layout: &Layout, octets: &[u8]) {
    match *layout {
        Layout::Fields(fields) => write_fields(out, fields, octets),
        Layout::OneOrThree(fields) => {
            let mut object = Object::open(out);
            object.fields(fields, octets, 0);
            if octets.len() > 1 {
                object.key("undescribed");
                write_hex(object.out, &octets[1..]);
            }
            object.close();
        }
        Layout::Extended(parts) => {
            let mut object = Object::open(out);
            for (index, (fields, _)) in parts.iter().zip(octets).enumerate() {
                object.fields(fields, octets, index * 8);
            }
            if let Some(more) = octets.get(parts.len()..).filter(|more| !more.is_empty()) {
                object.key("more");
                write_hex(object.out, more);
            }
            object.close();
        }
        Layout::Parts(parts) => {
            let mut object = Object::open(out);
            let mut at = 0;
            for fields in parts {
                if at < octets.len() {
                    object.fields(fields, octets, at * 8);
                }
                at += part_octets(fields);
            }
            object.close();
        }
        Layout::Chained(fields) => {
            write_array(out, octets.chunks(part_octets(fields)), |out, part| write_fields(out, fields, part));
        }
        Layout::Codes => {
            write_array(out, octets.iter(), |out, octet| write_integer(out, u64::from(octet >> 1)));
        }
        Layout::Repetitive(fields) => {
            write_array(out, octets[1..].chunks(octets_of(fields)), |out, part| {
                write_fields(out, fields, part);
            });
        }
        Layout::Sequence(items) => {
            out.push(b'[');
            let mut rest = &octets[1..];
            while let [frn, after @ ..] = rest {
                // The whole item has been measured.
                let Some(item) = items.iter().find(|item| item.frn == *frn) else { break };
                let Ok(length) = item.layout.measure(after) else { break };
                if rest.len() < octets.len() - 1 {
                    out.push(b',');
                }
                let mut object = Object::open(out);
                object.key(item.item);
                write_item(object.out, &item.layout, &after[..length]);
                object.close();
                rest = &after[length..];
            }
            out.push(b']');
        }
        Layout::Compound(subfields) => {
            let primary = octets.iter().position(|octet| octet & 1 == 0).map_or(0, |last| last + 1);
            let (primary, rest) = octets.split_at(primary);
            let mut object = Object::open(out);
            if is_padded(primary) {
                object.key(PRIMARY);
                write_hex(object.out, primary);
            }
            write_subfields(&mut object, subfields, |index| announced(primary, 7, index), rest);
            object.close();
        }
        Layout::Explicit(contents) => {
            let start = out.len();
            if !write_contents(out, contents, &octets[1..]) {
                out.truncate(start);
                write_hex(out, octets);
            }
        }
    }
}

/// The item with these octets as JSON.
pub(crate) fn item_json(layout: &Layout, octets: &[u8]) -> String {
    printed(|out| write_item(out, layout, octets))
}

/// The field that begins at this bit as JSON.
pub(crate) fn scalar_json(field: &Field, octets: &[u8], at: usize) -> String {
    printed(|out| write_value(out, field, octets, at))
}

fn printed(write: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut out = Vec::new();
    write(&mut out);
    String::from_utf8(out).expect("what is printed is ASCII")
}

/// Whether the primary subfield announces this subfield, of which each octet says `each`.
pub(crate) fn announced(primary: &[u8], each: usize, index: usize) -> bool {
    primary.get(index / each).is_some_and(|octet| octet << (index % each) & 0x80 != 0)
}

/// Whether what stands behind the length octet is what the layout knows.
pub(crate) fn is_known(contents: Contents, octets: &[u8]) -> bool {
    match contents {
        Contents::Opaque => false,
        Contents::Known(_, fields) => octets_of(fields) == octets.len() && constants_agree(fields, octets),
        Contents::Expansion(subfields) => octets
            .split_first()
            .is_some_and(|(_, rest)| measures(subfields, |index| announced(octets, 8, index), rest)),
    }
}

/// Prints what stands behind the length octet, if it is what the layout knows; the octets are then all told.
fn write_contents(out: &mut Vec<u8>, contents: Contents, octets: &[u8]) -> bool {
    if !is_known(contents, octets) {
        return false;
    }
    match contents {
        Contents::Opaque => return false,
        Contents::Known(key, fields) => {
            let mut object = Object::open(out);
            object.key(key);
            write_fields(object.out, fields, octets);
            object.close();
        }
        Contents::Expansion(subfields) => {
            let (primary, rest) = octets.split_at(1);
            let mut object = Object::open(out);
            write_subfields(&mut object, subfields, |index| announced(primary, 8, index), rest);
            object.close();
        }
    }
    true
}

/// Whether these subfields are defined and take exactly these octets.
fn measures(subfields: &[Subfield], announces: impl Fn(usize) -> bool, octets: &[u8]) -> bool {
    let mut offset = 0;
    for (_, subfield) in subfields.iter().enumerate().filter(|(index, _)| announces(*index)) {
        if subfield.key.is_empty() {
            return false;
        }
        let Ok(length) = subfield.layout.measure(&octets[offset..]) else { return false };
        offset += length;
    }
    offset == octets.len()
}

/// The primary subfield of a compound item, where it is longer than it need be.
pub(super) const PRIMARY: &str = "primary";

/// Whether the last octet of a primary subfield or FSPEC announces nothing, though there is one before it.
fn is_padded(primary: &[u8]) -> bool {
    matches!(primary, [.., _, 0])
}

/// Octets of fields that may leave the last bit to FX.
pub(crate) fn part_octets(fields: &[Field]) -> usize {
    fields.iter().map(|field| usize::from(field.bits)).sum::<usize>().div_ceil(8)
}

/// Adds these subfields to the members of an object.
fn write_subfields(
    object: &mut Object<'_>,
    subfields: &[Subfield],
    announces: impl Fn(usize) -> bool,
    octets: &[u8],
) {
    let mut rest = octets;
    for (_, subfield) in subfields.iter().enumerate().filter(|(index, _)| announces(*index)) {
        // The whole item has been measured.
        let Ok(length) = subfield.layout.measure(rest) else { break };
        object.key(subfield.key);
        write_item(object.out, &subfield.layout, &rest[..length]);
        rest = &rest[length..];
    }
}

/// Prints fields as an object; the only field of an item as its value.
fn write_fields(out: &mut Vec<u8>, fields: &[Field], octets: &[u8]) {
    if let [field] = fields
        && field.key.is_empty()
    {
        return write_value(out, field, octets, 0);
    }
    let mut object = Object::open(out);
    object.fields(fields, octets, 0);
    object.close();
}

/// The field itself, or what it is as another says, of `fields` that begin at bit `first`.
pub(crate) fn meant<'a>(field: &'a Field, fields: &[Field], octets: &[u8], first: usize) -> &'a Field {
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

/// Prints the field that begins at this bit.
fn write_value(out: &mut Vec<u8>, field: &Field, octets: &[u8], at: usize) {
    let width = usize::from(field.bits);
    match field.kind {
        Kind::Hex if width > 64 => write_hex(out, &octets[at / 8..(at + width) / 8]),
        Kind::Ascii => {
            let text = &octets[at / 8..(at + width) / 8];
            if text.iter().all(|octet| matches!(octet, b' '..=b'~')) {
                write_text(out, text);
            } else {
                write_octets(out, text);
            }
        }
        Kind::Icao => {
            let octets = &octets[at / 8..(at + width) / 8];
            match characters::decode(octets) {
                Some(text) => write_text(out, &text),
                None => write_octets(out, octets),
            }
        }
        kind => write_number(out, kind, field.count(octets, at), width),
    }
}

fn write_number(out: &mut Vec<u8>, kind: Kind, count: u64, width: usize) {
    match kind {
        Kind::CountOr(unknown) if count == unknown => out.extend_from_slice(b"null"),
        Kind::Quantity(quantity) if quantity.unknown == Some(count) => out.extend_from_slice(b"null"),
        Kind::Quantity(quantity) => write_decimal(out, quantity.value(count, width), quantity.decimals),
        Kind::CountFrom(first) => write_integer(out, count + first),
        Kind::Octal => write_digits(out, count, width, 3, b"01234567"),
        Kind::Hex => write_digits(out, count, width, 4, b"0123456789abcdef"),
        Kind::Address => write_digits(out, count, width, 4, b"0123456789ABCDEF"),
        _ => write_integer(out, count),
    }
}

/// `width` bits as digits of so many bits each.
fn write_digits(out: &mut Vec<u8>, count: u64, width: usize, bits: usize, digits: &[u8]) {
    out.push(b'"');
    for place in (0..width / bits).rev() {
        out.push(digits[(count >> (place * bits)) as usize & ((1 << bits) - 1)]);
    }
    out.push(b'"');
}

/// A text of printable ASCII characters.
fn write_text(out: &mut Vec<u8>, text: &[u8]) {
    out.push(b'"');
    for &octet in text {
        if matches!(octet, b'"' | b'\\') {
            out.push(b'\\');
        }
        out.push(octet);
    }
    out.push(b'"');
}

/// Octets where a text should be.
fn write_octets(out: &mut Vec<u8>, octets: &[u8]) {
    out.extend_from_slice(b"{\"hex\":");
    write_hex(out, octets);
    out.push(b'}');
}

fn write_array<T>(out: &mut Vec<u8>, parts: impl Iterator<Item = T>, write: impl Fn(&mut Vec<u8>, T)) {
    out.push(b'[');
    for (index, part) in parts.enumerate() {
        if index > 0 {
            out.push(b',');
        }
        write(out, part);
    }
    out.push(b']');
}

/// An object that is being printed.
pub(super) struct Object<'a> {
    pub out: &'a mut Vec<u8>,
    empty: bool,
}

impl<'a> Object<'a> {
    pub fn open(out: &'a mut Vec<u8>) -> Self {
        out.push(b'{');
        Self { out, empty: true }
    }

    /// Begins a member; its value is printed next. Keys need no escapes: they are ours.
    pub fn key(&mut self, key: &str) {
        self.out.extend_from_slice(if self.empty { b"\"" } else { b",\"" });
        self.empty = false;
        self.out.extend_from_slice(key.as_bytes());
        self.out.extend_from_slice(b"\":");
    }

    /// The fields that begin at this bit: spare bits where they are not zero, constants never.
    fn fields(&mut self, fields: &[Field], octets: &[u8], mut at: usize) {
        let first = at;
        for field in fields {
            let here = at;
            at += usize::from(field.bits);
            let field = meant(field, fields, octets, first);
            match field.kind {
                Kind::Spare if field.count(octets, here) == 0 => {}
                Kind::Constant(_) => {}
                _ => {
                    self.key(field.key);
                    write_value(self.out, field, octets, here);
                }
            }
        }
    }

    pub fn close(self) -> &'a mut Vec<u8> {
        self.out.push(b'}');
        self.out
    }
}
