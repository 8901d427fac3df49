//! Track of the radar: I048/042, 161, 170, 200, 210.

use crate::Chain;
use crate::item::items;

items! {
    /// I048/042 (5.2.5), calculated position in Cartesian co-ordinates, local to the radar.
    pub struct CartesianPosition(4) {
        /// X, metres east of the radar: LSB 1/128 NM (14.46875 m), -474,112 to 474,097 m.
        signed 16 "x_m" x_m / with_x_m = 1852.0 / 128.0, 1;
        /// Y, metres north of the radar: LSB 1/128 NM (14.46875 m), -474,112 to 474,097 m.
        signed 16 "y_m" y_m / with_y_m = 1852.0 / 128.0, 1;
    }

    /// I048/210 (5.2.21), track quality: standard deviations in the local grid.
    pub struct TrackQuality(4) {
        /// SIGMA X, of the position along the east axis, in metres: LSB 1/128 NM (14.46875 m), 0 to 3689.5 m.
        unsigned 8 "sigma_x_m" sigma_x_m / with_sigma_x_m = 1852.0 / 128.0, 1;
        /// SIGMA Y, of the position along the north axis, in metres: LSB 1/128 NM (14.46875 m), 0 to 3689.5 m.
        unsigned 8 "sigma_y_m" sigma_y_m / with_sigma_y_m = 1852.0 / 128.0, 1;
        /// SIGMA V, of the ground speed, in metres per second: LSB 2^-14 NM/s (0.113 m/s), 0 to 28.8 m/s.
        unsigned 8 "sigma_v_m_s" sigma_v_m_s / with_sigma_v_m_s = 1852.0 / 16384.0, 2;
        /// SIGMA H, of the heading, in degrees: LSB 360/4096 degrees (about 0.088), 0 to 22.4 degrees.
        unsigned 8 "sigma_h_deg" sigma_h_deg / with_sigma_h_deg = 360.0 / 4096.0, 2;
    }

    /// I048/161 (5.2.18), track number assigned by the radar.
    pub struct TrackNumber(2) {
        spare 4 "spare";
        /// The number, 0 to 4095.
        count 12 "track_number" number / with_number: u16;
    }
}

impl TrackNumber {
    /// The track number, or `None` above 4095.
    pub const fn new(number: u16) -> Option<Self> {
        Self([0; 2]).with_number(number)
    }
}

items! {
    /// I048/200 (5.2.20), calculated speed and heading of the track.
    pub struct TrackVelocity(4) {
        /// Ground speed in metres per second: LSB 2^-14 NM/s (about 0.22 kt, 0.113 m/s), 0 to below 4 NM/s.
        unsigned 16 "speed_m_s" speed_m_s / with_speed_m_s = 1852.0 / 16384.0, 2;
        /// Heading in degrees, clockwise from the radar's north: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
        angle 16 "heading_deg" heading_deg / with_heading_deg = 360.0 / 65536.0, 3;
    }
}

impl TrackVelocity {
    /// The nearest velocity. `None` if the speed is not in 0 to below 4 NM/s (7408 m/s) or a number is not finite; any finite
    /// heading is reduced to one turn.
    pub fn new(speed_m_s: f64, heading_deg: f64) -> Option<Self> {
        Self::default().with_speed_m_s(speed_m_s)?.with_heading_deg(heading_deg)
    }
}

items! {
    /// RAD in I048/170: sensor that maintains the track.
    all pub enum TrackSensor {
        /// 0: primary and secondary radar.
        Combined,
        /// 1: primary radar.
        Primary,
        /// 2: secondary radar or Mode S.
        Secondary,
        /// 3: not a valid code.
        Invalid,
    }

    /// CDM in I048/170: vertical mode.
    all pub enum ClimbMode {
        /// 0: level.
        Maintaining,
        /// 1: climbs.
        Climbing,
        /// 2: descends.
        Descending,
        /// 3: unknown.
        Unknown,
    }

    /// I048/170 (5.2.19), track status: one octet and, where sent, its extensions. Values of an absent extension are `false`.
    extended pub struct TrackStatus {
        first {
            /// CNF: tentative, not confirmed.
            flag 1 "cnf" is_tentative / with_tentative;
            /// RAD: sensor that maintains the track.
            code 2 "rad" sensor / with_sensor: TrackSensor;
            /// DOU: low confidence that the plot belongs to the track.
            flag 1 "dou" is_doubtful / with_doubtful;
            /// MAH: a horizontal manoeuvre is sensed.
            flag 1 "mah" is_manoeuvring / with_manoeuvring;
            /// CDM: vertical mode.
            code 2 "cdm" climb_mode / with_climb_mode: ClimbMode;
        }
        extension {
            /// TRE: the last report of this track.
            flag 1 "tre" is_last_report / with_last_report;
            /// GHO: a ghost track.
            flag 1 "gho" is_ghost / with_ghost;
            /// SUP: maintained with data of an adjacent node.
            flag 1 "sup" is_supplemented / with_supplemented;
            /// TCC: tracked in a plane tangential to the Earth, with slant range correction; not set: in the radar plane.
            flag 1 "tcc" is_slant_range_corrected / with_slant_range_corrected;
            spare 3 "spare_2";
        }
    }
}

impl TrackStatus {
    /// A confirmed combined track in level flight without other flags or extension.
    pub const fn new() -> Self {
        Self(Chain::new(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn track_number_keeps_its_spare_bits_out_of_the_number() {
        assert_eq!(TrackNumber::from_octets([0xf7, 0x83]).number(), 1923);
        assert_eq!(TrackNumber::new(4095).map(TrackNumber::octets), Some([0x0f, 0xff]));
        assert_eq!(TrackNumber::new(4096), None);
    }

    #[test]
    fn track_status() {
        let status = TrackStatus::new()
            .with_tentative(true)
            .with_sensor(TrackSensor::Primary)
            .with_climb_mode(ClimbMode::Unknown);
        assert_eq!(status.chain().octets(), [0xa6]);
        assert!(status.is_tentative() && !status.is_doubtful() && !status.is_manoeuvring());
        assert_eq!((status.sensor(), status.climb_mode()), (TrackSensor::Primary, ClimbMode::Unknown));
        assert!(!status.is_last_report() && !status.is_ghost());
        let last = status.with_last_report(true).with_doubtful(true).with_manoeuvring(true);
        assert_eq!(last.chain().octets(), [0xbf, 0x80]);
        assert!(last.is_last_report() && !last.is_ghost() && !last.is_supplemented());
        assert_eq!(last.with_ghost(true).with_last_report(false).chain().octets(), [0xbf, 0x40]);
        assert!(!last.is_slant_range_corrected());
    }

    #[test]
    fn track_velocity() {
        let velocity = TrackVelocity::new(1852.0, -180.0).unwrap();
        assert_eq!(velocity.octets(), [0x40, 0, 0x80, 0]);
        assert_eq!((velocity.speed_m_s(), velocity.heading_deg()), (1852.0, 180.0));
        assert_eq!(TrackVelocity::new(7408.0, 0.0), None);
    }
}
