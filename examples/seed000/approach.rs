//! Closest point of approach, and the effect of angular rate errors on it: equations 4 to 7.

use nalgebra::Vector3;

/// Closest point for straight flight of both aircraft.
#[derive(Clone, Copy, Debug)]
pub struct StraightApproach {
    /// Time to the closest point, seconds.
    pub time_s: f64,
    /// Miss vector, metres.
    pub miss: Vector3<f64>,
}

/// Equation 4: closest point from the line of sight to the intruder and its rate. V in the paper is the velocity of the
/// own ship relative to the intruder.
pub fn closest(line: &Vector3<f64>, rate: &Vector3<f64>) -> StraightApproach {
    let velocity = -rate;
    let time_s = line.dot(&velocity) / velocity.norm_squared();
    StraightApproach { time_s, miss: velocity * time_s - line }
}

/// Equations 5 and 6: error of the distance at the closest point due to an error of an angular rate (radians per
/// second), head on.
pub fn error_of_rate(range_m: f64, range_rate: f64, of_rate: f64) -> f64 {
    range_m * (range_m * of_rate / range_rate.abs()).atan().sin()
}

/// Equation 7: error due to both angular rates, approximated for small errors.
pub fn error_of_both(range_m: f64, range_rate: f64, [azimuth_rate, elevation_rate]: [f64; 2]) -> f64 {
    range_m * range_m / range_rate.abs() * azimuth_rate.hypot(elevation_rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closest_point_has_minimum_distance() {
        let (line, rate) = (Vector3::new(40.0, 2000.0, 30.0), Vector3::new(-1.0, -75.0, 0.5));
        let StraightApproach { time_s, miss } = closest(&line, &rate);
        let at = |time: f64| line + rate * time;
        assert!((at(time_s) + miss).norm() < 1e-9, "the miss points from the intruder to the own ship");
        assert!(at(time_s).norm() < at(time_s - 0.01).norm() && at(time_s).norm() < at(time_s + 0.01).norm());
    }

    #[test]
    fn equations_5_to_7_at_two_kilometres() {
        let degrees = |rates: [f64; 2]| rates.map(f64::to_radians);
        let (radar, both) = (degrees([0.29, 0.26]), degrees([0.099, 0.092]));
        assert!((error_of_both(2000.0, -75.0, radar) / 362.6 - 1.0).abs() < 1e-3);
        assert!((error_of_both(2000.0, -75.0, both) / 125.8 - 1.0).abs() < 1e-3);
        // The approximation is good for small angles; equation 7 is the root sum square of equations 5 and 6.
        let [azimuth, elevation] = both.map(|rate| error_of_rate(2000.0, -75.0, rate));
        assert!((azimuth.hypot(elevation) / error_of_both(2000.0, -75.0, both) - 1.0).abs() < 2e-3);
        // The error is quadratic in the range, and inverse to the range rate.
        assert!(
            (error_of_both(4000.0, -75.0, both) / error_of_both(2000.0, -75.0, both) - 4.0).abs() < 1e-12
        );
        assert!(
            (error_of_both(2000.0, 150.0, both) / error_of_both(2000.0, -75.0, both) - 0.5).abs() < 1e-12
        );
    }

    /// An error of the azimuth rate turns the relative velocity; equation 5 follows from equation 4 with the turned
    /// velocity.
    #[test]
    fn equation_5_is_equation_4_with_a_turned_velocity() {
        let (range, rate, error): (f64, f64, f64) = (1800.0, -75.0, 0.4_f64.to_radians());
        let wrong = closest(&Vector3::new(0.0, range, 0.0), &Vector3::new(range * error, rate, 0.0));
        assert!((wrong.miss.norm() - error_of_rate(range, rate, error)).abs() < 1e-9);
    }
}
