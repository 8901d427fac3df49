//! `--edition`: the edition of a category that the senders use.

use std::str::FromStr;

use asterix::{Record, cat021};

use super::Usage;
use input::json::Editions;

/// `1.31`, or `48:1.31` if no other argument names the category.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EditionOf {
    category: Option<u8>,
    edition: String,
}

impl FromStr for EditionOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((category, edition)) = text.split_once(':') else {
            return Ok(Self { category: None, edition: text.to_owned() });
        };
        match category.parse() {
            Ok(category) => Ok(Self { category: Some(category), edition: edition.to_owned() }),
            Err(_) => Err(format!("{category:?} is no category: 48:1.31 is edition 1.31 of CAT048")),
        }
    }
}

/// Adds the given editions to `editions`. An edition without a category is of `category`, or else of CAT021.
///
/// # Errors
/// An edition does not exist.
pub fn editions(
    mut editions: Editions,
    given: &[EditionOf],
    category: Option<u8>,
) -> Result<Editions, Usage> {
    for EditionOf { category: named, edition } in given {
        let category = named.or(category).unwrap_or(cat021::Record::CATEGORY);
        editions.choose(category, edition).map_err(|error| Usage(format!("--edition: {error}")))?;
    }
    Ok(editions)
}
