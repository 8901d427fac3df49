//! Numbers and octets in JSON.

use crate::hex;

/// Octets as a string of hexadecimal digits.
pub(super) fn write_hex(out: &mut Vec<u8>, octets: &[u8]) {
    out.push(b'"');
    hex::push(out, octets);
    out.push(b'"');
}

/// `value` with so many decimals, trailing zeros left out but for one: `34.98`, `3.0`; without any where `decimals` is 0.
pub(super) fn write_decimal(out: &mut Vec<u8>, value: f64, decimals: u8) {
    let scale = 10_u64.pow(u32::from(decimals));
    let scaled = (value * scale as f64).round() as i64;
    if scaled < 0 {
        out.push(b'-');
    }
    let (whole, fraction) = (scaled.unsigned_abs() / scale, scaled.unsigned_abs() % scale);
    write_integer(out, whole);
    if decimals > 0 {
        out.push(b'.');
        let start = out.len();
        let mut digit = scale / 10;
        let mut left = fraction;
        while left > 0 || out.len() == start {
            out.push(b'0' + (left / digit) as u8);
            left %= digit;
            digit /= 10;
        }
    }
}

/// A whole number.
pub(super) fn write_integer(out: &mut Vec<u8>, number: u64) {
    let mut digits = [0; 20];
    let mut at = digits.len();
    let mut left = number;
    loop {
        at -= 1;
        digits[at] = b'0' + (left % 10) as u8;
        left /= 10;
        if left == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
}

/// `value` to 10^-`decimals`, so that JSON shows no more digits than mean something.
pub(crate) fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decimal(value: f64, decimals: u8) -> String {
        let mut out = Vec::new();
        write_decimal(&mut out, value, decimals);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn decimals() {
        assert_eq!(decimal(1_627.734_375, 1), "1627.7");
        assert_eq!(decimal(34.980_468_75, 3), "34.98");
        assert_eq!(decimal(-0.000_000_167, 8), "-0.00000017");
        assert_eq!(decimal(-0.04, 1), "0.0");
        assert_eq!(decimal(3.0, 2), "3.0");
        assert_eq!(decimal(-55.0, 0), "-55");
        assert_eq!(decimal(86_399.992_187_5, 7), "86399.9921875");
        assert_eq!(decimal(10.05, 2), "10.05");
    }

    proptest::proptest! {
        #[test]
        fn decimals_read_as_the_rounded_number(value in -1e6..1e6_f64, decimals in 0_u8..8) {
            let read: f64 = decimal(value, decimals).parse().unwrap();
            proptest::prop_assert!((read - value).abs() <= 0.501 * 10_f64.powi(-i32::from(decimals)));
        }
    }

    #[test]
    fn integers() {
        for number in [0, 9, 10, 4095, u64::MAX] {
            let mut out = Vec::new();
            write_integer(&mut out, number);
            assert_eq!(String::from_utf8(out).unwrap(), number.to_string());
        }
    }
}
