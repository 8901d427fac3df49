//! Items from JSON, the inverse of `write`.

use asterix::{Chain, Contents, Field, Form, Fspec, Kind, Layout, Quantity, Subfield, UapItem, octets_of};

use super::characters;
use super::parsed::{Object, Value};
use super::write::{PRIMARY, meant, part_octets};

/// Maximum length of a primary subfield, in octets: that of an FSPEC.
const PRIMARY_OCTETS: usize = Fspec::MAX_OCTETS;

/// Problem of an item's value, in words that start with the end of a path to it: `rho_m: …`.
pub(super) type Trouble = String;

/// Appends the item that `value` describes.
pub(super) fn read_item(out: &mut Vec<u8>, layout: &Layout, value: Value<'_>) -> Result<(), Trouble> {
    match *layout {
        Layout::Fields(fields) => read_fields(out, fields, value),
        Layout::OneOrThree(fields) => {
            let mut object = Members::of(value)?;
            object.fields(out, fields)?;
            let undescribed = object.take("undescribed").map(octets).transpose()?;
            object.end(keys(fields))?;
            match undescribed {
                Some(octets) if octets.len() != 2 => Err("undescribed: must be two octets".to_owned()),
                Some(octets) => {
                    out.extend(octets);
                    Ok(())
                }
                None => Ok(()),
            }
        }
        Layout::Extended(parts) => read_extended(out, parts, value),
        Layout::Parts(parts) => read_parts(out, parts, value),
        Layout::Chained(fields) => {
            let parts = value.as_array().filter(|(count, _)| *count > 0);
            let (count, parts) = parts.ok_or("must be an array of one part or more")?;
            for (index, part) in parts.enumerate() {
                let at = out.len();
                out.resize(at + part_octets(fields), 0);
                let mut object = Members::of(part)?;
                object.put(&mut out[at..], fields).map_err(|trouble| format!("[{index}] {trouble}"))?;
                object.end(keys(fields))?;
                *out.last_mut().expect("a part has octets") |= u8::from(index + 1 < count);
            }
            Ok(())
        }
        Layout::Codes => {
            let codes = value.as_array().filter(|(count, _)| *count > 0);
            let (count, codes) = codes.ok_or("must be an array of one code or more")?;
            for (index, code) in codes.enumerate() {
                let code = code.as_u64().filter(|code| *code < 128).ok_or("a code must be 0 to 127")?;
                let extended = index + 1 < count;
                out.push((code as u8) << 1 | u8::from(extended));
            }
            Ok(())
        }
        Layout::Repetitive(fields) => {
            let (count, parts) = value.as_array().ok_or("must be an array")?;
            out.push(u8::try_from(count).map_err(|_| "has more than 255 parts")?);
            for (index, part) in parts.enumerate() {
                read_fields(out, fields, part).map_err(|trouble| format!("[{index}] {trouble}"))?;
            }
            Ok(())
        }
        Layout::Sequence(items) => {
            let (count, parts) = value.as_array().ok_or("must be an array of items")?;
            out.push(u8::try_from(count).map_err(|_| "has more than 255 items")?);
            for (index, part) in parts.enumerate() {
                read_listed(out, items, part).map_err(|trouble| format!("[{index}] {trouble}"))?;
            }
            Ok(())
        }
        Layout::Compound(subfields) => {
            let mut object = Members::of(value)?;
            // The length of the primary subfield is known only after it.
            let at = out.len();
            let announced = read_subfields(out, subfields, &mut object)?;
            let given = object.take(PRIMARY).map(octets).transpose()?;
            object.end(subfields.iter().map(|subfield| subfield.key))?;
            let (mut primary, mut length) = ([0_u8; PRIMARY_OCTETS], 1);
            for index in (0..subfields.len()).filter(|index| announced >> index & 1 == 1) {
                primary[index / 7] |= 0x80 >> (index % 7);
                length = index / 7 + 1;
            }
            primary[..length - 1].iter_mut().for_each(|octet| *octet |= 1);
            let shortest = &primary[..length];
            match given {
                Some(given) => {
                    let given = padded(shortest, given, subfields.len().div_ceil(7))?;
                    out.splice(at..at, given);
                }
                None => {
                    out.splice(at..at, shortest.iter().copied());
                }
            }
            Ok(())
        }
        Layout::Explicit(contents) => read_explicit(out, contents, value),
    }
}

