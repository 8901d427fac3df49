//! A histogram of durations, of bounded size.

/// Values are truncated to 2^10 ns, about 1 µs, before binning.
const CUT_BITS: u32 = 10;

/// An octave has 2^5 bins: a bin is at most 1/32 (3 %) of its values wide.
const BINS_BITS: u32 = 5;

/// Durations in bins of 3 % of their value (1 µs below 32 µs), for quantiles without keeping the values.
///
/// A quantile is the mean of the bin that holds it: off by at most 3 %, and exact where all values of the bin are equal.
#[derive(Clone, Debug, Default)]
pub(super) struct Histogram {
    /// In order of magnitude; at most about 1,600.
    negative: Vec<Bin>,
    positive: Vec<Bin>,
    count: u64,
    range: Option<(i64, i64)>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    count: u64,
    sum_ns: i128,
}

impl Bin {
    /// Of a bin that holds something.
    fn mean_ns(self) -> i64 {
        (self.sum_ns / i128::from(self.count)) as i64
    }
}

/// The bin of values of this magnitude.
fn index(magnitude_ns: u64) -> usize {
    let value = magnitude_ns >> CUT_BITS;
    let octave = value.checked_ilog2().unwrap_or(0).saturating_sub(BINS_BITS);
    ((octave << BINS_BITS) as u64 + (value >> octave)) as usize
}

impl Histogram {
    /// Counts a duration, which may be negative; nanoseconds.
    pub(super) fn add(&mut self, length_ns: i64) {
        let bins = if length_ns < 0 { &mut self.negative } else { &mut self.positive };
        let index = index(length_ns.unsigned_abs());
        if bins.len() <= index {
            bins.resize(index + 1, Bin::default());
        }
        bins[index].count += 1;
        bins[index].sum_ns += i128::from(length_ns);
        self.count += 1;
        let (least, greatest) = self.range.unwrap_or((length_ns, length_ns));
        self.range = Some((least.min(length_ns), greatest.max(length_ns)));
    }

    /// The least and the greatest, exact; nanoseconds.
    pub(super) fn range(&self) -> Option<(i64, i64)> {
        self.range
    }

    /// The duration that a share (0 to 1) of all do not exceed, nanoseconds.
    pub(super) fn quantile(&self, share: f64) -> Option<i64> {
        let (least, greatest) = self.range?;
        let rank = ((self.count as f64 * share).ceil() as u64).max(1);
        let mut below = 0;
        let holds_it = self.bins().find(|bin| {
            below += bin.count;
            below >= rank
        });
        Some(holds_it.map_or(greatest, Bin::mean_ns).clamp(least, greatest))
    }

    /// Number of durations longer than this, each bin counting as its mean.
    pub(super) fn longer_than(&self, length_ns: i64) -> u64 {
        self.bins().filter(|bin| bin.mean_ns() > length_ns).map(|bin| bin.count).sum()
    }

    /// The non-empty bins, in order of value.
    fn bins(&self) -> impl Iterator<Item = Bin> {
        let bins = self.negative.iter().rev().chain(&self.positive);
        bins.copied().filter(|bin| bin.count > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn equal_lengths_are_exact_and_nothing_has_no_median() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.quantile(0.5), histogram.range()), (None, None));
        for _ in 0..1000 {
            histogram.add(250_000_000);
        }
        histogram.add(9_000_000_000);
        assert_eq!(histogram.quantile(0.5), Some(250_000_000));
        assert_eq!(histogram.quantile(1.0), Some(9_000_000_000));
        assert_eq!(histogram.range(), Some((250_000_000, 9_000_000_000)));
        assert_eq!((histogram.longer_than(250_000_000), histogram.longer_than(0)), (1, 1001));
    }

    #[test]
    fn bins_follow_each_other_and_are_bounded() {
        let edges = (0..63).flat_map(|bit| [(1_u64 << bit) - 1, 1 << bit, (1 << bit) + (1 << bit >> 5)]);
        let indices: Vec<usize> = edges.map(index).collect();
        assert!(indices.is_sorted());
        assert_eq!((index(0), index(1 << 10), index(31 << 10), index(32 << 10)), (0, 1, 31, 32));
        assert!(index(u64::MAX) < 1_632);
    }

    proptest! {
        #[test]
        fn quantiles_are_within_the_width_of_a_bin(
            mut lengths in prop::collection::vec(-100_000_000_000_i64..100_000_000_000, 1..200),
            share in 0.0..=1.0_f64,
        ) {
            let mut histogram = Histogram::default();
            lengths.iter().for_each(|&length| histogram.add(length));
            lengths.sort_unstable();
            let rank = ((lengths.len() as f64 * share).ceil() as usize).max(1);
            let exact = lengths[rank - 1];
            let found = histogram.quantile(share).unwrap();
            prop_assert!((found - exact).abs() as f64 <= exact.abs() as f64 / 32.0 + 1024.0, "{found} {exact}");
        }
    }
}
