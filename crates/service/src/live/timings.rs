//! Histograms of the live service's slot times. Quantiles of any interval, and of several services together, can be
//! computed from them.

use std::time::Duration;

/// Bounds of the lateness of publication, in seconds: from the cost of a timer to a useless picture.
const LATENESS_S: &[f64] = &[0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0];
/// Bounds of the age of a slot's positions at publication, in seconds: the usual latencies, and one slot on either side of
/// the default.
const LATENCY_S: &[f64] =
    &[0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 6.25, 6.5, 7.0, 8.0, 10.0, 15.0, 20.0, 30.0, 60.0];

/// Histograms of the slots since the start.
#[derive(Clone, Debug)]
pub struct SlotTimings {
    /// Time from a slot's deadline to its publication.
    pub lateness: DurationHistogram,
    /// Time from a slot's positions to their publication.
    pub latency: DurationHistogram,
}

impl Default for SlotTimings {
    fn default() -> Self {
        Self { lateness: DurationHistogram::new(LATENESS_S), latency: DurationHistogram::new(LATENCY_S) }
    }
}

/// Histogram of durations.
#[derive(Clone, Debug)]
pub struct DurationHistogram {
    /// Upper bounds of the buckets, in seconds, ascending.
    bounds_s: &'static [f64],
    /// Number of durations in each bucket, and finally above all of them.
    counts: Vec<u64>,
    sum: Duration,
}

impl DurationHistogram {
    fn new(bounds_s: &'static [f64]) -> Self {
        Self { bounds_s, counts: vec![0; bounds_s.len() + 1], sum: Duration::ZERO }
    }

    /// Adds a duration.
    pub fn note(&mut self, duration: Duration) {
        let seconds = duration.as_secs_f64();
        self.counts[self.bounds_s.partition_point(|&bound_s| bound_s < seconds)] += 1;
        self.sum += duration;
    }

    /// Each bound, in seconds, with the number of durations up to it.
    pub fn cumulative(&self) -> impl Iterator<Item = (f64, u64)> {
        let mut up_to = 0;
        self.bounds_s.iter().zip(&self.counts).map(move |(&bound_s, count)| {
            up_to += count;
            (bound_s, up_to)
        })
    }

    /// Number of durations.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Sum of the durations, in seconds.
    pub fn sum_s(&self) -> f64 {
        self.sum.as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn durations_count_in_their_bucket_and_the_sum() {
        let mut lateness = SlotTimings::default().lateness;
        for ms in [0, 2, 3, 2_000, 2_001] {
            lateness.note(Duration::from_millis(ms));
        }
        let cumulative: Vec<_> = lateness.cumulative().collect();
        assert_eq!(cumulative[..2], [(0.002, 2), (0.005, 3)]);
        assert_eq!(cumulative.last(), Some(&(2.0, 4)));
        assert_eq!((lateness.count(), lateness.sum_s()), (5, 4.006));
    }

    proptest! {
        #[test]
        fn each_bucket_counts_durations_up_to_its_bound(durations_ms in prop::collection::vec(0..70_000u64, 0..50)) {
            let mut latency = SlotTimings::default().latency;
            durations_ms.iter().for_each(|&ms| latency.note(Duration::from_millis(ms)));
            for (bound_s, count) in latency.cumulative() {
                let expected = durations_ms.iter().filter(|&&ms| ms as f64 <= bound_s * 1000.0).count();
                prop_assert_eq!(count, expected as u64, "{}", bound_s);
            }
            prop_assert_eq!(latency.count(), durations_ms.len() as u64);
        }
    }
}
