//! Records as a table: one row per record, one column per scalar of its category.
//!
//! Names are those of `decode`'s JSON: `I048_040_rho_m` is `rho_m` of item 040. Repeated parts, and parts without a layout, are
//! one text column with their JSON.

use std::borrow::Cow;

use asterix::{Contents, Field, Form, Kind, Layout, Subfield, UapItem};

use super::table::{ColumnKind, TableCell, TableColumn, TableWriter};
use input::hex;
use input::json::{announced, form_of, is_known, meant, part_octets, write_item, write_value};

/// Mapping of the records of a category to columns.
pub(crate) struct RecordColumns {
    columns: Vec<TableColumn>,
    /// Items in order; `None` for one without a wanted column.
    items: Vec<(&'static UapItem, Option<LayoutNode>)>,
    /// Buffer of a cell's text.
    text: Vec<u8>,
}

/// Mapping of an item's parts to columns, with the structure of its layout.
enum LayoutNode {
    /// Fields of an item.
    Fields(Vec<FieldPosition>),
    /// Fields of each part.
    Parts(Vec<Vec<FieldPosition>>),
    /// Subfields; `None` for one that the specification does not define.
    Subfields(Vec<Option<LayoutNode>>),
    /// The whole item as text, in this column.
    Text(usize),
    /// Fields by form, or subfields, if the contents follow the layout; otherwise hexadecimal digits in this column.
    Explicit(Vec<Option<LayoutNode>>, usize),
}

/// Mapping of a field to a column.
struct FieldPosition {
    column: usize,
    /// Offset of the first bit in its item or part.
    at: usize,
    field: &'static Field,
    /// The field in the layout, if `field` is one of its possible meanings.
    of: Option<&'static Field>,
    /// 10 to the power of the decimals.
    scale: f64,
}

impl RecordColumns {
    /// Mapping for records of `category` with these items. The columns in `first`, which the caller fills, come before.
    pub fn of(category: u8, items: &'static [UapItem], first: Vec<TableColumn>) -> Self {
        let mut columns = first;
        let node = |item: &'static UapItem| {
            let name = format!("I{category:03}_{}", item.item);
            (item, Some(LayoutNode::new(&mut columns, &name, &item.layout)))
        };
        let items = items.iter().map(node).collect();
        Self { columns, items, text: Vec::new() }
    }

    /// All columns.
    pub fn columns(&self) -> &[TableColumn] {
        &self.columns
    }

    /// Restricts the mapping to wanted columns.
    pub fn keep(&mut self, is_wanted: impl Fn(usize) -> bool) {
        for (_, node) in &mut self.items {
            *node = node.take().and_then(|node| node.kept(&is_wanted));
        }
    }

