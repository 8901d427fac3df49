//! Records as a table: a row per record, a column per scalar of its category.
//!
//! Names are those of `decode`'s JSON: `I048_040_rho_m` is `rho_m` of item 040. What repeats, and what no layout describes,
//! is one column of text, with what the JSON has there.

use std::borrow::Cow;

use asterix::{Contents, Field, Kind, Layout, Subfield, UapItem};

use super::table::{Cell, Column, ColumnKind, Table};
use crate::hex;
use crate::json::{announced, is_known, item_json, meant, part_octets, scalar_json};

/// How the records of a category fill columns.
pub(crate) struct RecordColumns {
    columns: Vec<Column>,
    /// By the numbers of the items.
    items: Vec<(&'static str, Node)>,
}

/// Where the parts of an item go; as its layout is built.
enum Node {
    /// Its fields, from this column on: those that are neither spare nor constant.
    Fields(usize),
    /// The fields of each part, from these columns on.
    Parts(Vec<usize>),
    /// Its subfields; `None` of one that the specification does not define.
    Subfields(Vec<Option<Node>>),
    /// All of it as text.
    Text(usize),
    /// Its fields or subfields where they are what the layout knows, otherwise hexadecimal digits in this column.
    Explicit(Option<Box<Node>>, usize),
}

impl RecordColumns {
    /// Those of records of a category with these items, behind `first`, which other cells go into.
    pub(crate) fn of(category: u8, items: &'static [UapItem], first: Vec<Column>) -> Self {
        let mut columns = first;
        let node = |item: &UapItem| {
            let name = format!("I{category:03}_{}", item.item);
            (item.item, Node::new(&mut columns, &name, &item.layout))
        };
        let items = items.iter().map(node).collect();
        Self { columns, items }
    }

    /// All columns.
    pub(crate) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Sets the cells of a record of these items, each with its octets.
    pub(crate) fn fill<'a>(
        &self,
        table: &mut dyn Table,
        items: impl Iterator<Item = (&'static UapItem, &'a [u8])>,
    ) {
        for (item, octets) in items {
            if let Some((_, node)) = self.items.iter().find(|(number, _)| *number == item.item) {
                node.fill(table, &item.layout, octets);
            }
        }
    }
}