/// One of these items, preceded by its field reference number: an object with one member.
fn read_listed(out: &mut Vec<u8>, items: &[UapItem], value: Value<'_>) -> Result<(), Trouble> {
    let object = value.as_object().filter(|object| object.len() == 1);
    for (number, value) in object.ok_or("must be an object of one item")?.iter() {
        let item = items.iter().find(|item| item.item == number);
        let item = item.ok_or_else(|| format!("item {number} is none of this category"))?;
        out.push(item.frn);
        read_item(out, &item.layout, value).map_err(|trouble| format!("{number}: {trouble}"))?;
    }
    Ok(())
}

/// Keys of fields, including all meanings of a field.
fn keys(fields: &[Field]) -> impl Iterator<Item = &str> {
    fields.iter().flat_map(|field| {
        let cases = match field.kind {
            Kind::Depends(dependence) => dependence.cases,
            _ => &[],
        };
        cases.iter().map(|(_, case)| case.key).chain(cases.is_empty().then_some(field.key))
    })
}

/// The given primary subfield, if it announces the same subfields as the shortest one and has at most `most` octets.
fn padded(shortest: &[u8], given: Vec<u8>, most: usize) -> Result<Vec<u8>, Trouble> {
    let announces = |primary: &[u8], index: usize| primary.get(index).map_or(0, |octet| octet & !1);
    let same = given.len() <= most
        && (0..given.len().max(shortest.len()))
            .all(|index| announces(&given, index) == announces(shortest, index));
    let ends = given.iter().position(|octet| octet & 1 == 0);
    let whole = ends.is_some_and(|end| end + 1 == given.len());
    let wrong = || format!("{PRIMARY}: does not announce the subfields that are here; leave it out");
    (same && whole).then_some(given).ok_or_else(wrong)
}

/// All fields of a part must be present if the part or a later one is.
fn read_parts(out: &mut Vec<u8>, parts: &[&[Field]], value: Value<'_>) -> Result<(), Trouble> {
    let mut object = Members::of(value)?;
    let named = |fields: &&[Field]| fields.iter().any(|field| object.has(field.key));
    let last = parts.iter().rposition(named).unwrap_or(0);
    for (index, fields) in parts[..=last].iter().enumerate() {
        let at = out.len();
        out.resize(at + part_octets(fields), 0);
        object.put(&mut out[at..], fields)?;
        *out.last_mut().expect("a part has octets") |= u8::from(index < last);
    }
    object.end(parts.iter().flat_map(|fields| keys(fields)))
}

fn read_extended(out: &mut Vec<u8>, parts: &[&[Field]], value: Value<'_>) -> Result<(), Trouble> {
    let mut object = Members::of(value)?;
    let (mut put, mut sent) = (0, 1);
    while put < sent {
        let at = out.len();
        out.push(0);
        object.put(&mut out[at..], parts[put])?;
        out[at] |= 1;
        put += 1;
        // An octet was sent if one of its fields, or of a later octet, is present.
        if put == sent && !object.is_taken() {
            let named = |fields: &&[Field]| fields.iter().any(|field| object.has(field.key));
            let last = || parts.iter().rposition(named).map_or(1, |last| last + 1);
            sent = if object.has("more") { parts.len() } else { last() };
        }
    }
    let more = object.take("more").map(octets).transpose()?;
    object.end(parts.iter().flat_map(|fields| keys(fields)))?;
    match more {
        Some(more) => {
            let ends = more.iter().position(|octet| octet & 1 == 0);
            if ends.is_none_or(|end| end + 1 != more.len()) {
                return Err("more: the lowest bit must be set in all octets but the last".to_owned());
            }
            check_length(parts.len() + more.len())?;
            out.extend(more);
        }
        None => {
            if let Some(last) = out.last_mut() {
                *last &= !1;
            }
        }
    }
    Ok(())
}

/// Refuses a length that could not be read again.
fn check_length(octets: usize) -> Result<(), Trouble> {
    let most = Chain::MAX_OCTETS;
    if octets <= most { Ok(()) } else { Err(format!("would have {octets} octets; {most} are the most")) }
}

