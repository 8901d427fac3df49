//! How long the slots of the live service took, counted in buckets: quantiles of any interval, and of several services
//! together, can be had of them.

use std::time::Duration;

/// How late slots are published: from what a timer costs to what nobody calls a picture any more.
const LATENESS_S: &[f64] = &[0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0];
/// How old the positions of a slot are when they are published: the usual latencies, and a slot on either side of the default.
const LATENCY_S: &[f64] =
    &[0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 6.25, 6.5, 7.0, 8.0, 10.0, 15.0, 20.0, 30.0, 60.0];

/// Of the slots since the start.
#[derive(Clone, Debug)]
pub struct Timings {
    /// From when a slot was due to its publication.
    pub lateness: Histogram,
    /// From the time that its positions are of to its publication.
    pub latency: Histogram,
}

impl Default for Timings {
    fn default() -> Self {
        Self { lateness: Histogram::new(LATENESS_S), latency: Histogram::new(LATENCY_S) }
    }
}

/// Durations by how long they were.
#[derive(Clone, Debug)]
pub struct Histogram {
    /// Greatest duration of each bucket, seconds, ascending.
    bounds_s: &'static [f64],
    /// How many fell into each, and, at the end, above them all.
    counts: Vec<u64>,
    sum: Duration,
}

impl Histogram {
    fn new(bounds_s: &'static [f64]) -> Self {
        Self { bounds_s, counts: vec![0; bounds_s.len() + 1], sum: Duration::ZERO }
    }

    /// One more.
    pub fn note(&mut self, duration: Duration) {
        let seconds = duration.as_secs_f64();
        self.counts[self.bounds_s.partition_point(|&bound_s| bound_s < seconds)] += 1;
        self.sum += duration;
    }

    /// Each bound, seconds, and how many were not longer.
    pub fn cumulative(&self) -> impl Iterator<Item = (f64, u64)> {
        let mut up_to = 0;
        self.bounds_s.iter().zip(&self.counts).map(move |(&bound_s, count)| {
            up_to += count;
            (bound_s, up_to)
        })
    }

    /// How many there were.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// How long they were together, seconds.
    pub fn sum_s(&self) -> f64 {
        self.sum.as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_duration_counts_up_to_its_bound_and_a_long_one_in_the_sum() {
        let mut lateness = Timings::default().lateness;
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
        fn each_bucket_holds_what_is_not_longer(durations_ms in prop::collection::vec(0..70_000u64, 0..50)) {
            let mut latency = Timings::default().latency;
            durations_ms.iter().for_each(|&ms| latency.note(Duration::from_millis(ms)));
            for (bound_s, count) in latency.cumulative() {
                let expected = durations_ms.iter().filter(|&&ms| ms as f64 <= bound_s * 1000.0).count();
                prop_assert_eq!(count, expected as u64, "{}", bound_s);
            }
            prop_assert_eq!(latency.count(), durations_ms.len() as u64);
        }
    }
}
