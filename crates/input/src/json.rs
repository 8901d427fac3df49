//! Lossless JSON of records, one object per line. [`write_record`] describes the octets, and [`Encoder`] restores them. The
//! content does not depend on the output ([`Tree`]).
//!
//! * Keys of items are their numbers in the category, in the order of the record. An item of one number or text has this value.
//!   An item of several parts is an object with the names of the specification in lower case, a repetitive item an array.
//! * Physical values have their unit in the key (except seconds of I048/140 and I129/070), and as many decimals as needed to
//!   round back to the encoded count. Values that the specification tabulates stay codes of its table.
//! * Spare bits appear as `spare` if they are not zero; `fspec` appears if the FSPEC is longer than necessary.
//! * Special purpose and reserved expansion fields are objects if their layout is known, otherwise hexadecimal including the
//!   length octet. Texts that are not printable ASCII are `{"hex":"…"}`.
//!
//! Remote ID messages have the names of their standard (`remote_id.rs`).
//!
//! Categories and editions without a typed record follow the same rules. Their lines state the edition, and their keys are those
//! of [`asterix::all`].
//!
//! Everything else follows from the layouts of [`asterix::profile`] and [`asterix::all`]; no code here is specific to a category.

mod characters;
mod editions;
mod encoder;
mod entry;
mod line;
mod parsed;
mod read;
mod remote_id;
mod tree;
mod values;
mod write;

use asterix::{Fault, Fspec, TimeOfDay, cat021};

use crate::normalise::nearest_day;
use fusion::time::Time;

pub use editions::{EditionError, Editions, Reading};
pub use encoder::{Encoder, LineError};
pub use entry::{Entry, needs_untyped};
pub use remote_id::{REMOTE_ID, write_messages, write_refused};
pub use tree::Tree;
pub use values::rounded;
pub use write::{announced, form_of, is_known, meant, part_octets, write_item, write_value};

/// Position of a line's octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place<'a> {
    /// Name of the file, if there are several.
    pub input: Option<&'a str>,
    /// Offset in the file of the first octet; for a record, of its FSPEC.
    pub offset: u64,
    /// Offset in the file of the block's CAT octet.
    pub block: u64,
}

/// Appends the line of a record, with its octets if `hex` is set.
pub fn write_record(out: &mut impl Tree, entry: &Entry<'_>, hex: bool) {
    open_line(out, entry.time, entry.place, Some(entry.category));
    if let Some(source) = entry.source {
        number(out, "sac", source.sac.into());
        number(out, "sic", source.sic.into());
    }
    if let Some(edition) = entry.edition {
        text(out, "edition", edition);
    }
    if entry.untyped {
        out.key("untyped");
        out.yes();
    }
    let octets = entry.octets;
    if let Some(fspec) = Fspec::read(octets).ok().filter(|fspec| fspec.padding() > 0) {
        octets_of(out, "fspec", &octets[..fspec.length()]);
    }
    out.key("items");
    out.open_object();
    for (item, octets) in entry.items() {
        out.joined(item.item, item.joined());
        write_item(out, &item.layout, octets);
    }
    out.close_object();
    if hex {
        octets_of(out, "hex", octets);
    }
    close_line(out);
}

/// Time of a record with this time of day, received at `received`; `None` if either is unknown.
pub fn dated(time_of_day: Option<TimeOfDay>, received: Option<Time>) -> Option<Time> {
    // The day of the reception, the day before or the day after, whichever is nearest.
    nearest_day(time_of_day?.count(), received?)
}

/// An edition that a line may state.
pub trait Named: Copy {
    /// Name of the edition; `None` if a line need not state it.
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

/// Appends the line of a block that is not decoded, because its category is unknown or it has no record. `octets` start with its
/// CAT and LEN.
pub fn write_block(out: &mut impl Tree, category: u8, octets: &[u8], place: Place<'_>) {
    open_line(out, None, place, Some(category));
    octets_of(out, "hex", octets);
    close_line(out);
}

/// Appends the line of octets that cannot be read: the rest of a block after a bad record, or of a datagram after a bad block.
/// The fault's offset counts from `origin` in the file.
pub fn write_fault(out: &mut impl Tree, fault: Fault, octets: &[u8], origin: u64, place: Place<'_>) {
    let offset = origin + fault.offset as u64;
    let in_file = Fault { offset: usize::try_from(offset).unwrap_or(usize::MAX), ..fault };
    let error = Error { kind: fault.kind.name(), offset, item: fault.item, detail: in_file.to_string() };
    write_error(out, &error, place, fault.category, octets);
}

/// Appends the line of octets outside any block ([`PayloadKind::Unframed`](crate::capture::PayloadKind::Unframed)).
pub fn write_skipped(out: &mut impl Tree, octets: &[u8], place: Place<'_>) {
    let detail = format!("{} octets belong to no block", octets.len());
    let error = Error { kind: SKIPPED, offset: place.offset, item: None, detail };
    write_error(out, &error, place, None, octets);
}

/// Appends the line of octets that a sender appends to the blocks of each datagram.
pub fn write_trailer(out: &mut impl Tree, octets: &[u8], place: Place<'_>) {
    out.open_object();
    number(out, "trailer", octets.len() as u64);
    write_place(out, place, None);
    octets_of(out, "hex", octets);
    close_line(out);
}

/// Name under which octets outside any block are counted, besides the names of [`asterix::FaultKind`].
pub const SKIPPED: &str = "skipped";

/// Error of octets that cannot be read.
struct Error<'a> {
    kind: &'a str,
    /// Offset in the file.
    offset: u64,
    item: Option<&'a str>,
    detail: String,
}

fn write_error(
    out: &mut impl Tree,
    error: &Error<'_>,
    place: Place<'_>,
    category: Option<u8>,
    octets: &[u8],
) {
    out.open_object();
    out.key("error");
    out.open_object();
    text(out, "kind", error.kind);
    number(out, "offset", error.offset);
    if let Some(item) = error.item {
        text(out, "item", item);
    }
    text(out, "detail", &error.detail);
    out.close_object();
    write_place(out, place, category);
    octets_of(out, "hex", octets);
    close_line(out);
}

/// Begins a line.
fn open_line(out: &mut impl Tree, time: Option<Time>, place: Place<'_>, category: Option<u8>) {
    out.open_object();
    out.key("time");
    match time {
        Some(time) => out.text(&time.to_string()),
        None => out.null(),
    }
    write_place(out, place, category);
}

fn write_place(out: &mut impl Tree, place: Place<'_>, category: Option<u8>) {
    if let Some(input) = place.input {
        text(out, "input", input);
    }
    number(out, "offset", place.offset);
    number(out, "block", place.block);
    if let Some(category) = category {
        number(out, "cat", category.into());
    }
}

fn number(out: &mut impl Tree, key: &'static str, number: u64) {
    out.key(key);
    out.integer(number);
}

fn text(out: &mut impl Tree, key: &'static str, text: &str) {
    out.key(key);
    out.text(text);
}

fn octets_of(out: &mut impl Tree, key: &'static str, octets: &[u8]) {
    out.key(key);
    out.hex(octets);
}

fn close_line(out: &mut impl Tree) {
    out.close_object();
    out.end();
}
