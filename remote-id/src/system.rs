//! Where the operator is: message type 4 (F3411-22a table 9). Nobody's business without a right to it.

use super::message::LENGTH;

/// Where the operator is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct System(pub(crate) [u8; LENGTH]);

impl System {
    /// Latitude and longitude of the operator, degrees, WGS-84; both are 0 where they are not known.
    pub fn operator_deg(&self) -> [f64; 2] {
        [2, 6].map(|at| f64::from(i32::from_le_bytes(*self.0[at..].first_chunk().expect("25 octets"))) * 1e-7)
    }

    /// How many aircraft it speaks for.
    pub fn area_count(&self) -> u16 {
        u16::from_le_bytes([self.0[10], self.0[11]])
    }

    /// Radius, metres, around its place within which they fly.
    pub fn area_radius_m(&self) -> f64 {
        10.0 * f64::from(self.0[12])
    }
}