fn read_explicit(out: &mut Vec<u8>, contents: Contents, value: Value<'_>) -> Result<(), Trouble> {
    if value.as_str().is_some() {
        let octets = octets(value)?;
        return match octets.first() {
            Some(&length) if usize::from(length) == octets.len() => {
                out.extend(octets);
                Ok(())
            }
            _ => Err(format!("its first octet must be its length, {}", octets.len())),
        };
    }
    // The count includes the length itself.
    let at = out.len();
    out.push(0);
    match contents {
        Contents::Opaque => return Err("must be a text of hexadecimal octets".to_owned()),
        Contents::Known(forms) => {
            let mut object = Members::of(value)?;
            let keys = || forms.iter().map(|form| form.key);
            let (key, known) = keys()
                .find_map(|key| Some((key, object.take(key)?)))
                .ok_or_else(|| format!("has no `{}`", forms.first().map_or("", |form| form.key)))?;
            object.end(keys())?;
            let Form { fields, .. } = form_with(forms, key, known);
            read_fields(out, fields, known).map_err(|trouble| format!("{key}: {trouble}"))?;
        }
        Contents::Expansion(subfields) => {
            out.push(0);
            let mut object = Members::of(value)?;
            let announced = read_subfields(out, subfields, &mut object)?;
            object.end(subfields.iter().map(|subfield| subfield.key))?;
            out[at + 1] = (announced as u8).reverse_bits();
        }
    }
    out[at] = u8::try_from(out.len() - at).map_err(|_| "is longer than 255 octets")?;
    Ok(())
}

/// Form of this key with the most fields, none of them missing; otherwise the first form.
fn form_with<'a>(forms: &'a [Form], key: &str, value: Value<'_>) -> &'a Form {
    let is_said = |field: &&Field| !matches!(field.kind, Kind::Spare | Kind::Constant(_));
    let members = Members::of(value).ok();
    let is_whole = |form: &&Form| {
        let has = |field: &Field| members.as_ref().is_some_and(|members| members.has(field.key));
        form.key == key && form.fields.iter().filter(is_said).all(has)
    };
    forms.iter().filter(is_whole).max_by_key(|form| form.fields.len()).unwrap_or(&forms[0])
}

/// Appends the subfields that are present. Bit n of the result, lowest first, is set if the nth subfield is.
fn read_subfields(
    out: &mut Vec<u8>,
    subfields: &[Subfield],
    object: &mut Members<'_>,
) -> Result<u64, Trouble> {
    let mut announced = 0;
    for (index, subfield) in subfields.iter().enumerate().filter(|(_, subfield)| !subfield.key.is_empty()) {
        if let Some(value) = object.take(subfield.key) {
            announced |= 1 << index;
            read_item(out, &subfield.layout, value)
                .map_err(|trouble| format!("{}: {trouble}", subfield.key))?;
        }
    }
    Ok(announced)
}

/// Appends fields from an object, or the only field of an item from its value.
fn read_fields(out: &mut Vec<u8>, fields: &[Field], value: Value<'_>) -> Result<(), Trouble> {
    if let [field] = fields
        && field.key.is_empty()
    {
        let at = out.len();
        out.resize(at + octets_of(fields), 0);
        return put_value(&mut out[at..], 0, field, value);
    }
    let mut object = Members::of(value)?;
    object.fields(out, fields)?;
    object.end(keys(fields))
}

/// Writes a value at bit `at`, where its field starts.
#[inline(always)] // most values come this way
fn put_value(octets: &mut [u8], at: usize, field: &Field, value: Value<'_>) -> Result<(), Trouble> {
    let width = usize::from(field.bits);
    match field.kind {
        Kind::Hex if width > 64 => return put_octets(&mut octets[at / 8..(at + width) / 8], value),
        Kind::Ascii | Kind::Icao => {
            return put_text(&mut octets[at / 8..(at + width) / 8], field.kind, value);
        }
        _ => {}
    }
    match count_of(field.kind, width, value) {
        Some(count) if width >= 64 || count >> width == 0 => {
            field.set_count(octets, at, count);
            Ok(())
        }
        Some(_) => Err(format!("{value} does not fit {width} bits")),
        None => Err(no_count(field.kind, width, value)),
    }
}

fn put_octets(octets: &mut [u8], value: Value<'_>) -> Result<(), Trouble> {
    let given = self::octets(value)?;
    if given.len() != octets.len() {
        return Err(format!("must be {} octets", octets.len()));
    }
    octets.copy_from_slice(&given);
    Ok(())
}

fn put_text(octets: &mut [u8], kind: Kind, value: Value<'_>) -> Result<(), Trouble> {
    if let Some(hex) = value.as_object().and_then(|mut object| object.get("hex")) {
        return put_octets(octets, hex);
    }
    let text = value.as_str().ok_or("must be a text")?;
    let length = octets.len();
    if matches!(kind, Kind::Icao) {
        let wanted = "must be capital letters, digits and spaces";
        return characters::encode(text, octets)
            .ok_or_else(|| format!("{wanted}, at most {}", length / 3 * 4));
    }
    if text.len() == length && text.is_ascii() {
        octets.copy_from_slice(text.as_bytes());
        Ok(())
    } else {
        Err(format!("must be {length} ASCII characters"))
    }
}

