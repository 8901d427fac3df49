//! Editions of CAT021.

use alloc::string::String;
use core::fmt;
use core::str::FromStr;

use super::{
    QualityIndicators, Record, Standard, Surface, SurfaceCharacteristics21, TargetReport, TargetStatus, UAP,
};
use crate::{Describe, Profile, UapItem};

/// The edition of the specification that a sender uses.
///
/// The second octet of I021/271 has an FX bit from edition 2.2 on, and none up to 2.1. Reading it in a wrong edition misreads
/// the octets after it, often without a fault. All other changes define spare bits or lengthen an extended item, so the newest
/// layouts serve all editions from 2.2 on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Edition {
    /// 2.1.
    V2_1,
    /// 2.2: FX in the second octet of I021/271, ME in I021/200.
    V2_2,
    /// 2.3: LLC in I021/040.
    V2_3,
    /// 2.4.
    V2_4,
    /// 2.5: version 3 in I021/210.
    V2_5,
    /// 2.6: TBC and MBC in I021/040.
    #[default]
    V2_6,
    /// 2.7: SRC and validation in I021/090.
    V2_7,
}

impl Edition {
    /// All editions, oldest first.
    pub const ALL: [Self; 7] =
        [Self::V2_1, Self::V2_2, Self::V2_3, Self::V2_4, Self::V2_5, Self::V2_6, Self::V2_7];

    /// The name of the edition: `"2.1"`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::V2_1 => "2.1",
            Self::V2_2 => "2.2",
            Self::V2_3 => "2.3",
            Self::V2_4 => "2.4",
            Self::V2_5 => "2.5",
            Self::V2_6 => "2.6",
            Self::V2_7 => "2.7",
        }
    }

    /// The items in the order of the record, with the layouts of this edition.
    pub const fn profile(self) -> &'static Profile {
        match self {
            Self::V2_1 => &UAP_2_1,
            _ => UAP,
        }
    }

    /// The oldest edition that defines everything in this record; `None` if edition 2.1 does.
    pub fn least(record: &Record) -> Option<Self> {
        let octets = |chain: Option<&crate::Chain>| chain.map_or(0, |chain| chain.octets().len());
        let descriptor = record.target_report.as_ref();
        let quality = record.quality.as_ref();
        let newer = [
            (Self::V2_7, octets(quality.map(QualityIndicators::chain)) > 4),
            (Self::V2_7, quality.is_some_and(|quality| quality.is_integrity_received())),
            (Self::V2_6, octets(descriptor.map(TargetReport::chain)) > 3),
            (Self::V2_5, record.mops_version.is_some_and(|mops| mops.standard() == Standard::Do260C)),
            (Self::V2_3, descriptor.is_some_and(|descriptor| descriptor.is_lookup_failed())),
            (Self::V2_2, record.target_status.is_some_and(TargetStatus::is_military_emergency)),
        ];
        newer.into_iter().find_map(|(edition, needed)| needed.then_some(edition))
    }
}

/// The profile with the layout of I021/271 up to edition 2.1.
static UAP_2_1: Profile = Profile::new(&ITEMS_2_1);

const ITEMS_2_1: [UapItem; UAP.items().len()] = {
    let mut items = [UAP.items()[0]; UAP.items().len()];
    let mut index = 0;
    while index < items.len() {
        items[index] = UAP.items()[index];
        let UapItem { frn, item, name, .. } = items[index];
        if frn == Surface::FRN {
            items[index] = UapItem::new(frn, item, name, SurfaceCharacteristics21::LAYOUT);
        }
        index += 1;
    }
    items
};

impl fmt::Display for Edition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Error: a text is no edition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no edition of CAT021 that is read; known are 2.1, 2.2, 2.3, 2.4, 2.5, 2.6 and 2.7")]
pub struct UnknownEdition(pub String);

impl FromStr for Edition {
    type Err = UnknownEdition;

    fn from_str(text: &str) -> Result<Self, UnknownEdition> {
        let named = Self::ALL.into_iter().find(|edition| edition.name() == text);
        named.ok_or_else(|| UnknownEdition(text.into()))
    }
}
