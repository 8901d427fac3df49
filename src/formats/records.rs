//! Records as a table: a row per record, a column per scalar of its category.
//!
//! Names are those of `decode`'s JSON: `I048_040_rho_m` is `rho_m` of item 040. What repeats, and what no layout describes,
//! is one column of text, with what the JSON has there.

use std::borrow::Cow;

use asterix::{Contents, Field, Form, Kind, Layout, Subfield, UapItem};

use super::table::{Cell, Column, ColumnKind, Table};
use crate::hex;
use crate::json::{announced, form_of, is_known, meant, part_octets, write_item, write_value};

/// How the records of a category fill columns.
pub(crate) struct RecordColumns {
    columns: Vec<Column>,
    /// In the order of the items; `None` of one that fills no column that is wanted.
    items: Vec<(&'static UapItem, Option<Node>)>,
    /// The text of a cell.
    text: Vec<u8>,
}

/// Where the parts of an item go; as its layout is built.
enum Node {
    /// Its fields.
    Fields(Vec<Place>),
    /// The fields of each part.
    Parts(Vec<Vec<Place>>),
    /// Its subfields; `None` of one that the specification does not define.
    Subfields(Vec<Option<Node>>),
    /// All of it as text.
    Text(usize),
    /// Its fields, by form, or its subfields where they are what the layout knows, otherwise hexadecimal digits in this column.
    Explicit(Vec<Option<Node>>, usize),
}

/// Where a field goes.
struct Place {
    column: usize,
    /// The bit at which it begins, from the first of its item or part.
    at: usize,
    field: &'static Field,
    /// The field of which it is one of several meanings.
    of: Option<&'static Field>,
    /// 10 to the power of its decimals.
    scale: f64,
}

impl RecordColumns {
    /// Those of records of a category with these items, behind `first`, which other cells go into.
    pub(crate) fn of(category: u8, items: &'static [UapItem], first: Vec<Column>) -> Self {
        let mut columns = first;
        let node = |item: &'static UapItem| {
            let name = format!("I{category:03}_{}", item.item);
            (item, Some(Node::new(&mut columns, &name, &item.layout)))
        };
        let items = items.iter().map(node).collect();
        Self { columns, items, text: Vec::new() }
    }

    /// All columns.
    pub(crate) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Fills from now on only the columns that are wanted.
    pub(crate) fn keep(&mut self, is_wanted: impl Fn(usize) -> bool) {
        for (_, node) in &mut self.items {
            *node = node.take().and_then(|node| node.kept(&is_wanted));
        }
    }

    /// Sets the cells of a record of these items, each with its octets.
    pub(crate) fn fill<'a>(
        &mut self,
        table: &mut dyn Table,
        items: impl Iterator<Item = (&'static UapItem, &'a [u8])>,
    ) {
        let Self { items: nodes, text, .. } = self;
        let mut next = 0;
        for (item, octets) in items {
            // An item mostly stands behind the one before it; in another profile of its category it is another one.
            let behind = nodes[next..].iter().position(|(known, _)| std::ptr::eq(*known, item));
            let here = behind.map(|after| next + after);
            let here = here.or_else(|| nodes.iter().position(|(known, _)| known.item == item.item));
            let Some(here) = here else { continue };
            next = here + 1;
            if let (_, Some(node)) = &nodes[here] {
                node.fill(table, text, &item.layout, octets);
            }
        }
    }
}

impl Node {
    /// Adds the columns of an item or a subfield of this name.
    fn new(columns: &mut Vec<Column>, name: &str, layout: &'static Layout) -> Self {
        match layout {
            Layout::Fields(fields) | Layout::OneOrThree(fields) => Self::Fields(add(columns, name, fields)),
            Layout::Extended(parts) | Layout::Parts(parts) => {
                Self::Parts(parts.iter().map(|fields| add(columns, name, fields)).collect())
            }
            Layout::Compound(subfields) => Self::subfields(columns, name, subfields),
            Layout::Codes | Layout::Chained(_) | Layout::Repetitive(_) | Layout::Sequence(_) => {
                Self::Text(add_text(columns, name.to_owned()))
            }
            Layout::Explicit(contents) => {
                let known = match contents {
                    Contents::Opaque => Vec::new(),
                    Contents::Known(forms) => {
                        // Fields that several forms have share a column.
                        let from = columns.len();
                        let node = |form: &Form| {
                            let name = format!("{name}_{}", form.key);
                            Some(Self::Fields(add_shared(columns, from, &name, form.fields)))
                        };
                        forms.iter().map(node).collect()
                    }
                    Contents::Expansion(subfields) => vec![Some(Self::subfields(columns, name, subfields))],
                };
                Self::Explicit(known, add_text(columns, format!("{name}_hex")))
            }
        }
    }

