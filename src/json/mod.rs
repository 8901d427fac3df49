//! Records as JSON, one object a line, with nothing lost: the lines say what the octets were.
//!
//! * Items have the numbers of their category as keys, in the order of the record. An item of one number or text is that;
//!   an item of several parts is an object with the names of the specification in lower case.
//! * Physical values carry their unit in the key (seconds of I048/140 and I129/070 excepted) and as many decimals as it
//!   takes to round back to the count that was sent. What the specification tabulates stays the code of its table.
//! * Spare bits appear, as `spare`, where they are not zero; `fspec` where the FSPEC is longer than it need be.
//! * Items that the codec keeps as octets are hexadecimal, length or count octet included. Texts that are not printable
//!   ASCII are `{"hex":"…"}`.
//!
//! Each category has its file; [`Record`] is what a line needs of one. A block that is not looked into is a
//! [`BlockLine`], octets that cannot be read are a [`FaultLine`].

pub mod cat048;
pub mod cat129;
mod chain;
mod values;

use asterix::{DataSource, Fault, Fspec, TimeOfDay};
use serde::Serialize;

use crate::normalise::nearest_day;
use crate::time::Time;
pub use values::Hex;
pub(crate) use values::rounded;

/// A category's record that can be written as JSON.
pub trait Record: asterix::Record {
    /// The object `items`.
    type Items: Serialize;

    /// Every item that is present.
    fn items(&self) -> Self::Items;
    /// Item 010.
    fn data_source(&self) -> Option<DataSource>;
    /// Item 140 or 070.
    fn time_of_day(&self) -> Option<TimeOfDay>;
    /// The FSPEC, if it has octets that announce nothing.
    fn padded_fspec(&self) -> Option<Fspec>;
}

/// Where the octets of a line stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Place<'a> {
    /// The file, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<&'a str>,
    /// Offset in the file of the first octet: of a record its FSPEC.
    pub offset: u64,
    /// Offset in the file of the block's CAT octet.
    pub block: u64,
}

/// The line of a record.
#[derive(Serialize)]
pub struct RecordLine<'a, I> {
    /// RFC 3339 UTC with milliseconds, the rest cut off; `null` without a time of day or a time of reception.
    time: Option<String>,
    #[serde(flatten)]
    place: Place<'a>,
    cat: u8,
    #[serde(skip_serializing_if = "Option::is_none")]
    sac: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sic: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fspec: Option<Hex>,
    items: I,
    #[serde(skip_serializing_if = "Option::is_none")]
    hex: Option<Hex>,
}

impl<'a, I> RecordLine<'a, I> {
    /// The line of `record`, received at `received`; with its `octets` where they are wanted.
    pub fn new<R: Record<Items = I>>(
        record: &R,
        place: Place<'a>,
        received: Option<Time>,
        octets: Option<&[u8]>,
    ) -> Self {
        let time = received.zip(record.time_of_day()).and_then(|(received, time)| {
            // The day is that of the reception, or the next or the last, whichever is nearest.
            nearest_day(time.count(), received)
        });
        let source = record.data_source();
        let fspec = record.padded_fspec().map(|fspec| {
            let mut octets = Vec::with_capacity(Fspec::MAX_OCTETS);
            fspec.encode_into(&mut octets);
            Hex::new(&octets)
        });
        Self {
            time: time.map(|time| time.to_string()),
            place,
            cat: R::CATEGORY,
            sac: source.map(|source| source.sac),
            sic: source.map(|source| source.sic),
            fspec,
            items: record.items(),
            hex: octets.map(Hex::new),
        }
    }
}

/// The line of a block that is not looked into: its category is unknown, or it holds no record.
#[derive(Serialize)]
pub struct BlockLine<'a> {
    /// Always `null`.
    time: Option<String>,
    #[serde(flatten)]
    place: Place<'a>,
    cat: u8,
    hex: Hex,
}

impl<'a> BlockLine<'a> {
    /// The line of the block with these `octets`, CAT and LEN included.
    pub fn new(category: u8, place: Place<'a>, octets: &[u8]) -> Self {
        Self { time: None, place, cat: category, hex: Hex::new(octets) }
    }
}

/// The line of octets that cannot be read: the rest of a block from the bad record on, or of a datagram from the bad
/// block on.
#[derive(Serialize)]
pub struct FaultLine<'a> {
    error: Trouble,
    #[serde(flatten)]
    place: Place<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cat: Option<u8>,
    hex: Hex,
}

/// What is wrong.
#[derive(Serialize)]
struct Trouble {
    /// [`asterix::FaultKind::name`].
    kind: &'static str,
    /// Offset in the file of the trouble.
    offset: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    item: Option<&'static str>,
    detail: String,
}

impl<'a> FaultLine<'a> {
    /// The line of `fault`, whose offset counts from `origin` in the file, and of the `octets` lost with it.
    pub fn new(fault: Fault, origin: u64, place: Place<'a>, octets: &[u8]) -> Self {
        let offset = origin + fault.offset as u64;
        let in_file = Fault { offset: usize::try_from(offset).unwrap_or(usize::MAX), ..fault };
        Self {
            error: Trouble { kind: fault.kind.name(), offset, item: fault.item, detail: in_file.to_string() },
            place,
            cat: fault.category,
            hex: Hex::new(octets),
        }
    }
}
