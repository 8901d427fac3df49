//! The reserved expansion field of category 048, edition 1.13 (EUROCONTROL-SPEC-0149-4, appendix A).

mod general;
mod mode_5;
mod track;

use crate::Chain;
use crate::item::items;
use crate::record::expansion_field;

pub use crate::aircraft::{FigureOfMerit, XPulses};
pub use general::{
    AlternativeCode, AlternativeFlightLevel, Common, CrossSection, CrossSectionArea, Date, ExtendedRange,
    General, PlotNumber, PlotQuality, RangeWidth, ReplyLink, ReplyType, ScanNumber, Score, SignalToClutter,
};
pub use mode_5::{
    ExtendedMode1, Mode5, Mode5Altitude, Mode5New, Mode5Position, Mode5Summary, NationalOrigin,
    NewNationalOrigin, TimeOffset,
};
pub use track::{
    AdjacentSensor, AdsbLink, DataLink, DataLinkOrigin, DataLinkState, ExtrapolationSource, IdentityRequest,
    Lockout, PlotLink, Prediction, TrackAcquisition, TrackCharacteristics, TrackLife, TransitionCode,
    TurnState,
};

items! {
    /// M4E in RE: extended result of Mode 4 interrogation: one octet and, where sent, its extensions.
    extended pub struct ExtendedMode4 {
        first {
            spare 5 "spare";
            /// FOE/FRI: 0 no Mode 4 interrogation, 1 possibly friendly, 2 probably friendly, 3 friendly.
            count 2 "foe_fri" friend_or_foe / with_friend_or_foe: u8;
        }
    }
}

impl ExtendedMode4 {
    /// FOE/FRI: 0 no Mode 4 interrogation, 1 possibly friendly, 2 probably friendly, 3 friendly; `None` above.
    pub const fn new(friend_or_foe: u8) -> Option<Self> {
        Self(Chain::new(0)).with_friend_or_foe(friend_or_foe)
    }
}

items! {
    /// The reserved expansion field; an absent part is `None`.
    expansion pub struct ReservedExpansion {
        /// MD5, Mode 5 reports.
        "md5" mode_5: Mode5,
        /// M5N, Mode 5 reports in the new format.
        "m5n" mode_5_new: Mode5New,
        /// M4E, extended Mode 4 report.
        "m4e" extended_mode_4: ExtendedMode4,
        /// RPC, radar plot characteristics.
        "rpc" plot_quality: PlotQuality,
        /// ERR, slant range beyond the range of I048/040.
        "err_m" extended_range: ExtendedRange,
        /// RTC, radar track characteristics.
        "rtc" track_characteristics: TrackCharacteristics,
        /// CPC, common and plot characteristics.
        "cpc" common: Common,
        /// GEN48, generic data.
        "gen48" general: General,
    }
}

expansion_field! { ReservedExpansion }
