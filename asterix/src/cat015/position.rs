//! Position of the target: I015/600, 601. X points east and Y north, in a plane at the target.

use crate::item::items;

items! {
    /// I015/600, horizontal position information.
    compound pub struct PositionInformation {
        /// P84, the position.
        "p84" wgs84: Wgs84Position,
        /// HPR, the resolution.
        "hpr" resolution: PositionResolution,
        /// HPP, distribution of the errors.
        "hpp" precision: PositionPrecision,
    }

    /// P84 in I015/600: WGS-84.
    pub struct Wgs84Position(8) {
        /// Degrees north: LSB 180/2^31 degrees (9 mm), -90 to 90 degrees.
        signed 32 "latitude_deg" latitude_deg / with_latitude_deg = 180.0 / 2_147_483_648.0, 8;
        /// Degrees east: LSB 180/2^31 degrees (9 mm along the equator), -180 to below 180 degrees.
        signed 32 "longitude_deg" longitude_deg / with_longitude_deg = 180.0 / 2_147_483_648.0, 8;
    }

    /// HPR in I015/600: ellipse within which two targets are not resolved.
    pub struct PositionResolution(5) {
        /// RSHPX, east in metres: LSB 0.5 m, 0 to 32,767.5 m.
        unsigned 16 "rshpx_m" east_m / with_east_m = 0.5, 1;
        /// RSHPY, north in metres: LSB 0.5 m, 0 to 32,767.5 m.
        unsigned 16 "rshpy_m" north_m / with_north_m = 0.5, 1;
        /// CORSHPXY, their correlation: LSB 1/128, -1 to below 1.
        signed 8 "corshpxy" correlation / with_correlation = 1.0 / 128.0, 4;
    }

    /// HPP in I015/600: standard deviations.
    pub struct PositionPrecision(5) {
        /// SDHPX, east in metres: LSB 0.25 m, 0 to 16,383.75 m.
        unsigned 16 "sdhpx_m" east_m / with_east_m = 0.25, 2;
        /// SDHPY, north in metres: LSB 0.25 m, 0 to 16,383.75 m.
        unsigned 16 "sdhpy_m" north_m / with_north_m = 0.25, 2;
        /// COSDHPXY, their correlation: LSB 1/128, -1 to below 1.
        signed 8 "cosdhpxy" correlation / with_correlation = 1.0 / 128.0, 4;
    }

    /// I015/601, geometric height information.
    padded pub struct HeightInformation {
        /// GH, the height above the WGS-84 ellipsoid.
        "gh_m" height: Height,
        /// RSGH, the resolution.
        "rsgh_m" resolution: HeightDeviation,
        /// SDGH, the standard deviation.
        "sdgh_m" deviation: HeightDeviation,
        /// CI6, the interval of 67 %.
        "ci6" interval_67: ConfidenceInterval,
        /// CI9, the interval of 95 %.
        "ci9" interval_95: ConfidenceInterval,
        /// COGHHP, correlation with the horizontal position.
        "coghhp" position_correlation: PairCorrelation,
        /// COGHHV, correlation with the horizontal velocity.
        "coghhv" velocity_correlation: PairCorrelation,
        /// COGHHA, correlation with the horizontal acceleration.
        "coghha" acceleration_correlation: PairCorrelation,
    }

    /// GH in I015/601.
    /// Metres above the WGS-84 ellipsoid: LSB 0.01 m, -83,886.08 to 83,886.07 m.
    pub struct Height(3) = signed 24 "" metres / with_metres = 0.01, 2;

    /// RSGH, SDGH in I015/601.
    /// Metres: LSB 0.01 m, 0 to 167,772.15 m.
    pub struct HeightDeviation(3) = unsigned 24 "" metres / with_metres = 0.01, 2;

    /// COGHHP, COGHHV, COGHHA in I015/601; COVVHP, COVVHV, COVVHA in I015/604; COVAHP, COVAHV, COVAHA in I015/605:
    /// correlations with the components of a horizontal vector.
    pub struct PairCorrelation(2) {
        /// With the component east: LSB 1/128, -1 to below 1.
        signed 8 "x" east / with_east = 1.0 / 128.0, 4;
        /// With the component north: LSB 1/128, -1 to below 1.
        signed 8 "y" north / with_north = 1.0 / 128.0, 4;
    }

    /// CI6, CI9 in I015/601: confidence interval of the height.
    pub struct ConfidenceInterval(3) {
        /// UCI, upwards in metres: LSB 16 m, 0 to 65,520 m.
        unsigned 12 "upper_m" upper_m / with_upper_m = 16.0, 0;
        /// LCI, downwards in metres: LSB 16 m, 0 to 65,520 m.
        unsigned 12 "lower_m" lower_m / with_lower_m = 16.0, 0;
    }
}
