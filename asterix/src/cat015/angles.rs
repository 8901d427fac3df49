//! Direction of the target: I015/627, 628.

use crate::item::items;

items! {
    /// I015/627, azimuth information, relative to the sensor's reference point.
    compound pub struct AzimuthInformation {
        /// AZ, the azimuth.
        "az_deg" azimuth: Angle,
        /// RSAZ, the resolution.
        "rsaz_deg" resolution: AngleDeviation,
        /// SDASZ, the standard deviation.
        "sdasz_deg" deviation: AngleDeviation,
        /// AZR, the azimuth rate.
        "azr_deg_s" rate: AngleRate,
        /// SDAZR, its standard deviation.
        "sdazr" rate_deviation: AngleRateDeviation,
        /// AZEX, extent of the target in azimuth, clockwise.
        "azex" extent: AzimuthExtent,
    }

    /// AZ in I015/627.
    /// Degrees clockwise from true north: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
    pub struct Angle(2) = angle 16 "" degrees / with_degrees = 360.0 / 65536.0, 3;

    /// RSAZ, SDASZ in I015/627; RSEL, SDEL in I015/628.
    /// Degrees: LSB 45/65536 degrees (about 0.0007), 0 to below 45 degrees.
    pub struct AngleDeviation(2) = unsigned 16 "" degrees / with_degrees = 45.0 / 65536.0, 4;

    /// AZR in I015/627; ER in I015/628.
    /// Degrees per second: LSB 180/65536 degrees per second (about 0.0027), -90 to below 90 degrees per second.
    pub struct AngleRate(2) = signed 16 "" deg_s / with_deg_s = 180.0 / 65536.0, 4;

    /// SDAZR in I015/627; SDER in I015/628.
    pub struct AngleRateDeviation(3) {
        /// Degrees per second: LSB 45/65536 degrees per second (about 0.0007), 0 to below 45 degrees per second.
        unsigned 16 "deviation_deg_s" deg_s / with_deg_s = 45.0 / 65536.0, 4;
        /// Correlation with the angle: LSB 1/128, -1 to below 1.
        signed 8 "correlation" angle_correlation / with_angle_correlation = 1.0 / 128.0, 4;
    }

    /// AZEX in I015/627.
    pub struct AzimuthExtent(4) {
        /// S, start, in degrees clockwise from true north: LSB 360/65536 degrees, 0 to below 360 degrees.
        angle 16 "start_deg" start_deg / with_start_deg = 360.0 / 65536.0, 3;
        /// E, end, in degrees clockwise from true north: LSB 360/65536 degrees, 0 to below 360 degrees.
        angle 16 "end_deg" end_deg / with_end_deg = 360.0 / 65536.0, 3;
    }

    /// I015/628, elevation information, relative to the horizontal plane at the sensor.
    compound pub struct ElevationInformation {
        /// EL, the elevation.
        "el_deg" elevation: SignedAngle,
        /// RSEL, the resolution.
        "rsel_deg" resolution: AngleDeviation,
        /// SDEL, the standard deviation.
        "sdel_deg" deviation: AngleDeviation,
        /// ER, the elevation rate.
        "er_deg_s" rate: AngleRate,
        /// SDER, its standard deviation.
        "sder" rate_deviation: AngleRateDeviation,
        /// ELEX, extent of the target in elevation.
        "elex" extent: ElevationExtent,
    }

    /// EL in I015/628.
    /// Degrees upwards: LSB 180/65536 degrees (about 0.0027), -90 to below 90 degrees.
    pub struct SignedAngle(2) = signed 16 "" degrees / with_degrees = 180.0 / 65536.0, 4;

    /// ELEX in I015/628.
    pub struct ElevationExtent(4) {
        /// S, start, in degrees upwards: LSB 180/65536 degrees, -90 to below 90 degrees.
        signed 16 "start_deg" start_deg / with_start_deg = 180.0 / 65536.0, 4;
        /// E, end, in degrees upwards: LSB 180/65536 degrees, -90 to below 90 degrees.
        signed 16 "end_deg" end_deg / with_end_deg = 180.0 / 65536.0, 4;
    }
}