    /// Sets the cells of a record with these items and their octets.
    pub fn fill<'a>(
        &mut self,
        table: &mut dyn TableWriter,
        items: impl Iterator<Item = (&'static UapItem, &'a [u8])>,
    ) {
        let Self { items: nodes, text, .. } = self;
        let mut next = 0;
        for (item, octets) in items {
            // Items mostly come in this order. Another profile of the category has its own object for the same item number.
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

impl LayoutNode {
    /// Adds the columns of an item or a subfield named `name`.
    fn new(columns: &mut Vec<TableColumn>, name: &str, layout: &'static Layout) -> Self {
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
                        // Fields common to several forms share a column.
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

    fn subfields(columns: &mut Vec<TableColumn>, name: &str, subfields: &'static [Subfield]) -> Self {
        let mut node = |subfield: &'static Subfield| {
            let is_defined = !subfield.key.is_empty();
            is_defined.then(|| Self::new(columns, &format!("{name}_{}", subfield.key), &subfield.layout))
        };
        Self::Subfields(subfields.iter().map(&mut node).collect())
    }

    /// The mapping restricted to wanted columns, if any remain.
    fn kept(self, is_wanted: &impl Fn(usize) -> bool) -> Option<Self> {
        let wanted = |mut places: Vec<FieldPosition>| {
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
            // Whether this column has a value depends on whether the layout is known.
            Self::Explicit(known, column) => {
                let known: Vec<_> = known.into_iter().map(|node| node?.kept(is_wanted)).collect();
                (known.iter().any(Option::is_some) || is_wanted(column))
                    .then_some(Self::Explicit(known, column))
            }
        }
    }

    /// Sets the cells of an item whose octets its layout has measured.
    fn fill(&self, table: &mut dyn TableWriter, text: &mut Vec<u8>, layout: &Layout, octets: &[u8]) {
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
                    return table.set(*column, TableCell::Text(hex::text(octets).into()));
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
                table.set(*column, TableCell::Text(text_of(text)));
            }
            _ => {}
        }
    }

    fn fill_subfields(
        nodes: &[Option<Self>],
        table: &mut dyn TableWriter,
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

/// Adds the columns of fields. Returns their mapping.
fn add(columns: &mut Vec<TableColumn>, name: &str, fields: &'static [Field]) -> Vec<FieldPosition> {
    let from = columns.len();
    add_shared(columns, from, name, fields)
}

/// Adds the columns of fields. A column of the same name, from index `from` on, is shared.
fn add_shared(
    columns: &mut Vec<TableColumn>,
    from: usize,
    name: &str,
    fields: &'static [Field],
) -> Vec<FieldPosition> {
    let (mut places, mut at) = (Vec::new(), 0);
    for field in fields {
        for meaning in meanings(field).filter(|field| has_column(field)) {
            let of = matches!(field.kind, Kind::Depends(_)).then_some(field);
            let decimals = if let Kind::Quantity(quantity) = meaning.kind { quantity.decimals } else { 0 };
            let scale = 10_f64.powi(decimals.into());
            let name = match (meaning.key, meaning.kind) {
                // The only field of an item. Where JSON has no unit in the key, the unit is the second.
                ("", Kind::Quantity(_)) if !has_unit(name) => format!("{name}_s"),
                ("", _) => name.to_owned(),
                (key, _) => format!("{name}_{key}"),
            };
            let known = columns[from..].iter().position(|column| column.name == name);
            let column = known.map_or(columns.len(), |at| from + at);
            if known.is_none() {
                columns.push(TableColumn::new(name, kind(meaning)));
            }
            places.push(FieldPosition { column, at, field: meaning, of, scale });
        }
        at += usize::from(field.bits);
    }
    places
}

fn add_text(columns: &mut Vec<TableColumn>, name: String) -> usize {
    columns.push(TableColumn::new(name, ColumnKind::Text));
    columns.len() - 1
}

/// Whether the name has more than category and item: the key of a subfield includes the unit.
fn has_unit(name: &str) -> bool {
    name.matches('_').count() > 1
}

/// The field, or all of its possible meanings. Last is the field itself: a whole number if no meaning applies.
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

/// Sets the cells of fields from bit `at` on. Values that mean "unknown" stay null.
fn set(
    table: &mut dyn TableWriter,
    text: &mut Vec<u8>,
    places: &[FieldPosition],
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

fn cell<'a>(place: &FieldPosition, text: &'a mut Vec<u8>, octets: &[u8], at: usize) -> Option<TableCell<'a>> {
    let field = place.field;
    if kind(field) == ColumnKind::Text {
        text.clear();
        write_value(text, field, octets, at);
        return Some(TableCell::Text(unquoted(text)));
    }
    let (width, count) = (usize::from(field.bits), field.count(octets, at));
    match field.kind {
        Kind::CountOr(unknown) if count == unknown => None,
        Kind::Quantity(quantity) if quantity.unknown == Some(count) => None,
        Kind::Quantity(quantity) => {
            Some(TableCell::Quantity((quantity.value(count, width) * place.scale).round() / place.scale))
        }
        Kind::CountFrom(first) => i64::try_from(count + first).ok().map(TableCell::Count),
        _ => i64::try_from(count).ok().map(TableCell::Count),
    }
}

/// Text of a JSON value. Values that are not texts stay JSON, such as octets in place of a text.
fn unquoted(json: &[u8]) -> Cow<'_, str> {
    match json {
        [b'"', text @ .., b'"'] if !text.contains(&b'\\') => text_of(text),
        _ => serde_json::from_slice(json).map_or_else(|_| text_of(json), Cow::Owned),
    }
}

/// Converts printed text, which is ASCII. Checking that first is faster than a lossy conversion.
fn text_of(printed: &[u8]) -> Cow<'_, str> {
    str::from_utf8(printed).map_or_else(|_| String::from_utf8_lossy(printed), Cow::Borrowed)
}