fn count_of(kind: Kind, width: usize, value: Value<'_>) -> Option<u64> {
    let digits = |base: u32, bits: usize| {
        let text = value.as_str().filter(|text| text.len() == width / bits && !text.starts_with('+'))?;
        u64::from_str_radix(text, base).ok()
    };
    match kind {
        Kind::Octal => digits(8, 3),
        Kind::Hex | Kind::Address => digits(16, 4),
        Kind::CountOr(unknown) if value.is_null() => Some(unknown),
        Kind::Quantity(Quantity { unknown: Some(unknown), .. }) if value.is_null() => Some(unknown),
        Kind::Quantity(quantity) => quantity.count(value.as_f64()?, width),
        Kind::CountFrom(first) => value.as_u64()?.checked_sub(first),
        _ => value.as_u64(),
    }
}

/// Reason why a value has no count.
#[cold]
fn no_count(kind: Kind, width: usize, value: Value<'_>) -> Trouble {
    let digits = |base, bits| format!("must be a text of {} digits to the base {base}", width / bits);
    match kind {
        Kind::Octal => digits(8, 3),
        Kind::Hex | Kind::Address => digits(16, 4),
        Kind::Quantity(_) => match value.as_f64() {
            Some(number) => format!("{number} is out of range"),
            None => "must be a number".to_owned(),
        },
        Kind::CountFrom(first) => format!("must be {first} or more"),
        _ => "must be a whole number".to_owned(),
    }
}

/// Octets of a hexadecimal text.
pub(super) fn octets(value: Value<'_>) -> Result<Vec<u8>, Trouble> {
    let octets = value.as_str().and_then(crate::hex::octets);
    octets.ok_or_else(|| "must be a text of hexadecimal octets".to_owned())
}

/// Members of an object, each of which must be taken.
struct Members<'a> {
    object: Object<'a>,
    taken: usize,
}

impl<'a> Members<'a> {
    fn of(value: Value<'a>) -> Result<Self, Trouble> {
        let object = value.as_object().ok_or("must be an object")?;
        Ok(Self { object, taken: 0 })
    }

    fn has(&self, key: &str) -> bool {
        self.object.has(key)
    }

    /// Whether all members were taken.
    fn is_taken(&self) -> bool {
        self.taken == self.object.len()
    }

    fn take(&mut self, key: &str) -> Option<Value<'a>> {
        if self.is_taken() {
            return None;
        }
        let value = self.object.get(key)?;
        self.taken += 1;
        Some(value)
    }

    /// Appends fields of whole octets.
    fn fields(&mut self, out: &mut Vec<u8>, fields: &[Field]) -> Result<(), Trouble> {
        let at = out.len();
        out.resize(at + octets_of(fields), 0);
        self.put(&mut out[at..], fields)
    }

    /// Writes fields from the first bit of `octets` on. Missing spare bits are zero.
    fn put(&mut self, octets: &mut [u8], fields: &[Field]) -> Result<(), Trouble> {
        let mut at = 0;
        for field in fields {
            let here = at;
            at += usize::from(field.bits);
            if let Kind::Constant(constant) = field.kind {
                field.set_count(octets, here, constant);
                continue;
            }
            // The field it depends on comes earlier.
            let field = meant(field, fields, octets, 0);
            match self.take(field.key) {
                Some(value) => put_value(octets, here, field, value)
                    .map_err(|trouble| format!("{}: {trouble}", field.key))?,
                None if matches!(field.kind, Kind::Spare) => {}
                None => return Err(format!("has no `{}`", field.key)),
            }
        }
        Ok(())
    }

    /// Reports a member that was not taken, as it is not in `known`.
    fn end<'k>(&self, known: impl Iterator<Item = &'k str>) -> Result<(), Trouble> {
        if self.is_taken() { Ok(()) } else { Err(self.surplus(known)) }
    }

    #[cold]
    fn surplus<'k>(&self, known: impl Iterator<Item = &'k str>) -> Trouble {
        let known: Vec<&str> = known.filter(|key| !key.is_empty() && !key.starts_with("spare")).collect();
        let mut keys = self.object.iter().map(|(key, _)| key);
        let unknown = keys.find(|key| {
            !known.contains(key)
                && !key.starts_with("spare")
                && !matches!(*key, "more" | "undescribed" | PRIMARY)
        });
        match (unknown, self.object.twice()) {
            (None, Some(twice)) => format!("`{twice}` is there twice"),
            (unknown, _) => {
                let unknown = unknown.unwrap_or("a member");
                format!("`{unknown}` is unknown here; known are {}", known.join(", "))
            }
        }
    }
}
