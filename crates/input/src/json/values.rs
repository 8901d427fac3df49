//! Numbers and octets in JSON.

use std::fmt;
use std::io::Write;

use crate::hex;

/// Octets as a string of hexadecimal digits.
pub(super) fn write_hex(out: &mut Vec<u8>, octets: &[u8]) {
    out.push(b'"');
    hex::push(out, octets);
    out.push(b'"');
}

/// `value` with this number of decimals, without trailing zeros except one: `34.98`, `3.0`. Without a decimal point if `decimals`
/// is 0.
pub(super) fn write_decimal(out: &mut Vec<u8>, value: f64, decimals: u8) {
    let scaled = nearest(value * POWERS_OF_TEN[usize::from(decimals)]);
    if scaled < 0 {
        out.push(b'-');
    }
    let (mut left, mut places) = (scaled.unsigned_abs(), decimals);
    if places == 0 {
        return write_integer(out, left);
    }
    while places > 1 && left.is_multiple_of(10) {
        left /= 10;
        places -= 1;
    }
    if left >= 10_u64.pow(Digits::FEW - 2) || u32::from(places) > Digits::FEW - 2 {
        let scale = 10_u64.pow(places.into());
        let (whole, fraction, places) = (left / scale, left % scale, usize::from(places));
        return write_long(out, format_args!("{whole}.{fraction:0places$}"));
    }
    let mut digits = Digits::default();
    for _ in 0..places {
        left = digits.push(left);
    }
    digits.put(b'.');
    digits.whole(left);
    digits.append_to(out);
}

/// Exact factors for numbers of decimals.
const POWERS_OF_TEN: [f64; 19] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18];

/// Nearest whole number, halves away from zero, as [`f64::round`] but without its call.
fn nearest(value: f64) -> i64 {
    // The largest number below one half; added to itself it must not give one.
    (value + 0.499_999_999_999_999_94_f64.copysign(value)) as i64
}

/// A whole number.
pub(super) fn write_integer(out: &mut Vec<u8>, number: u64) {
    if number < 10 {
        return out.push(b'0' + number as u8);
    }
    if number >= 10_u64.pow(Digits::FEW) {
        return write_long(out, format_args!("{number}"));
    }
    let mut digits = Digits::default();
    digits.whole(number);
    digits.append_to(out);
}

#[cold]
fn write_long(out: &mut Vec<u8>, number: fmt::Arguments<'_>) {
    out.write_fmt(number).expect("writing to a vector cannot fail");
}

/// Characters of a number, assembled from the last to the first in one word. A load after a single store of the word does not
/// stall, unlike one after stores of single octets.
#[derive(Default)]
struct Digits {
    word: u128,
    length: usize,
}

impl Digits {
    /// Number of characters that fit a word.
    const FEW: u32 = 16;

    fn put(&mut self, character: u8) {
        self.word = self.word << 8 | u128::from(character);
        self.length += 1;
    }

    /// Adds the last digit of a number, and returns the number without it.
    fn push(&mut self, number: u64) -> u64 {
        self.put(b'0' + (number % 10) as u8);
        number / 10
    }

    /// Adds all digits of a number, at least one.
    fn whole(&mut self, number: u64) {
        let mut left = self.push(number);
        while left > 0 {
            left = self.push(left);
        }
    }

    fn append_to(&self, out: &mut Vec<u8>) {
        let start = out.len();
        out.extend_from_slice(&self.word.to_le_bytes());
        out.truncate(start + self.length);
    }
}

/// `value` rounded to `decimals` decimals, so that JSON shows no meaningless digits.
pub fn rounded(value: f64, decimals: i32) -> f64 {
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
        assert_eq!(decimal(99_999_999_999_999.9, 1), "99999999999999.9");
        assert_eq!(decimal(9_999_999_999_999.9, 1), "9999999999999.9");
        assert_eq!(decimal(-1.5e-15, 16), "-0.0000000000000015");
        assert_eq!(decimal(2e-14, 14), "0.00000000000002");
    }

    proptest::proptest! {
        #[test]
        fn rounds_as_the_standard_library_does(bits: u64, half in -1_000_000_i64..1_000_000) {
            for value in [f64::from_bits(bits), half as f64 / 2.0, (half as f64 / 2.0).next_up(), (half as f64 / 2.0).next_down()] {
                proptest::prop_assert_eq!(nearest(value), value.round() as i64);
            }
        }
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
        for number in [0, 9, 10, 4095, 9_999_999_999_999_999, 10_000_000_000_000_000, u64::MAX] {
            let mut out = Vec::new();
            write_integer(&mut out, number);
            assert_eq!(String::from_utf8(out).unwrap(), number.to_string());
        }
    }
}
