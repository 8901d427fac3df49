//! The items of category 129.

use crate::Describe;
use crate::Layout;
use crate::bits;
use crate::item::{in_place, items};
use crate::octets::read_octets;

items! {
    /// I129/015 (5.2.2), data destination identifier.
    words pub struct DataDestination {
        /// Destination area code.
        dac: u8 { count 8 "dac"; }
        /// Destination identification code.
        dic: u8 { count 8 "dic"; }
    }

    /// I129/090 (5.2.9) and I129/100 (5.2.10), an altitude.
    /// Metres: LSB 0.1 m, -838,860.8 m to 838,860.7 m.
    pub struct Altitude(3) = signed_per 24 "altitude_m" metres / with_metres = 10.0, 1;
}

impl Altitude {
    /// The nearest altitude; `None` if it is out of range.
    pub fn from_metres(altitude_m: f64) -> Option<Self> {
        Self::default().with_metres(altitude_m)
    }
}

items! {
    /// I129/110 (5.2.11), accuracy of the GNSS position: 50 % circular error probable.
    /// The count: LSB 1 m, 0 for unknown.
    pub struct GnssAccuracy(2) = count_or 16 "accuracy_m" count: u16 = 0;
}

impl GnssAccuracy {
    /// Unknown, or more than 255 m.
    pub const UNKNOWN: Self = Self([0; 2]);

    /// The item with this count.
    pub const fn from_count(count: u16) -> Self {
        Self(count.to_be_bytes())
    }

    /// The accuracy rounded to a metre, and at least 1 m because 0 means unknown; [`GnssAccuracy::UNKNOWN`] above 255 m, as the
    /// specification requires. `None` for negative numbers and NaN.
    pub fn from_metres(accuracy_m: f64) -> Option<Self> {
        if accuracy_m.is_nan() || accuracy_m < 0.0 {
            return None;
        }
        let count = bits::nearest(accuracy_m, 0, 255);
        Some(count.map_or(Self::UNKNOWN, |count| Self::from_count(count.max(1) as u16)))
    }

    /// The accuracy in metres; `None` if unknown.
    pub fn metres(self) -> Option<f64> {
        (self != Self::UNKNOWN).then_some(f64::from(self.count()))
    }
}

items! {
    /// Certification category of the UAS in I129/120.
    all pub enum CertificationCategory {
        /// 0: unknown.
        Unknown,
        /// 1: open.
        Open,
        /// 2: specific.
        Specific,
        /// 3: certified.
        Certified,
    }

    /// The octet of I129/120 that the specification describes.
    pub struct RiskCategories(1) {
        /// Certification category of the UAS.
        code 2 "certification_category" certification / with_certification: CertificationCategory;
        /// Air risk category (ARC), 1 to 4.
        count_from 2 "air_risk_category" air_risk: u8 = 1;
        /// Airspace encounter category (AEC), 0 to 15; the values are not defined.
        count 4 "airspace_encounter_category" airspace_encounter / with_airspace_encounter: u8;
    }
}

/// I129/120 (5.2.12), operational risk.
///
/// Edition 1.2 is contradictory: its table of items states 1 octet, its section 5.2.12 states 3 and describes the first one.
/// A block holds exactly one record, so the length is the one with which the record ends at the end of the block. It is 1 if
/// both or neither fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct OperationalRisk {
    /// The described octet.
    pub categories: RiskCategories,
    /// The other two octets, if the item has three.
    pub undescribed: Option<[u8; 2]>,
}

in_place! {
    OperationalRisk (long: bool) reader => {
        let categories = RiskCategories(read_octets(reader)?);
        let undescribed = if long { Some(read_octets(reader)?) } else { None };
        Ok(Self { categories, undescribed })
    },
    self writer => {
        writer.write_bytes(&self.categories.0)?;
        self.undescribed.map_or(Ok(()), |octets| writer.write_bytes(&octets))
    }
}

impl OperationalRisk {
    /// Its field reference number.
    pub(super) const FRN: u8 = 12;

