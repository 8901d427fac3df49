//! Motion of the aircraft: I021/151, 155, 157, 160, 165.

use crate::item::items;

/// Metres per second in a knot.
const KNOT_M_S: f64 = 1852.0 / 3600.0;

/// Metres per second in a foot per minute.
const FOOT_A_MINUTE_M_S: f64 = 0.3048 / 60.0;

items! {
    /// I021/151, true airspeed.
    pub struct TrueAirspeed(2) {
        /// RE: the range of the item is exceeded.
        flag 1 "re" is_exceeded / with_exceeded;
        /// Metres per second: LSB 1 kt (0.514 m/s), 0 to 16,857 m/s.
        unsigned 15 "tas_m_s" speed_m_s / with_speed_m_s = KNOT_M_S, 1;
    }

    /// I021/155, barometric, and I021/157, geometric vertical rate.
    pub struct VerticalRate(2) {
        /// RE: the range of the item is exceeded.
        flag 1 "re" is_exceeded / with_exceeded;
        /// Metres per second, up positive: LSB 6.25 ft/min (0.03175 m/s), -520.2 to 520.2 m/s.
        signed 15 "rate_m_s" up_m_s / with_up_m_s = 6.25 * FOOT_A_MINUTE_M_S, 2;
    }

    /// I021/160, ground vector of an airborne target.
    pub struct GroundVector(4) {
        /// RE: the range of the item is exceeded.
        flag 1 "re" is_exceeded / with_exceeded;
        /// Ground speed in metres per second: LSB 2^-14 NM/s (0.113 m/s), 0 to below 2 NM/s (3704 m/s).
        unsigned 15 "speed_m_s" speed_m_s / with_speed_m_s = 1852.0 / 16_384.0, 2;
        /// Track angle in degrees, clockwise from true north: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
        angle 16 "track_deg" track_deg / with_track_deg = 360.0 / 65536.0, 3;
    }
}

impl GroundVector {
    /// The nearest vector. `None` if the speed is not in 0 to below 3704 m/s or a number is not finite; any finite angle is
    /// reduced to one turn.
    pub fn new(speed_m_s: f64, track_deg: f64) -> Option<Self> {
        Self::default().with_speed_m_s(speed_m_s)?.with_track_deg(track_deg)
    }
}

items! {
    /// I021/165, track angle rate.
    pub struct TrackAngleRate(2) {
        spare 6 "spare";
        /// Degrees per second, clockwise positive: LSB 1/32 degrees per second, -16 to 15.97.
        signed 10 "rate_deg_s" rate_deg_s / with_rate_deg_s = 1.0 / 32.0, 5;
    }
}
