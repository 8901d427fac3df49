//! Remote ID declarations of a drone besides identity and position (ASTM F3411), published unchanged.

use serde::{Deserialize, Serialize};

/// Declarations of a drone, in the units of the messages that carry them. All absent: the drone has no Remote ID.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Declaration {
    /// Type of aircraft, 0 (not declared) to 15.
    pub ua_type: Option<u8>,
    /// Operational status, 0 (undeclared) to 15.
    pub status: Option<u8>,
    /// Height above take-off or ground.
    pub height: Option<DeclaredHeight>,
    /// The operator's registration, padded with NULs; all NUL: not received.
    pub operator_id: [u8; 20],
    /// The operator's position.
    pub operator: Option<OperatorPlace>,
}

/// A height that a drone states relative to the ground or its take-off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeclaredHeight {
    /// Height, in half metres.
    pub half_metres: i32,
    /// Whether the height is above the ground below the drone; otherwise it is above the take-off location.
    pub is_above_ground: bool,
}

/// An operator's position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OperatorPlace {
    /// Latitude and longitude, in 1e-7 degrees.
    pub place: [i32; 2],
    /// Height above the ellipsoid, in half metres.
    pub half_metres: Option<i32>,
    /// Source of the position: 0 take-off location, 1 measured, 2 fixed.
    pub kind: u8,
}

/// Operational status that declares an emergency.
const EMERGENCY: u8 = 3;

impl Declaration {
    /// Whether the drone declares an emergency.
    pub fn is_emergency(&self) -> bool {
        self.status == Some(EMERGENCY)
    }

    /// This declaration, with absent items taken from an earlier one.
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
