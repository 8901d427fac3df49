//! Biases of the sensor: I063/070, 080, 081, 090, 091, 092.

use crate::item::items;

items! {
    /// I063/070, bias of the sensor's time stamps.
    pub struct TimeBias(2) {
        /// Milliseconds: LSB 1 ms, -32,768 to 32,767 ms.
        signed 16 "bias_ms" milliseconds / with_milliseconds = 1.0, 0;
    }

    /// I063/080 for SSR and Mode S and I063/090 for PSR: range gain and bias.
    pub struct RangeBias(4) {
        /// Gain: relative excess of the range, LSB 1e-5, -0.32768 to 0.32767.
        signed_per 16 "gain" gain / with_gain = 100_000.0, 5;
        /// Bias in metres: LSB 1/128 NM (14.46875 m), -474,112 to 474,097 m.
        signed 16 "bias_m" bias_m / with_bias_m = 1852.0 / 128.0, 1;
    }

    /// I063/081 for SSR and Mode S and I063/091 for PSR: azimuth bias.
    pub struct AzimuthBias(2) {
        /// Degrees: LSB 360/65536 degrees (about 0.0055), -180 to below 180 degrees.
        signed 16 "azimuth_bias_deg" degrees / with_degrees = 360.0 / 65536.0, 3;
    }

    /// I063/092, elevation bias of PSR.
    pub struct ElevationBias(2) {
        /// Degrees: LSB 360/65536 degrees (about 0.0055), -180 to below 180 degrees.
        signed 16 "elevation_bias_deg" degrees / with_degrees = 360.0 / 65536.0, 3;
    }
}
