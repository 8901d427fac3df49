//! Intended trajectory reported by an aircraft: TIS and TID in I021/110 and I062/380.

use crate::item::items;

/// Degrees per count of a 24-bit position.
const POSITION_LSB_DEG: f64 = 180.0 / 8_388_608.0;

items! {
    /// TIS, trajectory intent status: one octet and, where sent, its extensions.
    extended pub struct IntentStatus {
        first {
            /// NAV: no trajectory intent is available.
            flag 1 "nav" is_unavailable / with_unavailable;
            /// NVB: the trajectory intent is not valid.
            flag 1 "nvb" is_invalid / with_invalid;
            spare 5 "spare";
        }
    }

    /// PT in TID: the kind of a point.
    pub enum PointType {
        /// unknown.
        Unknown = 0,
        /// fly by the waypoint.
        FlyBy = 1,
        /// fly over the waypoint.
        FlyOver = 2,
        /// hold pattern.
        Hold = 3,
        /// procedure hold.
        ProcedureHold = 4,
        /// procedure turn.
        ProcedureTurn = 5,
        /// leg of a fixed radius.
        FixedRadius = 6,
        /// top of climb.
        TopOfClimb = 7,
        /// top of descent.
        TopOfDescent = 8,
        /// start of level flight.
        StartOfLevel = 9,
        /// cross-over altitude.
        CrossOverAltitude = 10,
        /// transition altitude.
        TransitionAltitude = 11,
    }

    /// TD in TID: direction of the turn.
    all pub enum TurnDirection {
        /// 0: not available.
        Unavailable,
        /// 1: right.
        Right,
        /// 2: left.
        Left,
        /// 3: no turn.
        None,
    }

    /// A part of TID: a point of the intended trajectory.
    pub struct TrajectoryPoint(15) {
        /// TCA: the point has no number.
        flag 1 "tca" is_unnumbered / with_unnumbered;
        /// NC: the aircraft does not comply with it.
        flag 1 "nc" is_non_compliant / with_non_compliant;
        /// TCPN, number of the point, 0 to 63.
        count 6 "tcpn" number / with_number: u8;
        /// Altitude in metres: LSB 10 ft (3.048 m), -99,877 to 99,874 m.
        signed 16 "altitude_m" altitude_m / with_altitude_m = 10.0 * 0.3048, 2;
        /// Latitude in degrees, north positive: LSB 180/2^23 degrees (2.4 m).
        signed 24 "latitude_deg" latitude_deg / with_latitude_deg = POSITION_LSB_DEG, 5;
        /// Longitude in degrees, east positive: LSB 180/2^23 degrees (2.4 m).
        signed 24 "longitude_deg" longitude_deg / with_longitude_deg = POSITION_LSB_DEG, 5;
        /// PT, the kind of point.
        code 4 "pt" point_type / with_point_type: PointType;
        /// TD, direction of the turn.
        code 2 "td" turn / with_turn: TurnDirection;
        /// TRA: the radius of the turn is given.
        flag 1 "tra" has_radius / with_radius_given;
        /// TOA: the time over the point is not given.
        flag 1 "toa" is_time_unknown / with_time_unknown;
        /// TOV, time over the point in seconds: LSB 1 s.
        count 24 "tov_s" time_s / with_time_s: u32;
        /// TTR, radius of the turn in metres: LSB 0.01 NM (18.52 m), 0 to 1,213,708 m.
        unsigned 16 "ttr_m" radius_m / with_radius_m = 18.52, 1;
    }
}
