//! Converts the tables in `definitions` into layouts. `make.py` in that folder describes their form.
//!
//! The layouts of an edition are created when it is first used, and remain allocated while the program runs.

use std::iter::Peekable;
use std::str::Lines;

use super::units::{bare, convert, decimals, key};
use crate::layout::{field, quantity};
use crate::{Contents, Dependence, Field, Kind, Layout, Profile, Quantity, Subfield, UapItem};

/// An error in a table. It cannot occur outside the tests of this crate, which read all tables.
type Bad = String;

/// A category with its editions in the order of its table, oldest first.
#[derive(Debug)]
pub(super) struct Head {
    pub number: u8,
    pub title: &'static str,
    pub editions: Vec<&'static str>,
    pub expansions: Vec<&'static str>,
}

/// The content of one edition.
#[derive(Debug, Default)]
pub(super) struct Edition {
    /// Name and items of each profile.
    pub profiles: Vec<(&'static str, &'static Profile)>,
    pub choice: Option<Choice>,
}

/// The field that selects the profile of a record.
#[derive(Debug)]
pub(super) struct Choice {
    /// Number of the item.
    pub item: &'static str,
    /// Key of the field.
    pub field: String,
    /// Values of the field, each with the index of its profile.
    pub profiles: Vec<(u64, usize)>,
}

/// Reads category, title and editions from a table.
pub(super) fn head(table: &'static str) -> Result<Head, Bad> {
    let mut head = Head { number: 0, title: "", editions: Vec::new(), expansions: Vec::new() };
    for line in lines(table) {
        match line.split_once(' ').ok_or(line)? {
            ("editions", editions) => head.editions = editions.split(' ').collect(),
            ("expansions", editions) => head.expansions = editions.split(' ').collect(),
            ("uap", _) => break,
            (category, title) => (head.number, head.title) = (number(category)?, title),
        }
    }
    Ok(head)
}

/// Reads one edition from a table, with one edition of its reserved expansion field.
pub(super) fn edition(
    table: &'static str,
    head: &Head,
    edition: &str,
    expansion: Option<&str>,
) -> Result<Edition, Bad> {
    let applies = |editions: &str| is_among(&head.editions, editions, edition);
    let (mut uaps, mut choice) = (Vec::new(), None);
    let (mut items, mut extended) = (Vec::new(), Contents::Opaque);
    let mut lines = lines(table);
    while let Some(line) = lines.next() {
        let mut words = line.splitn(4, ' ');
        let (kind, editions) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        match (kind, words.next(), words.next()) {
            ("uap", Some(name), Some(listed)) if applies(editions) => uaps.push((name, listed)),
            ("select", Some(item), Some(cases)) if applies(editions) => choice = Some((item, cases)),
            ("item", Some(number), Some(name)) if applies(editions) => {
                let line = lines.next().ok_or(line)?;
                items.push((number, name, layout(line.trim_start(), 1, &mut lines, Place::Item)?));
            }
            ("re", ..)
                if expansion.is_some_and(|expansion| is_among(&head.expansions, editions, expansion)) =>
            {
                // The octet that announces subfields has eight bits; those without a subfield in this edition are undefined.
                let mut eight = subfields(1, &mut lines)?;
                eight.resize(8, Subfield::UNDEFINED);
                extended = Contents::Expansion(eight.leak());
            }
            _ => {}
        }
    }
    for (_, _, layout) in &mut items {
        if *layout == EXPANSION {
            *layout = Layout::Explicit(extended);
        }
    }
    let mut made = Edition::default();
    for (name, listed) in &uaps {
        made.profiles.push((name, uap(listed, &items)?));
    }
    if let Some((item, cases)) = choice {
        let mut cases = cases.split(' ');
        let field = cases.next().filter(|field| *field != "-").map_or(String::new(), bare);
        let mut profiles = Vec::new();
        for case in cases {
            let (name, value) = case.split_once('=').ok_or(case)?;
            let profile = uaps.iter().position(|(uap, _)| *uap == name).ok_or(case)?;
            profiles.push((number(value)?, profile));
        }
        made.choice = Some(Choice { item, field, profiles });
    }
    Ok(made)
}

