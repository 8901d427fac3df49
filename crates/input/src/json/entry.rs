//! A decoded record of any category.

use asterix::all::{Definition, Untyped};
use asterix::{DataSource, Record, UapItem, items};

use super::{Named, Place, Reading, dated};
use fusion::time::Time;

/// A record with its octets.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// Time of the record; `None` if its time of day or the day is unknown.
    pub time: Option<Time>,
    /// Position in the file.
    pub place: Place<'a>,
    /// Category of the record.
    pub category: u8,
    /// Source of the record.
    pub source: Option<DataSource>,
    /// Edition, if [`Encoder`](super::Encoder) would assume another one.
    pub edition: Option<&'static str>,
    /// Whether [`Encoder`](super::Encoder) would wrongly assume a typed record.
    pub untyped: bool,
    /// All items that a record of this category and edition may have.
    pub all: &'static [UapItem],
    /// All octets, from the FSPEC on.
    pub octets: &'a [u8],
    profile: &'static [UapItem],
}

impl<'a> Entry<'a> {
    /// Entry of a typed record with these octets, received at `received`.
    pub fn typed<R: Record<Edition: Named>>(
        record: &R,
        edition: R::Edition,
        octets: &'a [u8],
        place: Place<'a>,
        received: Option<Time>,
    ) -> Self {
        let profile = R::profile(edition).items();
        Self {
            time: dated(record.time_of_day(), received),
            place,
            category: R::CATEGORY,
            source: record.data_source(),
            edition: edition.name(),
            untyped: false,
            all: profile,
            octets,
            profile,
        }
    }

    /// Entry of an untyped record, whose edition is always stated. `untyped` is the result of [`needs_untyped`] for its
    /// definition.
    pub fn untyped(record: &Untyped<'a>, untyped: bool, place: Place<'a>, received: Option<Time>) -> Self {
        let definition = record.definition();
        Self {
            time: dated(record.time_of_day(), received),
            place,
            category: definition.category(),
            source: record.data_source(),
            edition: Some(definition.name()),
            untyped,
            all: definition.items(),
            octets: record.octets(),
            profile: record.profile(),
        }
    }

    /// Items of the record, each with its octets.
    pub fn items(&self) -> impl Iterator<Item = (&'static UapItem, &'a [u8])> + use<'a> {
        items(self.profile, self.octets)
    }
}

/// Whether a line has to state that records of this definition were read without a type.
pub fn needs_untyped(definition: &Definition) -> bool {
    !matches!(Reading::named(definition.category(), definition.name(), false), Ok(Reading::Untyped(_)))
}
