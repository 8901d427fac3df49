//! The items of category 129.

use deku::{DekuRead, DekuWrite};

use crate::item::{Describe, octets};
use crate::items::{nearest, octets24, sign_extend, word24};
use crate::layout::{count, field, quantity};
use crate::{Kind, Layout};

/// I129/015, data destination identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
pub struct DataDestination {
    /// Destination area code.
    pub dac: u8,
    /// Destination identification code.
    pub dic: u8,
}

impl Describe for DataDestination {
    const LAYOUT: Layout = Layout::Fields(&[count("dac", 8), count("dic", 8)]);
}

/// I129/080, position in WGS-84: two 32-bit two's complement numbers, LSB 180/2^30 degrees (1.9 cm along a meridian).
///
/// Numbers beyond the ranges decode; [`Position::in_range`] tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct Position {
    /// Latitude in counts, north positive; -2^29 to 2^29 is the Earth.
    pub latitude: i32,
    /// Longitude in counts, east positive; -2^30 to 2^30 is the Earth.
    pub longitude: i32,
}

impl Position {
    /// Counts in 180 degrees.
    const HALF_TURN: i32 = 1 << 30;

    /// The nearest position; `None` outside -90 to 90 degrees of latitude or -180 to 180 degrees of longitude.
    pub fn new(latitude_deg: f64, longitude_deg: f64) -> Option<Self> {
        let count =
            |degrees: f64, limit: i32| nearest(degrees * f64::from(Self::HALF_TURN) / 180.0, -limit, limit);
        Some(Self {
            latitude: count(latitude_deg, Self::HALF_TURN / 2)?,
            longitude: count(longitude_deg, Self::HALF_TURN)?,
        })
    }

    /// Latitude in degrees, north positive.
    pub fn latitude_deg(self) -> f64 {
        f64::from(self.latitude) * (180.0 / f64::from(Self::HALF_TURN))
    }

    /// Longitude in degrees, east positive.
    pub fn longitude_deg(self) -> f64 {
        f64::from(self.longitude) * (180.0 / f64::from(Self::HALF_TURN))
    }

    /// Whether it is on the Earth: latitude within 90 and longitude within 180 degrees.
    pub const fn in_range(self) -> bool {
        self.latitude.unsigned_abs() <= Self::HALF_TURN as u32 / 2
            && self.longitude.unsigned_abs() <= Self::HALF_TURN as u32
    }
}

impl Describe for Position {
    const LAYOUT: Layout = Layout::Fields(&[
        quantity("latitude_deg", 32, true, 180.0 / Self::HALF_TURN as f64, 8),
        quantity("longitude_deg", 32, true, 180.0 / Self::HALF_TURN as f64, 8),
    ]);
}

/// I129/090 and I129/100, an altitude: 24-bit two's complement, LSB 0.1 m, -838,860.8 m to 838,860.7 m.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Altitude([u8; 3]);

octets!(Altitude, 3);

impl Altitude {
    /// The altitude of this many 0.1 m, or `None` beyond 24 bits.
    pub const fn from_count(count: i32) -> Option<Self> {
        if count == sign_extend(count as u32, 24) { Some(Self(octets24(count as u32))) } else { None }
    }

    /// The nearest altitude, or `None` beyond the range.
    pub fn from_metres(altitude_m: f64) -> Option<Self> {
        Self::from_count(nearest(altitude_m * 10.0, -0x80_0000, 0x7f_ffff)?)
    }

    /// The altitude in units of 0.1 m.
    pub const fn count(self) -> i32 {
        sign_extend(word24(self.0), 24)
    }

    /// The altitude in metres.
    pub fn metres(self) -> f64 {
        f64::from(self.count()) / 10.0
    }
}

impl Describe for Altitude {
    const LAYOUT: Layout = Layout::Fields(&[quantity("altitude_m", 24, true, 0.1, 1)]);
}

/// I129/110, accuracy of the GNSS position: 50 % circular error probable, LSB 1 m.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(endian = "big")]
pub struct GnssAccuracy(u16);

impl GnssAccuracy {
    /// Unknown, or more than 255 m.
    pub const UNKNOWN: Self = Self(0);

    /// The item as it stands.
    pub const fn from_count(count: u16) -> Self {
        Self(count)
    }

    /// The accuracy to the nearest metre, at least 1 m because 0 means unknown; [`GnssAccuracy::UNKNOWN`] above 255 m,
    /// as the item says. `None` for a negative number and for what is no number.
    pub fn from_metres(accuracy_m: f64) -> Option<Self> {
        if accuracy_m.is_nan() || accuracy_m < 0.0 {
            return None;
        }
        Some(nearest(accuracy_m, 0, 255).map_or(Self::UNKNOWN, |count| Self(count.max(1) as u16)))
    }

    /// The item as it stands, 0 for unknown.
    pub const fn count(self) -> u16 {
        self.0
    }

