//! How the target was detected: I048/020.

use deku::{DekuRead, DekuWrite};

use crate::item::Describe;
use crate::layout::{count, field};
use crate::{Chain, Kind, Layout};

/// TYP in I048/020: what detected the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DetectionType {
    /// 0: nothing did; the track is coasted.
    NoDetection,
    /// 1: primary radar (PSR) alone.
    Primary,
    /// 2: secondary radar (SSR) alone.
    Secondary,
    /// 3: SSR and PSR.
    SecondaryAndPrimary,
    /// 4: Mode S all-call alone.
    ModeSAllCall,
    /// 5: Mode S roll-call alone.
    ModeSRollCall,
    /// 6: Mode S all-call and PSR.
    ModeSAllCallAndPrimary,
    /// 7: Mode S roll-call and PSR.
    ModeSRollCallAndPrimary,
}

/// FOE/FRI in I048/020: the result of Mode 4 interrogation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FriendOrFoe {
    /// 0: not interrogated.
    NotInterrogated,
    /// 1: friendly target.
    Friendly,
    /// 2: unknown target.
    Unknown,
    /// 3: no reply.
    NoReply,
}

/// I048/020, target report descriptor: one octet and, where sent, its extensions (5 in edition 1.32; more are kept).
///
/// What an absent first extension would say is `false`. The later extensions say of each value whether it is populated:
/// `None` when it is not, or when the extension is absent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
pub struct TargetReport(Chain);

impl TargetReport {
    /// An actual report of an aircraft's transponder or of its echo, without extension.
    pub const fn new(detection: DetectionType) -> Self {
        Self(Chain::new((detection as u8) << 5))
    }

    /// The octets as they stand.
    pub const fn chain(&self) -> &Chain {
        &self.0
    }

    const fn bits(&self, octet: usize, shift: u8, mask: u8) -> u8 {
        match self.0.octet(octet) {
            Some(octet) => octet >> shift & mask,
            None => 0,
        }
    }

    /// The value below the element-populated bit at `populated` (counted from the lowest bit, 0).
    const fn populated(&self, octet: usize, populated: u8, width: u8) -> Option<u8> {
        if self.bits(octet, populated, 1) == 1 {
            Some(self.bits(octet, populated - width, (1 << width) - 1))
        } else {
            None
        }
    }

    const fn populated_flag(&self, octet: usize, populated: u8) -> Option<bool> {
        match self.populated(octet, populated, 1) {
            Some(value) => Some(value == 1),
            None => None,
        }
    }

    /// TYP: what detected the target.
    pub const fn detection(&self) -> DetectionType {
        match self.bits(0, 5, 7) {
            0 => DetectionType::NoDetection,
            1 => DetectionType::Primary,
            2 => DetectionType::Secondary,
            3 => DetectionType::SecondaryAndPrimary,
            4 => DetectionType::ModeSAllCall,
            5 => DetectionType::ModeSRollCall,
            6 => DetectionType::ModeSAllCallAndPrimary,
            _ => DetectionType::ModeSRollCallAndPrimary,
        }
    }

    /// SIM = 1: a simulated target.
    pub const fn is_simulated(&self) -> bool {
        self.bits(0, 4, 1) == 1
    }

    /// RDP: the radar data processing chain, 1 or 2.
    pub const fn processing_chain(&self) -> u8 {
        1 + self.bits(0, 3, 1)
    }

    /// SPI = 1: special position identification.
    pub const fn is_special_position(&self) -> bool {
        self.bits(0, 2, 1) == 1
    }

    /// RAB = 1: from a field monitor (a fixed transponder), not from an aircraft.
    pub const fn is_field_monitor(&self) -> bool {
        self.bits(0, 1, 1) == 1
    }

    /// TST = 1 (first extension): a test target.
    pub const fn is_test(&self) -> bool {
        self.bits(1, 7, 1) == 1
    }

    /// ERR = 1 (first extension): farther than I048/040 can say.
    pub const fn is_extended_range(&self) -> bool {
        self.bits(1, 6, 1) == 1
    }

    /// XPP = 1 (first extension): X-pulse present.
    pub const fn has_x_pulse(&self) -> bool {
        self.bits(1, 5, 1) == 1
    }

    /// ME = 1 (first extension): military emergency.
    pub const fn is_military_emergency(&self) -> bool {
        self.bits(1, 4, 1) == 1
    }

    /// MI = 1 (first extension): military identification.
    pub const fn is_military_identification(&self) -> bool {
        self.bits(1, 3, 1) == 1
    }

    /// FOE/FRI (first extension): the result of Mode 4 interrogation.
    pub const fn friend_or_foe(&self) -> FriendOrFoe {
        match self.bits(1, 1, 3) {
            0 => FriendOrFoe::NotInterrogated,
            1 => FriendOrFoe::Friendly,
            2 => FriendOrFoe::Unknown,
            _ => FriendOrFoe::NoReply,
        }
    }

    /// ADSB (second extension): on-site ADS-B information is available.
    pub const fn on_site_adsb(&self) -> Option<bool> {
        self.populated_flag(2, 7)
    }

    /// SCN (second extension): surveillance cluster network information is available.
    pub const fn surveillance_cluster(&self) -> Option<bool> {
        self.populated_flag(2, 5)
    }

    /// PAI (second extension): passive acquisition interface information is available.
    pub const fn passive_acquisition(&self) -> Option<bool> {
        self.populated_flag(2, 3)
    }

    /// ACASXV (third extension): 0 not an extended version, 1 ACAS Xa version 1, 2 ACAS Xu version 1.
    pub const fn acas_version(&self) -> Option<u8> {
        self.populated(3, 7, 4)
    }

