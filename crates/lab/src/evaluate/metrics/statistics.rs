//! Statistics of position errors.

use crate::evaluate::types::ErrorStatistics;
use input::statistics::quantile;

/// Statistics of errors in metres, in any order; `None` without any. The standard deviation is the sample standard
/// deviation (n - 1).
pub(crate) fn statistics(errors_m: impl Iterator<Item = f64>) -> Option<ErrorStatistics> {
    let mut errors_m: Vec<f64> = errors_m.collect();
    errors_m.sort_by(f64::total_cmp);
    let count = errors_m.len();
    if count == 0 {
        return None;
    }
    let mean_m = errors_m.iter().sum::<f64>() / count as f64;
    let squares: f64 = errors_m.iter().map(|error_m| (error_m - mean_m).powi(2)).sum();
    let variance = if count > 1 { squares / (count - 1) as f64 } else { 0.0 };
    Some(ErrorStatistics {
        count: count as u64,
        mean_m,
        sem_m: (variance / count as f64).sqrt(),
        p50_m: quantile(&errors_m, 0.5)?,
        p95_m: quantile(&errors_m, 0.95)?,
    })
}

/// `numerator / denominator`; `None` if the denominator is 0.
pub(super) fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_spread_and_percentiles() {
        // Mean 2.5; squares 2.25 + 0.25 + 0.25 + 2.25 = 5, variance 5/3, SEM sqrt(5/12).
        // p50 halfway from 2 to 3; p95 at place 2.85: 3 + 0.85.
        let result = statistics([4.0, 1.0, 3.0, 2.0].into_iter()).unwrap();
        assert_eq!((result.count, result.mean_m, result.p50_m), (4, 2.5, 2.5));
        assert!((result.sem_m - (5.0_f64 / 12.0).sqrt()).abs() < 1e-12);
        assert!((result.p95_m - 3.85).abs() < 1e-12);
        let single = statistics(std::iter::once(7.0)).unwrap();
        assert_eq!((single.mean_m, single.sem_m, single.p50_m, single.p95_m), (7.0, 0.0, 7.0, 7.0));
        assert_eq!(statistics(std::iter::empty()), None);
    }
}
