//! Quantiles of values that are all in memory. (For a stream of values, see the histogram of `survey`.)

/// The quantile `share` (0 to 1) of `sorted`, interpolated linearly between the values next to index `share` · (n - 1), as by
/// NumPy's default; `None` if there are no values.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = share * last as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[(place.ceil() as usize).min(last)]);
    Some(below + place.fract() * (above - below))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_values_it_is_linear() {
        let four = [1.0, 2.0, 3.0, 4.0];
        assert_eq!([0.0, 0.5, 1.0].map(|share| quantile(&four, share)), [1.0, 2.5, 4.0].map(Some));
        assert!((quantile(&four, 0.95).unwrap() - 3.85).abs() < 1e-12);
        assert_eq!((quantile(&[7.0], 0.95), quantile(&[], 0.5)), (Some(7.0), None));
    }
}
