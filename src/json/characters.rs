//! Characters of six bits (ICAO Annex 10, volume IV, table 3-7).

/// The characters in ASCII, four to three octets; `None` where a code stands for no character.
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

/// The octets of a text of so many octets, filled up with spaces; `None` for a longer text or another character.
pub(super) fn encode(text: &str, octets: usize) -> Option<Vec<u8>> {
    let places = octets / 3 * 4;
    if text.len() > places {
        return None;
    }
    let mut codes = Vec::with_capacity(places);
    for index in 0..places {
        codes.push(match text.as_bytes().get(index).copied().unwrap_or(b' ') {
            letter @ b'A'..=b'Z' => letter - b'A' + 1,
            other @ (b' ' | b'0'..=b'9') => other,
            _ => return None,
        });
    }
    let words =
        codes.chunks(4).map(|four| four.iter().fold(0_u32, |word, &code| word << 6 | u32::from(code)));
    Some(words.flat_map(|word| word.to_be_bytes()[1..].to_vec()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_read_back() {
        let octets = encode("ROT415", 6).unwrap();
        assert_eq!(octets, [0x48, 0xf5, 0x34, 0xc7, 0x58, 0x20]);
        assert_eq!(decode(&octets).unwrap(), b"ROT415  ");
        assert_eq!(decode(&[0; 6]), None);
        assert_eq!((encode("rot", 6), encode("123456789", 6)), (None, None));
    }
}
