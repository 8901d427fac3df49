//! Accuracy of the track: I062/500, standard deviations.

use crate::item::items;

items! {
    /// I062/500, estimated accuracies.
    padded pub struct EstimatedAccuracies {
        /// APC, of the position in the system's plane.
        "apc" position: PositionAccuracy,
        /// COV, covariance of the position's components.
        "cov_m" covariance: Covariance,
        /// APW, of the position in WGS-84.
        "apw" wgs84: Wgs84Accuracy,
        /// AGA, of the geometric altitude.
        "aga_m" geometric: HeightAccuracy,
        /// ABA, of the barometric altitude.
        "aba_flight_level" barometric: LevelAccuracy,
        /// ATV, of the velocity.
        "atv" velocity: VelocityAccuracy,
        /// AA, of the acceleration.
        "aa" acceleration: AccelerationAccuracy,
        /// ARC, of the rate of climb.
        "arc_m_s" climb: ClimbAccuracy,
        _,
        _,
        _,
        _,
        _,
        _,
    }

    /// APC in I062/500.
    pub struct PositionAccuracy(4) {
        /// East in metres: LSB 0.5 m, 0 to 32,767.5 m.
        unsigned 16 "x_m" east_m / with_east_m = 0.5, 1;
        /// North in metres: LSB 0.5 m, 0 to 32,767.5 m.
        unsigned 16 "y_m" north_m / with_north_m = 0.5, 1;
    }

    /// COV in I062/500: square root of the absolute covariance of east and north, with its sign.
    /// Metres: LSB 0.5 m, -16,384 to 16,383.5 m.
    pub struct Covariance(2) = signed 16 "" metres / with_metres = 0.5, 1;
}

impl Covariance {
    /// The nearest item for a covariance in square metres; `None` if it is out of range.
    pub fn from_square_metres(covariance_m2: f64) -> Option<Self> {
        Self::default().with_metres(libm::sqrt(covariance_m2.abs()).copysign(covariance_m2))
    }

    /// The covariance in square metres.
    pub fn square_metres(self) -> f64 {
        self.metres() * self.metres().abs()
    }
}

items! {
    /// APW in I062/500.
    pub struct Wgs84Accuracy(4) {
        /// Latitude in degrees: LSB 180/2^25 degrees (0.6 m), 0 to 0.35 degrees.
        unsigned 16 "lat_deg" latitude_deg / with_latitude_deg = 180.0 / 33_554_432.0, 6;
        /// Longitude in degrees: LSB 180/2^25 degrees (0.6 m along the equator), 0 to 0.35 degrees.
        unsigned 16 "lon_deg" longitude_deg / with_longitude_deg = 180.0 / 33_554_432.0, 6;
    }

    /// AGA in I062/500.
    /// Metres: LSB 6.25 ft (1.905 m), 0 to 485.8 m.
    pub struct HeightAccuracy(1) = unsigned 8 "" metres / with_metres = 6.25 * 0.3048, 1;

    /// ABA in I062/500.
    /// Hundreds of feet: LSB 1/4 (25 ft), 0 to 63.75.
    pub struct LevelAccuracy(1) = unsigned 8 "" flight_level / with_flight_level = 0.25, 2;

    /// ATV in I062/500.
    pub struct VelocityAccuracy(2) {
        /// East in metres per second: LSB 0.25 m/s, 0 to 63.75 m/s.
        unsigned 8 "x_m_s" east_m_s / with_east_m_s = 0.25, 2;
        /// North in metres per second: LSB 0.25 m/s, 0 to 63.75 m/s.
        unsigned 8 "y_m_s" north_m_s / with_north_m_s = 0.25, 2;
    }

    /// AA in I062/500.
    pub struct AccelerationAccuracy(2) {
        /// East in metres per second squared: LSB 0.25 m/s², 0 to 63.75 m/s².
        unsigned 8 "x_m_s2" east_m_s2 / with_east_m_s2 = 0.25, 2;
        /// North in metres per second squared: LSB 0.25 m/s², 0 to 63.75 m/s².
        unsigned 8 "y_m_s2" north_m_s2 / with_north_m_s2 = 0.25, 2;
    }

    /// ARC in I062/500.
    /// Metres per second: LSB 6.25 ft/min (0.03175 m/s), 0 to 8.1 m/s.
    pub struct ClimbAccuracy(1) = unsigned 8 "" up_m_s / with_up_m_s = 6.25 * 0.3048 / 60.0, 2;
}
