//! Records as JSON, one object a line, with nothing lost: [`write_record`] says what the octets were, and an
//! [`Encoder`] makes them again.
//!
//! * Items have the numbers of their category as keys, in the order of the record. An item of one number or text is that;
//!   an item of several parts is an object with the names of the specification in lower case, a repetitive item an array.
//! * Physical values carry their unit in the key (seconds of I048/140 and I129/070 excepted) and as many decimals as it
//!   takes to round back to the count that was sent. What the specification tabulates stays the code of its table.
//! * Spare bits appear, as `spare`, where they are not zero; `fspec` where the FSPEC is longer than it need be.
//! * Special purpose and reserved expansion fields are objects where their layout is known, otherwise hexadecimal, length
//!   octet included. Texts that are not printable ASCII are `{"hex":"…"}`.
//!
//! Messages of Remote ID have the names of their standard (`remote_id.rs`).
//!
//! Categories and editions without a typed record are printed by the same rules; a line says its edition, and their keys are
//! those of [`asterix::all`].
//!
//! All else follows from the layouts of [`asterix::profile`] and [`asterix::all`]: nothing here knows a category.

mod characters;
mod editions;
mod encoder;
mod read;
mod remote_id;
mod values;
mod write;

use asterix::all::Untyped;
use asterix::{DataSource, Fault, Fspec, Record, TimeOfDay, UapItem, cat021, items};

use crate::normalise::nearest_day;
use fusion::time::Time;
use values::{write_hex, write_integer};
use write::{Object, write_item};

pub use editions::{EditionError, Editions, Reading};
pub use encoder::{Encoder, LineError};
pub use remote_id::{REMOTE_ID, write_messages, write_refused};
pub(crate) use values::rounded;
pub(crate) use write::{announced, is_known, item_json, meant, part_octets, scalar_json};

/// Where the octets of a line stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place<'a> {
    /// The file, where there are several.
    pub input: Option<&'a str>,
    /// Offset in the file of the first octet: of a record its FSPEC.
    pub offset: u64,
    /// Offset in the file of the block's CAT octet.
    pub block: u64,
}

/// Appends the line of a record with these octets, received at `received`; with its octets where `hex` asks for them.
/// The edition is said where it is not the one that [`Encoder`] takes for granted.
pub fn write_record<R: Record<Edition: Named>>(
    out: &mut Vec<u8>,
    record: &R,
    edition: R::Edition,
    octets: &[u8],
    place: Place<'_>,
    received: Option<Time>,
    hex: bool,
) {
    let head = Head {
        time: dated(record.time_of_day(), received),
        place,
        category: R::CATEGORY,
        source: record.data_source(),
        edition: edition.name(),
        untyped: false,
    };
    write_items(out, &head, items(R::profile(edition), octets), octets, hex);
}

/// The same of a record without a type. Its edition is always said; and `untyped`, where [`Encoder`] would take it for one with.
pub fn write_untyped(
    out: &mut Vec<u8>,
    record: &Untyped<'_>,
    place: Place<'_>,
    received: Option<Time>,
    hex: bool,
) {
    let definition = record.definition();
    let head = Head {
        time: dated(record.time_of_day(), received),
        place,
        category: definition.category(),
        source: record.data_source(),
        edition: Some(definition.name()),
        untyped: !matches!(
            Reading::named(definition.category(), definition.name(), false),
            Ok(Reading::Untyped(_))
        ),
    };
    write_items(out, &head, record.items(), record.octets(), hex);
}

/// What a line says before the items.
struct Head<'a> {
    time: Option<Time>,
    place: Place<'a>,
    category: u8,
    source: Option<DataSource>,
    edition: Option<&'a str>,
    untyped: bool,
}

fn write_items<'a>(
    out: &mut Vec<u8>,
    head: &Head<'_>,
    items: impl Iterator<Item = (&'static UapItem, &'a [u8])>,
    octets: &[u8],
    hex: bool,
) {
    let mut line = Line::open(out, head.time, head.place, Some(head.category));
    if let Some(source) = head.source {
        line.number("sac", source.sac.into());
        line.number("sic", source.sic.into());
    }
    if let Some(edition) = head.edition {
        line.text("edition", edition);
    }
    if head.untyped {
        line.0.key("untyped");
        line.0.out.extend_from_slice(b"true");
    }
    if let Some(fspec) = Fspec::read(octets).ok().filter(|fspec| fspec.padding() > 0) {
        line.hex("fspec", &octets[..fspec.length()]);
    }
    line.0.key("items");
    let mut object = Object::open(line.0.out);
    for (item, octets) in items {
        object.key(item.item);
        write_item(object.out, &item.layout, octets);
    }
    object.close();
    if hex {
        line.hex("hex", octets);
    }
    line.close();
}

