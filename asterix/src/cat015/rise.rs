//! Vertical motion of the target: I015/604, 605.

use crate::cat015::PairCorrelation;
use crate::item::items;

items! {
    /// I015/604, vertical velocity information.
    compound pub struct VerticalVelocityInformation {
        /// VV, the velocity upwards.
        "vv_m_s" velocity: VerticalVelocity,
        /// RSVV, the resolution.
        "rsvv_m_s" resolution: VerticalVelocityResolution,
        /// SDVV, the standard deviation.
        "sdvv" precision: VerticalVelocityPrecision,
        /// COVVHP, correlation with the horizontal position.
        "covvhp" position_correlation: PairCorrelation,
        /// COVVHV, correlation with the horizontal velocity.
        "covvhv" velocity_correlation: PairCorrelation,
        /// COVVHA, correlation with the horizontal acceleration.
        "covvha" acceleration_correlation: PairCorrelation,
    }

    /// VV in I015/604.
    /// Metres per second upwards: LSB 0.01 m/s, -83,886.08 to 83,886.07 m/s.
    pub struct VerticalVelocity(3) = signed 24 "" up_m_s / with_up_m_s = 0.01, 2;

    /// RSVV in I015/604.
    /// Metres per second: LSB 0.01 m/s, 0 to 655.35 m/s.
    pub struct VerticalVelocityResolution(2) = unsigned 16 "" up_m_s / with_up_m_s = 0.01, 2;

    /// SDVV in I015/604.
    pub struct VerticalVelocityPrecision(3) {
        /// SDVV, standard deviation in metres per second: LSB 0.01 m/s, 0 to 655.35 m/s.
        unsigned 16 "sdvv_m_s" up_m_s / with_up_m_s = 0.01, 2;
        /// COVVGH, correlation with the height: LSB 1/128, -1 to below 1.
        signed 8 "covvgh" height_correlation / with_height_correlation = 1.0 / 128.0, 4;
    }

    /// I015/605, vertical acceleration information.
    compound pub struct VerticalAccelerationInformation {
        /// VA, the acceleration upwards.
        "va_m_s2" acceleration: VerticalAcceleration,
        /// RSVA, the standard deviation.
        "rsva" precision: VerticalAccelerationPrecision,
        /// COVAHP, correlation with the horizontal position.
        "covahp" position_correlation: PairCorrelation,
        /// COVAHV, correlation with the horizontal velocity.
        "covahv" velocity_correlation: PairCorrelation,
        /// COVAHA, correlation with the horizontal acceleration.
        "covaha" acceleration_correlation: PairCorrelation,
    }

    /// VA in I015/605.
    /// Metres per second squared upwards: LSB 0.01 m/s², -327.68 to 327.67 m/s².
    pub struct VerticalAcceleration(2) = signed 16 "" up_m_s2 / with_up_m_s2 = 0.01, 2;

    /// RSVA in I015/605.
    pub struct VerticalAccelerationPrecision(4) {
        /// SDVA, standard deviation in metres per second squared: LSB 0.01 m/s², 0 to 655.35 m/s².
        unsigned 16 "sdva_m_s2" up_m_s2 / with_up_m_s2 = 0.01, 2;
        /// COVAGH, correlation with the height: LSB 1/128, -1 to below 1.
        signed 8 "covagh" height_correlation / with_height_correlation = 1.0 / 128.0, 4;
        /// COVAVV, correlation with the vertical velocity: LSB 1/128, -1 to below 1.
        signed 8 "covavv" velocity_correlation / with_velocity_correlation = 1.0 / 128.0, 4;
    }
}
