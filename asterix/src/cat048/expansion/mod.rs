//! The reserved expansion field of category 048, edition 1.13 (EUROCONTROL-SPEC-0149-4, appendix A).

mod general;
mod mode_5;
mod track;

use std::io::Cursor;

use deku::reader::Reader;
use deku::writer::Writer;
use deku::{DekuRead, DekuReader, DekuWrite, DekuWriter};

use crate::item::Describe;
use crate::layout::{count, field};
use crate::{Chain, Contents, Explicit, Kind, Layout, Subfield};

pub use general::{
    AlternativeCode, AlternativeFlightLevel, Common, CrossSection, CrossSectionArea, Date, ExtendedRange,
    General, PlotNumber, PlotQuality, RangeWidth, ReplyLink, ReplyType, ScanNumber, Score, SignalToClutter,
};
pub use mode_5::{
    ExtendedMode1, FigureOfMerit, Mode5, Mode5Altitude, Mode5New, Mode5Position, Mode5Summary,
    NationalOrigin, NewNationalOrigin, TimeOffset, XPulses,
};
pub use track::{
    AdjacentSensor, AdsbLink, DataLink, DataLinkOrigin, DataLinkState, ExtrapolationSource, IdentityRequest,
    Lockout, PlotLink, Prediction, TrackAcquisition, TrackCharacteristics, TrackLife, TransitionCode,
    TurnState,
};

/// M4E in RE: the answer to a Mode 4 interrogation in three steps: one octet and, where sent, its extensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
pub struct ExtendedMode4(Chain);

impl ExtendedMode4 {
    /// FOE/FRI: 0 no Mode 4 interrogation, 1 possibly friendly, 2 probably friendly, 3 friendly; `None` above.
    pub const fn new(friend_or_foe: u8) -> Option<Self> {
        if friend_or_foe < 4 { Some(Self(Chain::new(friend_or_foe << 1))) } else { None }
    }

    /// The octets as they stand.
    pub const fn chain(&self) -> &Chain {
        &self.0
    }

    /// FOE/FRI: 0 no Mode 4 interrogation, 1 possibly friendly, 2 probably friendly, 3 friendly.
    pub const fn friend_or_foe(&self) -> u8 {
        match self.0.octet(0) {
            Some(octet) => octet >> 1 & 3,
            None => 0,
        }
    }
}

impl Describe for ExtendedMode4 {
    const LAYOUT: Layout = Layout::Extended(&[&[field("spare", 5, Kind::Spare), count("foe_fri", 2)]]);
}

/// What the reserved expansion field holds; an absent part is `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(ctx = "announced: u8")]
pub struct ReservedExpansion {
    /// MD5, Mode 5 reports.
    #[deku(cond = "announced & 0x80 != 0")]
    pub mode_5: Option<Mode5>,
    /// M5N, Mode 5 reports in the new format.
    #[deku(cond = "announced & 0x40 != 0")]
    pub mode_5_new: Option<Mode5New>,
    /// M4E, extended Mode 4 report.
    #[deku(cond = "announced & 0x20 != 0")]
    pub extended_mode_4: Option<ExtendedMode4>,
    /// RPC, radar plot characteristics.
    #[deku(cond = "announced & 0x10 != 0")]
    pub plot_quality: Option<PlotQuality>,
    /// ERR, the slant range where I048/040 cannot hold it.
    #[deku(cond = "announced & 0x08 != 0")]
    pub extended_range: Option<ExtendedRange>,
    /// RTC, radar track characteristics.
    #[deku(cond = "announced & 0x04 != 0")]
    pub track_characteristics: Option<TrackCharacteristics>,
    /// CPC, common and plot characteristics.
    #[deku(cond = "announced & 0x02 != 0")]
    pub common: Option<Common>,
    /// GEN48, generic data.
    #[deku(cond = "announced & 0x01 != 0")]
    pub general: Option<General>,
}

impl ReservedExpansion {
    /// The parts, in the order of the bits that announce them.
    pub const SUBFIELDS: &'static [Subfield] = &[
        Subfield { key: "md5", layout: Mode5::LAYOUT },
        Subfield { key: "m5n", layout: Mode5New::LAYOUT },
        Subfield { key: "m4e", layout: ExtendedMode4::LAYOUT },
        Subfield { key: "rpc", layout: PlotQuality::LAYOUT },
        Subfield { key: "err_m", layout: ExtendedRange::LAYOUT },
        Subfield { key: "rtc", layout: TrackCharacteristics::LAYOUT },
        Subfield { key: "cpc", layout: Common::LAYOUT },
        Subfield { key: "gen48", layout: General::LAYOUT },
    ];

    /// Structure of the item.
    pub const LAYOUT: Layout = Layout::Explicit(Contents::Expansion(Self::SUBFIELDS));

    /// Reads a reserved expansion field. `None` where its octets are not what edition 1.13 says, or where
    /// [`ReservedExpansion::to_field`] would not give the same octets: such a field is of another edition or damaged, and
    /// its octets are all that is known.
    pub fn read(field: &Explicit) -> Option<Self> {
        let (&announced, subfields) = field.contents().split_first()?;
        let read =
            Self::from_reader_with_ctx(&mut Reader::new(&mut Cursor::new(subfields)), announced).ok()?;
        (read.to_field().as_ref() == Some(field)).then_some(read)
    }

    /// The field that says this; `None` when it is longer than 254 octets.
    pub fn to_field(&self) -> Option<Explicit> {
        let present = [
            self.mode_5.is_some(),
            self.mode_5_new.is_some(),
            self.extended_mode_4.is_some(),
            self.plot_quality.is_some(),
            self.extended_range.is_some(),
            self.track_characteristics.is_some(),
            self.common.is_some(),
            self.general.is_some(),
        ];
        let announced = present.iter().fold(0, |bits, &present| bits << 1 | u8::from(present));
        let mut cursor = Cursor::new(vec![announced]);
        cursor.set_position(1);
        let mut writer = Writer::new(&mut cursor);
        self.to_writer(&mut writer, announced).expect("writing whole octets to a vector cannot fail");
        Explicit::new(cursor.get_ref())
    }
}
