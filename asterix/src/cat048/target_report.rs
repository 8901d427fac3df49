//! Target report descriptor: I048/020.

use crate::Chain;
use crate::item::items;

items! {
    /// TYP in I048/020: means of detection.
    all pub enum DetectionType {
        /// 0: no detection; the track is coasted.
        NoDetection,
        /// 1: primary radar (PSR) only.
        Primary,
        /// 2: secondary radar (SSR) only.
        Secondary,
        /// 3: SSR and PSR.
        SecondaryAndPrimary,
        /// 4: Mode S all-call only.
        ModeSAllCall,
        /// 5: Mode S roll-call only.
        ModeSRollCall,
        /// 6: Mode S all-call and PSR.
        ModeSAllCallAndPrimary,
        /// 7: Mode S roll-call and PSR.
        ModeSRollCallAndPrimary,
    }

    /// FOE/FRI in I048/020: the result of Mode 4 interrogation.
    all pub enum FriendOrFoe {
        /// 0: not interrogated.
        NotInterrogated,
        /// 1: friendly target.
        Friendly,
        /// 2: unknown target.
        Unknown,
        /// 3: no reply.
        NoReply,
    }

    /// I048/020 (5.2.2), target report descriptor: one octet and, where sent, its extensions (5 in edition 1.32; more are
    /// kept).
    ///
    /// Values of an absent first extension are `false`. In the later extensions a bit states whether each value is populated:
    /// `None` if not, or if the extension is absent.
    extended pub struct TargetReport {
        first {
            /// TYP: means of detection.
            code 3 "typ" detection / with_detection: DetectionType;
            /// SIM: a simulated target.
            flag 1 "sim" is_simulated / with_simulated;
            /// RDP: from radar data processing chain 2; not set: chain 1.
            flag 1 "rdp" is_chain_2 / with_chain_2;
            /// SPI: special position identification.
            flag 1 "spi" is_special_position / with_special_position;
            /// RAB: from a field monitor (a fixed transponder), not from an aircraft.
            flag 1 "rab" is_field_monitor / with_field_monitor;
        }
        extension {
            /// TST: a test target.
            flag 1 "tst" is_test / with_test;
            /// ERR: beyond the range of I048/040.
            flag 1 "err" is_extended_range / with_extended_range;
            /// XPP: X-pulse present.
            flag 1 "xpp" has_x_pulse / with_x_pulse;
            /// ME: military emergency.
            flag 1 "me" is_military_emergency / with_military_emergency;
            /// MI: military identification.
            flag 1 "mi" is_military_identification / with_military_identification;
            /// FOE/FRI: the result of Mode 4 interrogation.
            code 2 "foe_fri" friend_or_foe / with_friend_or_foe: FriendOrFoe;
        }
        extension {
            count 1 "adsb_ep";
            /// ADSB: on-site ADS-B information is available.
            populated_flag 1 "adsb" on_site_adsb / with_on_site_adsb;
            count 1 "scn_ep";
            /// SCN: surveillance cluster network information is available.
            populated_flag 1 "scn" surveillance_cluster / with_surveillance_cluster;
            count 1 "pai_ep";
            /// PAI: passive acquisition interface information is available.
            populated_flag 1 "pai" passive_acquisition / with_passive_acquisition;
            spare 1 "spare_3";
        }
        extension {
            count 1 "acasxv_ep";
            /// ACASXV: 0 not an extended version, 1 ACAS Xa version 1, 2 ACAS Xu version 1.
            populated 4 "acasxv" acas_version / with_acas_version: u8;
            count 1 "poxpr_ep";
            /// POXPR: the transponder supports phase overlay.
            populated_flag 1 "poxpr" phase_overlay_supported / with_phase_overlay_supported;
        }
        extension {
            count 1 "poact_ep";
            /// POACT: phase overlay is active in this plot.
            populated_flag 1 "poact" phase_overlay_active / with_phase_overlay_active;
            count 1 "dtfxpr_ep";
            /// DTFXPR: the transponder supports basic dataflash.
            populated_flag 1 "dtfxpr" dataflash_supported / with_dataflash_supported;
            count 1 "dtfact_ep";
            /// DTFACT: basic dataflash is active in this plot.
            populated_flag 1 "dtfact" dataflash_active / with_dataflash_active;
            spare 1 "spare_5";
        }
        extension {
            count 1 "irmxpr_ep";
            /// IRMXPR: the transponder is capable of interrogation and reply monitoring.
            populated_flag 1 "irmxpr" reply_monitoring_supported / with_reply_monitoring_supported;
            count 1 "irmact_ep";
            /// IRMACT: interrogation and reply monitoring is active.
            populated_flag 1 "irmact" reply_monitoring_active / with_reply_monitoring_active;
            spare 3 "spare_6";
        }
    }
}

impl TargetReport {
    /// A report of an actual target with a transponder or an echo, without extension.
    pub const fn new(detection: DetectionType) -> Self {
        Self(Chain::new(0)).with_detection(detection)
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
        assert!(!report.is_chain_2());
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

    #[test]
    fn a_setter_populates_and_empties() {
        let report = TargetReport::new(DetectionType::Primary);
        assert_eq!(report.with_on_site_adsb(None), report);
        assert_eq!(report.with_acas_version(None), Some(report));
        assert_eq!(report.with_acas_version(Some(16)), None);
        let report = report.with_acas_version(Some(2)).unwrap().with_phase_overlay_supported(Some(true));
        assert_eq!(report.chain().octets(), [0x21, 0x01, 0x01, 0x96]);
        let report = report.with_on_site_adsb(Some(false)).with_phase_overlay_supported(None);
        assert_eq!(report.chain().octets(), [0x21, 0x01, 0x81, 0x90]);
        let report = report.with_acas_version(None).unwrap().with_on_site_adsb(None);
        assert_eq!(report.chain().octets(), [0x21, 0x01, 0x01, 0x00]);

        let report = TargetReport::new(DetectionType::NoDetection)
            .with_surveillance_cluster(Some(true))
            .with_passive_acquisition(Some(false))
            .with_phase_overlay_active(Some(true))
            .with_dataflash_supported(Some(false))
            .with_dataflash_active(Some(true))
            .with_reply_monitoring_supported(Some(true))
            .with_reply_monitoring_active(Some(false));
        assert_eq!(report.chain().octets(), [0x01, 0x01, 0x39, 0x01, 0xed, 0xe0]);
    }
}
