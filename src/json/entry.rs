//! A record that was found, whatever its category.

use asterix::all::{Definition, Untyped};
use asterix::{DataSource, Record, UapItem, items};

use super::{Named, Place, Reading, dated};
use fusion::time::Time;

/// A record as its octets say it.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// When it was made; `None` where its time of day or the day is not known.
    pub time: Option<Time>,
    /// Where it stands.
    pub place: Place<'a>,
    /// Its category.
    pub category: u8,
    /// Who reports.
    pub source: Option<DataSource>,
    /// Its edition, where [`Encoder`](super::Encoder) would take it for another.
    pub edition: Option<&'static str>,
    /// Whether [`Encoder`](super::Encoder) would take it for one with a type.
    pub untyped: bool,
    /// Every item that a record of its category and edition may have.
    pub all: &'static [UapItem],
    /// All octets, from its FSPEC on.
    pub octets: &'a [u8],
    profile: &'static [UapItem],
}

impl<'a> Entry<'a> {
    /// Of a record with these octets, received at `received`.
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

    /// Of a record without a type, whose edition is always said; `untyped` is what [`needs_untyped`] says of its definition.
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

    /// Its items, each with its own octets.
    pub fn items(&self) -> impl Iterator<Item = (&'static UapItem, &'a [u8])> + use<'a> {
        items(self.profile, self.octets)
    }
}

/// Whether a line must say that records of this definition were read without a type.
pub fn needs_untyped(definition: &Definition) -> bool {
    !matches!(Reading::named(definition.category(), definition.name(), false), Ok(Reading::Untyped(_)))
}
