//! Faults in octets received from outside.

use core::fmt;

/// A part of a datagram that could not be read, with the reason. The records before it are valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fault {
    /// Category of the block; `None` for one or two octets that are no block header.
    pub category: Option<u8>,
    /// Number of the item, for example `"040"`; `None` if the fault is in the block or in the FSPEC.
    pub item: Option<&'static str>,
    /// Offset of the fault from the start of the datagram: the CAT octet of a bad block, the first octet of a bad FSPEC (for a
    /// reserved bit, the FSPEC octet with the bit), or the first octet of a bad item.
    pub offset: usize,
    /// The reason.
    pub kind: FaultKind,
}

/// Reason of a [`Fault`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FaultKind {
    /// LEN is below 3, the length of the block header, which it includes.
    BlockTooShort,
    /// LEN exceeds the end of the datagram, or one or two octets remain, which is less than a block header.
    BlockPastEnd,
    /// The block ends within the FSPEC.
    FspecPastEnd,
    /// The FSPEC is longer than any record of the category needs.
    FspecTooLong,
    /// The FSPEC announces an item that the category does not define, so its length is unknown.
    ReservedFrn,
    /// The item runs past the end of its block.
    ItemPastEnd,
    /// The primary subfield of a compound item announces more octets of subfields than the item defines.
    PrimarySubfieldExtended,
    /// The primary subfield of a compound item announces a subfield that the item does not define, so its length is unknown.
    ReservedSubfield,
    /// The block ends where the repetition count of an item should be.
    NoRepetitionCount,
    /// The length octet of an SP or RE field is 0, although it counts itself.
    LengthZero,
    /// An item has more extensions than [`crate::Chain::MAX_OCTETS`] allows.
    ChainTooLong,
    /// The item that selects the profile of the record (I001/020, I007/410) is missing or selects none.
    NoProfile,
}

impl FaultKind {
    /// Every kind, for tables of counters.
    pub const ALL: [Self; 12] = [
        Self::BlockTooShort,
        Self::BlockPastEnd,
        Self::FspecPastEnd,
        Self::FspecTooLong,
        Self::ReservedFrn,
        Self::ItemPastEnd,
        Self::PrimarySubfieldExtended,
        Self::ReservedSubfield,
        Self::NoRepetitionCount,
        Self::LengthZero,
        Self::ChainTooLong,
        Self::NoProfile,
    ];

    /// Short name for counters, stable across releases: `"item_past_end"`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BlockTooShort => "block_too_short",
            Self::BlockPastEnd => "block_past_end",
            Self::FspecPastEnd => "fspec_past_end",
            Self::FspecTooLong => "fspec_too_long",
            Self::ReservedFrn => "reserved_frn",
            Self::ItemPastEnd => "item_past_end",
            Self::PrimarySubfieldExtended => "primary_subfield_extended",
            Self::ReservedSubfield => "reserved_subfield",
            Self::NoRepetitionCount => "no_repetition_count",
            Self::LengthZero => "length_zero",
            Self::ChainTooLong => "chain_too_long",
            Self::NoProfile => "no_profile",
        }
    }
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BlockTooShort => "the block's LEN is below 3, the size of its own header",
            Self::BlockPastEnd => "the block runs past the end of the datagram",
            Self::FspecPastEnd => "the FSPEC runs past the end of its block",
            Self::FspecTooLong => "the FSPEC is longer than any record needs",
            Self::ReservedFrn => "the FSPEC announces an item that the category does not define",
            Self::ItemPastEnd => "the item runs past the end of its block",
            Self::PrimarySubfieldExtended => {
                "the primary subfield announces another octet, which does not exist"
            }
            Self::ReservedSubfield => {
                "the primary subfield announces a subfield that the item does not define"
            }
            Self::NoRepetitionCount => "the block ends before the item's repetition count",
            Self::LengthZero => "the length octet is 0, although it counts itself",
            Self::ChainTooLong => "the item has more extensions than any edition defines",
            Self::NoProfile => "nothing says which of the category's profiles the record follows",
        })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.category {
            Some(category) => write!(f, "CAT{category:03} ")?,
            None => f.write_str("ASTERIX ")?,
        }
        if let Some(item) = self.item {
            write!(f, "item {item} ")?;
        }
        write!(f, "at octet {}: {}", self.offset, self.kind)
    }
}

impl core::error::Error for Fault {}
