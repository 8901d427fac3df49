//! Shares, medians and rates, with their standard errors.

use crate::summary::Mean;

/// Share of so many, percent; the standard error is that of a binomial of probability (k + ½) / (n + 1), so that none and all
/// have one, too.
pub fn share(of: impl IntoIterator<Item = bool>) -> Option<Mean> {
    let (mut found, mut count) = (0, 0);
    for is_found in of {
        found += usize::from(is_found);
        count += 1;
    }
    let (k, n) = (found as f64, count as f64);
    let likely = (k + 0.5) / (n + 1.0);
    let error = Some(100.0 * (likely * (1.0 - likely) / n).sqrt());
    (count > 0).then_some(Mean { mean: 100.0 * k / n, error, count })
}

/// Median; what was never found counts as infinite. The standard error is half of the distance between the values half a
/// standard deviation of the binomial, √n / 2, below and above the middle.
pub fn median(values: impl IntoIterator<Item = Option<f64>>) -> Option<Mean> {
    let mut sorted: Vec<f64> = values.into_iter().map(|value| value.unwrap_or(f64::INFINITY)).collect();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len();
    let at = |place: f64| sorted[(place.round().max(0.0) as usize).min(count - 1)];
    let middle = (count as f64 - 1.0) / 2.0;
    let apart = (count as f64).sqrt() / 2.0;
    let of = || Mean {
        mean: (at(middle.floor()) + at(middle.ceil())) / 2.0,
        error: Some((at(middle + apart) - at(middle - apart)) / 2.0).filter(|error| error.is_finite()),
        count,
    };
    (count > 0).then(of)
}

/// So many in `hours`, a stretch of `per_h`; the standard error is that of a Poisson distribution of one more.
pub fn rate(events: usize, hours: f64, per_h: f64) -> Option<Mean> {
    let of = |events: f64| events / hours * per_h;
    (hours > 0.0).then(|| Mean {
        mean: of(events as f64),
        error: Some(of((events as f64 + 1.0).sqrt())),
        count: hours.round() as usize,
    })
}

/// Ratio of two sums over flights that have something to divide by, with the standard error of a ratio of means.
pub fn ratio(pairs: &[(f64, f64)]) -> Option<Mean> {
    let pairs: Vec<_> = pairs.iter().filter(|pair| pair.1 > 0.0).collect();
    let (count, n) = (pairs.len(), pairs.len() as f64);
    let (over, under) = pairs.iter().fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
    let mean = over / under;
    let squares: f64 = pairs.iter().map(|pair| (pair.0 - mean * pair.1).powi(2)).sum();
    let error = (count > 1).then(|| (squares * n / (n - 1.0)).sqrt() / under);
    (count > 0).then_some(Mean { mean, error, count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn none_and_all_have_an_error() {
        let some = share([true, true, false, true]).unwrap();
        assert_eq!((some.mean, some.count), (75.0, 4));
        // (3.5 / 5) (1.5 / 5) / 4 = 0.0525.
        assert!((some.error.unwrap() - 22.912_878).abs() < 1e-5);
        assert!(share([true; 20]).unwrap().error.unwrap() > 3.0);
        assert_eq!(share([]), None);
    }

    #[test]
    fn what_is_never_found_is_late() {
        let found = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
        assert_eq!(median(found(&[3.0, 1.0, 2.0])).unwrap().mean, 2.0);
        let with_missed = [Some(1.0), None, Some(2.0), Some(5.0)];
        assert_eq!(median(with_missed).unwrap().mean, 3.5);
        assert_eq!(median([None, Some(1.0), None]).unwrap().mean, f64::INFINITY);
        // Nine values: √9 / 2 = 1.5 places to each side of 5, rounded to 3 and 7 (place 2.5 and 5.5 of 0 to 8).
        let nine = median(found(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])).unwrap();
        assert_eq!((nine.mean, nine.error, nine.count), (5.0, Some(1.5), 9));
    }

    #[test]
    fn a_rate_is_of_the_hours() {
        let rate = rate(3, 24.0, 12.0).unwrap();
        assert_eq!((rate.mean, rate.error, rate.count), (1.5, Some(1.0), 24));
    }
}
