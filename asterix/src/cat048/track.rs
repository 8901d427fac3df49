//! The radar's own track: I048/042, 161, 170, 200, 210.

use deku::{DekuRead, DekuWrite};

use crate::item::{Describe, item};
use crate::items::nearest;
use crate::layout::{count, field, quantity};
use crate::{Chain, Kind, Layout};

item! {
    /// I048/042 (5.2.5), calculated position in Cartesian co-ordinates, local to the radar.
    pub struct CartesianPosition(4) {
        /// X, metres east of the radar: LSB 1/128 NM (14.46875 m), -474,112 to 474,097 m.
        signed 16 "x_m" x_m / with_x_m = 1852.0 / 128.0, 1;
        /// Y, metres north of the radar: LSB 1/128 NM (14.46875 m), -474,112 to 474,097 m.
        signed 16 "y_m" y_m / with_y_m = 1852.0 / 128.0, 1;
    }
}

item! {
    /// I048/210 (5.2.21), track quality: standard deviations in the local grid.
    pub struct TrackQuality(4) {
        /// SIGMA X, of the position along the east axis, in metres: LSB 1/128 NM (14.46875 m), 0 to 3689.5 m.
        unsigned 8 "sigma_x_m" sigma_x_m / with_sigma_x_m = 1852.0 / 128.0, 1;
        /// SIGMA Y, of the position along the north axis, in metres: LSB 1/128 NM (14.46875 m), 0 to 3689.5 m.
        unsigned 8 "sigma_y_m" sigma_y_m / with_sigma_y_m = 1852.0 / 128.0, 1;
        /// SIGMA V, of the ground speed, in metres a second: LSB 2^-14 NM/s (0.113 m/s), 0 to 28.8 m/s.
        unsigned 8 "sigma_v_m_s" sigma_v_m_s / with_sigma_v_m_s = 1852.0 / 16384.0, 2;
        /// SIGMA H, of the heading, in degrees: LSB 360/4096 degrees (about 0.088), 0 to 22.4 degrees.
        unsigned 8 "sigma_h_deg" sigma_h_deg / with_sigma_h_deg = 360.0 / 4096.0, 2;
    }
}

/// I048/161, the radar's number of the track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct TrackNumber(u16);

impl TrackNumber {
    /// The item as it stands: four spare bits and 12 bits of number.
    pub const fn from_word(word: u16) -> Self {
        Self(word)
    }

    /// The track number, or `None` above 4095.
    pub const fn new(number: u16) -> Option<Self> {
        if number <= 0x0fff { Some(Self(number)) } else { None }
    }

    /// The item as it stands.
    pub const fn word(self) -> u16 {
        self.0
    }

    /// The number, 0 to 4095.
    pub const fn number(self) -> u16 {
        self.0 & 0x0fff
    }
}

impl Describe for TrackNumber {
    const LAYOUT: Layout = Layout::Fields(&[field("spare", 4, Kind::Spare), count("track_number", 12)]);
}

/// RAD in I048/170: what keeps the track alive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TrackSensor {
    /// 0: primary and secondary radar.
    Combined,
    /// 1: primary radar.
    Primary,
    /// 2: secondary radar or Mode S.
    Secondary,
    /// 3: not a valid code.
    Invalid,
}

/// CDM in I048/170: climbing or descending.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClimbMode {
    /// 0: keeps its height.
    Maintaining,
    /// 1: climbs.
    Climbing,
    /// 2: descends.
    Descending,
    /// 3: unknown.
    Unknown,
}

/// I048/170, track status: one octet and, where sent, its extensions. What an absent extension would say is `false`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
pub struct TrackStatus(Chain);

impl TrackStatus {
    /// A confirmed combined track that does nothing special, without extension.
    pub const fn new() -> Self {
        Self(Chain::new(0))
    }

    /// The octets as they stand.
    pub const fn chain(&self) -> &Chain {
        &self.0
    }

    const fn bits(&self, octet: usize, shift: u8, mask: u8) -> u8 {
        match self.0.octet(octet) {
            Some(octet) => octet >> shift & mask,
            None => 0,
        }
    }

    /// CNF = 1: tentative, not confirmed.
    pub const fn is_tentative(&self) -> bool {
        self.bits(0, 7, 1) == 1
    }

    /// RAD: what keeps the track alive.
    pub const fn sensor(&self) -> TrackSensor {
        match self.bits(0, 5, 3) {
            0 => TrackSensor::Combined,
            1 => TrackSensor::Primary,
            2 => TrackSensor::Secondary,
            _ => TrackSensor::Invalid,
        }
    }

    /// DOU = 1: low confidence that the plot belongs to the track.
    pub const fn is_doubtful(&self) -> bool {
        self.bits(0, 4, 1) == 1
    }

    /// MAH = 1: a horizontal manoeuvre is sensed.
    pub const fn is_manoeuvring(&self) -> bool {
        self.bits(0, 3, 1) == 1
    }

    /// CDM: climbing or descending.
    pub const fn climb_mode(&self) -> ClimbMode {
        match self.bits(0, 1, 3) {
            0 => ClimbMode::Maintaining,
            1 => ClimbMode::Climbing,
            2 => ClimbMode::Descending,
            _ => ClimbMode::Unknown,
        }
    }

