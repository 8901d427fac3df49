//! Difference between pressure altitude and height, from aircraft that report both.
//!
//! Pressure altitude assumes the standard atmosphere: on a day of 990 hPa it is 190 m too high, and warm air adds a
//! fraction of the height. Until aircraft nearby have shown the difference, the height has a coarse bound. The bound stays
//! coarser the further above or below these aircraft a target is.

use serde::{Deserialize, Serialize};

use fusion::time::{SECOND, Time};

/// Time in which the weight of reports decreases to 1/e, in seconds: weather changes over hours.
const MEMORY_S: f64 = 600.0;
/// Weighted number of reports from which the difference counts as known.
const REPORTS: f64 = 10.0;
/// Standard deviation of a height from a pressure altitude, in metres: encoders, and variations of the air between two
/// aircraft.
const SIGMA_M: f64 = 38.0;
/// Additional standard deviation per metre above or below the aircraft that showed the difference, as the air's temperature
/// differs from the standard.
const SIGMA_A_METRE: f64 = 0.05;
/// Standard deviation of a height before any aircraft has shown the difference, in metres: on 95 % of the days it is within
/// 300 m of the standard pressure at sea level (36 hPa).
const UNSHOWN_SIGMA_M: f64 = 300.0 / 1.96;
/// Additional standard deviation per metre above sea level: mean temperature of the air below.
const UNSHOWN_SIGMA_A_METRE: f64 = 0.02;

/// Difference between height above the ellipsoid and pressure altitude, from a site's aircraft.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Barometer {
    /// Weighted number of reports.
    reports: f64,
    /// Means of difference and pressure altitude, in metres.
    difference_m: f64,
    altitude_m: f64,
    latest: Time,
}

impl Barometer {
    /// Adds a report with both values, in metres.
    pub fn learn(&mut self, altitude_m: f64, height_m: f64, time: Time) {
        self.forget(time);
        self.reports += 1.0;
        self.difference_m += (height_m - altitude_m - self.difference_m) / self.reports;
        self.altitude_m += (altitude_m - self.altitude_m) / self.reports;
    }

    /// Height above the ellipsoid from a pressure altitude, with its standard deviation, in metres; `None` while too few
    /// aircraft have reported both.
    pub fn shown_m(&mut self, altitude_m: f64, time: Time) -> Option<(f64, f64)> {
        self.forget(time);
        (self.reports >= REPORTS).then(|| self.by_reports(altitude_m))
    }

    /// Height above the ellipsoid from a pressure altitude, with its standard deviation, in metres, at any time. With few
    /// reports, it is interpolated between their difference and the standard atmosphere above a geoid of this undulation,
    /// in metres.
    pub fn height_m(&mut self, altitude_m: f64, undulation_m: f64, time: Time) -> (f64, f64) {
        self.forget(time);
        let (shown_m, shown_sigma_m) = self.by_reports(altitude_m);
        let share = (self.reports / REPORTS).min(1.0);
        let unshown_sigma_m = UNSHOWN_SIGMA_M.hypot(UNSHOWN_SIGMA_A_METRE * altitude_m);
        if share == 0.0 {
            return (altitude_m + undulation_m, unshown_sigma_m);
        }
        // A few reports never widen the bound that applies without them.
        let shown_sigma_m = if share < 1.0 { shown_sigma_m.min(unshown_sigma_m) } else { shown_sigma_m };
        let between = |shown: f64, unshown: f64| share * shown + (1.0 - share) * unshown;
        (between(shown_m, altitude_m + undulation_m), between(shown_sigma_m, unshown_sigma_m))
    }

    fn by_reports(&self, altitude_m: f64) -> (f64, f64) {
        let away_m = (altitude_m - self.altitude_m).abs();
        (altitude_m + self.difference_m, SIGMA_M + SIGMA_A_METRE * away_m)
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
    fn pressure_offset_is_known_while_reports_are_recent() {
        let mut barometer = Barometer::default();
        assert_eq!(barometer.shown_m(500.0, at(0)), None);
        (0..12).for_each(|second| barometer.learn(1000.0, 1190.0, at(second)));
        let (height_m, sigma_m) = barometer.shown_m(1000.0, at(12)).unwrap();
        assert!((height_m - 1190.0).abs() < 1e-9 && sigma_m == SIGMA_M);
        let (height_m, sigma_m) = barometer.shown_m(3000.0, at(12)).unwrap();
        assert!((height_m - 3190.0).abs() < 1e-9 && (sigma_m - SIGMA_M - 100.0).abs() < 1e-9);
        assert_eq!(barometer.shown_m(1000.0, at(400)), None, "the weather may have changed");
    }

    #[test]
    fn unknown_pressure_offset_is_bounded_by_300_m() {
        let mut barometer = Barometer::default();
        let (height_m, sigma_m) = barometer.height_m(500.0, 47.0, at(0));
        assert!((height_m - 547.0).abs() < 1e-9 && (1.96 * sigma_m - 300.0).abs() < 2.0, "{sigma_m}");
        // A day of 990 hPa: each report of both values brings the height closer, and the bound holds.
        let mut before_m = sigma_m;
        for second in 0..10 {
            barometer.learn(1000.0, 1000.0 + 47.0 - 190.0, at(second));
            let (height_m, sigma_m) = barometer.height_m(1000.0, 47.0, at(second));
            assert!((height_m - 857.0).abs() < 1.96 * sigma_m && sigma_m < before_m, "{height_m} {sigma_m}");
            before_m = sigma_m;
        }
        assert!(before_m < 40.0, "{before_m}");
        // The reports expire.
        assert!(barometer.height_m(1000.0, 47.0, at(4000)).1 > 150.0);
    }

    #[test]
    fn latest_reports_weigh_most() {
        let mut barometer = Barometer::default();
        (0..1000).for_each(|second| barometer.learn(1000.0, 1190.0, at(second)));
        (4000..4100).for_each(|second| barometer.learn(1000.0, 1100.0, at(second)));
        let (height_m, _) = barometer.shown_m(1000.0, at(4100)).unwrap();
        assert!((height_m - 1100.0).abs() < 5.0, "{height_m}");
    }
}
