//! Mode 3/A code of the transponder: I048/070. Address and identification are in [`aircraft`](crate::aircraft).

use core::fmt;

use crate::item::items;

items! {
    /// I048/070 (5.2.10), Mode 3/A code.
    pub struct Mode3A(2) {
        /// V = 0: the code is validated.
        unset 1 "v" is_validated / with_validated;
        /// G = 1: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// L = 1: the code was not extracted during the last scan.
        flag 1 "l" is_not_extracted / with_not_extracted;
        spare 1 "spare";
        /// The code, 0 to octal 7777: four octal digits, as [`Mode3A`]'s `Display` writes them.
        octal 12 "mode_3a" code / with_code: u16;
    }
}

impl Mode3A {
    /// A validated code read from the reply, or `None` above octal 7777.
    pub const fn new(code: u16) -> Option<Self> {
        Self([0; 2]).with_code(code)
    }
}

impl fmt::Display for Mode3A {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04o}", self.code())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mode_3a_is_octal() {
        let code = Mode3A::from_octets([0xe8, 0x04]);
        assert_eq!((code.code(), code.to_string().as_str()), (0o4004, "4004"));
        assert!(!code.is_validated() && code.is_garbled() && code.is_not_extracted());
        assert_eq!(Mode3A::new(0o7000).map(Mode3A::octets), Some([0x0e, 0x00]));
        assert_eq!(Mode3A::new(0o10000), None);
    }
}