fn lines(table: &'static str) -> Peekable<Lines<'static>> {
    let mut lines = table.lines().peekable();
    while lines.next_if(|line| line.starts_with('#')).is_some() {}
    lines
}

/// Whether a list such as `1.27-1.29,1.31` includes an edition.
fn is_among(order: &[&str], editions: &str, edition: &str) -> bool {
    let place = |edition: &str| order.iter().position(|listed| *listed == edition);
    let place_of = place(edition);
    editions.split(',').any(|run| {
        let (first, last) = run.split_once('-').unwrap_or((run, run));
        place(first) <= place_of && place_of <= place(last)
    })
}

/// The profile with these items, which are listed by number.
fn uap(listed: &str, items: &[(&'static str, &'static str, Layout)]) -> Result<&'static Profile, Bad> {
    let (mut uap, mut sequence) = (Vec::new(), None);
    for (number, frn) in listed.split(' ').zip(1..) {
        match number {
            "-" => {}
            SEQUENCE => sequence = Some(frn),
            _ => {
                let found = items.iter().find(|(item, ..)| *item == number);
                let &(item, name, layout) = found.ok_or_else(|| format!("no item {number}"))?;
                uap.push(UapItem::new(frn, item, name, layout));
            }
        }
    }
    if let Some(frn) = sequence {
        // The sequence consists of the other items.
        let layout = Layout::Sequence(uap.clone().leak());
        uap.push(UapItem::new(frn, SEQUENCE, "Random Field Sequencing", layout));
        uap.sort_by_key(|item| item.frn);
    }
    Ok(Box::leak(Box::new(Profile::new(uap.leak()))))
}

/// Name of random field sequencing in a profile.
const SEQUENCE: &str = "RFS";

/// A reserved expansion field whose edition is not yet known.
const EXPANSION: Layout = Layout::Explicit(Contents::Expansion(&[]));

/// The key that has the unit of a value without a name.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// The key of the field.
    Item,
    /// The key of the subfield.
    Subfield,
}

/// The layout that begins with this text. `indent` is the indentation of its line; its subfields follow, further indented.
fn layout(
    text: &'static str,
    indent: usize,
    lines: &mut Peekable<Lines<'static>>,
    place: Place,
) -> Result<Layout, Bad> {
    let (kind, rest) = text.split_once(' ').unwrap_or((text, ""));
    Ok(match kind {
        "comp" => Layout::Compound(subfields(indent + 1, lines)?.leak()),
        "explicit" => Layout::Explicit(Contents::Opaque),
        "expansion" => EXPANSION,
        "rep" => Layout::Repetitive(fields(rest, place, &mut 0)?),
        "repfx" if rest == ":7" => Layout::Codes,
        "repfx" => Layout::Chained(fields(rest, place, &mut 0)?),
        "ext" => {
            let (mut parts, mut spares) = (Vec::new(), 0);
            for part in rest.split(" > ") {
                parts.push(fields(part, place, &mut spares)?);
            }
            let parts: &'static [&'static [Field]] = parts.leak();
            let is_seven = |fields: &&[Field]| fields.iter().map(|field| field.bits).sum::<u16>() == 7;
            if parts.iter().all(is_seven) { Layout::Extended(parts) } else { Layout::Parts(parts) }
        }
        _ => Layout::Fields(fields(text, place, &mut 0)?),
    })
}

/// The subfields in the next lines, which have this indentation.
fn subfields(indent: usize, lines: &mut Peekable<Lines<'static>>) -> Result<Vec<Subfield>, Bad> {
    let mut subfields = Vec::new();
    let is_here = |line: &&str| line.len() - line.trim_start().len() == indent;
    while let Some(line) = lines.next_if(is_here) {
        let line = line.trim_start();
        subfields.push(match line.split_once(' ') {
            None => Subfield::UNDEFINED,
            Some((name, text)) => {
                let layout = layout(text, indent, lines, Place::Subfield)?;
                let key: &'static str = key(name, ending(text)?).leak();
                Subfield::new(key, layout)
            }
        });
    }
    Ok(subfields)
}

/// Suffix of a subfield's key: the unit of its only value, if the value has no name.
fn ending(text: &str) -> Result<&'static str, Bad> {
    let value = text.strip_prefix("rep ").unwrap_or(text);
    match value.strip_prefix(':') {
        Some(value) if !value.contains(' ') => {
            let (bits, what) = split(value);
            Ok(quantity_of(number(bits)?, what).map_or("", |(ending, _)| ending))
        }
        _ => Ok(""),
    }
}

