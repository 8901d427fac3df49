//! Meteorological data from the aircraft: I021/220.

use crate::item::items;

items! {
    /// I021/220, met information.
    compound pub struct MetInformation {
        /// WS, wind speed.
        "ws" wind_speed: WindSpeed,
        /// WD, wind direction.
        "wd" wind_direction: WindDirection,
        /// TMP, temperature.
        "tmp" temperature: Temperature,
        /// TRB, turbulence.
        "trb" turbulence: Turbulence,
        _,
        _,
        _,
    }

    /// WS in I021/220.
    pub struct WindSpeed(2) {
        /// Metres per second: LSB 1 kt (0.514 m/s), 0 to 300 kt; the bits hold 65,535 kt.
        unsigned 16 "speed_m_s" speed_m_s / with_speed_m_s = 1852.0 / 3600.0, 1;
    }

    /// WD in I021/220.
    pub struct WindDirection(2) {
        /// Degrees from which the wind blows: LSB 1 degree, 1 to 360 degrees; the bits hold 0 to 65,535.
        count 16 "direction_deg" direction_deg / with_direction_deg: u16;
    }

    /// TMP in I021/220.
    pub struct Temperature(2) {
        /// Degrees Celsius: LSB 0.25 degrees, -100 to 100 degrees; the bits hold -8192 to 8191.75.
        signed 16 "temperature_c" celsius / with_celsius = 0.25, 2;
    }

    /// TRB in I021/220.
    /// Turbulence, 0 to 15.
    pub struct Turbulence(1) = count 8 "" turbulence / with_turbulence: u8;
}