impl Node {
    /// Adds the columns of an item or a subfield of this name.
    fn new(columns: &mut Vec<Column>, name: &str, layout: &Layout) -> Self {
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
                    Contents::Opaque => None,
                    Contents::Known(key, fields) => {
                        Some(Self::Fields(add(columns, &format!("{name}_{key}"), fields)))
                    }
                    Contents::Expansion(subfields) => Some(Self::subfields(columns, name, subfields)),
                };
                Self::Explicit(known.map(Box::new), add_text(columns, format!("{name}_hex")))
            }
        }
    }

    fn subfields(columns: &mut Vec<Column>, name: &str, subfields: &[Subfield]) -> Self {
        let mut node = |subfield: &Subfield| {
            let is_defined = !subfield.key.is_empty();
            is_defined.then(|| Self::new(columns, &format!("{name}_{}", subfield.key), &subfield.layout))
        };
        Self::Subfields(subfields.iter().map(&mut node).collect())
    }

    /// Sets the cells of an item with these octets, which are those that its layout measures.
    fn fill(&self, table: &mut dyn Table, layout: &Layout, octets: &[u8]) {
        match (self, layout) {
            (Self::Fields(first), Layout::Fields(fields) | Layout::OneOrThree(fields)) => {
                set(table, *first, fields, octets, 0);
            }
            (Self::Parts(firsts), Layout::Extended(parts) | Layout::Parts(parts)) => {
                let mut at = 0;
                for (&first, fields) in firsts.iter().zip(*parts) {
                    if at < octets.len() {
                        set(table, first, fields, octets, at * 8);
                    }
                    at += part_octets(fields);
                }
            }
            (Self::Subfields(nodes), Layout::Compound(subfields)) => {
                let primary = octets.iter().position(|octet| octet & 1 == 0).map_or(0, |last| last + 1);
                let (primary, rest) = octets.split_at(primary);
                Self::fill_subfields(nodes, table, subfields, |index| announced(primary, 7, index), rest);
            }
            (Self::Explicit(Some(known), _), Layout::Explicit(contents))
                if is_known(*contents, &octets[1..]) =>
            {
                match (&**known, contents) {
                    (Self::Fields(first), Contents::Known(_, fields)) => {
                        set(table, *first, fields, &octets[1..], 0);
                    }
                    (Self::Subfields(nodes), Contents::Expansion(subfields)) => {
                        let (primary, rest) = octets[1..].split_at(1);
                        Self::fill_subfields(
                            nodes,
                            table,
                            subfields,
                            |index| announced(primary, 8, index),
                            rest,
                        );
                    }
                    _ => {}
                }
            }
            (Self::Explicit(_, column), _) => {
                table.set(*column, Cell::Text(hex::text(octets).into()));
            }
            (Self::Text(column), layout) => {
                table.set(*column, Cell::Text(item_json(layout, octets).into()));
            }
            _ => {}
        }
    }

    fn fill_subfields(
        nodes: &[Option<Self>],
        table: &mut dyn Table,
        subfields: &[Subfield],
        announces: impl Fn(usize) -> bool,
        octets: &[u8],
    ) {
        let mut rest = octets;
        for (index, (node, subfield)) in nodes.iter().zip(subfields).enumerate() {
            let (true, Some(node)) = (announces(index), node) else { continue };
            // The whole item has been measured.
            let Ok(length) = subfield.layout.measure(rest) else { break };
            node.fill(table, &subfield.layout, &rest[..length]);
            rest = &rest[length..];
        }
    }
}

/// Adds the columns of fields; the first one's place.
fn add(columns: &mut Vec<Column>, name: &str, fields: &[Field]) -> usize {
    let first = columns.len();
    for field in fields.iter().flat_map(meanings).filter(|field| has_column(field)) {
        let name = match (field.key, field.kind) {
            // The only field of an item; where JSON leaves the unit out, it is the second.
            ("", Kind::Quantity(_)) if !has_unit(name) => format!("{name}_s"),
            ("", _) => name.to_owned(),
            (key, _) => format!("{name}_{key}"),
        };
        columns.push(Column::new(name, kind(field)));
    }
    first
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
fn set(table: &mut dyn Table, first: usize, fields: &[Field], octets: &[u8], at: usize) {
    let (mut column, begin, mut at) = (first, at, at);
    for field in fields {
        let here = at;
        at += usize::from(field.bits);
        let said = meant(field, fields, octets, begin);
        for meaning in meanings(field).filter(|field| has_column(field)) {
            if meaning.key == said.key
                && let Some(cell) = cell(meaning, octets, here)
            {
                table.set(column, cell);
            }
            column += 1;
        }
    }
}

fn cell(field: &Field, octets: &[u8], at: usize) -> Option<Cell<'static>> {
    let width = usize::from(field.bits);
    let count = || field.count(octets, at);
    if kind(field) == ColumnKind::Text {
        let json = scalar_json(field, octets, at);
        // A text; what is none is printed as an object.
        let text = serde_json::from_str(&json).unwrap_or(json);
        return Some(Cell::Text(Cow::Owned(text)));
    }
    match field.kind {
        Kind::CountOr(unknown) if count() == unknown => None,
        Kind::Quantity(quantity) if quantity.unknown == Some(count()) => None,
        Kind::Quantity(quantity) => {
            let scale = 10_f64.powi(quantity.decimals.into());
            Some(Cell::Quantity((quantity.value(count(), width) * scale).round() / scale))
        }
        Kind::CountFrom(first) => i64::try_from(count() + first).ok().map(Cell::Count),
        _ => i64::try_from(count()).ok().map(Cell::Count),
    }
}
