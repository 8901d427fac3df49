//! Names of cells.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Name of a cell: 1 to 32 characters of `a-z`, `0-9` and `-`, as required for subjects and ids.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct CellName(String);

/// Maximum length of a name.
const LONGEST: usize = 32;

/// Error: a text is not a valid name of a cell.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} names no cell: take 1 to 32 of a-z, 0-9 and -")]
pub struct NotAName(String);

impl CellName {
    /// The name with this text.
    ///
    /// # Errors
    /// The text is empty, too long, or has other characters.
    pub fn new(text: &str) -> Result<Self, NotAName> {
        let is_plain = |octet: u8| matches!(octet, b'a'..=b'z' | b'0'..=b'9' | b'-');
        let is_name = (1..=LONGEST).contains(&text.len()) && text.bytes().all(is_plain);
        if is_name { Ok(Self(text.to_owned())) } else { Err(NotAName(text.to_owned())) }
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The name of a square by row and column, counted from 0 at the equator and Greenwich: `n512-e0043`, with `s` and `w` for
    /// negative ones.
    pub(super) fn of_square((row, column): (i64, i64)) -> Self {
        let side = |of: i64, signs: [char; 2]| if of < 0 { signs[0] } else { signs[1] };
        let (south, west) = (side(row, ['s', 'n']), side(column, ['w', 'e']));
        Self(format!("{south}{:03}-{west}{:04}", row.abs(), column.abs()))
    }

    /// Row and column of a square; `None`: this is not the name of one.
    pub(super) fn square(&self) -> Option<(i64, i64)> {
        let (row, column) = self.0.split_once('-')?;
        let signed = |text: &str, signs: [char; 2]| {
            let count = |rest: &str| rest.parse::<u32>().ok().map(i64::from);
            match (text.strip_prefix(signs[0]), text.strip_prefix(signs[1])) {
                (Some(rest), _) => count(rest).map(|count| -count),
                (_, Some(rest)) => count(rest),
                _ => None,
            }
        };
        let square = (signed(row, ['s', 'n'])?, signed(column, ['w', 'e'])?);
        // Other spellings of the name are not valid.
        (Self::of_square(square) == *self).then_some(square)
    }
}

impl fmt::Display for CellName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl TryFrom<String> for CellName {
    type Error = NotAName;

    fn try_from(text: String) -> Result<Self, NotAName> {
        Self::new(&text)
    }
}

impl From<CellName> for String {
    fn from(name: CellName) -> Self {
        name.0
    }
}