    /// POXPR (third extension): the transponder supports phase overlay.
    pub const fn phase_overlay_supported(&self) -> Option<bool> {
        self.populated_flag(3, 2)
    }

    /// POACT (fourth extension): phase overlay is active in this plot.
    pub const fn phase_overlay_active(&self) -> Option<bool> {
        self.populated_flag(4, 7)
    }

    /// DTFXPR (fourth extension): the transponder supports basic dataflash.
    pub const fn dataflash_supported(&self) -> Option<bool> {
        self.populated_flag(4, 5)
    }

    /// DTFACT (fourth extension): basic dataflash is active in this plot.
    pub const fn dataflash_active(&self) -> Option<bool> {
        self.populated_flag(4, 3)
    }

    /// IRMXPR (fifth extension): the transponder is capable of interrogation and reply monitoring.
    pub const fn reply_monitoring_supported(&self) -> Option<bool> {
        self.populated_flag(5, 7)
    }

    /// IRMACT (fifth extension): interrogation and reply monitoring is active.
    pub const fn reply_monitoring_active(&self) -> Option<bool> {
        self.populated_flag(5, 5)
    }

    /// The same with SIM.
    #[must_use]
    pub const fn with_simulated(self, simulated: bool) -> Self {
        Self(self.0.with(0, 0x10, (simulated as u8) << 4))
    }

    /// The same with SPI.
    #[must_use]
    pub const fn with_special_position(self, special: bool) -> Self {
        Self(self.0.with(0, 0x04, (special as u8) << 2))
    }

    /// The same with RAB.
    #[must_use]
    pub const fn with_field_monitor(self, monitor: bool) -> Self {
        Self(self.0.with(0, 0x02, (monitor as u8) << 1))
    }

    /// The same with TST, in the first extension.
    #[must_use]
    pub const fn with_test(self, test: bool) -> Self {
        Self(self.0.with(1, 0x80, (test as u8) << 7))
    }
}

impl Describe for TargetReport {
    /// `…_ep` is the element-populated bit of the value that follows it.
    const LAYOUT: Layout = Layout::Extended(&[
        &[count("typ", 3), count("sim", 1), count("rdp", 1), count("spi", 1), count("rab", 1)],
        &[
            count("tst", 1),
            count("err", 1),
            count("xpp", 1),
            count("me", 1),
            count("mi", 1),
            count("foe_fri", 2),
        ],
        &[
            count("adsb_ep", 1),
            count("adsb", 1),
            count("scn_ep", 1),
            count("scn", 1),
            count("pai_ep", 1),
            count("pai", 1),
            field("spare_3", 1, Kind::Spare),
        ],
        &[count("acasxv_ep", 1), count("acasxv", 4), count("poxpr_ep", 1), count("poxpr", 1)],
        &[
            count("poact_ep", 1),
            count("poact", 1),
            count("dtfxpr_ep", 1),
            count("dtfxpr", 1),
            count("dtfact_ep", 1),
            count("dtfact", 1),
            field("spare_5", 1, Kind::Spare),
        ],
        &[
            count("irmxpr_ep", 1),
            count("irmxpr", 1),
            count("irmact_ep", 1),
            count("irmact", 1),
            field("spare_6", 3, Kind::Spare),
        ],
    ]);
}

impl From<Chain> for TargetReport {
    /// A descriptor with any octets, for what the setters do not cover.
    fn from(chain: Chain) -> Self {
        Self(chain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_octet() {
        let report = TargetReport::new(DetectionType::ModeSRollCallAndPrimary).with_simulated(true);
        assert_eq!(report.chain().octets(), [0xf0]);
        assert!(report.is_simulated() && !report.is_test() && !report.is_special_position());
        assert_eq!(report.detection(), DetectionType::ModeSRollCallAndPrimary);
        assert_eq!(report.processing_chain(), 1);
        let report = TargetReport::new(DetectionType::NoDetection)
            .with_special_position(true)
            .with_field_monitor(true);
        assert_eq!(report.chain().octets(), [0x06]);
        assert!(report.is_special_position() && report.is_field_monitor());
        assert_eq!(report.friend_or_foe(), FriendOrFoe::NotInterrogated);
    }

    #[test]
    fn extensions() {
        let report = TargetReport::new(DetectionType::Primary).with_test(true);
        assert_eq!(report.chain().octets(), [0x21, 0x80]);
        assert!(report.is_test() && !report.is_extended_range());
        assert_eq!(report.with_test(false).chain().octets(), [0x21, 0x00]);
        let report = TargetReport::from(
            Chain::new(0)
                .with(1, 0xff, 0x7e)
                .with(2, 0xff, 0xd0)
                .with(3, 0xff, 0x96)
                .with(4, 0xff, 0x38)
                .with(5, 0xff, 0xa0),
        );
        assert_eq!(report.chain().octets(), [0x01, 0x7f, 0xd1, 0x97, 0x39, 0xa0]);
        assert!(report.is_extended_range() && report.has_x_pulse() && report.is_military_emergency());
        assert!(report.is_military_identification() && !report.is_test());
        assert_eq!(report.friend_or_foe(), FriendOrFoe::NoReply);
        assert_eq!(report.on_site_adsb(), Some(true));
        assert_eq!(report.surveillance_cluster(), None);
        assert_eq!(report.passive_acquisition(), None);
        assert_eq!(report.acas_version(), Some(2));
        assert_eq!(report.phase_overlay_supported(), Some(true));
        assert_eq!(report.phase_overlay_active(), None);
        assert_eq!(report.dataflash_supported(), Some(true));
        assert_eq!(report.dataflash_active(), Some(false));
        assert_eq!(report.reply_monitoring_supported(), Some(false));
        assert_eq!(report.reply_monitoring_active(), Some(false));
    }
}
