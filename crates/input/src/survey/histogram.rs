//! A histogram of durations, of bounded size.

/// Values are truncated to 2^10 ns, about 1 µs, before binning.
const CUT_BITS: u32 = 10;

/// An octave has 2^5 bins, so the width of a bin is at most 1/32 (3 %) of its values.
const BINS_BITS: u32 = 5;

/// Durations in bins of 3 % of their value (1 µs below 32 µs), for quantiles without storing the values.
///
/// A quantile is the mean of the bin that contains it: wrong by at most 3 %, and exact if all values of the bin are equal.
#[derive(Clone, Debug, Default)]
pub(super) struct Histogram {
    /// Bins in order of magnitude; at most about 1,600.
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
    /// The mean of a bin that is not empty, in nanoseconds.
    fn mean_ns(self) -> i64 {
        (self.sum_ns / i128::from(self.count)) as i64
    }
}

/// Index of the bin for this magnitude.
fn index(magnitude_ns: u64) -> usize {
    let value = magnitude_ns >> CUT_BITS;
    let octave = value.checked_ilog2().unwrap_or(0).saturating_sub(BINS_BITS);
    ((octave << BINS_BITS) as u64 + (value >> octave)) as usize
}

impl Histogram {
    /// Counts a duration, in nanoseconds; it may be negative.
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

    /// Minimum and maximum, in nanoseconds; exact.
    pub(super) fn range(&self) -> Option<(i64, i64)> {
        self.range
    }

    /// The quantile `share` (0 to 1) of the durations, in nanoseconds.
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

    /// Number of durations above this, in nanoseconds; each bin counts by its mean.
    pub(super) fn longer_than(&self, length_ns: i64) -> u64 {
        self.bins().filter(|bin| bin.mean_ns() > length_ns).map(|bin| bin.count).sum()
    }

    /// The non-empty bins in the order of their values.
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
    fn equal_values_are_exact_and_empty_has_no_median() {
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
    fn bins_are_contiguous_and_bounded() {
        let edges = (0..63).flat_map(|bit| [(1_u64 << bit) - 1, 1 << bit, (1 << bit) + (1 << bit >> 5)]);
        let indices: Vec<usize> = edges.map(index).collect();
        assert!(indices.is_sorted());
        assert_eq!((index(0), index(1 << 10), index(31 << 10), index(32 << 10)), (0, 1, 31, 32));
        assert!(index(u64::MAX) < 1_632);
    }

    proptest! {
        #[test]
        fn quantiles_are_within_one_bin_width(
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
