//! Reads keys from the tree. A getter returns `None` for an absent key, and for a wrong one after adding an error. A table
//! that is read despite errors is discarded; reading goes on only to find further errors.

use std::fmt::Display;
use std::net::Ipv4Addr;
use std::ops::RangeInclusive;

use jiff::SignedDuration;

use crate::error::{Faults, Place};
use crate::tree::{Node, Table, Value, quoted};

/// Placeholder for a number that the generator of a configuration could not know.
pub const FILL_IN: &str = "fill in";

/// A table whose keys are read one by one. A key that was never asked for is unknown.
pub struct Section<'a> {
    key: String,
    place: &'a Place,
    entries: Option<&'a Table>,
    asked: Vec<&'static str>,
    faults: &'a Faults,
}

impl<'a> Section<'a> {
    /// The whole file.
    pub fn top(root: &'a Table, faults: &'a Faults) -> Self {
        Self { key: String::new(), place: &Place::File, entries: Some(root), asked: Vec::new(), faults }
    }

    /// The value of a key, if it is given.
    pub fn item(&mut self, name: &'static str) -> Option<Item<'a>> {
        self.asked.push(name);
        self.written(name)
    }

    /// The value of a key, if it is given; this does not count as asking for the key.
    pub fn written(&self, name: &str) -> Option<Item<'a>> {
        let node = self.entries?.get(name)?;
        Some(Item { key: join(&self.key, name), node, faults: self.faults })
    }

    /// The path of the table.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Whether none of the keys has an error, so that they can be compared.
    pub fn is_sound(&self, names: &[&str]) -> bool {
        names.iter().all(|name| self.faults.none_of(&join(&self.key, name)))
    }

    /// Adds an error about keys that contradict each other, at the first of them that is given. Does nothing if one of them has
    /// an error of its own.
    pub fn contradict(&self, names: &[&str], message: impl Display) {
        if let (true, Some(item)) = (self.is_sound(names), names.iter().find_map(|name| self.written(name))) {
            item.refuse(message);
        }
    }

    /// The value of a key that does not belong here, if it is given; it is not listed among the expected keys.
    pub fn stray(&mut self, name: &'static str) -> Option<Item<'a>> {
        self.entries?.contains_key(name).then(|| self.item(name)).flatten()
    }

    /// The value of a required key; `meaning` says what to write.
    pub fn need(&mut self, name: &'static str, meaning: &str) -> Option<Item<'a>> {
        let item = self.item(name);
        // A missing or broken section has already been reported as a whole.
        if item.is_none() && self.entries.is_some() {
            let message = format!("this key is missing; add {meaning}");
            self.faults.add(self.place, &join(&self.key, name), None, message);
        }
        item
    }

    /// The table with that name; without entries if it is absent.
    pub fn section(&mut self, name: &'static str) -> Self {
        let item = self.item(name);
        self.open(name, item)
    }

    /// The table with that name, which is required; `meaning` says what to write.
    pub fn need_section(&mut self, name: &'static str, meaning: &str) -> Self {
        let item = self.need(name, meaning);
        self.open(name, item)
    }

    fn open(&self, name: &str, item: Option<Item<'a>>) -> Self {
        item.and_then(|item| item.section()).unwrap_or_else(|| Self {
            key: join(&self.key, name),
            place: self.place,
            entries: None,
            asked: Vec::new(),
            faults: self.faults,
        })
    }

    /// Every key with its value, for a table whose keys are chosen by the user.
    pub fn all(&self) -> impl Iterator<Item = (&'a str, Item<'a>)> {
        self.entries.into_iter().flatten().map(|(name, node)| {
            let item = Item { key: join(&self.key, name), node, faults: self.faults };
            (name.as_str(), item)
        })
    }

    /// Adds an error about the table as a whole.
    pub fn refuse(&self, message: impl Display) {
        self.faults.add(self.place, &self.key, None, message);
    }

    /// Counts every key as asked for: the meaning of this table is unknown, so no key can be called wrong.
    pub fn abandon(&mut self) {
        self.entries = None;
    }

    /// Refuses the keys that were not asked for.
    pub fn finish(self) {
        for (name, item) in self.all().filter(|(name, _)| !self.asked.contains(name)) {
            let near = self.asked.iter().find(|known| is_near(known, name));
            let near = near.map_or_else(String::new, |known| format!("did you mean {known}? "));
            let expected = self.asked.join(", ");
            item.faults.add(
                &item.node.place,
                &item.key,
                None,
                format!("this key is unknown; {near}expected here: {expected}"),
            );
        }
    }
}

/// A value, with its place and the path of its key.
#[derive(Clone)]
pub struct Item<'a> {
    key: String,
    node: &'a Node,
    faults: &'a Faults,
}

impl<'a> Item<'a> {
    /// Adds an error about the value.
    pub fn refuse(&self, message: impl Display) {
        self.faults.add(&self.node.place, &self.key, self.node.value.shown(), message);
    }

    /// Adds an error about the value without showing the value: it may be a secret.
    pub fn refuse_secret(&self, message: impl Display) {
        self.faults.add(&self.node.place, &self.key, None, message);
    }

