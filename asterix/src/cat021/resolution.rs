//! Advisory of the collision avoidance system: I021/260.

use crate::item::items;

items! {
    /// I021/260, ACAS resolution advisory.
    pub struct ResolutionAdvisory(7) {
        /// TYP, type of the message: 28 of 1090 ES.
        count 5 "typ" message_type / with_message_type: u8;
        /// STYP, its subtype: 2 of 1090 ES.
        count 3 "styp" subtype / with_subtype: u8;
        /// ARA, active resolution advisories, 14 bits.
        count 14 "ara" advisories / with_advisories: u16;
        /// RAC, record of complements, four bits.
        count 4 "rac" complements / with_complements: u8;
        /// RAT: the advisory has ended.
        flag 1 "rat" is_terminated / with_terminated;
        /// MTE: several threats at once.
        flag 1 "mte" has_multiple_threats / with_multiple_threats;
        /// TTI, kind of the threat's identity.
        count 2 "tti" threat_type / with_threat_type: u8;
        /// TID, the threat's identity, 26 bits.
        count 26 "tid" threat / with_threat: u32;
    }
}
