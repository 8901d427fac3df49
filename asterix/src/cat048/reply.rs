//! Codes from the replies and the confidence in them: Mode 1, 2 and C, I048/050, 055, 060, 065, 080, 100.

use crate::item::items;

items! {
    /// I048/050 (5.2.6), Mode 2 code.
    pub struct Mode2(2) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// L: the code is smoothed by a local tracker, not read from the reply.
        flag 1 "l" is_smoothed / with_smoothed;
        spare 1 "spare";
        /// The code, 0 to octal 7777.
        octal 12 "mode_2" code / with_code: u16;
    }

    /// I048/055 (5.2.7), Mode 1 code.
    pub struct Mode1(1) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        /// L: the code is smoothed by a local tracker, not read from the reply.
        flag 1 "l" is_smoothed / with_smoothed;
        /// The bits A4, A2, A1, B2, B1 of the code; as an octal number it is `(bits >> 2) * 10 + (bits & 3)`.
        count 5 "mode_1" code_bits / with_code_bits: u8;
    }

    /// I048/060 (5.2.8), confidence in the bits of the Mode 2 code.
    pub struct Mode2Confidence(2) {
        spare 4 "spare";
        /// The pulses of low quality, in the order A4 A2 A1 B4 B2 B1 C4 C2 C1 D4 D2 D1 from the highest bit: the bits of the
        /// octal code.
        octal 12 "low_quality" low_quality / with_low_quality: u16;
    }

    /// I048/065 (5.2.9), confidence in the bits of the Mode 1 code.
    pub struct Mode1Confidence(1) {
        spare 3 "spare";
        /// The pulses of low quality, in the order A4 A2 A1 B2 B1 from the highest bit: the bits of the code.
        count 5 "low_quality" low_quality / with_low_quality: u8;
    }

    /// I048/080 (5.2.11), confidence in the bits of the Mode 3/A code.
    pub struct Mode3AConfidence(2) {
        spare 4 "spare";
        /// The pulses of low quality, in the order A4 A2 A1 B4 B2 B1 C4 C2 C1 D4 D2 D1 from the highest bit: the bits of the
        /// octal code.
        octal 12 "low_quality" low_quality / with_low_quality: u16;
    }

    /// I048/100 (5.2.13), Mode C code as received, and the confidence in its bits.
    pub struct ModeC(4) {
        /// V: the code is not validated.
        flag 1 "v" is_not_validated / with_not_validated;
        /// G: the code is garbled.
        flag 1 "g" is_garbled / with_garbled;
        spare 2 "spare";
        /// The code in Gray notation: the pulses C1 A1 C2 A2 C4 A4 B1 D1 B2 D2 B4 D4 from the highest bit.
        hex 12 "mode_c_gray" gray_code / with_gray_code: u16;
        spare 4 "spare_2";
        /// The pulses of low quality, in the order of the code.
        hex 12 "low_quality" low_quality / with_low_quality: u16;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_their_confidence() {
        let code = Mode2::from_octets([0xaa, 0xbc]);
        assert!(code.is_not_validated() && !code.is_garbled() && code.is_smoothed());
        assert_eq!(code.code(), 0o5274);
        assert_eq!(Mode2::default().with_code(0o5274).unwrap().octets(), [0x0a, 0xbc]);
        assert_eq!(Mode2::default().with_code(0o10000), None);
        assert_eq!(Mode1::from_octets([0x5f]).code_bits(), 0x1f);
        assert!(Mode1::from_octets([0x5f]).is_garbled());
        assert_eq!(Mode3AConfidence::from_octets([0xf8, 0x01]).low_quality(), 0o4001);
        let code = ModeC::from_octets([0x7a, 0xbc, 0xf1, 0x23]);
        assert_eq!((code.gray_code(), code.low_quality()), (0xabc, 0x123));
        assert!(!code.is_not_validated() && code.is_garbled());
        assert_eq!(
            format!("{:?}", Mode1Confidence::from_octets([0x11])),
            "Mode1Confidence { low_quality: 17 }"
        );
    }
}
