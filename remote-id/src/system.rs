//! System: position of the operator, message type 4 (F3411-22a table 9). This is personal data.

use super::count::nearest;
use super::location::{altitude_m, altitude_octets};
use super::octets::LENGTH;

/// Position of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct System(pub(crate) [u8; LENGTH]);

/// The values of a system message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemContent {
    /// Source of the operator's position, 0 to 3: 0 take-off, 1 measured, 2 fixed.
    pub location_type: u8,
    /// Region of the classification, 0 to 7: 0 undeclared, 1 European Union.
    pub classification: u8,
    /// Latitude and longitude of the operator, degrees, WGS-84; steps of 1e-7. `None`: unknown.
    pub operator_deg: Option<[f64; 2]>,
    /// Number of aircraft that the message represents.
    pub area_count: u16,
    /// Radius of their area around this aircraft's position, metres; steps of 10, up to 2,550.
    pub area_radius_m: f64,
    /// Ceiling of their area above the WGS-84 ellipsoid, metres; steps of 0.5. `None`: unknown.
    pub area_ceiling_m: Option<f64>,
    /// Floor of their area above the WGS-84 ellipsoid, metres; steps of 0.5. `None`: unknown.
    pub area_floor_m: Option<f64>,
    /// Category and class in the European Union, 0 to 15 each; 0: undeclared.
    pub category_and_class: [u8; 2],
    /// Height of the operator above the WGS-84 ellipsoid, metres; steps of 0.5. `None`: unknown.
    pub operator_altitude_m: Option<f64>,
    /// Time, whole seconds since the beginning of 2019, UTC.
    pub time_s: u32,
}

impl System {
    /// A message with these values, each rounded to the nearest one that the message can hold.
    pub fn new(content: &SystemContent) -> Self {
        let mut octets = [0; LENGTH];
        octets[0] = 0x42;
        octets[1] = (content.classification & 0b111) << 2 | content.location_type & 0b11;
        for (at, degrees) in [2, 6].into_iter().zip(content.operator_deg.unwrap_or_default()) {
            let count = nearest(degrees, 1e-7, f64::from(i32::MIN), f64::from(i32::MAX)) as i32;
            octets[at..at + 4].copy_from_slice(&count.to_le_bytes());
        }
        octets[10..12].copy_from_slice(&content.area_count.to_le_bytes());
        octets[12] = nearest(content.area_radius_m, 10.0, 0.0, 255.0) as u8;
        octets[13..15].copy_from_slice(&altitude_octets(content.area_ceiling_m));
        octets[15..17].copy_from_slice(&altitude_octets(content.area_floor_m));
        let [category, class] = content.category_and_class;
        octets[17] = (category & 0xf) << 4 | class & 0xf;
        octets[18..20].copy_from_slice(&altitude_octets(content.operator_altitude_m));
        octets[20..24].copy_from_slice(&content.time_s.to_le_bytes());
        Self(octets)
    }

    /// The values of the message.
    pub fn content(&self) -> SystemContent {
        SystemContent {
            location_type: self.0[1] & 0b11,
            classification: self.0[1] >> 2 & 0b111,
            operator_deg: Some(self.operator_deg()).filter(|place| *place != [0.0; 2]),
            area_count: self.area_count(),
            area_radius_m: self.area_radius_m(),
            area_ceiling_m: altitude_m([self.0[13], self.0[14]]),
            area_floor_m: altitude_m([self.0[15], self.0[16]]),
            category_and_class: [self.0[17] >> 4, self.0[17] & 0xf],
            operator_altitude_m: altitude_m([self.0[18], self.0[19]]),
            time_s: u32::from_le_bytes([self.0[20], self.0[21], self.0[22], self.0[23]]),
        }
    }

    /// Latitude and longitude of the operator, degrees, WGS-84; both are 0 if unknown.
    pub fn operator_deg(&self) -> [f64; 2] {
        [2, 6].map(|at| f64::from(i32::from_le_bytes(*self.0[at..].first_chunk().expect("25 octets"))) * 1e-7)
    }

    /// Number of aircraft that the message represents.
    pub fn area_count(&self) -> u16 {
        u16::from_le_bytes([self.0[10], self.0[11]])
    }

    /// Radius of their area around this aircraft's position, metres.
    pub fn area_radius_m(&self) -> f64 {
        10.0 * f64::from(self.0[12])
    }
}
