//! Actual and selected altitude reported by an aircraft.

use crate::item::items;

/// Metres in a foot.
const FOOT_M: f64 = 0.3048;

items! {
    /// I021/140, I062/130 and GAL in I062/380: height above the WGS-84 ellipsoid.
    pub struct GeometricHeight(2) {
        /// Metres: LSB 6.25 ft (1.905 m), -62,423 to 62,421 m. The highest count of I021/140 means "greater than".
        signed 16 "height_m" height_m / with_height_m = 6.25 * FOOT_M, 3;
    }

    /// I021/145 and I062/136: pressure altitude.
    pub struct BarometricLevel(2) {
        /// The flight level (hundreds of feet above the 1013.25 hPa surface), exact: LSB 1/4 (25 ft), -8192 to 8191.75.
        signed 16 "flight_level" flight_level / with_flight_level = 0.25, 2;
    }

    /// Source of a selected altitude.
    all pub enum AltitudeSource {
        /// 0: unknown.
        Unknown,
        /// 1: aircraft (holding altitude).
        Aircraft,
        /// 2: the flight control unit.
        ControlUnit,
        /// 3: the flight management system.
        ManagementSystem,
    }

    /// I021/146 and SAL in I062/380: the altitude that the crew selected.
    pub struct SelectedAltitude(2) {
        /// SAS: the source is given.
        flag 1 "sas" has_source / with_source_given;
        /// The source.
        code 2 "source" source / with_source: AltitudeSource;
        /// Metres: LSB 25 ft (7.62 m), -31,212 to 31,204 m.
        signed 13 "altitude_m" altitude_m / with_altitude_m = 25.0 * FOOT_M, 2;
    }

    /// I021/148 and FSS in I062/380: the altitude at which the aircraft will level off.
    pub struct FinalAltitude(2) {
        /// MV: the vertical mode is managed.
        flag 1 "mv" is_vertical_managed / with_vertical_managed;
        /// AH: altitude hold.
        flag 1 "ah" is_altitude_held / with_altitude_held;
        /// AM: approach.
        flag 1 "am" is_approach / with_approach;
        /// Metres: LSB 25 ft (7.62 m), -31,212 to 31,204 m.
        signed 13 "altitude_m" altitude_m / with_altitude_m = 25.0 * FOOT_M, 2;
    }
}