    /// The item with one octet. `None` if the air risk category is not in 1 to 4 or the airspace encounter category is above 15.
    pub const fn new(certification: CertificationCategory, air_risk: u8, encounter: u8) -> Option<Self> {
        if air_risk < 1 || air_risk > 4 || encounter > 15 {
            return None;
        }
        let octet = certification.code() << 6 | (air_risk - 1) << 4 | encounter;
        Some(Self { categories: RiskCategories([octet]), undescribed: None })
    }
}

impl Describe for OperationalRisk {
    const LAYOUT: Layout = Layout::OneOrThree(RiskCategories::FIELDS);
}

items! {
    /// I129/185 (5.2.13), horizontal velocity.
    pub struct HorizontalVelocity(5) {
        /// East in metres per second: LSB 0.01 m/s, -5242.88 to 5242.87 m/s.
        signed_per 20 "east_m_s" east_m_s / with_east_m_s = 100.0, 2;
        /// North in metres per second: LSB 0.01 m/s, -5242.88 to 5242.87 m/s.
        signed_per 20 "north_m_s" north_m_s / with_north_m_s = 100.0, 2;
    }
}

impl HorizontalVelocity {
    /// The nearest velocity; `None` if it is out of range.
    pub fn new(east_m_s: f64, north_m_s: f64) -> Option<Self> {
        Self::default().with_east_m_s(east_m_s)?.with_north_m_s(north_m_s)
    }
}

items! {
    /// I129/220 (5.2.14), vertical velocity.
    pub struct VerticalVelocity(3) {
        spare 4 "spare";
        /// Metres per second, up positive: LSB 0.01 m/s, -5242.88 to 5242.87 m/s.
        signed_per 20 "up_m_s" up_m_s / with_up_m_s = 100.0, 2;
    }
}

impl VerticalVelocity {
    /// The nearest velocity; `None` if it is out of range.
    pub fn new(up_m_s: f64) -> Option<Self> {
        Self::default().with_up_m_s(up_m_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn altitude() {
        assert_eq!(Altitude::from_metres(120.0), Some(Altitude([0x00, 0x04, 0xb0])));
        assert_eq!(Altitude::from_metres(-0.25), Some(Altitude([0xff, 0xff, 0xfd])));
        assert_eq!(Altitude([0x80, 0, 0]).metres(), -838_860.8);
        assert_eq!(Altitude::from_metres(838_860.8), None);
        assert_eq!(Altitude::from_metres(-838_860.8), Some(Altitude([0x80, 0, 0])));
    }

    #[test]
    fn gnss_accuracy() {
        assert_eq!(GnssAccuracy::from_metres(3.4), Some(GnssAccuracy::from_count(3)));
        assert_eq!(GnssAccuracy::from_metres(0.2), Some(GnssAccuracy::from_count(1)));
        assert_eq!(GnssAccuracy::from_metres(256.0), Some(GnssAccuracy::UNKNOWN));
        assert_eq!(GnssAccuracy::from_metres(f64::INFINITY), Some(GnssAccuracy::UNKNOWN));
        assert_eq!(GnssAccuracy::from_metres(-1.0), None);
        assert_eq!(GnssAccuracy::from_count(300).metres(), Some(300.0));
        assert_eq!(GnssAccuracy::UNKNOWN.metres(), None);
    }

    #[test]
    fn operational_risk() {
        let risk = OperationalRisk::new(CertificationCategory::Specific, 3, 9).unwrap();
        let categories = risk.categories;
        assert_eq!((categories.octets(), risk.undescribed), ([0b1010_1001], None));
        assert_eq!(categories.certification(), CertificationCategory::Specific);
        assert_eq!((categories.air_risk(), categories.airspace_encounter()), (3, 9));
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
        assert_eq!((extreme.east_m_s(), extreme.north_m_s()), (-5242.88, 5242.87));
        assert_eq!(HorizontalVelocity::new(0.0, 5242.88), None);
        assert_eq!(VerticalVelocity::new(-2.25), Some(VerticalVelocity([0x0f, 0xff, 0x1f])));
        assert_eq!(VerticalVelocity([0xff, 0xff, 0x1f]).up_m_s(), -2.25); // spare bits set
        assert_eq!(VerticalVelocity([0xf0, 0, 1]).up_m_s(), 0.01);
        assert_eq!(VerticalVelocity::new(f64::NAN), None);
    }
}
