//! How far pressure altitude is from height, as aircraft that state both show it.
//!
//! Pressure altitude assumes the standard atmosphere: on a day of 990 hPa it is 190 m too high, and warm air adds a share of the
//! height. So it is no height until aircraft nearby have shown the difference, and the further above or below them, the worse.

use serde::{Deserialize, Serialize};

use fusion::time::{SECOND, Time};

/// What was shown is forgotten to 1/e in this time, seconds: weather changes over hours.
const MEMORY_S: f64 = 600.0;
/// So many reports, as far as they are remembered, make it known.
const REPORTS: f64 = 10.0;
/// Sigma of a height that is made of a pressure altitude, metres: encoders, and what air does between two aircraft.
const SIGMA_M: f64 = 38.0;
/// And for each metre above or below the aircraft that showed the difference: air is warmer or colder than standard.
const SIGMA_A_METRE: f64 = 0.05;

/// The difference of the heights above the ellipsoid and the pressure altitudes of a site's aircraft.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Barometer {
    /// How many reports it rests on, as far as they are remembered.
    reports: f64,
    /// Means of difference and pressure altitude, metres.
    difference_m: f64,
    altitude_m: f64,
    latest: Time,
}

impl Barometer {
    /// Takes in a report that states both, metres.
    pub fn learn(&mut self, altitude_m: f64, height_m: f64, time: Time) {
        self.forget(time);
        self.reports += 1.0;
        self.difference_m += (height_m - altitude_m - self.difference_m) / self.reports;
        self.altitude_m += (altitude_m - self.altitude_m) / self.reports;
    }

    /// The height above the ellipsoid of a pressure altitude, and its standard deviation, metres; `None`: not known.
    pub fn height_m(&mut self, altitude_m: f64, time: Time) -> Option<(f64, f64)> {
        self.forget(time);
        let away_m = (altitude_m - self.altitude_m).abs();
        (self.reports >= REPORTS)
            .then_some((altitude_m + self.difference_m, SIGMA_M + SIGMA_A_METRE * away_m))
    }

    fn forget(&mut self, time: Time) {
        let passed_s = (time.nanos() - self.latest.nanos()).max(0) as f64 / SECOND as f64;
        self.reports *= (-passed_s / MEMORY_S).exp();
        self.latest = self.latest.max(time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos((1_700_000_000 + seconds) * SECOND)
    }

    #[test]
    fn it_is_known_once_aircraft_have_shown_it_and_for_a_while() {
        let mut barometer = Barometer::default();
        assert_eq!(barometer.height_m(500.0, at(0)), None);
        (0..12).for_each(|second| barometer.learn(1000.0, 1190.0, at(second)));
        let (height_m, sigma_m) = barometer.height_m(1000.0, at(12)).unwrap();
        assert!((height_m - 1190.0).abs() < 1e-9 && sigma_m == SIGMA_M);
        let (height_m, sigma_m) = barometer.height_m(3000.0, at(12)).unwrap();
        assert!((height_m - 3190.0).abs() < 1e-9 && (sigma_m - SIGMA_M - 100.0).abs() < 1e-9);
        assert_eq!(barometer.height_m(1000.0, at(400)), None, "the weather may have changed");
    }

    #[test]
    fn the_latest_aircraft_count_most() {
        let mut barometer = Barometer::default();
        (0..1000).for_each(|second| barometer.learn(1000.0, 1190.0, at(second)));
        (4000..4100).for_each(|second| barometer.learn(1000.0, 1100.0, at(second)));
        let (height_m, _) = barometer.height_m(1000.0, at(4100)).unwrap();
        assert!((height_m - 1100.0).abs() < 5.0, "{height_m}");
    }
}