/// The fields in a text. `spares` counts spare fields for their names.
fn fields(text: &str, place: Place, spares: &mut usize) -> Result<&'static [Field], Bad> {
    let mut fields = Vec::new();
    // A field that depends on another one has spaces inside braces.
    let mut rest = text;
    while !rest.is_empty() {
        let end = match (rest.find(' '), rest.find('{')) {
            (Some(space), Some(brace)) if brace < space => {
                rest.find('}').map(|brace| brace + 1).filter(|end| *end < rest.len())
            }
            (space, None) | (space, Some(_)) => space,
        };
        let (token, after) = end.map_or((rest, ""), |end| (&rest[..end], &rest[end + 1..]));
        rest = after;
        push_field(&mut fields, token, place, spares)?;
    }
    Ok(fields.leak())
}

fn push_field(fields: &mut Vec<Field>, token: &str, place: Place, spares: &mut usize) -> Result<(), Bad> {
    if let Some(bits) = token.strip_prefix('_') {
        *spares += 1;
        let key = if *spares == 1 { "spare".to_owned() } else { format!("spare_{spares}") };
        fields.push(field(key.leak(), number(bits)?, Kind::Spare));
        return Ok(());
    }
    let (name, what) = token.split_once(':').ok_or(token)?;
    let (bits, what) = split(what);
    let bits = number(bits)?;
    if let Some(depends) = what.strip_prefix('{').and_then(|depends| depends.strip_suffix('}')) {
        let mut words = depends.split(' ');
        let on = bare(words.next().unwrap_or("")).leak();
        let mut cases = Vec::new();
        for case in words {
            let (value, what) = case.split_once('=').ok_or(case)?;
            cases.push((number(value)?, of(name, bits, what, place)?));
        }
        let kind = Kind::Depends(Box::leak(Box::new(Dependence { on, cases: cases.leak() })));
        fields.push(field(bare(name).leak(), bits, kind));
    } else if what == "b" {
        fields.push(field("data", bits - 8, Kind::Hex));
        fields.extend(["bds1", "bds2"].map(|key| field(key, 4, Kind::Count)));
    } else {
        fields.push(of(name, bits, what, place)?);
    }
    Ok(())
}

/// A field with a name, a number of bits, and a kind as text.
fn of(name: &str, bits: u16, what: &str, place: Place) -> Result<Field, Bad> {
    let kind = match what {
        "" => Kind::Count,
        "a" => Kind::Address,
        "x" => Kind::Hex,
        "o" => Kind::Octal,
        "i" => Kind::Icao,
        "t" => Kind::Ascii,
        _ => {
            let (ending, kind) = quantity_of(bits, what).ok_or_else(|| format!("{name}:{bits}{what}"))?;
            let is_bare =
                name.is_empty() && (place == Place::Subfield || is_time_of_day(bits, kind) && ending == "s");
            let key = if is_bare { String::new() } else { key(name, ending) };
            return Ok(field(key.leak(), bits, kind));
        }
    };
    Ok(field(bare(name).leak(), bits, kind))
}

/// Suffix of the key and kind of a quantity: `u1/2^8NM`.
fn quantity_of(bits: u16, what: &str) -> Option<(&'static str, Kind)> {
    let signed = match what.chars().next()? {
        's' => true,
        'u' => false,
        _ => return None,
    };
    let (lsb, unit) = split(&what[1..]);
    let (count, of) = lsb.split_once('/').unwrap_or((lsb, "1"));
    let (ending, lsb) = convert(unit, power(count)?, power(of)?)?;
    if !signed && lsb == 1.0 && ending.is_empty() {
        return Some((ending, Kind::Count));
    }
    let kind = quantity(signed, lsb, decimals(lsb));
    let kind = if is_time_of_day(bits, kind) && unit == "s" { quantity(signed, lsb, 7) } else { kind };
    Some((ending, kind))
}

/// Whether seconds with this number of bits are a time of day, whose key is empty if it has no name.
pub(super) fn is_time_of_day(bits: u16, kind: Kind) -> bool {
    bits == 24 && matches!(kind, Kind::Quantity(Quantity { signed: false, lsb, .. }) if lsb == 1.0 / 128.0)
}

/// Splits a number from the text after it: `1/2^8` and `NM`.
fn split(text: &str) -> (&str, &str) {
    let is_number = |character: char| character.is_ascii_digit() || matches!(character, '/' | '^');
    text.split_at(text.find(|character| !is_number(character)).unwrap_or(text.len()))
}

/// The value of a power: `2^8`.
fn power(text: &str) -> Option<f64> {
    match text.split_once('^') {
        Some((base, exponent)) => Some(base.parse::<f64>().ok()?.powi(exponent.parse().ok()?)),
        None => text.parse().ok(),
    }
}

fn number<T: std::str::FromStr>(text: &str) -> Result<T, Bad> {
    text.parse().map_err(|_| format!("{text:?} is no number"))
}
