//! Bit fields in octets; bits are counted from the highest bit of the first octet.

/// The `width` (at most 64) bits that begin at bit `offset`, as an unsigned number.
#[inline]
pub(crate) const fn get(octets: &[u8], offset: usize, width: usize) -> u64 {
    let (mut index, end) = (offset / 8, offset + width);
    if end > index * 8 + 64 {
        return get_of_nine(octets, offset, width);
    }
    let mut word = 0;
    while index * 8 < end {
        word = word << 8 | octets[index] as u64;
        index += 1;
    }
    word >> (index * 8 - end) & mask(width)
}

/// Like [`get`], for more than 56 bits, which extend over nine octets.
const fn get_of_nine(octets: &[u8], offset: usize, width: usize) -> u64 {
    get(octets, offset, width - 8) << 8 | get(octets, offset + width - 8, 8)
}

/// `octets` with the `width` (at most 64) bits that begin at bit `offset` replaced by the low bits of `value`.
#[inline]
pub(crate) const fn set<const N: usize>(
    mut octets: [u8; N],
    offset: usize,
    width: usize,
    value: u64,
) -> [u8; N] {
    put(&mut octets, offset, width, value);
    octets
}

/// Replaces the `width` (at most 64) bits that begin at bit `offset` by the low bits of `value`.
#[inline]
pub(crate) const fn put(octets: &mut [u8], offset: usize, width: usize, value: u64) {
    let end = offset + width;
    if end <= offset / 8 * 8 + 8 {
        // Most fields are in one octet.
        let (shift, octet) = (offset / 8 * 8 + 8 - end, &mut octets[offset / 8]);
        let mask = mask(width) << shift;
        *octet = *octet & !mask as u8 | (value << shift & mask) as u8;
        return;
    }
    put_in_several(octets, offset, width, value);
}

/// Like [`put`], for bits that extend over several octets.
const fn put_in_several(octets: &mut [u8], offset: usize, width: usize, value: u64) {
    let end = offset + width;
    if end > offset / 8 * 8 + 64 {
        return put_in_nine(octets, offset, width, value);
    }
    let mut index = end.div_ceil(8);
    let shift = index * 8 - end;
    let mut bits = (value & mask(width)) << shift;
    let mut kept = !(mask(width) << shift);
    while index * 8 > offset {
        index -= 1;
        octets[index] = octets[index] & kept as u8 | bits as u8;
        bits >>= 8;
        kept = kept >> 8 | 0xff << 56;
    }
}

/// Like [`put`], for more than 56 bits, which extend over nine octets.
const fn put_in_nine(octets: &mut [u8], offset: usize, width: usize, value: u64) {
    put(octets, offset, width - 8, value >> 8);
    put(octets, offset + width - 8, 8, value);
}

/// The lowest `width` bits of `word` as two's complement.
pub(crate) const fn signed(word: u64, width: usize) -> i64 {
    (word << (64 - width)) as i64 >> (64 - width)
}

/// The integer nearest to `value`, halves away from zero; `None` outside `min` to `max` and for NaN.
pub(crate) fn nearest(value: f64, min: i64, max: i64) -> Option<i64> {
    let rounded = libm::round(value);
    (rounded >= min as f64 && rounded <= max as f64).then_some(rounded as i64)
}

/// Like [`nearest`], encoded in `width` bits (at most 32); `None` if it does not fit.
pub(crate) fn nearest_count(value: f64, width: usize, signed: bool) -> Option<u64> {
    let range = 1_i64 << width;
    let low = if signed { -range / 2 } else { 0 };
    nearest(value, low, low + range - 1).map(|count| count as u64)
}

/// The angle reduced to 0 to 360 degrees: `f64::rem_euclid`, which needs the standard library.
pub(crate) fn turned(angle_deg: f64) -> f64 {
    let rest = angle_deg % 360.0;
    if rest < 0.0 { rest + 360.0 } else { rest }
}

/// A mask of the lowest `width` bits.
pub(crate) const fn mask(width: usize) -> u64 {
    if width >= 64 { u64::MAX } else { (1 << width) - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_any_place_and_width() {
        let octets = [0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0, 0x12];
        assert_eq!(get(&octets, 0, 8), 0x12);
        assert_eq!(get(&octets, 4, 12), 0x234);
        assert_eq!(get(&octets, 7, 1), 0);
        assert_eq!(get(&octets, 4, 64), 0x2345_6789_abcd_ef01);
        assert_eq!(get(&octets, 15, 3), 0b001);
        assert_eq!((signed(0x3fff, 14), signed(0x1fff, 14), signed(u64::MAX, 64)), (-1, 8191, -1));
    }

    #[test]
    fn rounds_halves_away_from_zero() {
        for (value, expected) in
            [(0.5, Some(1)), (-0.5, Some(-1)), (0.49, Some(0)), (2.4999, Some(2)), (-2.5, Some(-3))]
        {
            assert_eq!(nearest(value, -3, 3), expected);
        }
        for value in [3.5, -3.5, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(nearest(value, -3, 3), None);
        }
        assert_eq!((nearest_count(-8.4, 4, true), nearest_count(7.5, 4, true)), (Some(-8_i64 as u64), None));
        assert_eq!((nearest_count(15.4, 4, false), nearest_count(-0.6, 4, false)), (Some(15), None));
    }

    #[test]
    fn extends_the_sign_of_any_width() {
        for (word, width, expected) in [
            (0x3fff, 14, -1),
            (0x1fff, 14, 8191),
            (0xff_ffff, 24, -1),
            (0x8_0000, 20, -524_288),
            (0xabc7_ffff, 20, 524_287),
        ] {
            assert_eq!(signed(word, width), expected);
        }
    }

    proptest::proptest! {
        #[test]
        fn written_bits_are_read_back_and_others_are_unchanged(
            octets: [u8; 12], offset in 0_usize..96, width in 1_usize..=64, value: u64,
        ) {
            proptest::prop_assume!(offset + width <= 96);
            let changed = set(octets, offset, width, value);
            proptest::prop_assert_eq!(get(&changed, offset, width), value & mask(width));
            for bit in (0..96).filter(|bit| !(offset..offset + width).contains(bit)) {
                proptest::prop_assert_eq!(get(&changed, bit, 1), get(&octets, bit, 1));
            }
            proptest::prop_assert_eq!(set(changed, offset, width, get(&octets, offset, width)), octets);
        }
    }
}
