//! Motion of the track: I062/185, 200, 210, 220.

use crate::item::items;

items! {
    /// I062/185, calculated velocity.
    pub struct Velocity(4) {
        /// VX, metres per second east: LSB 0.25 m/s, -8192 to 8191.75 m/s.
        signed 16 "vx_m_s" east_m_s / with_east_m_s = 0.25, 2;
        /// VY, metres per second north: LSB 0.25 m/s, -8192 to 8191.75 m/s.
        signed 16 "vy_m_s" north_m_s / with_north_m_s = 0.25, 2;
    }
}

impl Velocity {
    /// The nearest velocity; `None` if it is out of range.
    pub fn new(east_m_s: f64, north_m_s: f64) -> Option<Self> {
        Self::default().with_east_m_s(east_m_s)?.with_north_m_s(north_m_s)
    }
}

items! {
    /// TRANS in I062/200.
    all pub enum TransversalMode {
        /// 0: constant course.
        Constant,
        /// 1: right turn.
        Right,
        /// 2: left turn.
        Left,
        /// 3: undetermined.
        Undetermined,
    }

    /// LONG in I062/200.
    all pub enum LongitudinalMode {
        /// 0: constant ground speed.
        Constant,
        /// 1: increasing ground speed.
        Faster,
        /// 2: decreasing ground speed.
        Slower,
        /// 3: undetermined.
        Undetermined,
    }

    /// VERT in I062/200.
    all pub enum VerticalMode {
        /// 0: level.
        Level,
        /// 1: climbs.
        Climbing,
        /// 2: descends.
        Descending,
        /// 3: undetermined.
        Undetermined,
    }

    /// I062/200, mode of movement.
    pub struct ModeOfMovement(1) {
        /// TRANS: turning.
        code 2 "trans" transversal / with_transversal: TransversalMode;
        /// LONG: change of ground speed.
        code 2 "long" longitudinal / with_longitudinal: LongitudinalMode;
        /// VERT: climbing or descending.
        code 2 "vert" vertical / with_vertical: VerticalMode;
        /// ADF: the altitudes of several sources disagree.
        flag 1 "adf" has_altitude_discrepancy / with_altitude_discrepancy;
        spare 1 "spare";
    }

    /// I062/210, calculated acceleration.
    pub struct Acceleration(2) {
        /// AX, metres per second squared east: LSB 0.25 m/s², -32 to 31.75 m/s².
        signed 8 "ax_m_s2" east_m_s2 / with_east_m_s2 = 0.25, 2;
        /// AY, metres per second squared north: LSB 0.25 m/s², -32 to 31.75 m/s².
        signed 8 "ay_m_s2" north_m_s2 / with_north_m_s2 = 0.25, 2;
    }

    /// I062/220 and BVR and GVR in I062/380, rate of climb.
    pub struct ClimbRate(2) {
        /// Metres per second, up positive: LSB 6.25 ft/min (0.03175 m/s), -1040.4 to 1040.4 m/s.
        signed 16 "rate_m_s" up_m_s / with_up_m_s = 6.25 * 0.3048 / 60.0, 2;
    }
}