    /// The accuracy in metres; `None` when unknown.
    pub fn metres(self) -> Option<f64> {
        (self.0 != 0).then_some(f64::from(self.0))
    }
}

impl Describe for GnssAccuracy {
    const LAYOUT: Layout = Layout::Fields(&[field("accuracy_m", 16, Kind::CountOr(0))]);
}

/// Certification category of the UAS in I129/120.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CertificationCategory {
    /// 0: unknown.
    Unknown,
    /// 1: open.
    Open,
    /// 2: specific.
    Specific,
    /// 3: certified.
    Certified,
}

/// I129/120, operational risk.
///
/// Edition 1.2 contradicts itself: its table of items says 1 octet, its section 5.2.12 says 3 and describes the first.
/// A block holds exactly one record, so the length is the one that ends the record at the end of the block, 1 when both
/// or neither do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, DekuRead, DekuWrite)]
#[deku(ctx = "long: bool")]
pub struct OperationalRisk {
    /// The described octet.
    pub octet: u8,
    /// The other two octets, where the item has three.
    #[deku(cond = "long")]
    pub undescribed: Option<[u8; 2]>,
}

impl OperationalRisk {
    /// Its field reference number.
    pub(super) const FRN: u8 = 12;

    /// The item in one octet. `None` when the air risk category is not in 1 to 4 or the airspace encounter category above
    /// 15.
    pub const fn new(certification: CertificationCategory, air_risk: u8, encounter: u8) -> Option<Self> {
        if air_risk < 1 || air_risk > 4 || encounter > 15 {
            return None;
        }
        Some(Self { octet: (certification as u8) << 6 | (air_risk - 1) << 4 | encounter, undescribed: None })
    }

    /// Certification category of the UAS.
    pub const fn certification_category(self) -> CertificationCategory {
        match self.octet >> 6 {
            0 => CertificationCategory::Unknown,
            1 => CertificationCategory::Open,
            2 => CertificationCategory::Specific,
            _ => CertificationCategory::Certified,
        }
    }

    /// Air risk category (ARC), 1 to 4.
    pub const fn air_risk_category(self) -> u8 {
        (self.octet >> 4 & 3) + 1
    }

    /// Airspace encounter category (AEC), 0 to 15; the edition does not define the values.
    pub const fn airspace_encounter_category(self) -> u8 {
        self.octet & 0x0f
    }
}

impl Describe for OperationalRisk {
    const LAYOUT: Layout = Layout::OneOrThree(&[
        count("certification_category", 2),
        field("air_risk_category", 2, Kind::CountFrom(1)),
        count("airspace_encounter_category", 4),
    ]);
}

/// LSB of the velocities, as counts in 1 m/s.
const PER_METRE_PER_SECOND: f64 = 100.0;

/// The count nearest to a velocity that has 20 bits.
fn velocity_count(velocity_m_s: f64) -> Option<i32> {
    nearest(velocity_m_s * PER_METRE_PER_SECOND, -0x8_0000, 0x7_ffff)
}

/// I129/185, horizontal velocity: two 20-bit two's complement numbers, LSB 0.01 m/s, -5242.88 to 5242.87 m/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct HorizontalVelocity([u8; 5]);

octets!(HorizontalVelocity, 5);

impl HorizontalVelocity {
    /// The nearest velocity, or `None` beyond the range.
    pub fn new(east_m_s: f64, north_m_s: f64) -> Option<Self> {
        let east = velocity_count(east_m_s)? as u64 & 0xf_ffff;
        let north = velocity_count(north_m_s)? as u64 & 0xf_ffff;
        let [_, _, _, octets @ ..] = (east << 20 | north).to_be_bytes();
        Some(Self(octets))
    }

    /// East in counts of 0.01 m/s.
    pub const fn east(self) -> i32 {
        let [a, b, c, ..] = self.0;
        sign_extend(word24([a, b, c]) >> 4, 20)
    }

    /// North in counts of 0.01 m/s.
    pub const fn north(self) -> i32 {
        let [_, _, c, d, e] = self.0;
        sign_extend(word24([c, d, e]), 20)
    }

    /// East in metres a second.
    pub fn east_m_s(self) -> f64 {
        f64::from(self.east()) / PER_METRE_PER_SECOND
    }

    /// North in metres a second.
    pub fn north_m_s(self) -> f64 {
        f64::from(self.north()) / PER_METRE_PER_SECOND
    }
}

impl Describe for HorizontalVelocity {
    const LAYOUT: Layout = Layout::Fields(&[
        quantity("east_m_s", 20, true, 1.0 / PER_METRE_PER_SECOND, 2),
        quantity("north_m_s", 20, true, 1.0 / PER_METRE_PER_SECOND, 2),
    ]);
}

/// I129/220, vertical velocity, up positive: four spare bits and 20 bits of two's complement, LSB 0.01 m/s, -5242.88 to
/// 5242.87 m/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VerticalVelocity([u8; 3]);

octets!(VerticalVelocity, 3);

