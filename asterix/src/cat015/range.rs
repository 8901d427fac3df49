//! Measurements along the line of sight, and signal strength: I015/625, 626, 630.

use crate::item::items;

items! {
    /// I015/625, range information, relative to the sensor's reference point; for a bistatic sensor by way of the target.
    padded pub struct RangeInformation {
        /// R, the range.
        "r_m" range: Range,
        /// RSR, the resolution.
        "rsr_m" resolution: RangeDeviation,
        /// SDR, the standard deviation.
        "sdr_m" deviation: RangeDeviation,
        /// RR, the range rate, derived from ranges.
        "rr_m_s" rate: RangeRate,
        /// RSRR, the resolution.
        "rsrr_m_s" rate_resolution: RangeRateResolution,
        /// SDRR, the standard deviation.
        "sdrr" rate_precision: RangeRatePrecision,
        /// RA, the range acceleration, derived from range rates.
        "ra_m_s2" acceleration: RangeAcceleration,
        /// SDRA, the standard deviation.
        "sdra" acceleration_precision: RangeAccelerationPrecision,
    }

    /// R in I015/625.
    /// Metres: LSB 0.1 m, -838,860.8 to 838,860.7 m.
    pub struct Range(3) = signed 24 "" metres / with_metres = 0.1, 1;

    /// RSR, SDR in I015/625.
    /// Metres: LSB 0.1 m, 0 to 1,677,721.5 m.
    pub struct RangeDeviation(3) = unsigned 24 "" metres / with_metres = 0.1, 1;

    /// RR in I015/625.
    /// Metres per second, away from the sensor: LSB 0.1 m/s, -838,860.8 to 838,860.7 m/s.
    pub struct RangeRate(3) = signed 24 "" m_s / with_m_s = 0.1, 1;

    /// RSRR in I015/625.
    /// Metres per second: LSB 0.1 m/s, 0 to 1,677,721.5 m/s.
    pub struct RangeRateResolution(3) = unsigned 24 "" m_s / with_m_s = 0.1, 1;

    /// SDRR in I015/625.
    pub struct RangeRatePrecision(4) {
        /// SDRR, standard deviation in metres per second: LSB 0.1 m/s, 0 to 1,677,721.5 m/s.
        unsigned 24 "sdrr_m_s" m_s / with_m_s = 0.1, 1;
        /// CORRR, correlation with the range: LSB 1/128, -1 to below 1.
        signed 8 "corrr" range_correlation / with_range_correlation = 1.0 / 128.0, 4;
    }

    /// RA in I015/625.
    /// Metres per second squared: LSB 1/64 m/s², -512 to 511.98 m/s².
    pub struct RangeAcceleration(2) = signed 16 "" m_s2 / with_m_s2 = 1.0 / 64.0, 3;

    /// SDRA in I015/625.
    pub struct RangeAccelerationPrecision(4) {
        /// SDRA, standard deviation in metres per second squared: LSB 1/128 m/s², 0 to 511.99 m/s².
        unsigned 16 "sdra_m_s2" m_s2 / with_m_s2 = 1.0 / 128.0, 3;
        /// CORAR, correlation with the range: LSB 1/128, -1 to below 1.
        signed 8 "corar" range_correlation / with_range_correlation = 1.0 / 128.0, 4;
        /// CORARR, correlation with the range rate: LSB 1/128, -1 to below 1.
        signed 8 "corarr" rate_correlation / with_rate_correlation = 1.0 / 128.0, 4;
    }

    /// I015/626, Doppler information.
    padded pub struct DopplerInformation {
        /// DV, the velocity.
        "dv_m_s" velocity: DopplerVelocity,
        /// SDDV, its standard deviation.
        "sddv_m_s" deviation: DopplerDeviation,
        /// DA, the acceleration.
        "da_m_s2" acceleration: DopplerAcceleration,
        /// SDDA, its standard deviation.
        "sdda" acceleration_precision: DopplerAccelerationPrecision,
        /// CODVR, correlation of velocity and range.
        "codvr" range_correlation: Correlation,
        /// CODVRR, correlation of velocity and range rate.
        "codvrr" rate_correlation: Correlation,
        /// CODVRA, correlation of velocity and range acceleration.
        "codvra" range_acceleration_correlation: Correlation,
        /// CODAR, correlation of acceleration and range.
        "codar" acceleration_range_correlation: Correlation,
        /// CODARR, correlation of acceleration and range rate.
        "codarr" acceleration_rate_correlation: Correlation,
        /// CODARA, correlation of acceleration and range acceleration.
        "codara" accelerations_correlation: Correlation,
    }

    /// DV in I015/626.
    /// Metres per second: LSB 0.01 m/s, -83,886.08 to 83,886.07 m/s.
    pub struct DopplerVelocity(3) = signed 24 "" m_s / with_m_s = 0.01, 2;

    /// SDDV in I015/626.
    /// Metres per second: LSB 1/64 m/s, 0 to 1,023.98 m/s.
    pub struct DopplerDeviation(2) = unsigned 16 "" m_s / with_m_s = 1.0 / 64.0, 3;

    /// DA in I015/626.
    /// Metres per second squared: LSB 1/64 m/s², -512 to 511.98 m/s².
    pub struct DopplerAcceleration(2) = signed 16 "" m_s2 / with_m_s2 = 1.0 / 64.0, 3;

    /// SDDA in I015/626.
    pub struct DopplerAccelerationPrecision(3) {
        /// SDDA, standard deviation in metres per second squared: LSB 1/64 m/s², 0 to 1,023.98 m/s².
        unsigned 16 "sdda_m_s2" m_s2 / with_m_s2 = 1.0 / 64.0, 3;
        /// CODADV, correlation with the velocity: LSB 1/128, -1 to below 1.
        signed 8 "codadv" velocity_correlation / with_velocity_correlation = 1.0 / 128.0, 4;
    }

    /// CODVR, CODVRR, CODVRA, CODAR, CODARR, CODARA in I015/626.
    /// The correlation: LSB 1/128, -1 to below 1.
    pub struct Correlation(1) = signed 8 "" correlation / with_correlation = 1.0 / 128.0, 4;

    /// I015/630, path quality.
    compound pub struct PathQuality {
        /// DPP, power of the direct path.
        "dpp_db" direct_power: Power,
        /// DPS, signal to noise ratio of the direct path.
        "dps_db" direct_ratio: Power,
        /// RPP, power of the reflected path.
        "rpp" reflected_power: ReflectedPower,
        /// RPS, signal to noise ratio of the reflected path.
        "rps_db" reflected_ratio: Power,
    }

    /// DPP, DPS, RPS in I015/630.
    /// Decibels: LSB 1 dB, -128 to 127 dB.
    pub struct Power(1) = signed 8 "" db / with_db = 1.0, 0;

    /// RPP in I015/630.
    pub struct ReflectedPower(2) {
        spare 7 "spare";
        /// Decibels: LSB 1 dB, -256 to 255 dB.
        signed 9 "rpp_db" db / with_db = 1.0, 0;
    }
}
