//! Six-bit characters (ICAO Annex 10, volume IV, table 3-7).

/// Decodes to ASCII, four characters from three octets; `None` if a code is not a character.
pub(super) fn decode(octets: &[u8]) -> Option<Vec<u8>> {
    let codes = octets.chunks(3).flat_map(|three| {
        let word = three.iter().fold(0_u32, |word, &octet| word << 8 | u32::from(octet));
        [18, 12, 6, 0].map(|shift| (word >> shift & 0x3f) as u8)
    });
    codes
        .map(|code| match code {
            1..=26 => Some(code - 1 + b'A'),
            b' ' | b'0'..=b'9' => Some(code),
            _ => None,
        })
        .collect()
}

/// Encodes a text into `octets`, padded with spaces; `None` if it is too long or has another character.
pub(super) fn encode(text: &str, octets: &mut [u8]) -> Option<()> {
    if text.len() > octets.len() / 3 * 4 {
        return None;
    }
    let mut letters = text.bytes().chain(std::iter::repeat(b' '));
    for three in octets.chunks_exact_mut(3) {
        let mut word = 0_u32;
        for letter in letters.by_ref().take(4) {
            let code = match letter {
                b'A'..=b'Z' => letter - b'A' + 1,
                b' ' | b'0'..=b'9' => letter,
                _ => return None,
            };
            word = word << 6 | u32::from(code);
        }
        three.copy_from_slice(&word.to_be_bytes()[1..]);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_round_trip() {
        let mut octets = [0; 6];
        encode("ROT415", &mut octets).unwrap();
        assert_eq!(octets, [0x48, 0xf5, 0x34, 0xc7, 0x58, 0x20]);
        assert_eq!(decode(&octets).unwrap(), b"ROT415  ");
        assert_eq!(decode(&[0; 6]), None);
        assert_eq!((encode("rot", &mut octets), encode("123456789", &mut octets)), (None, None));
    }
}
