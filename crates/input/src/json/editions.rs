//! Edition of a category, and the decoder for it: the typed record, or the layouts of its definition.

use std::collections::BTreeMap;

use asterix::all::{self, Definition, UnknownEdition};
use asterix::{Record, cat021, profile};

/// Decoder of a category's records.
#[derive(Clone, Copy, Debug)]
pub enum Reading {
    /// Typed record of the category.
    Typed,
    /// Typed record of CAT021, in this edition.
    Cat021(cat021::Edition),
    /// Layouts of an edition without a typed record.
    Untyped(&'static Definition),
    /// None, because the category has no public definition.
    Unknown,
}

/// Reason why an edition cannot be selected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditionError {
    /// The category has no public definition.
    #[error("category {0} has no public definition, and so no editions")]
    Category(u8),
    /// The category has other editions.
    #[error(transparent)]
    Edition(#[from] UnknownEdition),
}

impl Reading {
    /// Decoder of an edition named as in [`all::Category::edition`]. An edition with a typed record uses it, unless `untyped` is
    /// set.
    ///
    /// # Errors
    /// The edition does not exist.
    pub fn named(category: u8, edition: &str, untyped: bool) -> Result<Self, EditionError> {
        if category == cat021::Record::CATEGORY
            && !untyped
            && let Ok(edition) = edition.parse()
        {
            return Ok(Self::Cat021(edition));
        }
        let category = all::category(category).ok_or(EditionError::Category(category))?;
        let definition = category.edition(edition)?;
        // Typed records are of the newest editions.
        let is_typed = profile(category.number()).is_some() && definition.name() == category.newest().name();
        Ok(if is_typed && !untyped { Self::Typed } else { Self::Untyped(definition) })
    }

    /// Default decoder of a category.
    fn usual(category: u8, untyped: bool) -> Self {
        match category {
            cat021::Record::CATEGORY if untyped => {
                let usual = cat021::Edition::default();
                Self::named(category, usual.name(), true).unwrap_or(Self::Cat021(usual))
            }
            _ if untyped => {
                all::category(category).map_or(Self::Unknown, |category| Self::Untyped(category.newest()))
            }
            cat021::Record::CATEGORY => Self::Cat021(cat021::Edition::default()),
            _ if profile(category).is_some() => Self::Typed,
            _ => all::category(category).map_or(Self::Unknown, |category| Self::Untyped(category.newest())),
        }
    }
}

/// Selected editions. Other categories use the edition of the typed record, or the newest.
#[derive(Clone, Debug, Default)]
pub struct Editions {
    chosen: BTreeMap<u8, Reading>,
    untyped: bool,
}

impl Editions {
    /// No selected edition. All categories are decoded by their definitions, even those with a typed record.
    pub fn untyped() -> Self {
        Self { untyped: true, ..Self::default() }
    }

    /// Selects an edition.
    ///
    /// # Errors
    /// The edition does not exist.
    pub fn choose(&mut self, category: u8, edition: &str) -> Result<(), EditionError> {
        self.chosen.insert(category, Reading::named(category, edition, self.untyped)?);
        Ok(())
    }

    /// Decoder of a category's records.
    pub fn of(&self, category: u8) -> Reading {
        self.chosen.get(&category).copied().unwrap_or_else(|| Reading::usual(category, self.untyped))
    }
}

impl From<cat021::Edition> for Editions {
    fn from(edition: cat021::Edition) -> Self {
        let chosen = BTreeMap::from([(cat021::Record::CATEGORY, Reading::Cat021(edition))]);
        Self { chosen, untyped: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(reading: Reading) -> String {
        match reading {
            Reading::Typed => "typed".to_owned(),
            Reading::Cat021(edition) => format!("typed {edition}"),
            Reading::Untyped(definition) => format!("untyped {}", definition.name()),
            Reading::Unknown => "unknown".to_owned(),
        }
    }

    #[test]
    fn edition_with_a_type_is_read_as_that_type() {
        for (category, edition, expected) in [
            (48, "1.32", "typed"),
            (48, "1.31", "untyped 1.31"),
            (48, "1.32/1.13", "typed"),
            (48, "1.32/1.12", "untyped 1.32/1.12"),
            (21, "2.1", "typed 2.1"),
            (21, "0.26", "untyped 0.26"),
            (21, "2.7/1.4", "untyped 2.7/1.4"),
            (62, "1.20", "untyped 1.20"),
            (129, "1.2", "typed"),
            (10, "1.1", "untyped 1.1"),
        ] {
            assert_eq!(described(Reading::named(category, edition, false).unwrap()), expected);
        }
        let usual = |category| described(Editions::default().of(category));
        assert_eq!(
            [21, 48, 129, 10, 20, 61].map(usual),
            ["typed 2.6", "typed", "typed", "untyped 1.1", "untyped 1.11", "unknown"]
        );
        let untyped = |category| described(Editions::untyped().of(category));
        assert_eq!([21, 48, 129, 61].map(untyped), ["untyped 2.6", "untyped 1.32", "untyped 1.2", "unknown"]);
        // Every typed record but that of CAT021 is of the newest defined edition.
        for (category, edition) in
            [(15, "1.2"), (34, "1.29"), (48, "1.32"), (62, "1.21"), (63, "1.7"), (65, "1.6"), (129, "1.2")]
        {
            assert_eq!(all::category(category).unwrap().newest().edition(), edition);
        }
    }

    #[test]
    fn unknown_edition_is_not_chosen() {
        let mut editions = Editions::default();
        assert_eq!(editions.choose(61, "1.0"), Err(EditionError::Category(61)));
        let error = editions.choose(21, "2.8").unwrap_err().to_string();
        assert!(
            error.starts_with("\"2.8\" is no edition of CAT021 that is known; known are 0.23, "),
            "{error}"
        );
        assert_eq!(described(editions.of(21)), "typed 2.6");
        editions.choose(20, "1.9").unwrap();
        assert_eq!(described(editions.of(20)), "untyped 1.9");
    }
}
