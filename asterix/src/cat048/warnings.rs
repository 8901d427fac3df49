//! Warnings, error conditions and target classification: I048/030.

use deku::DekuError;
use deku::no_std_io::{Read, Seek};
use deku::reader::Reader;
use smallvec::SmallVec;

use crate::item::in_place;
use crate::octets::read_octet;
use crate::{Describe, Layout};

/// I048/030 (5.2.3), and I015/030: one or more codes of 7 bits. [`warning_name`] names those of I048/030; undefined ones are
/// kept.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Warnings(SmallVec<[u8; 16]>);

impl Warnings {
    /// The item with these codes, in this order; `None` if there is no code or one is above 127.
    pub fn new(codes: &[u8]) -> Option<Self> {
        if codes.iter().any(|&code| code > 0x7f) {
            return None;
        }
        let mut octets: SmallVec<_> = codes.iter().map(|code| code << 1 | 1).collect();
        *octets.last_mut()? &= !1;
        Some(Self(octets))
    }

    /// The octets of the item: the codes, each with FX.
    pub fn octets(&self) -> &[u8] {
        &self.0
    }

    /// The codes, 0 to 127, in the order sent; at least one.
    pub fn codes(&self) -> impl Iterator<Item = u8> {
        self.0.iter().map(|octet| octet >> 1)
    }

    #[inline(always)]
    fn read<R: Read + Seek>(reader: &mut Reader<R>) -> Result<Self, DekuError> {
        let mut octets = SmallVec::new();
        loop {
            let octet = read_octet(reader)?;
            octets.push(octet);
            if octet & 1 == 0 {
                return Ok(Self(octets));
            }
        }
    }
}

impl Describe for Warnings {
    const LAYOUT: Layout = Layout::Codes;
}

in_place! {
    Warnings () reader => Self::read(reader),
    self writer => writer.write_bytes(&self.0)
}

/// Meaning of a code of I048/030 in edition 1.32; `None` if the code is undefined.
pub const fn warning_name(code: u8) -> Option<&'static str> {
    Some(match code {
        1 => "multipath reply (reflection)",
        2 => "reply to a sidelobe",
        3 => "split plot",
        4 => "second time around reply",
        5 => "angel",
        6 => "slow target on a road (vehicle)",
        7 => "fixed PSR plot",
        8 => "slow PSR target",
        9 => "low quality PSR plot",
        10 => "phantom SSR plot",
        11 => "Mode 3/A code does not match",
        12 => "altitude code abnormal for the track",
        13 => "target in clutter area",
        14 => "maximum Doppler response in the zero filter",
        15 => "transponder anomaly",
        16 => "duplicated or illegal Mode S address",
        17 => "Mode S error correction applied",
        18 => "altitude code not decodable",
        19 => "birds",
        20 => "flock of birds",
        21 => "Mode 1 in the original reply",
        22 => "Mode 2 in the original reply",
        23 => "plot possibly of a wind turbine",
        24 => "helicopter",
        25 => "maximum of re-interrogations reached (surveillance)",
        26 => "maximum of re-interrogations reached (BDS)",
        27 => "BDS overlay incoherent",
        28 => "possible BDS swap",
        29 => "track updated in the zenithal gap",
        30 => "Mode S track acquired again",
        31 => "duplicated Mode 5 pair",
        32 => "wrong DF reply format",
        33 => "Mode S transponder answers Mode A/C-only all-call",
        34 => "wrong SI capability report",
        35 => "possible IC conflict",
        36 => "IC conflict detection possible, none now",
        37 => "duplicate Mode 5 PIN",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_in_order() {
        let warnings = Warnings::new(&[19, 0, 127]).unwrap();
        assert_eq!(warnings.octets(), [0x27, 0x01, 0xfe]);
        assert_eq!(warnings.codes().collect::<Vec<_>>(), [19, 0, 127]);
        assert_eq!(Warnings::new(&[8]).unwrap().octets(), [0x10]);
        assert!(Warnings::new(&[7; 200]).unwrap().codes().eq([7; 200]));
        for refused in [&[][..], &[128][..]] {
            assert_eq!(Warnings::new(refused), None);
        }
    }

    #[test]
    fn names() {
        assert_eq!(warning_name(19), Some("birds"));
        assert_eq!((warning_name(0), warning_name(38)), (None, None));
    }
}
