//! Consistency of published covariances: normalised estimation error squared (NEES). Y. Bar-Shalom, X. R. Li, T.
//! Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001, section 5.4.

use crate::evaluate::place::LocalOffset;
use crate::evaluate::scored_point::ScoredPoint;
use crate::evaluate::types::{Covariance, Nees};

/// Limit on the size of an error, in standard deviations. With consistent covariances and normal errors, one error in
/// 900 exceeds it over ground (two dimensions), and one in 4,600 in height.
const BEYOND_SIGMAS: f64 = 3.7;

/// Mean NEES over the points with a positive definite covariance; `None` without any.
pub(in crate::evaluate) fn mean<'a>(points: impl Iterator<Item = &'a ScoredPoint<'a>>) -> Option<Nees> {
    let (mut count, mut horizontal) = (0_u64, 0.0);
    let (mut heights, mut vertical) = (0_u64, 0.0);
    let (mut beyond, mut vertical_beyond) = (0_u64, 0_u64);
    for scored_point in points {
        let Some((error, covariance)) = scored_point.error.zip(scored_point.point.covariance) else {
            continue;
        };
        if let Some(of_point) = of_plane(&error, &covariance) {
            horizontal += of_point;
            count += 1;
            // `of_plane` is the mean over two dimensions.
            beyond += u64::from(2.0 * of_point > BEYOND_SIGMAS * BEYOND_SIGMAS);
        }
        if let Some(up_m) = error.up_m.filter(|_| covariance.vertical_m2 > 0.0) {
            let of_point = up_m * up_m / covariance.vertical_m2;
            vertical += of_point;
            heights += 1;
            vertical_beyond += u64::from(of_point > BEYOND_SIGMAS * BEYOND_SIGMAS);
        }
    }
    (count > 0).then(|| Nees {
        count,
        horizontal: horizontal / count as f64,
        vertical: (heights > 0).then(|| vertical / heights as f64),
        beyond_percent: 100.0 * beyond as f64 / count as f64,
        vertical_beyond_percent: (heights > 0).then(|| 100.0 * vertical_beyond as f64 / heights as f64),
    })
}

/// eᵀ P⁻¹ e / 2 over ground, with the inverse of a 2 × 2 matrix written out.
pub(in crate::evaluate) fn of_plane(error: &LocalOffset, covariance: &Covariance) -> Option<f64> {
    let Covariance { east_m2, north_m2, east_north_m2, .. } = *covariance;
    let determinant = east_m2 * north_m2 - east_north_m2 * east_north_m2;
    let (east_m, north_m) = (error.east_m, error.north_m);
    let squared =
        north_m2 * east_m * east_m - 2.0 * east_north_m2 * east_m * north_m + east_m2 * north_m * north_m;
    (east_m2 > 0.0 && determinant > 0.0).then(|| squared / determinant / 2.0)
}

#[cfg(test)]
mod tests {
    use fusion::slots::SlotGrid;
    use fusion::time::Time;

    use super::*;
    use crate::evaluate::place::GeodeticPlace;
    use crate::evaluate::types::{OutputPoint, PointFlags, PointSource};

    #[test]
    fn share_beyond_3_7_deviations_counts_each_dimension_apart() {
        let covariance = Covariance { east_m2: 4.0, north_m2: 9.0, east_north_m2: 0.0, vertical_m2: 1.0 };
        let point = point(covariance);
        let offsets = [(7.3, 0.0, 3.6), (7.5, 0.0, 3.6), (0.0, 11.0, -3.8), (6.0, 9.0, 0.0)];
        // 3.65, 3.75, 3.67 and 4.24 deviations over ground.
        let scored_point = offsets.map(|(east_m, north_m, up_m)| {
            scored_point(&point, LocalOffset { east_m, north_m, up_m: Some(up_m) })
        });
        let nees = mean(scored_point.iter()).unwrap();
        assert_eq!((nees.beyond_percent, nees.vertical_beyond_percent), (50.0, Some(25.0)));
        let flat = judged_flat(&point);
        assert_eq!(mean([flat].iter()).unwrap().vertical_beyond_percent, None);
    }

    fn point(covariance: Covariance) -> OutputPoint {
        OutputPoint {
            time: Time::from_nanos(0),
            place: GeodeticPlace { latitude_deg: 52.0, longitude_deg: 0.0, altitude_amsl_m: None },
            source: PointSource::Fused,
            number: 1,
            radar_track: None,
            sensor: None,
            transponder: None,
            identity: None,
            covariance: Some(covariance),
            flags: PointFlags::default(),
        }
    }

    fn scored_point(point: &OutputPoint, error: LocalOffset) -> ScoredPoint<'_> {
        let slot = SlotGrid::default().of(point.time);
        ScoredPoint {
            point,
            slot,
            drone: Some(0),
            truth: None,
            error: Some(error),
            paired: None,
            seduced: false,
            state: None,
        }
    }

    fn judged_flat(point: &OutputPoint) -> ScoredPoint<'_> {
        scored_point(point, LocalOffset { east_m: 1.0, north_m: 0.0, up_m: None })
    }

    fn plane(east_m2: f64, north_m2: f64, east_north_m2: f64) -> Option<f64> {
        let covariance = Covariance { east_m2, north_m2, east_north_m2, vertical_m2: 1.0 };
        of_plane(&LocalOffset { east_m: 3.0, north_m: -4.0, up_m: None }, &covariance)
    }

    #[test]
    fn error_is_normalised_by_its_own_covariance() {
        assert_eq!(plane(9.0, 16.0, 0.0), Some(1.0), "one deviation on each axis");
        assert_eq!(plane(9.0, 4.0, 0.0), Some(2.5));
        // P⁻¹ = [4, -2; -2, 5] / 16: (4 · 9 + 2 · 2 · 12 + 5 · 16) / 16 / 2.
        assert_eq!(plane(5.0, 4.0, 2.0), Some(164.0 / 32.0));
    }

    #[test]
    fn invalid_covariance_has_no_nees() {
        for (east_m2, north_m2, east_north_m2) in
            [(0.0, 4.0, 0.0), (4.0, 4.0, 4.0), (-1.0, -1.0, 0.0), (f64::NAN, 1.0, 0.0)]
        {
            assert_eq!(plane(east_m2, north_m2, east_north_m2), None);
        }
    }
}
