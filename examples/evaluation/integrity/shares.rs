//! Shares, medians and rates, with their standard errors.

use crate::summary::MeanValue;

/// Share of true values, percent. Its standard error is for a binomial with probability (k + ½) / (n + 1), so that
/// shares of 0 and 100 % have one, too.
pub fn share(of: impl IntoIterator<Item = bool>) -> Option<MeanValue> {
    let (mut found, mut count) = (0, 0);
    for is_found in of {
        found += usize::from(is_found);
        count += 1;
    }
    let (k, n) = (found as f64, count as f64);
    let likely = (k + 0.5) / (n + 1.0);
    let error = Some(100.0 * (likely * (1.0 - likely) / n).sqrt());
    (count > 0).then_some(MeanValue { mean: 100.0 * k / n, error, count })
}

/// Median; `None` counts as infinite. The standard error is half of the distance between the values √n / 2 ranks below
/// and above the middle: one standard deviation of the binomial.
pub fn median(values: impl IntoIterator<Item = Option<f64>>) -> Option<MeanValue> {
    let mut sorted: Vec<f64> = values.into_iter().map(|value| value.unwrap_or(f64::INFINITY)).collect();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len();
    let at = |place: f64| sorted[(place.round().max(0.0) as usize).min(count - 1)];
    let middle = (count as f64 - 1.0) / 2.0;
    let apart = (count as f64).sqrt() / 2.0;
    let of = || MeanValue {
        mean: (at(middle.floor()) + at(middle.ceil())) / 2.0,
        error: Some((at(middle + apart) - at(middle - apart)) / 2.0).filter(|error| error.is_finite()),
        count,
    };
    (count > 0).then(of)
}

/// Rate of events in `hours`, per `per_h` hours. Its standard error is for a Poisson distribution with one more
/// event.
pub fn rate(events: usize, hours: f64, per_h: f64) -> Option<MeanValue> {
    let of = |events: f64| events / hours * per_h;
    (hours > 0.0).then(|| MeanValue {
        mean: of(events as f64),
        error: Some(of((events as f64 + 1.0).sqrt())),
        count: hours.round() as usize,
    })
}

/// Ratio of two sums over flights with a positive divisor, with the standard error of a ratio of means.
pub fn ratio(pairs: &[(f64, f64)]) -> Option<MeanValue> {
    let pairs: Vec<_> = pairs.iter().filter(|pair| pair.1 > 0.0).collect();
    let (count, n) = (pairs.len(), pairs.len() as f64);
    let (over, under) = pairs.iter().fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
    let mean = over / under;
    let squares: f64 = pairs.iter().map(|pair| (pair.0 - mean * pair.1).powi(2)).sum();
    let error = (count > 1).then(|| (squares * n / (n - 1.0)).sqrt() / under);
    (count > 0).then_some(MeanValue { mean, error, count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn share_of_none_or_all_has_an_error() {
        let some = share([true, true, false, true]).unwrap();
        assert_eq!((some.mean, some.count), (75.0, 4));
        // (3.5 / 5) (1.5 / 5) / 4 = 0.0525.
        assert!((some.error.unwrap() - 22.912_878).abs() < 1e-5);
        assert!(share([true; 20]).unwrap().error.unwrap() > 3.0);
        assert_eq!(share([]), None);
    }

    #[test]
    fn never_found_counts_as_infinite_delay() {
        let found = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
        assert_eq!(median(found(&[3.0, 1.0, 2.0])).unwrap().mean, 2.0);
        let with_missed = [Some(1.0), None, Some(2.0), Some(5.0)];
        assert_eq!(median(with_missed).unwrap().mean, 3.5);
        assert_eq!(median([None, Some(1.0), None]).unwrap().mean, f64::INFINITY);
        // Nine values: √9 / 2 = 1.5 ranks to each side of 5, rounded to 3 and 7 (rank 2.5 and 5.5 of 0 to 8).
        let nine = median(found(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])).unwrap();
        assert_eq!((nine.mean, nine.error, nine.count), (5.0, Some(1.5), 9));
    }

    #[test]
    fn rate_is_per_given_hours() {
        let rate = rate(3, 24.0, 12.0).unwrap();
        assert_eq!((rate.mean, rate.error, rate.count), (1.5, Some(1.0), 24));
    }
}
