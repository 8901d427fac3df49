//! The reserved expansion field of category 062, edition 1.3 (EUROCONTROL-SPEC-0149-9, appendix A). Edition 1.2 is the same
//! with fewer bits and subfields defined.

use super::Velocity;
use crate::Repeated;
use crate::item::items;
use crate::record::expansion_field;

items! {
    /// The reserved expansion field; an absent part is `None`.
    expansion pub struct ReservedExpansion {
        /// CST, contributing sensors with their track numbers.
        "cst" sensors_with_tracks: Repeated<SensorTrack>,
        /// CSN, contributing sensors without track numbers.
        "csn" sensors: Repeated<Sensor>,
        /// TVS, velocity relative to the system's reference point.
        "tvs" velocity: Velocity,
        /// STS, supplementary status of the track.
        "sts" status: SupplementaryStatus,
        /// V3, data of ADS-B version 3; from edition 1.3 on.
        "v3" version_3: Version3,
        _,
        _,
        _,
    }

    /// TYP in CST and CSN: detection by the sensor.
    pub enum SensorDetection {
        /// none.
        None = 0,
        /// PSR.
        Psr = 1,
        /// SSR.
        Ssr = 2,
        /// SSR and PSR.
        SsrAndPsr = 3,
        /// Mode S all-call.
        AllCall = 4,
        /// Mode S roll-call.
        RollCall = 5,
        /// Mode S all-call and PSR.
        AllCallAndPsr = 6,
        /// Mode S roll-call and PSR.
        RollCallAndPsr = 7,
        /// ADS-B.
        Adsb = 8,
        /// wide area multilateration.
        Multilateration = 9,
    }

    /// A part of CST in RE: a sensor and its track.
    pub struct SensorTrack(5) {
        /// SAC of the sensor.
        count 8 "sac" sac / with_sac: u8;
        /// SIC of the sensor.
        count 8 "sic" sic / with_sic: u8;
        spare 4 "spare";
        /// TYP, detection by the sensor.
        code 4 "typ" detection / with_detection: SensorDetection;
        /// LTN, track number of the sensor, 0 to 65535.
        count 16 "ltn" track_number / with_track_number: u16;
    }

    /// A part of CSN in RE: a sensor.
    pub struct Sensor(3) {
        /// SAC of the sensor.
        count 8 "sac" sac / with_sac: u8;
        /// SIC of the sensor.
        count 8 "sic" sic / with_sic: u8;
        spare 4 "spare";
        /// TYP, detection by the sensor.
        code 4 "typ" detection / with_detection: SensorDetection;
    }

    /// STS in RE: one octet and, where sent, its extensions.
    extended pub struct SupplementaryStatus {
        first {
            /// FDR: flight plan data retained from a system that is no longer active.
            flag 1 "fdr" is_plan_retained / with_plan_retained;
            count 1 "lnav_ep";
            /// LNAV: lateral navigation is not engaged; from edition 1.3 on.
            populated_flag 1 "lnav" is_lateral_off;
            spare 4 "spare";
        }
    }

    /// V3 in RE.
    compound pub struct Version3 {
        /// PS3, priority status.
        "ps3" priority: Priority3,
        /// AS, aircraft status.
        "as" status: Status3,
        /// UAS, status of an unmanned aircraft.
        "uas" unmanned: Unmanned3,
        /// CASS, collision avoidance.
        "cass" collision_avoidance: CollisionAvoidance3,
        _,
        _,
        _,
    }

    /// PS3 in V3.
    pub struct Priority3(1) {
        count 1 "ep";
        /// 0 none, 1 general emergency, 2 unmanned aircraft without link, 3 minimum fuel, 4 no communications, 5 unlawful
        /// interference, 6 in distress, 7 in distress, activated manually.
        populated 3 "ps3" priority: u8;
        spare 4 "spare";
    }

    /// AS in V3.
    pub struct Status3(3) {
        count 1 "rce_ep";
        /// RCE, reduced capability: 0 none, 1 TABS, 3 other.
        populated 2 "rce" reduced_capability: u8;
        count 1 "rrl_ep";
        /// RRL: the rate of replies is limited.
        populated_flag 1 "rrl" is_reply_limited;
        count 1 "tpw_ep";
        /// TPW, transmit power: 0 unknown or below 70 W, 1 70 W, 2 125 W, 3 200 W.
        populated 2 "tpw" transmit_power: u8;
        count 1 "tsi_ep";
        /// TSI, transponder: 0 unknown, 1 left or single, 2 right, 3 auxiliary.
        populated 2 "tsi" transponder_side: u8;
        count 1 "tao_ep";
        count 1 "tao_re";
        /// TAO, offset of the transponder's antenna, 0 to 63.
        count 6 "tao" antenna_offset: u8;
        spare 5 "spare";
    }

    /// UAS in V3.
    pub struct Unmanned3(1) {
        count 1 "muo_ep";
        /// MUO: unmanned.
        populated_flag 1 "muo" is_unmanned;
        count 1 "daa_ep";
        /// DAA, detect and avoid: 0 none, 1 with resolution advisories, 2 without.
        populated 2 "daa" detect_and_avoid: u8;
        count 1 "rwc_ep";
        /// RWC: a corrective alert to remain well clear is active.
        populated_flag 1 "rwc" has_well_clear_alert;
        spare 1 "spare";
    }

    /// CASS in V3.
    pub struct CollisionAvoidance3(1) {
        count 1 "svh_ep";
        /// SVH, sense of advisories: 0 vertical, 1 horizontal, 2 blended, 3 either for each intruder.
        populated 2 "svh" advisory_sense: u8;
        count 1 "catc_ep";
        /// CATC, kind of collision avoidance, 0 to 7.
        populated 3 "catc" collision_avoidance: u8;
        spare 1 "spare";
    }
}

expansion_field! { ReservedExpansion }
