//! Parsed JSON as one flat list: each value is followed by its content. serde_json parses it; a tree of maps would cost several
//! times as much.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

/// A value, with the length of its content in the list.
#[derive(Debug)]
pub(super) struct Node<'a> {
    /// Key of a member of an object; empty for other values.
    key: Cow<'a, str>,
    kind: Kind<'a>,
    /// Number of nodes of this value, including its content.
    length: usize,
}

#[derive(Debug)]
enum Kind<'a> {
    Null,
    Bool(bool),
    Whole(u64),
    Negative(i64),
    Decimal(f64),
    Text(Cow<'a, str>),
    /// Array with this number of elements.
    Array(usize),
    /// Object with this number of members.
    Object(usize),
}

/// An empty list that reuses the memory of `nodes`, so that lines need no allocation.
pub(super) fn emptied<'a>(mut nodes: Vec<Node<'_>>) -> Vec<Node<'a>> {
    nodes.clear();
    // The standard library collects into the vector that it consumes.
    nodes.into_iter().map_while(|_| None).collect()
}

/// A value in the list.
#[derive(Clone, Copy, Debug)]
pub(super) struct Value<'a>(&'a [Node<'a>]);

impl<'a> Value<'a> {
    /// Value at index `place`.
    pub fn at(nodes: &'a [Node<'a>], place: usize) -> Self {
        Self(&nodes[place..place + nodes[place].length])
    }

    fn kind(self) -> &'a Kind<'a> {
        &self.0[0].kind
    }

    pub fn is_null(self) -> bool {
        matches!(self.kind(), Kind::Null)
    }

    pub fn as_str(self) -> Option<&'a str> {
        match self.kind() {
            Kind::Text(text) => Some(text),
            _ => None,
        }
    }

    /// A non-negative whole number.
    pub fn as_u64(self) -> Option<u64> {
        match *self.kind() {
            Kind::Whole(number) => Some(number),
            _ => None,
        }
    }

    /// Any number.
    pub fn as_f64(self) -> Option<f64> {
        match *self.kind() {
            Kind::Whole(number) => Some(number as f64),
            Kind::Negative(number) => Some(number as f64),
            Kind::Decimal(number) => Some(number),
            _ => None,
        }
    }

    /// Number of elements of an array, and the elements.
    pub fn as_array(self) -> Option<(usize, impl Iterator<Item = Self>)> {
        match *self.kind() {
            Kind::Array(count) => Some((count, siblings(&self.0[1..]).map(|(_, element)| element))),
            _ => None,
        }
    }

    pub fn as_object(self) -> Option<Object<'a>> {
        match *self.kind() {
            Kind::Object(length) => Some(Object { members: &self.0[1..], length, next: 0, passed: false }),
            _ => None,
        }
    }
}

/// Writes JSON; an array or an object without its content.
impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = match self.kind() {
            Kind::Null => serde_json::Value::Null,
            Kind::Bool(bool) => (*bool).into(),
            Kind::Whole(number) => (*number).into(),
            Kind::Negative(number) => (*number).into(),
            Kind::Decimal(number) => (*number).into(),
            Kind::Text(text) => (&**text).into(),
            Kind::Array(_) => return f.write_str("an array"),
            Kind::Object(_) => return f.write_str("an object"),
        };
        value.fmt(f)
    }
}

/// Consecutive values, with their keys.
fn siblings<'a>(mut nodes: &'a [Node<'a>]) -> impl Iterator<Item = (&'a str, Value<'a>)> {
    std::iter::from_fn(move || {
        let first = nodes.first()?;
        let (value, rest) = nodes.split_at(first.length);
        nodes = rest;
        Some((&*first.key, Value(value)))
    })
}

/// Members of an object. Looking them up in their own order is fast.
#[derive(Clone, Debug)]
pub(super) struct Object<'a> {
    members: &'a [Node<'a>],
    length: usize,
    /// Index after the member found last.
    next: usize,
    /// Whether an earlier member was skipped.
    passed: bool,
}

