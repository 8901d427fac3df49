//! The closest point of approach, and what errors of the angular rates do to it: equations 4 to 7.

use nalgebra::Vector3;

/// The closest point if both fly straight on.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// Time until then, seconds.
    pub time_s: f64,
    /// The vector of the miss, metres.
    pub miss: Vector3<f64>,
}

/// Equation 4: by the line of sight to the intruder, and its rate. The paper's V is that of the own ship with respect to the
/// intruder.
pub fn closest(line: &Vector3<f64>, rate: &Vector3<f64>) -> Closest {
    let velocity = -rate;
    let time_s = line.dot(&velocity) / velocity.norm_squared();
    Closest { time_s, miss: velocity * time_s - line }
}

/// Equations 5 and 6: the error of the distance at the closest point that an error of an angular rate makes (radians a
/// second), head on.
pub fn error_of_rate(range_m: f64, range_rate: f64, of_rate: f64) -> f64 {
    range_m * (range_m * of_rate / range_rate.abs()).atan().sin()
}

/// Equation 7: both together, as approximated for small ones.
pub fn error_of_both(range_m: f64, range_rate: f64, [azimuth_rate, elevation_rate]: [f64; 2]) -> f64 {
    range_m * range_m / range_rate.abs() * azimuth_rate.hypot(elevation_rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closest_point_is_where_they_are_closest() {
        let (line, rate) = (Vector3::new(40.0, 2000.0, 30.0), Vector3::new(-1.0, -75.0, 0.5));
        let Closest { time_s, miss } = closest(&line, &rate);
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
        // The approximation is good where the turn is small, and 7 is 5 and 6 across each other.
        let [azimuth, elevation] = both.map(|rate| error_of_rate(2000.0, -75.0, rate));
        assert!((azimuth.hypot(elevation) / error_of_both(2000.0, -75.0, both) - 1.0).abs() < 2e-3);
        // Quadratic in the range, and inverse to the range rate.
        assert!(
            (error_of_both(4000.0, -75.0, both) / error_of_both(2000.0, -75.0, both) - 4.0).abs() < 1e-12
        );
        assert!(
            (error_of_both(2000.0, 150.0, both) / error_of_both(2000.0, -75.0, both) - 0.5).abs() < 1e-12
        );
    }

    /// An error of the azimuth rate turns the relative velocity: equation 5 is what equation 4 makes of that.
    #[test]
    fn equation_5_is_equation_4_with_a_turned_velocity() {
        let (range, rate, error): (f64, f64, f64) = (1800.0, -75.0, 0.4_f64.to_radians());
        let wrong = closest(&Vector3::new(0.0, range, 0.0), &Vector3::new(range * error, rate, 0.0));
        assert!((wrong.miss.norm() - error_of_rate(range, rate, error)).abs() < 1e-9);
    }
}
