//! STA in RE: capability and status of the aircraft.

use crate::item::items;

items! {
    /// STA in RE: aircraft status: one octet and, where sent, its extensions (5 in edition 1.5; more are kept).
    ///
    /// For most values a bit states whether they are populated: `None` if not, or if the extension is absent.
    extended pub struct AircraftStatus {
        first {
            /// ES: receives 1090 ES.
            flag 1 "es" receives_squitter / with_squitter;
            /// UAT: receives UAT.
            flag 1 "uat" receives_uat / with_uat;
            count 1 "rce_ep";
            /// RCE, reduced capability: 0 none, 1 TABS, 3 other.
            populated 2 "rce" reduced_capability: u8;
            count 1 "rrl_ep";
            /// RRL: the rate of replies is limited.
            populated_flag 1 "rrl" is_reply_limited;
        }
        extension {
            count 1 "ps3_ep";
            /// PS3, priority status of version 3: 0 none, 1 general emergency, 2 unmanned aircraft without link, 3 minimum
            /// fuel, 4 no communications, 5 unlawful interference, 6 in distress, 7 in distress, activated manually.
            populated 3 "ps3" priority: u8;
            count 1 "tpw_ep";
            /// TPW, transmit power: 0 unknown or below 70 W, 1 70 W, 2 125 W, 3 200 W.
            populated 2 "tpw" transmit_power: u8;
        }
        extension {
            count 1 "tsi_ep";
            /// TSI, transponder: 0 unknown, 1 left or single, 2 right, 3 auxiliary.
            populated 2 "tsi" transponder_side: u8;
            count 1 "muo_ep";
            /// MUO: unmanned.
            populated_flag 1 "muo" is_unmanned;
            count 1 "rwc_ep";
            /// RWC: a corrective alert to remain well clear is active.
            populated_flag 1 "rwc" has_well_clear_alert;
        }
        extension {
            count 1 "daa_ep";
            /// DAA, detect and avoid: 0 none, 1 with resolution advisories, 2 without.
            populated 2 "daa" detect_and_avoid: u8;
            count 1 "df17ca_ep";
            /// DF17CA, capability of the transponder, 0 to 7.
            populated 3 "df17ca" transponder_capability: u8;
        }
        extension {
            count 1 "svh_ep";
            /// SVH, sense of advisories: 0 vertical, 1 horizontal, 2 blended, 3 either for each intruder.
            populated 2 "svh" advisory_sense: u8;
            count 1 "catc_ep";
            /// CATC, kind of collision avoidance, 0 to 7.
            populated 3 "catc" collision_avoidance: u8;
        }
        extension {
            count 1 "tao_ep";
            /// TAO, offset of the transponder's antenna as a code, 0 to 31.
            populated 5 "tao" antenna_offset: u8;
            spare 1 "spare_6";
        }
    }
}