/// When a record was made with this time of day that was received at `received`; `None` where either is not known.
pub(crate) fn dated(time_of_day: Option<TimeOfDay>, received: Option<Time>) -> Option<Time> {
    // The day is that of the reception, or the next or the last, whichever is nearest.
    nearest_day(time_of_day?.count(), received?)
}

/// An edition as a line says it.
pub trait Named: Copy {
    /// Its name; `None` where a line need not say it.
    fn name(self) -> Option<&'static str>;
}

impl Named for () {
    fn name(self) -> Option<&'static str> {
        None
    }
}

impl Named for cat021::Edition {
    fn name(self) -> Option<&'static str> {
        (self != Self::default()).then_some(self.name())
    }
}

/// Appends the line of a block that is not looked into, because its category is unknown or it holds no record; `octets`
/// begin with its CAT and LEN.
pub fn write_block(out: &mut Vec<u8>, category: u8, octets: &[u8], place: Place<'_>) {
    let mut line = Line::open(out, None, place, Some(category));
    line.hex("hex", octets);
    line.close();
}

/// Appends the line of octets that cannot be read: the rest of a block from the bad record on, or of a datagram from the
/// bad block on. The offset of the fault counts from `origin` in the file.
pub fn write_fault(out: &mut Vec<u8>, fault: Fault, octets: &[u8], origin: u64, place: Place<'_>) {
    let offset = origin + fault.offset as u64;
    let in_file = Fault { offset: usize::try_from(offset).unwrap_or(usize::MAX), ..fault };
    let mut line = Line(Object::open(out));
    line.0.key("error");
    let mut error = Line(Object::open(line.0.out));
    error.text("kind", fault.kind.name());
    error.number("offset", offset);
    if let Some(item) = fault.item {
        error.text("item", item);
    }
    error.text("detail", &in_file.to_string());
    error.0.close();
    line.place(place, fault.category);
    line.hex("hex", octets);
    line.close();
}

/// Appends the line of octets that belong to no block ([`Contents::Unframed`](crate::capture::Contents::Unframed)).
pub fn write_skipped(out: &mut Vec<u8>, octets: &[u8], place: Place<'_>) {
    let mut line = Line(Object::open(out));
    line.0.key("error");
    let mut error = Line(Object::open(line.0.out));
    error.text("kind", SKIPPED);
    error.number("offset", place.offset);
    error.text("detail", &format!("{} octets belong to no block", octets.len()));
    error.0.close();
    line.place(place, None);
    line.hex("hex", octets);
    line.close();
}

/// Appends the line of the octets that a sender puts behind the blocks of each datagram.
pub fn write_trailer(out: &mut Vec<u8>, octets: &[u8], place: Place<'_>) {
    let mut line = Line(Object::open(out));
    line.number("trailer", octets.len() as u64);
    line.place(place, None);
    line.hex("hex", octets);
    line.close();
}

/// What octets that belong to no block are counted as, beside the names of [`asterix::FaultKind`].
pub const SKIPPED: &str = "skipped";

/// A line that is being printed.
struct Line<'a>(Object<'a>);

impl<'a> Line<'a> {
    fn open(out: &'a mut Vec<u8>, time: Option<Time>, place: Place<'_>, category: Option<u8>) -> Self {
        let mut line = Self(Object::open(out));
        match time {
            Some(time) => line.text("time", &time.to_string()),
            None => {
                line.0.key("time");
                line.0.out.extend_from_slice(b"null");
            }
        }
        line.place(place, category);
        line
    }

    fn place(&mut self, place: Place<'_>, category: Option<u8>) {
        if let Some(input) = place.input {
            self.text("input", input);
        }
        self.number("offset", place.offset);
        self.number("block", place.block);
        if let Some(category) = category {
            self.number("cat", category.into());
        }
    }

    fn number(&mut self, key: &str, number: u64) {
        self.0.key(key);
        write_integer(self.0.out, number);
    }

    fn value(&mut self, key: &str, value: &serde_json::Value) {
        self.0.key(key);
        serde_json::to_writer(&mut *self.0.out, value).expect("writing to a vector cannot fail");
    }

    fn hex(&mut self, key: &str, octets: &[u8]) {
        self.0.key(key);
        write_hex(self.0.out, octets);
    }

    fn text(&mut self, key: &str, text: &str) {
        self.0.key(key);
        serde_json::to_writer(&mut *self.0.out, text).expect("writing to a vector cannot fail");
    }

    fn close(self) {
        let out = self.0.close();
        out.push(b'\n');
    }
}
