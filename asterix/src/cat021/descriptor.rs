//! Target report descriptor: I021/040.

use crate::item::items;

items! {
    /// ATP in I021/040: kind of the target address.
    pub enum AddressType {
        /// the aircraft's 24-bit ICAO address.
        Icao = 0,
        /// an address used by another target, too.
        Duplicate = 1,
        /// address of a surface vehicle.
        SurfaceVehicle = 2,
        /// anonymous.
        Anonymous = 3,
    }

    /// ARC in I021/040: step of the reported altitude.
    all pub enum AltitudeReporting {
        /// 0: 25 ft.
        Feet25,
        /// 1: 100 ft.
        Feet100,
        /// 2: unknown.
        Unknown,
        /// 3: not a valid code.
        Invalid,
    }

    /// CL in I021/040: confidence in the report.
    pub enum Confidence {
        /// valid.
        Valid = 0,
        /// suspect.
        Suspect = 1,
        /// no information.
        Unknown = 2,
    }

    /// I021/040, target report descriptor: one octet and, where sent, its extensions (4 in edition 2.6; more are kept).
    ///
    /// Values of an absent extension are `false`, or `None` if a bit states whether they are populated.
    extended pub struct TargetReport {
        first {
            /// ATP, kind of the target address.
            code 3 "atp" address_type / with_address_type: AddressType;
            /// ARC, step of the reported altitude.
            code 2 "arc" altitude_reporting / with_altitude_reporting: AltitudeReporting;
            /// RC: within range, validation of the position still pending.
            flag 1 "rc" is_range_checked / with_range_checked;
            /// RAB: from a field monitor, not from an aircraft.
            flag 1 "rab" is_field_monitor / with_field_monitor;
        }
        extension {
            /// DCR: differentially corrected.
            flag 1 "dcr" is_corrected / with_corrected;
            /// GBS: the ground bit is set.
            flag 1 "gbs" is_on_ground / with_on_ground;
            /// SIM: a simulated target.
            flag 1 "sim" is_simulated / with_simulated;
            /// TST: a test target.
            flag 1 "tst" is_test / with_test;
            /// SAA: cannot provide the selected altitude.
            flag 1 "saa" lacks_selected_altitude / with_selected_altitude_lacking;
            /// CL, confidence in the report.
            code 2 "cl" confidence / with_confidence: Confidence;
        }
        extension {
            spare 1 "spare_3";
            /// LLC: the address failed the look-up in a list; from edition 2.3 on.
            flag 1 "llc" is_lookup_failed / with_lookup_failed;
            /// IPC: the independent check of the position failed.
            flag 1 "ipc" is_position_check_failed / with_position_check_failed;
            /// NOGO: not to be used.
            flag 1 "nogo" is_nogo / with_nogo;
            /// CPR: the validation of the compact position failed.
            flag 1 "cpr" is_compact_position_invalid / with_compact_position_invalid;
            /// LDPJ: the locally decoded position jumped.
            flag 1 "ldpj" has_position_jump / with_position_jump;
            /// RCF: the range check failed.
            flag 1 "rcf" is_out_of_range / with_out_of_range;
        }
        extension {
            count 1 "tbc_ep";
            /// TBC, total number of bits corrected; from edition 2.6 on.
            populated 6 "tbc" bits_corrected: u8;
        }
        extension {
            count 1 "mbc_ep";
            /// MBC, maximum number of bits corrected in a message; from edition 2.6 on.
            populated 6 "mbc" most_bits_corrected: u8;
        }
    }
}