impl<'a> Object<'a> {
    /// Number of members.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Members with their keys.
    pub fn iter(&self) -> impl Iterator<Item = (&'a str, Value<'a>)> + use<'a> {
        siblings(self.members)
    }

    #[inline]
    pub fn get(&mut self, key: &str) -> Option<Value<'a>> {
        match self.members.get(self.next) {
            Some(node) if node.key == key => Some(self.found(self.next)),
            _ => self.search(key),
        }
    }

    #[inline(never)]
    fn search(&mut self, key: &str) -> Option<Value<'a>> {
        let place = match self.find(key, self.next, self.members.len()) {
            Some(place) => place,
            None if self.passed => self.find(key, 0, self.next)?,
            None => return None,
        };
        self.passed |= place != self.next;
        Some(self.found(place))
    }

    #[inline]
    fn found(&mut self, place: usize) -> Value<'a> {
        let value = Value::at(self.members, place);
        self.next = place + value.0.len();
        value
    }

    pub fn has(&self, key: &str) -> bool {
        self.find(key, 0, self.members.len()).is_some()
    }

    /// A key that occurs twice.
    pub fn twice(&self) -> Option<&'a str> {
        let mut keys: Vec<_> = self.iter().map(|(key, _)| key).collect();
        keys.sort_unstable();
        keys.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
    }

    fn find(&self, key: &str, from: usize, to: usize) -> Option<usize> {
        let mut place = from;
        while place < to {
            let node = &self.members[place];
            if node.key == key {
                return Some(place);
            }
            place += node.length;
        }
        None
    }
}

/// A key of an object, borrowed unless it has escapes.
pub(super) struct Key<'a>(pub Cow<'a, str>);

impl<'de> Deserialize<'de> for Key<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;

        impl<'de> Visitor<'de> for Text {
            type Value = Key<'de>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a string")
            }

            fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Key<'de>, E> {
                Ok(Key(Cow::Borrowed(text)))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Key<'de>, E> {
                Ok(Key(Cow::Owned(text.to_owned())))
            }
        }

        deserializer.deserialize_str(Text)
    }
}

/// Appends a parsed value with this key.
pub(super) struct Append<'n, 'a> {
    pub nodes: &'n mut Vec<Node<'a>>,
    pub key: Cow<'a, str>,
}

impl<'a> Append<'_, 'a> {
    fn push<E>(self, kind: Kind<'a>) -> Result<(), E> {
        self.nodes.push(Node { key: self.key, kind, length: 1 });
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Append<'_, 'de> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Append<'_, 'de> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any valid JSON value")
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.push(Kind::Null)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        self.push(Kind::Bool(value))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<(), E> {
        self.push(Kind::Whole(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<(), E> {
        self.push(Kind::Negative(number))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<(), E> {
        self.push(Kind::Decimal(number))
    }

    fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<(), E> {
        self.push(Kind::Text(Cow::Borrowed(text)))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        self.push(Kind::Text(Cow::Owned(text.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let Self { nodes, key } = self;
        let (place, mut count) = (nodes.len(), 0);
        nodes.push(Node { key, kind: Kind::Array(0), length: 1 });
        while elements.next_element_seed(Append { nodes: &mut *nodes, key: Cow::Borrowed("") })?.is_some() {
            count += 1;
        }
        nodes[place].kind = Kind::Array(count);
        nodes[place].length = nodes.len() - place;
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        let Self { nodes, key } = self;
        let (place, mut count) = (nodes.len(), 0);
        nodes.push(Node { key, kind: Kind::Object(0), length: 1 });
        while let Some(Key(key)) = members.next_key()? {
            members.next_value_seed(Append { nodes: &mut *nodes, key })?;
            count += 1;
        }
        nodes[place].kind = Kind::Object(count);
        nodes[place].length = nodes.len() - place;
        Ok(())
    }
}