    fn subfields(columns: &mut Vec<Column>, name: &str, subfields: &'static [Subfield]) -> Self {
        let mut node = |subfield: &'static Subfield| {
            let is_defined = !subfield.key.is_empty();
            is_defined.then(|| Self::new(columns, &format!("{name}_{}", subfield.key), &subfield.layout))
        };
        Self::Subfields(subfields.iter().map(&mut node).collect())
    }

    /// What remains of it where only these columns are wanted.
    fn kept(self, is_wanted: &impl Fn(usize) -> bool) -> Option<Self> {
        let wanted = |mut places: Vec<Place>| {
            places.retain(|place| is_wanted(place.column));
            places
        };
        match self {
            Self::Fields(places) => {
                Some(wanted(places)).filter(|places| !places.is_empty()).map(Self::Fields)
            }
            Self::Parts(parts) => {
                let parts: Vec<_> = parts.into_iter().map(wanted).collect();
                parts.iter().any(|places| !places.is_empty()).then_some(Self::Parts(parts))
            }
            Self::Subfields(nodes) => {
                let nodes: Vec<_> = nodes.into_iter().map(|node| node?.kept(is_wanted)).collect();
                nodes.iter().any(Option::is_some).then_some(Self::Subfields(nodes))
            }
            Self::Text(column) => is_wanted(column).then_some(self),
            // Whether its column has something depends on whether its layout is known.
            Self::Explicit(known, column) => {
                let known: Vec<_> = known.into_iter().map(|node| node?.kept(is_wanted)).collect();
                (known.iter().any(Option::is_some) || is_wanted(column))
                    .then_some(Self::Explicit(known, column))
            }
        }
    }

    /// Sets the cells of an item with these octets, which are those that its layout measures.
    fn fill(&self, table: &mut dyn Table, text: &mut Vec<u8>, layout: &Layout, octets: &[u8]) {
        match (self, layout) {
            (Self::Fields(places), Layout::Fields(fields) | Layout::OneOrThree(fields)) => {
                set(table, text, places, fields, octets, 0);
            }
            (Self::Parts(places), Layout::Extended(parts) | Layout::Parts(parts)) => {
                let mut at = 0;
                for (places, fields) in places.iter().zip(*parts) {
                    if at < octets.len() {
                        set(table, text, places, fields, octets, at * 8);
                    }
                    at += part_octets(fields);
                }
            }
            (Self::Subfields(nodes), Layout::Compound(subfields)) => {
                let primary = octets.iter().position(|octet| octet & 1 == 0).map_or(0, |last| last + 1);
                let (primary, rest) = octets.split_at(primary);
                Self::fill_subfields(
                    nodes,
                    table,
                    text,
                    subfields,
                    |index| announced(primary, 7, index),
                    rest,
                );
            }
            (Self::Explicit(known, column), Layout::Explicit(contents)) => {
                if !is_known(*contents, &octets[1..]) {
                    return table.set(*column, Cell::Text(hex::text(octets).into()));
                }
                match (&known[..], contents) {
                    (nodes, Contents::Known(forms)) => {
                        let form = form_of(forms, &octets[1..]);
                        let node = form.and_then(|(at, form)| Some((nodes.get(at)?.as_ref()?, form)));
                        if let Some((Self::Fields(places), form)) = node {
                            set(table, text, places, form.fields, &octets[1..], 0);
                        }
                    }
                    ([Some(Self::Subfields(nodes))], Contents::Expansion(subfields)) => {
                        let (primary, rest) = octets[1..].split_at(1);
                        let is_there = |index| announced(primary, 8, index);
                        Self::fill_subfields(nodes, table, text, subfields, is_there, rest);
                    }
                    _ => {}
                }
            }
            (Self::Text(column), layout) => {
                text.clear();
                write_item(text, layout, octets);
                table.set(*column, Cell::Text(text_of(text)));
            }
            _ => {}
        }
    }

    fn fill_subfields(
        nodes: &[Option<Self>],
        table: &mut dyn Table,
        text: &mut Vec<u8>,
        subfields: &[Subfield],
        announces: impl Fn(usize) -> bool,
        octets: &[u8],
    ) {
        let mut rest = octets;
        for (index, (node, subfield)) in nodes.iter().zip(subfields).enumerate() {
            if !announces(index) || subfield.key.is_empty() {
                continue;
            }
            // The whole item has been measured.
            let Ok(length) = subfield.measure(rest) else { break };
            if let Some(node) = node {
                node.fill(table, text, &subfield.layout, &rest[..length]);
            }
            rest = &rest[length..];
        }
    }
}

