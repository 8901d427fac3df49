//! A line of `decode`, with the members needed for encoding.

use std::borrow::Cow;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, Visitor};

use super::parsed::{Append, Key, Node, Object, Value};

/// A line. Its values are in the list into which it was read.
#[derive(Debug, Default)]
pub(super) struct Line {
    pub is_error: bool,
    pub input: Option<String>,
    pub offset: Option<u64>,
    pub block: Option<u64>,
    pub category: Option<u8>,
    pub edition: Option<String>,
    pub untyped: bool,
    fspec: Option<usize>,
    items: Option<usize>,
    hex: Option<usize>,
}

impl Line {
    /// Parses a line, and appends its values to `nodes`.
    pub fn read<'a>(line: &'a str, nodes: &mut Vec<Node<'a>>) -> Result<Self, serde_json::Error> {
        let mut reader = serde_json::Deserializer::from_str(line);
        let line = Members { nodes }.deserialize(&mut reader)?;
        reader.end()?;
        Ok(line)
    }

    pub fn fspec<'a>(&self, nodes: &'a [Node<'a>]) -> Option<Value<'a>> {
        self.fspec.map(|place| Value::at(nodes, place)).filter(|value| !value.is_null())
    }

    pub fn items<'a>(&self, nodes: &'a [Node<'a>]) -> Option<Object<'a>> {
        self.items.and_then(|place| Value::at(nodes, place).as_object())
    }

    pub fn hex<'a>(&self, nodes: &'a [Node<'a>]) -> Option<Value<'a>> {
        self.hex.map(|place| Value::at(nodes, place)).filter(|value| !value.is_null())
    }
}

struct Members<'n, 'a> {
    nodes: &'n mut Vec<Node<'a>>,
}

impl<'de> DeserializeSeed<'de> for Members<'_, 'de> {
    type Value = Line;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Line, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Members<'_, 'de> {
    type Value = Line;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("struct Line")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Line, A::Error> {
        let nodes = self.nodes;
        let (mut line, mut seen) = (Line::default(), 0_u16);
        while let Some(Key(key)) = members.next_key()? {
            let Some(place) = KEYS.iter().position(|known| *known == key) else {
                members.next_value::<IgnoredAny>()?;
                continue;
            };
            if seen >> place & 1 == 1 {
                return Err(Error::duplicate_field(KEYS[place]));
            }
            seen |= 1 << place;
            let at = nodes.len();
            match KEYS[place] {
                "error" => line.is_error = members.next_value::<Option<IgnoredAny>>()?.is_some(),
                "input" => line.input = members.next_value()?,
                "offset" => line.offset = members.next_value()?,
                "block" => line.block = members.next_value()?,
                "cat" => line.category = members.next_value()?,
                "edition" => line.edition = members.next_value()?,
                "untyped" => line.untyped = members.next_value()?,
                "items" => {
                    members.next_value_seed(Items { nodes: &mut *nodes })?;
                    line.items = (nodes.len() > at).then_some(at);
                }
                known => {
                    members.next_value_seed(Append { nodes: &mut *nodes, key: Cow::Borrowed("") })?;
                    *if known == "hex" { &mut line.hex } else { &mut line.fspec } = Some(at);
                }
            }
        }
        Ok(line)
    }
}

/// Members that are used, each at most once.
const KEYS: [&str; 10] =
    ["error", "input", "offset", "block", "cat", "edition", "untyped", "fspec", "items", "hex"];

/// An object or null, whose values are not appended.
struct Items<'n, 'a> {
    nodes: &'n mut Vec<Node<'a>>,
}

impl<'de> DeserializeSeed<'de> for Items<'_, 'de> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_option(self)
    }
}

impl<'de> Visitor<'de> for Items<'_, 'de> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_none<E: Error>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, members: A) -> Result<(), A::Error> {
        Append { nodes: self.nodes, key: Cow::Borrowed("") }.visit_map(members)
    }
}
