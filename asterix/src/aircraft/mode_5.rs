//! Mode 5 in the reserved expansion fields of CAT021 and CAT048.

use crate::item::items;

items! {
    /// XP in MES (CAT021), and in MD5 and M5N (CAT048): the replies in which an X pulse was present.
    pub struct XPulses(1) {
        spare 2 "spare";
        /// XP: Mode 5 PIN.
        flag 1 "xp" in_mode_5_pin / with_mode_5_pin;
        /// X5: Mode 5 data.
        flag 1 "x5" in_mode_5_data / with_mode_5_data;
        /// XC: Mode C.
        flag 1 "xc" in_mode_c / with_mode_c;
        /// X3: Mode 3/A.
        flag 1 "x3" in_mode_3a / with_mode_3a;
        /// X2: Mode 2.
        flag 1 "x2" in_mode_2 / with_mode_2;
        /// X1: Mode 1.
        flag 1 "x1" in_mode_1 / with_mode_1;
    }

    /// FOM in MES (CAT021) and in M5N (CAT048): figure of merit of the reported position.
    pub struct FigureOfMerit(1) {
        spare 3 "spare";
        /// The figure, 0 to 31.
        count 5 "fom" figure / with_figure: u8;
    }
}
