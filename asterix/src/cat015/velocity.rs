//! Horizontal motion of the target: I015/602, 603. X points east and Y north, in a plane at the target.

use crate::item::items;

items! {
    /// I015/602, horizontal velocity information.
    compound pub struct VelocityInformation {
        /// HV, the velocity.
        "hv" velocity: Velocity,
        /// RSHV, the resolution.
        "rshv" resolution: VelocityResolution,
        /// SDHV, the standard deviation.
        "sdhv" precision: VelocityPrecision,
        /// COHVHP, correlation with the horizontal position.
        "cohvhp" position_correlation: CrossCorrelation,
    }

    /// HV in I015/602.
    pub struct Velocity(5) {
        /// East in metres per second: LSB 0.01 m/s, -5,242.88 to 5,242.87 m/s.
        signed 20 "x_m_s" east_m_s / with_east_m_s = 0.01, 2;
        /// North in metres per second: LSB 0.01 m/s, -5,242.88 to 5,242.87 m/s.
        signed 20 "y_m_s" north_m_s / with_north_m_s = 0.01, 2;
    }

    /// RSHV in I015/602: minimum difference at which two targets are resolved.
    pub struct VelocityResolution(5) {
        /// East in metres per second: LSB 0.01 m/s, 0 to 655.35 m/s.
        unsigned 16 "x_m_s" east_m_s / with_east_m_s = 0.01, 2;
        /// North in metres per second: LSB 0.01 m/s, 0 to 655.35 m/s.
        unsigned 16 "y_m_s" north_m_s / with_north_m_s = 0.01, 2;
        /// CORSHVXY, their correlation: LSB 1/128, -1 to below 1.
        signed 8 "corshvxy" correlation / with_correlation = 1.0 / 128.0, 4;
    }

    /// SDHV in I015/602: standard deviations.
    pub struct VelocityPrecision(5) {
        /// East in metres per second: LSB 0.01 m/s, 0 to 655.35 m/s.
        unsigned 16 "x_m_s" east_m_s / with_east_m_s = 0.01, 2;
        /// North in metres per second: LSB 0.01 m/s, 0 to 655.35 m/s.
        unsigned 16 "y_m_s" north_m_s / with_north_m_s = 0.01, 2;
        /// COHVXY, their correlation: LSB 1/128, -1 to below 1.
        signed 8 "cohvxy" correlation / with_correlation = 1.0 / 128.0, 4;
    }

    /// COHVHP in I015/602; COHAHP, COHAHV in I015/603: correlations of the components of two horizontal vectors.
    pub struct CrossCorrelation(4) {
        /// East with east: LSB 1/128, -1 to below 1.
        signed 8 "x_x" east_east / with_east_east = 1.0 / 128.0, 4;
        /// East with north: LSB 1/128, -1 to below 1.
        signed 8 "x_y" east_north / with_east_north = 1.0 / 128.0, 4;
        /// North with east: LSB 1/128, -1 to below 1.
        signed 8 "y_x" north_east / with_north_east = 1.0 / 128.0, 4;
        /// North with north: LSB 1/128, -1 to below 1.
        signed 8 "y_y" north_north / with_north_north = 1.0 / 128.0, 4;
    }

    /// I015/603, horizontal acceleration information.
    compound pub struct AccelerationInformation {
        /// HA, the acceleration.
        "ha" acceleration: Acceleration,
        /// SDHA, the standard deviation.
        "sdha" precision: AccelerationPrecision,
        /// COHAHP, correlation with the horizontal position.
        "cohahp" position_correlation: CrossCorrelation,
        /// COHAHV, correlation with the horizontal velocity.
        "cohahv" velocity_correlation: CrossCorrelation,
    }

    /// HA in I015/603.
    pub struct Acceleration(3) {
        /// East in metres per second squared: LSB 1/16 m/s², -128 to 127.94 m/s².
        signed 12 "x_m_s2" east_m_s2 / with_east_m_s2 = 1.0 / 16.0, 2;
        /// North in metres per second squared: LSB 1/16 m/s², -128 to 127.94 m/s².
        signed 12 "y_m_s2" north_m_s2 / with_north_m_s2 = 1.0 / 16.0, 2;
    }

    /// SDHA in I015/603: standard deviations.
    pub struct AccelerationPrecision(4) {
        /// East in metres per second squared: LSB 1/16 m/s², 0 to 255.94 m/s².
        unsigned 12 "x_m_s2" east_m_s2 / with_east_m_s2 = 1.0 / 16.0, 2;
        /// North in metres per second squared: LSB 1/16 m/s², 0 to 255.94 m/s².
        unsigned 12 "y_m_s2" north_m_s2 / with_north_m_s2 = 1.0 / 16.0, 2;
        /// COHAXY, their correlation: LSB 1/128, -1 to below 1.
        signed 8 "cohaxy" correlation / with_correlation = 1.0 / 128.0, 4;
    }
}
