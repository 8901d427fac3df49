//! Octets as hexadecimal text: lower case, two digits each.

/// Appends the digits of `octets` to `out`.
pub fn push(out: &mut Vec<u8>, octets: &[u8]) {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digits = |octet: &u8| [octet >> 4, octet & 0x0f].map(|digit| DIGITS[usize::from(digit)]);
    out.extend(octets.iter().flat_map(digits));
}

/// The digits of `octets`.
pub fn text(octets: &[u8]) -> String {
    let mut digits = Vec::with_capacity(2 * octets.len());
    push(&mut digits, octets);
    String::from_utf8(digits).expect("digits are ASCII")
}

/// The octets of a hexadecimal text in either case; `None` for other characters or an odd number of digits.
pub fn octets(text: &str) -> Option<Vec<u8>> {
    let digit = |digit: u8| char::from(digit).to_digit(16);
    let octet = |pair: &[u8]| match *pair {
        [high, low] => Some((digit(high)? << 4 | digit(low)?) as u8),
        _ => None,
    };
    text.as_bytes().chunks(2).map(octet).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        #[test]
        fn written_digits_read_back(given: Vec<u8>) {
            let mut out = Vec::new();
            push(&mut out, &given);
            proptest::prop_assert_eq!(&String::from_utf8(out).unwrap(), &text(&given));
            proptest::prop_assert_eq!(octets(&text(&given)), Some(given));
        }
    }

    #[test]
    fn either_case_is_read_and_nothing_else() {
        assert_eq!(octets("0aFf"), Some(vec![0x0a, 0xff]));
        assert_eq!((octets("0aF"), octets("0g"), octets("é")), (None, None, None));
    }
}
