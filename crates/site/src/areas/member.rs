//! Members of a zone file, each with its path for error messages.

use std::fmt::Display;

use serde_json::Value;

/// Maximum number of characters of a value that an error message shows.
const SHOWN: usize = 60;

/// A value in a file with its path.
#[derive(Clone, Debug)]
pub(super) struct Member<'a> {
    path: String,
    value: &'a Value,
}

impl<'a> Member<'a> {
    /// The root: the file, or a zone, with paths relative to it.
    pub(super) fn top(value: &'a Value) -> Self {
        Self { path: String::new(), value }
    }

    /// The member with that name, regardless of case; `None` if it is absent or blank.
    pub(super) fn get(&self, name: &str) -> Option<Self> {
        self.members().find(|member| member.name().eq_ignore_ascii_case(name))
    }

    /// The member with that name, which is required; `understood` completes the error message.
    pub(super) fn need(&self, name: &str, understood: impl Display) -> Result<Self, String> {
        let missing = || format!("{} is missing; {understood}", joined(&self.path, name));
        self.get(name).ok_or_else(missing)
    }

    /// The members that are not blank; none if this is not an object.
    pub(super) fn members(&self) -> impl Iterator<Item = Self> {
        let members = self.value.as_object().into_iter().flatten();
        members
            .filter(|(_, value)| !is_blank(value))
            .map(|(name, value)| Self { path: joined(&self.path, name), value })
    }

    /// The entries of a list; a value that is no list is its own only entry.
    pub(super) fn entries(&self) -> Vec<Self> {
        let Value::Array(values) = self.value else { return vec![self.clone()] };
        let entry = |(index, value)| Self { path: format!("{}[{index}]", self.path), value };
        values.iter().enumerate().map(entry).collect()
    }

    /// The last part of the path.
    pub(super) fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or_default()
    }

    pub(super) fn value(&self) -> &'a Value {
        self.value
    }

    pub(super) fn is_object(&self) -> bool {
        self.value.is_object()
    }

    /// The value as text, trimmed.
    pub(super) fn text(&self) -> Result<&'a str, String> {
        self.value.as_str().map(str::trim).ok_or_else(|| self.refused("a text is understood"))
    }

    /// The value as a finite number; numbers in quotes are accepted.
    pub(super) fn number(&self) -> Result<f64, String> {
        let number = match self.value {
            Value::Number(number) => number.as_f64(),
            Value::String(text) => text.trim().parse().ok(),
            _ => None,
        };
        number.filter(|number| number.is_finite()).ok_or_else(|| self.refused("a number is understood"))
    }

    /// The error message for a value that cannot be used.
    pub(super) fn refused(&self, understood: impl Display) -> String {
        let mut shown: String = self.value.to_string();
        if shown.chars().count() > SHOWN {
            shown = shown.chars().take(SHOWN).chain("…".chars()).collect();
        }
        let path = if self.path.is_empty() { "the zone" } else { &self.path };
        format!("{path} = {shown} is not understood; {understood}")
    }

    /// Refuses any member that is not among `known`: an ignored member could be a limit.
    pub(super) fn knows_only(&self, known: &[&str]) -> Result<(), String> {
        let is_known = |member: &Self| known.iter().any(|known| member.name().eq_ignore_ascii_case(known));
        match self.members().find(|member| !is_known(member)) {
            Some(stranger) => {
                Err(stranger.refused(format_args!("understood beside it are: {}", known.join(", "))))
            }
            None => Ok(()),
        }
    }
}

fn joined(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

/// Whether a value is null or empty. Published files write such values for "no limit".
pub(super) fn is_blank(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::String(text) => text.trim().is_empty(),
        Value::Array(values) => values.iter().all(is_blank),
        Value::Object(members) => members.values().all(is_blank),
        Value::Bool(_) | Value::Number(_) => false,
    }
}