/// Adds the columns of fields; where each goes.
fn add(columns: &mut Vec<Column>, name: &str, fields: &'static [Field]) -> Vec<Place> {
    let from = columns.len();
    add_shared(columns, from, name, fields)
}

/// The same; a column of the same name, from index `from` on, is used again.
fn add_shared(columns: &mut Vec<Column>, from: usize, name: &str, fields: &'static [Field]) -> Vec<Place> {
    let (mut places, mut at) = (Vec::new(), 0);
    for field in fields {
        for meaning in meanings(field).filter(|field| has_column(field)) {
            let of = matches!(field.kind, Kind::Depends(_)).then_some(field);
            let decimals = if let Kind::Quantity(quantity) = meaning.kind { quantity.decimals } else { 0 };
            let scale = 10_f64.powi(decimals.into());
            let name = match (meaning.key, meaning.kind) {
                // The only field of an item; where JSON leaves the unit out, it is the second.
                ("", Kind::Quantity(_)) if !has_unit(name) => format!("{name}_s"),
                ("", _) => name.to_owned(),
                (key, _) => format!("{name}_{key}"),
            };
            let known = columns[from..].iter().position(|column| column.name == name);
            let column = known.map_or(columns.len(), |at| from + at);
            if known.is_none() {
                columns.push(Column::new(name, kind(meaning)));
            }
            places.push(Place { column, at, field: meaning, of, scale });
        }
        at += usize::from(field.bits);
    }
    places
}

fn add_text(columns: &mut Vec<Column>, name: String) -> usize {
    columns.push(Column::new(name, ColumnKind::Text));
    columns.len() - 1
}

/// Whether a name says more than category and item: the key of a subfield has its unit.
fn has_unit(name: &str) -> bool {
    name.matches('_').count() > 1
}

/// The field, or all that it may be; itself last, a whole number where no case is.
fn meanings(field: &Field) -> impl Iterator<Item = &Field> {
    let cases = match field.kind {
        Kind::Depends(dependence) => dependence.cases,
        _ => &[],
    };
    cases.iter().map(|(_, case)| case).chain([field])
}

fn has_column(field: &Field) -> bool {
    !matches!(field.kind, Kind::Spare | Kind::Constant(_))
}

fn kind(field: &Field) -> ColumnKind {
    match field.kind {
        Kind::Quantity(_) => ColumnKind::Quantity,
        Kind::Count | Kind::CountOr(_) | Kind::CountFrom(_) | Kind::Depends(_) if field.bits < 64 => {
            ColumnKind::Count
        }
        _ => ColumnKind::Text,
    }
}

/// Sets the cells of fields that begin at this bit; those that mean "unknown" stay null.
fn set(
    table: &mut dyn Table,
    text: &mut Vec<u8>,
    places: &[Place],
    fields: &[Field],
    octets: &[u8],
    begin: usize,
) {
    for place in places {
        let is_meant = |of| meant(of, fields, octets, begin).key == place.field.key;
        if place.of.is_none_or(is_meant)
            && let Some(cell) = cell(place, text, octets, begin + place.at)
        {
            table.set(place.column, cell);
        }
    }
}

fn cell<'a>(place: &Place, text: &'a mut Vec<u8>, octets: &[u8], at: usize) -> Option<Cell<'a>> {
    let field = place.field;
    if kind(field) == ColumnKind::Text {
        text.clear();
        write_value(text, field, octets, at);
        return Some(Cell::Text(unquoted(text)));
    }
    let (width, count) = (usize::from(field.bits), field.count(octets, at));
    match field.kind {
        Kind::CountOr(unknown) if count == unknown => None,
        Kind::Quantity(quantity) if quantity.unknown == Some(count) => None,
        Kind::Quantity(quantity) => {
            Some(Cell::Quantity((quantity.value(count, width) * place.scale).round() / place.scale))
        }
        Kind::CountFrom(first) => i64::try_from(count + first).ok().map(Cell::Count),
        _ => i64::try_from(count).ok().map(Cell::Count),
    }
}

/// The text of a value; what is none, as octets where a text should be, stays JSON.
fn unquoted(json: &[u8]) -> Cow<'_, str> {
    match json {
        [b'"', text @ .., b'"'] if !text.contains(&b'\\') => text_of(text),
        _ => serde_json::from_slice(json).map_or_else(|_| text_of(json), Cow::Owned),
    }
}

/// What is printed is ASCII; to find that out is quicker than to look for what is not.
fn text_of(printed: &[u8]) -> Cow<'_, str> {
    str::from_utf8(printed).map_or_else(|_| String::from_utf8_lossy(printed), Cow::Borrowed)
}
