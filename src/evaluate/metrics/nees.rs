//! Consistency of the stated covariances: normalised estimation error squared. Y. Bar-Shalom, X. R. Li, T. Kirubarajan,
//! *Estimation with Applications to Tracking and Navigation*, 2001, section 5.4.

use crate::evaluate::judged::Judged;
use crate::evaluate::place::Offset;
use crate::evaluate::types::{Covariance, Nees};

/// Mean over the points with a positive definite covariance; `None` without any.
pub(in crate::evaluate) fn mean<'a>(points: impl Iterator<Item = &'a Judged<'a>>) -> Option<Nees> {
    let (mut count, mut horizontal) = (0_u64, 0.0);
    let (mut heights, mut vertical) = (0_u64, 0.0);
    for judged in points {
        let Some((error, covariance)) = judged.error.zip(judged.point.covariance) else { continue };
        if let Some(of_point) = of_plane(&error, &covariance) {
            horizontal += of_point;
            count += 1;
        }
        if let Some(up_m) = error.up_m.filter(|_| covariance.vertical_m2 > 0.0) {
            vertical += up_m * up_m / covariance.vertical_m2;
            heights += 1;
        }
    }
    (count > 0).then(|| Nees {
        count,
        horizontal: horizontal / count as f64,
        vertical: (heights > 0).then(|| vertical / heights as f64),
    })
}

/// eᵀ P⁻¹ e / 2 over ground, with the inverse of a 2 × 2 matrix written out.
pub(in crate::evaluate) fn of_plane(error: &Offset, covariance: &Covariance) -> Option<f64> {
    let Covariance { east_m2, north_m2, east_north_m2, .. } = *covariance;
    let determinant = east_m2 * north_m2 - east_north_m2 * east_north_m2;
    let (east_m, north_m) = (error.east_m, error.north_m);
    let squared =
        north_m2 * east_m * east_m - 2.0 * east_north_m2 * east_m * north_m + east_m2 * north_m * north_m;
    (east_m2 > 0.0 && determinant > 0.0).then(|| squared / determinant / 2.0)
}

/// The 95 % interval of the mean NEES of consistent covariances. `degrees`: degrees of freedom in that mean, two per
/// independent sample over ground and one in height. Points of one drone are not independent; its mean counts as one sample.
///
/// The 2.5 and 97.5 % points of chi-square over its degrees of freedom, by the approximation of E. B. Wilson and M. M.
/// Hilferty, *The distribution of chi-square*, 1931; its error is below 0.004 from ten degrees on.
pub fn honest_band(degrees: f64) -> (f64, f64) {
    let variance = 2.0 / (9.0 * degrees);
    let at = |sigmas: f64| (1.0 - variance + sigmas * variance.sqrt()).max(0.0).powi(3);
    (at(-1.96), at(1.96))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_that_of_the_tables() {
        // Chi-square of 10, 20 and 100 degrees: 3.247 to 20.483, 9.591 to 34.170, 74.222 to 129.561.
        for (degrees, low, high) in
            [(10.0, 0.3247, 2.0483), (20.0, 0.479_55, 1.7085), (100.0, 0.742_22, 1.295_61)]
        {
            let band = honest_band(degrees);
            assert!((band.0 - low).abs() < 4e-3 && (band.1 - high).abs() < 4e-3, "{band:?}");
        }
    }

    fn plane(east_m2: f64, north_m2: f64, east_north_m2: f64) -> Option<f64> {
        let covariance = Covariance { east_m2, north_m2, east_north_m2, vertical_m2: 1.0 };
        of_plane(&Offset { east_m: 3.0, north_m: -4.0, up_m: None }, &covariance)
    }

    #[test]
    fn an_error_is_measured_in_its_own_deviations() {
        assert_eq!(plane(9.0, 16.0, 0.0), Some(1.0), "one deviation on each axis");
        assert_eq!(plane(9.0, 4.0, 0.0), Some(2.5));
        // P⁻¹ = [4, -2; -2, 5] / 16: (4 · 9 + 2 · 2 · 12 + 5 · 16) / 16 / 2.
        assert_eq!(plane(5.0, 4.0, 2.0), Some(164.0 / 32.0));
    }

    #[test]
    fn what_is_no_covariance_tells_nothing() {
        for (east_m2, north_m2, east_north_m2) in
            [(0.0, 4.0, 0.0), (4.0, 4.0, 4.0), (-1.0, -1.0, 0.0), (f64::NAN, 1.0, 0.0)]
        {
            assert_eq!(plane(east_m2, north_m2, east_north_m2), None);
        }
    }
}