    /// TRE = 1: the last report of this track.
    pub const fn is_last_report(&self) -> bool {
        self.bits(1, 7, 1) == 1
    }

    /// GHO = 1: a ghost.
    pub const fn is_ghost(&self) -> bool {
        self.bits(1, 6, 1) == 1
    }

    /// SUP = 1: kept with data of a neighbouring node.
    pub const fn is_supplemented(&self) -> bool {
        self.bits(1, 5, 1) == 1
    }

    /// TCC = 1: tracked in a plane tangential to the Earth, with slant range correction; 0: in the radar plane.
    pub const fn is_slant_range_corrected(&self) -> bool {
        self.bits(1, 4, 1) == 1
    }

    /// The same with CNF.
    #[must_use]
    pub const fn with_tentative(self, tentative: bool) -> Self {
        Self(self.0.with(0, 0x80, (tentative as u8) << 7))
    }

    /// The same with RAD.
    #[must_use]
    pub const fn with_sensor(self, sensor: TrackSensor) -> Self {
        Self(self.0.with(0, 0x60, (sensor as u8) << 5))
    }

    /// The same with DOU.
    #[must_use]
    pub const fn with_doubtful(self, doubtful: bool) -> Self {
        Self(self.0.with(0, 0x10, (doubtful as u8) << 4))
    }

    /// The same with MAH.
    #[must_use]
    pub const fn with_manoeuvring(self, manoeuvring: bool) -> Self {
        Self(self.0.with(0, 0x08, (manoeuvring as u8) << 3))
    }

    /// The same with CDM.
    #[must_use]
    pub const fn with_climb_mode(self, mode: ClimbMode) -> Self {
        Self(self.0.with(0, 0x06, (mode as u8) << 1))
    }

    /// The same with TRE, in the first extension.
    #[must_use]
    pub const fn with_last_report(self, last: bool) -> Self {
        Self(self.0.with(1, 0x80, (last as u8) << 7))
    }

    /// The same with GHO, in the first extension.
    #[must_use]
    pub const fn with_ghost(self, ghost: bool) -> Self {
        Self(self.0.with(1, 0x40, (ghost as u8) << 6))
    }
}

impl Describe for TrackStatus {
    const LAYOUT: Layout = Layout::Extended(&[
        &[count("cnf", 1), count("rad", 2), count("dou", 1), count("mah", 1), count("cdm", 2)],
        &[
            count("tre", 1),
            count("gho", 1),
            count("sup", 1),
            count("tcc", 1),
            field("spare_2", 3, Kind::Spare),
        ],
    ]);
}

impl From<Chain> for TrackStatus {
    /// A status with any octets, for what the setters do not cover.
    fn from(chain: Chain) -> Self {
        Self(chain)
    }
}

impl Default for TrackStatus {
    fn default() -> Self {
        Self::new()
    }
}

/// I048/200, calculated speed and heading of the track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct TrackVelocity {
    /// Ground speed: LSB 2^-14 NM/s (about 0.22 kt, 0.113 m/s), 0 to below 4 NM/s.
    pub speed: u16,
    /// Heading, clockwise from the radar's north: LSB 360/65536 degrees.
    pub heading: u16,
}

impl TrackVelocity {
    /// The nearest velocity. `None` when the speed is not in 0 to below 4 NM/s (7408 m/s) or a number is not finite; any
    /// finite heading is brought into one turn.
    pub fn new(speed_m_s: f64, heading_deg: f64) -> Option<Self> {
        let speed = nearest(speed_m_s * 16384.0 / 1852.0, 0, i32::from(u16::MAX))?;
        let heading = nearest(heading_deg.rem_euclid(360.0) * 65536.0 / 360.0, 0, 65536)?;
        Some(Self { speed: speed as u16, heading: heading as u16 })
    }

    /// Ground speed in nautical miles a second, exact.
    pub fn speed_nm_s(self) -> f64 {
        f64::from(self.speed) / 16384.0
    }

    /// Ground speed in metres a second.
    pub fn speed_m_s(self) -> f64 {
        f64::from(self.speed) * (1852.0 / 16384.0)
    }

    /// Heading in degrees, 0 to below 360, exact.
    pub fn heading_deg(self) -> f64 {
        f64::from(self.heading) * (360.0 / 65536.0)
    }
}

impl Describe for TrackVelocity {
    const LAYOUT: Layout = Layout::Fields(&[
        quantity("speed_m_s", 16, false, 1852.0 / 16384.0, 2),
        quantity("heading_deg", 16, false, 360.0 / 65536.0, 3),
    ]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn track_number_keeps_its_spare_bits_out_of_the_number() {
        assert_eq!(TrackNumber::from_word(0xf783).number(), 1923);
        assert_eq!(TrackNumber::new(4095).map(TrackNumber::word), Some(0x0fff));
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
        assert_eq!(velocity, TrackVelocity { speed: 16384, heading: 32768 });
        assert_eq!(
            (velocity.speed_nm_s(), velocity.speed_m_s(), velocity.heading_deg()),
            (1.0, 1852.0, 180.0)
        );
        assert_eq!(TrackVelocity::new(7408.0, 0.0), None);
    }
}
