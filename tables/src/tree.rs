//! The file as a tree of values, each with the place where it was written.

use std::collections::BTreeMap;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Faults, Place};

/// A value and where it was written.
#[derive(Clone, Debug)]
pub struct Node {
    /// Where it was written.
    pub place: Place,
    /// What was written.
    pub value: Value,
}

/// The tables of the tree: the line of a key is that of its name.
pub type Table = BTreeMap<String, Node>;

/// A TOML value.
#[derive(Clone, Debug)]
pub enum Value {
    /// Keys with their values.
    Table(Table),
    /// Values one after the other.
    List(Vec<Node>),
    /// Text in quotes.
    Text(String),
    /// A whole number without quotes.
    Whole(i64),
    /// A number with a fraction; one beyond 64 bits is infinite.
    Number(f64),
    /// True or false.
    Flag(bool),
    /// A date or time, as it was written.
    Date(String),
}

/// Lines with a syntax error that are shown: one bracket left open breaks every line behind it.
const SYNTAX_ERRORS_SHOWN: usize = 3;

/// The tree of `text`; incomplete where `faults` got something.
pub fn parse(text: &str, faults: &Faults) -> Table {
    let lines = Lines::of(text);
    let (root, mut errors) = DeTable::parse_recoverable(text);
    // The recovery stumbles several times over one mistake: the first of a line tells.
    errors.sort_by_key(|error| error.span().map(|span| span.start));
    let place = |error: &toml::de::Error| error.span().map_or(Place::File, |span| lines.place(span.start));
    errors.dedup_by_key(|error| place(error));
    for error in errors.iter().take(SYNTAX_ERRORS_SHOWN) {
        faults.add(&place(error), "", None, format!("this is not TOML: {}", error.message()));
    }
    if faults.any() { Table::new() } else { table(root.get_ref(), &|at| lines.place(at)) }
}

/// The value of a variable: TOML where it is, else text.
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
        // One beyond 64 bits is beyond every range that is asked for.
        DeValue::Integer(whole) => i128::from_str_radix(whole.as_str(), whole.radix())
            .map_or(Value::Number(f64::INFINITY), |whole| {
                i64::try_from(whole).map_or(Value::Number(whole as f64), Value::Whole)
            }),
        DeValue::Float(number) => number.as_str().parse().map_or(Value::Number(f64::NAN), Value::Number),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(date) => Value::Date(date.to_string()),
    }
}

/// Where the lines of a text begin.
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
    /// What it is, for "found …".
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

    /// TOML where that is short; a table never is. A text with an `@` is not shown: an address may have a
    /// password before it.
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
