//! Registers of a transponder.

use crate::item::items;

items! {
    /// A part of I048/250 (5.2.25), I021/250 and BDSDATA in I062/380: a BDS register that the transponder sent.
    pub struct BdsRegister(8) {
        /// MB data, the 56 bits of the register.
        hex 56 "data" data / with_data: u64;
        /// BDS1, the first half of the register's number: 4 of BDS 4,0.
        count 4 "bds1" bds1 / with_bds1: u8;
        /// BDS2, the second half of the register's number: 0 of BDS 4,0.
        count 4 "bds2" bds2 / with_bds2: u8;
    }
}
