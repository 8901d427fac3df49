//! One file a metric.

pub(super) mod association;
pub(super) mod false_tracks;
pub(super) mod gospa;
pub(super) mod identity;
pub(super) mod nees;
pub(super) mod scene;
pub(super) mod statistics;
pub(super) mod update;

/// `numerator / denominator`, where there is something to divide by.
fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}
