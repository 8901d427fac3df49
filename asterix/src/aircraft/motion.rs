//! Motion reported by an aircraft.

use crate::item::items;

items! {
    /// I021/150 and IAS in I062/380: indicated air speed or Mach number.
    pub struct AirSpeed(2) {
        /// IM: the value is a Mach number.
        flag 1 "im" is_mach;
        /// The count: LSB 2^-14 NM/s (0.113 m/s), or Mach 0.001.
        count 15 "air_speed" count: u16;
    }
}

impl AirSpeed {
    /// Metres per second per count of an indicated air speed.
    const LSB_M_S: f64 = 1852.0 / 16_384.0;

    /// The nearest indicated air speed; `None` outside 0 to below 2 NM/s (3704 m/s).
    pub fn from_indicated_m_s(speed_m_s: f64) -> Option<Self> {
        Self::of(false, speed_m_s / Self::LSB_M_S)
    }

    /// The nearest Mach number; `None` outside 0 to 32.767.
    pub fn from_mach(mach: f64) -> Option<Self> {
        Self::of(true, mach * 1000.0)
    }

    fn of(is_mach: bool, counts: f64) -> Option<Self> {
        let count = crate::bits::nearest(counts, 0, 0x7fff)? as u16;
        Some(Self((u16::from(is_mach) << 15 | count).to_be_bytes()))
    }

    /// The indicated air speed in metres per second; `None` if the item is a Mach number.
    pub fn indicated_m_s(self) -> Option<f64> {
        (!self.is_mach()).then_some(f64::from(self.count()) * Self::LSB_M_S)
    }

    /// The Mach number; `None` if the item is an indicated air speed.
    pub fn mach(self) -> Option<f64> {
        self.is_mach().then_some(f64::from(self.count()) / 1000.0)
    }
}

items! {
    /// I021/152 and MHG in I062/380: magnetic heading.
    pub struct MagneticHeading(2) {
        /// Degrees, clockwise from magnetic north: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
        angle 16 "heading_deg" heading_deg / with_heading_deg = 360.0 / 65536.0, 3;
    }

    /// I021/230 and RAN in I062/380: roll angle.
    pub struct RollAngle(2) {
        /// Degrees, right wing down positive: LSB 0.01 degrees, -180 to 180 degrees; the bits hold -327.68 to 327.67.
        signed_per 16 "roll_deg" roll_deg / with_roll_deg = 100.0, 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn air_speed_is_one_or_the_other() {
        let mach = AirSpeed::from_mach(0.78).unwrap();
        assert_eq!((mach.octets(), mach.mach(), mach.indicated_m_s()), ([0x83, 0x0c], Some(0.78), None));
        let indicated = AirSpeed::from_indicated_m_s(115.75).unwrap();
        assert_eq!((indicated.octets(), indicated.indicated_m_s()), ([0x04, 0x00], Some(115.75)));
        assert_eq!(indicated.mach(), None);
        assert_eq!((AirSpeed::from_mach(32.8), AirSpeed::from_indicated_m_s(-1.0)), (None, None));
    }
}
