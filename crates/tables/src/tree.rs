//! The file as a tree of values, each with its place in the file.

use std::collections::BTreeMap;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Faults, Place};

/// A value with its place.
#[derive(Clone, Debug)]
pub struct Node {
    /// The place where it is written.
    pub place: Place,
    /// The value.
    pub value: Value,
}

/// A table of the tree; the place of an entry is the line of its key.
pub type Table = BTreeMap<String, Node>;

/// A TOML value.
#[derive(Clone, Debug)]
pub enum Value {
    /// Keys with their values.
    Table(Table),
    /// A list of values.
    List(Vec<Node>),
    /// Text in quotes.
    Text(String),
    /// A whole number without quotes.
    Whole(i64),
    /// A number with a fraction; integers beyond 64 bits become infinite.
    Number(f64),
    /// `true` or `false`.
    Flag(bool),
    /// A date or time, as it is written.
    Date(String),
}

/// Maximum number of syntax errors shown: one open bracket breaks every line after it.
const SYNTAX_ERRORS_SHOWN: usize = 3;

/// Parses `text`. The tree is empty if there are syntax errors, which are added to `faults`.
pub fn parse(text: &str, faults: &Faults) -> Table {
    let lines = Lines::of(text);
    let (root, mut errors) = DeTable::parse_recoverable(text);
    // The recovering parser reports one mistake several times: only the first error of a line is kept.
    errors.sort_by_key(|error| error.span().map(|span| span.start));
    let place = |error: &toml::de::Error| error.span().map_or(Place::File, |span| lines.place(span.start));
    errors.dedup_by_key(|error| place(error));
    for error in errors.iter().take(SYNTAX_ERRORS_SHOWN) {
        faults.add(&place(error), "", None, format!("this is not TOML: {}", error.message()));
    }
    if faults.any() { Table::new() } else { table(root.get_ref(), &|at| lines.place(at)) }
}

/// Parses the value of a variable: as TOML if possible, otherwise as text.
pub fn parse_variable(name: &str, text: &str) -> Node {
    let place = || Place::Variable(name.to_owned());
    match DeValue::parse(text.trim()) {
        Ok(read) => Node { place: place(), value: value(read.get_ref(), &|_| place()) },
        Err(_) => Node { place: place(), value: Value::Text(text.to_owned()) },
    }
}

fn table(entries: &DeTable<'_>, place: &dyn Fn(usize) -> Place) -> Table {
    entries
        .iter()
        .map(|(key, entry)| {
            let node = Node { place: place(key.span().start), value: value(entry.get_ref(), place) };
            (key.get_ref().to_string(), node)
        })
        .collect()
}

fn value(read: &DeValue<'_>, place: &dyn Fn(usize) -> Place) -> Value {
    match read {
        DeValue::Table(entries) => Value::Table(table(entries, place)),
        DeValue::Array(list) => {
            let node = |entry: &Spanned<DeValue<'_>>| Node {
                place: place(entry.span().start),
                value: value(entry.get_ref(), place),
            };
            Value::List(list.iter().map(node).collect())
        }
        DeValue::String(text) => Value::Text(text.to_string()),
        // An integer beyond 64 bits becomes infinite, which is outside every range.
        DeValue::Integer(whole) => i128::from_str_radix(whole.as_str(), whole.radix())
            .map_or(Value::Number(f64::INFINITY), |whole| {
                i64::try_from(whole).map_or(Value::Number(whole as f64), Value::Whole)
            }),
        DeValue::Float(number) => number.as_str().parse().map_or(Value::Number(f64::NAN), Value::Number),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(date) => Value::Date(date.to_string()),
    }
}

/// Offsets at which the lines of a text begin, without the first line.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(text.match_indices('\n').map(|(at, _)| at + 1).collect())
    }

    fn place(&self, offset: usize) -> Place {
        Place::Line(1 + self.0.partition_point(|&start| start <= offset))
    }
}

impl Value {
    /// The kind of the value, for "found …".
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Table(_) => "a table",
            Self::List(_) => "a list",
            Self::Text(_) => "text",
            Self::Whole(_) => "a whole number",
            Self::Number(_) => "a number with a fraction",
            Self::Flag(_) => "true or false",
            Self::Date(_) => "a date or time",
        }
    }

    /// The value as TOML, if that is short. Tables are never shown, nor is text with an `@`: an address may contain a password.
    pub fn shown(&self) -> Option<String> {
        const LONGEST: usize = 60;
        let shown = match self {
            Self::Table(_) => return None,
            Self::List(list) => {
                let parts: Option<Vec<_>> = list.iter().map(|node| node.value.shown()).collect();
                format!("[{}]", parts?.join(", "))
            }
            Self::Text(text) if text.contains('@') => return None,
            Self::Text(text) => quoted(text),
            Self::Whole(whole) => whole.to_string(),
            Self::Number(number) => format!("{number:?}"),
            Self::Flag(flag) => flag.to_string(),
            Self::Date(date) => date.clone(),
        };
        (shown.chars().count() <= LONGEST).then_some(shown)
    }
}

/// `text` as a TOML string on one line.
pub fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push_str(&format!("\\u{:04X}", u32::from(c))),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
