//! What a drone declares by Remote ID beside identity and position (ASTM F3411), to be published unchanged.

use serde::{Deserialize, Serialize};

/// Declarations of a drone, as counts of the messages that carry them. All absent: it has no Remote ID.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Declaration {
    /// Type of aircraft, 0 (not declared) to 15.
    pub ua_type: Option<u8>,
    /// Operational status, 0 (undeclared) to 15.
    pub status: Option<u8>,
    /// Height above take-off or ground.
    pub height: Option<DeclaredHeight>,
    /// The operator's registration, filled up with NULs; all NUL: not received.
    pub operator_id: [u8; 20],
    /// Where the operator is.
    pub operator: Option<OperatorPlace>,
}

/// A height that a drone states relative to a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeclaredHeight {
    /// Half metres.
    pub half_metres: i32,
    /// Above the ground below it; else above the place of its take-off.
    pub is_above_ground: bool,
}

/// Place of an operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OperatorPlace {
    /// Latitude and longitude, 1e-7 degrees.
    pub place: [i32; 2],
    /// Height above the ellipsoid, half metres.
    pub half_metres: Option<i32>,
    /// How it is known: 0 the place of take-off, 1 measured, 2 fixed.
    pub kind: u8,
}

/// Operational status that declares an emergency.
const EMERGENCY: u8 = 3;

impl Declaration {
    /// Whether the drone declares an emergency.
    pub fn is_emergency(&self) -> bool {
        self.status == Some(EMERGENCY)
    }

    /// The same, with items that are absent taken from an earlier declaration.
    #[must_use]
    pub fn or(self, earlier: Self) -> Self {
        Self {
            ua_type: self.ua_type.or(earlier.ua_type),
            status: self.status.or(earlier.status),
            height: self.height.or(earlier.height.filter(|_| self.status.is_none())),
            operator_id: if self.operator_id == [0; 20] { earlier.operator_id } else { self.operator_id },
            operator: self.operator.or(earlier.operator),
        }
    }
}