    fn expected(&self, what: &str) {
        self.refuse(format!("expected {what}, found {}", self.node.value.kind()));
    }

    /// Whether the value is still the placeholder [`FILL_IN`]; if so, adds an error. `rule` describes the valid values.
    fn is_to_be_filled_in(&self, rule: &str) -> bool {
        let is_open = matches!(&self.node.value, Value::Text(text) if text == FILL_IN);
        if is_open {
            self.refuse(format!("this is still to be filled in; {rule}"));
        }
        is_open
    }

    /// A finite number that is `valid`; `rule` describes the valid numbers.
    pub fn number(&self, rule: &str, valid: impl Fn(f64) -> bool) -> Option<f64> {
        let number = match self.node.value {
            Value::Number(number) => number,
            Value::Whole(whole) => whole as f64,
            _ if self.is_to_be_filled_in(rule) => return None,
            _ => {
                self.expected("a number without quotes, such as 0.25");
                return None;
            }
        };
        let good = number.is_finite() && valid(number);
        if !good {
            self.refuse(rule);
        }
        good.then_some(number)
    }

    /// A duration of at most a day, in seconds, that is `valid`; rounded to nanoseconds.
    pub fn seconds(&self, rule: &str, valid: impl Fn(f64) -> bool) -> Option<SignedDuration> {
        let nanos = |seconds: f64| (seconds * 1e9).round();
        let seconds = self.number(rule, |s| (0.0..=86_400.0).contains(&s) && valid(nanos(s) / 1e9))?;
        Some(SignedDuration::from_nanos(nanos(seconds) as i64))
    }

    /// A duration of at most a day; adds no error if the value is none.
    pub fn any_seconds(&self) -> Option<SignedDuration> {
        let seconds = match self.node.value {
            Value::Number(number) => number,
            Value::Whole(whole) => whole as f64,
            _ => return None,
        };
        (0.0..=86_400.0)
            .contains(&seconds)
            .then(|| SignedDuration::from_nanos((seconds * 1e9).round() as i64))
    }

    /// A whole number in `range`; `rule` describes the range.
    pub fn whole<T>(&self, range: RangeInclusive<T>, rule: &str) -> Option<T>
    where
        T: TryFrom<i64> + PartialOrd,
    {
        let whole = match self.node.value {
            Value::Whole(whole) => T::try_from(whole).ok().filter(|whole| range.contains(whole)),
            Value::Number(_) => None,
            _ if self.is_to_be_filled_in(rule) => return None,
            _ => {
                self.expected("a whole number without quotes");
                return None;
            }
        };
        if whole.is_none() {
            self.refuse(rule);
        }
        whole
    }

    /// Text that is not blank.
    pub fn text(&self) -> Option<&'a str> {
        let Value::Text(text) = &self.node.value else {
            self.expected("text in quotes");
            return None;
        };
        if text.trim().is_empty() {
            self.refuse("this is blank; write what it should be, or remove the key");
            return None;
        }
        Some(text)
    }

    /// `true` or `false`.
    pub fn flag(&self) -> Option<bool> {
        let Value::Flag(flag) = self.node.value else {
            self.expected("true or false, without quotes");
            return None;
        };
        Some(flag)
    }

    /// An IPv4 address.
    pub fn ipv4(&self) -> Option<Ipv4Addr> {
        let address = self.text()?.parse().ok();
        if address.is_none() {
            self.refuse("expected an IPv4 address, such as \"127.0.0.1\"; names are not looked up");
        }
        address
    }

    /// The entries of a list.
    pub fn list(&self) -> Option<Vec<Self>> {
        let Value::List(list) = &self.node.value else {
            self.expected("a list, such as [ … ]");
            return None;
        };
        let entry = |(i, node)| Self { key: format!("{}[{i}]", self.key), node, faults: self.faults };
        Some(list.iter().enumerate().map(entry).collect())
    }

    /// The value as a table.
    pub fn section(&self) -> Option<Section<'a>> {
        let Value::Table(entries) = &self.node.value else {
            self.expected("a table, such as { key = value }");
            return None;
        };
        Some(Section {
            key: self.key.clone(),
            place: &self.node.place,
            entries: Some(entries),
            asked: Vec::new(),
            faults: self.faults,
        })
    }

    /// The path of the configuration file.
    pub fn file(&self) -> &'a str {
        self.faults.file()
    }
}

fn join(path: &str, name: &str) -> String {
    let bare = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    let name = if bare && !name.is_empty() { name.to_owned() } else { quoted(name) };
    if path.is_empty() { name } else { format!("{path}.{name}") }
}

/// Whether `written` may be meant as `known`: the unit is missing, or at most two characters differ.
fn is_near(known: &str, written: &str) -> bool {
    // The distance costs the product of the lengths, and a file may hold very long keys.
    let comparable = written.len() >= 3 && written.len() <= known.len() + 2;
    comparable && (known.starts_with(written) || edits(known, written) <= 2)
}

/// Number of characters to insert, remove or change (Levenshtein distance), one row of the matrix at a time.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let change = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
