//! Bins of range and height.

/// Widths of bins of range, metres.
pub(super) const RANGE_STEPS_M: [f64; 9] =
    [100.0, 250.0, 500.0, 1000.0, 2500.0, 5000.0, 10_000.0, 25_000.0, 50_000.0];
/// Widths of bins of height, metres.
pub(super) const HEIGHT_STEPS_M: [f64; 8] = [25.0, 50.0, 100.0, 250.0, 500.0, 1000.0, 2500.0, 5000.0];

/// The smallest width by which the largest value lies in at most `bins` bins; else the largest width.
pub(super) fn step(values: impl Iterator<Item = f64>, steps: &[f64], bins: f64) -> f64 {
    let largest = values.fold(0.0, f64::max);
    let widest = steps.last().copied().unwrap_or(1.0);
    steps.iter().copied().find(|step| largest < step * bins).unwrap_or(widest)
}

/// Bin of a value.
pub(super) fn bin(value: f64, step: f64) -> i64 {
    (value / step).floor() as i64
}

/// Limits of a bin: `500-1000`.
pub(super) fn label(index: i64, step: f64) -> String {
    let step = step as i64;
    format!("{}-{}", index * step, (index + 1) * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_cover_all_values_with_round_limits() {
        let step_m = step([120.0, 2499.0].into_iter(), &RANGE_STEPS_M, 10.0);
        assert_eq!((step_m, label(bin(2499.0, step_m), step_m)), (250.0, "2250-2500".to_owned()));
        assert_eq!(step([2500.0].into_iter(), &RANGE_STEPS_M, 10.0), 500.0);
        assert_eq!(step([9e9].into_iter(), &RANGE_STEPS_M, 10.0), 50_000.0);
        assert_eq!((bin(-0.5, 25.0), label(-1, 25.0)), (-1, "-25-0".to_owned()));
    }
}