impl VerticalVelocity {
    /// The nearest velocity, or `None` beyond the range.
    pub fn new(up_m_s: f64) -> Option<Self> {
        Some(Self(octets24(velocity_count(up_m_s)? as u32 & 0xf_ffff)))
    }

    /// Up in counts of 0.01 m/s.
    pub const fn up(self) -> i32 {
        sign_extend(word24(self.0), 20)
    }

    /// Up in metres a second.
    pub fn up_m_s(self) -> f64 {
        f64::from(self.up()) / PER_METRE_PER_SECOND
    }
}

impl Describe for VerticalVelocity {
    const LAYOUT: Layout = Layout::Fields(&[
        field("spare", 4, Kind::Spare),
        quantity("up_m_s", 20, true, 1.0 / PER_METRE_PER_SECOND, 2),
    ]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn position() {
        let position = Position::new(54.5, 15.0).unwrap();
        assert_eq!(position, Position { latitude: 0x1360_b60b, longitude: 0x0555_5555 });
        assert!(
            (position.latitude_deg() - 54.5).abs() < 1e-7 && (position.longitude_deg() - 15.0).abs() < 1e-7
        );
        let corner = Position::new(-90.0, 180.0).unwrap();
        assert_eq!(corner, Position { latitude: -(1 << 29), longitude: 1 << 30 });
        assert!(corner.in_range());
        assert!(!Position { latitude: (1 << 29) + 1, longitude: 0 }.in_range());
        assert!(!Position { latitude: 0, longitude: i32::MIN }.in_range());
        for (latitude_deg, longitude_deg) in [(90.1, 0.0), (0.0, -180.1), (f64::NAN, 0.0)] {
            assert_eq!(Position::new(latitude_deg, longitude_deg), None);
        }
    }

    #[test]
    fn altitude() {
        assert_eq!(Altitude::from_metres(120.0), Some(Altitude([0x00, 0x04, 0xb0])));
        assert_eq!(Altitude::from_metres(-0.25), Some(Altitude([0xff, 0xff, 0xfd])));
        assert_eq!(Altitude([0x80, 0, 0]).metres(), -838_860.8);
        assert_eq!(Altitude::from_metres(838_860.8), None);
        assert_eq!(Altitude::from_count(0x80_0000), None);
        assert_eq!(Altitude::from_count(-0x80_0000).map(Altitude::count), Some(-0x80_0000));
    }

    #[test]
    fn gnss_accuracy() {
        assert_eq!(GnssAccuracy::from_metres(3.4), Some(GnssAccuracy(3)));
        assert_eq!(GnssAccuracy::from_metres(0.2), Some(GnssAccuracy(1)));
        assert_eq!(GnssAccuracy::from_metres(256.0), Some(GnssAccuracy::UNKNOWN));
        assert_eq!(GnssAccuracy::from_metres(f64::INFINITY), Some(GnssAccuracy::UNKNOWN));
        assert_eq!(GnssAccuracy::from_metres(-1.0), None);
        assert_eq!(GnssAccuracy(300).metres(), Some(300.0));
        assert_eq!(GnssAccuracy::UNKNOWN.metres(), None);
    }

    #[test]
    fn operational_risk() {
        let risk = OperationalRisk::new(CertificationCategory::Specific, 3, 9).unwrap();
        assert_eq!(risk.octet, 0b1010_1001);
        assert_eq!(risk.certification_category(), CertificationCategory::Specific);
        assert_eq!((risk.air_risk_category(), risk.airspace_encounter_category()), (3, 9));
        assert_eq!(OperationalRisk::new(CertificationCategory::Open, 0, 0), None);
        assert_eq!(OperationalRisk::new(CertificationCategory::Open, 5, 0), None);
        assert_eq!(OperationalRisk::new(CertificationCategory::Open, 1, 16), None);
    }

    #[test]
    fn velocities_of_20_bits() {
        let horizontal = HorizontalVelocity::new(3.0, -1.5).unwrap();
        assert_eq!(horizontal, HorizontalVelocity([0x00, 0x12, 0xcf, 0xff, 0x6a]));
        assert_eq!((horizontal.east_m_s(), horizontal.north_m_s()), (3.0, -1.5));
        let extreme = HorizontalVelocity::new(-5242.88, 5242.87).unwrap();
        assert_eq!((extreme.east(), extreme.north()), (-0x8_0000, 0x7_ffff));
        assert_eq!(HorizontalVelocity::new(0.0, 5242.88), None);
        assert_eq!(VerticalVelocity::new(-2.25), Some(VerticalVelocity([0x0f, 0xff, 0x1f])));
        assert_eq!(VerticalVelocity([0xff, 0xff, 0x1f]).up_m_s(), -2.25); // spare bits set
        assert_eq!(VerticalVelocity([0xf0, 0, 1]).up(), 1);
        assert_eq!(VerticalVelocity::new(f64::NAN), None);
    }
}
