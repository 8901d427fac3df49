//! Remote ID declarations of a drone, with the names of ASTM F3411.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::text;
use fusion::declaration::{Declaration, DeclaredHeight, OperatorPlace};

/// Types of aircraft, by number.
pub const UA_TYPES: [&str; 16] = [
    "NotDeclared",
    "Aeroplane",
    "Helicopter",
    "Gyroplane",
    "HybridLift",
    "Ornithopter",
    "Glider",
    "Kite",
    "FreeBalloon",
    "CaptiveBalloon",
    "Airship",
    "FreeFallOrParachute",
    "Rocket",
    "TetheredPoweredAircraft",
    "GroundObstacle",
    "Other",
];
/// Operational status, by number; other numbers are undefined.
pub const STATUSES: [&str; 5] = ["Undeclared", "Ground", "Airborne", "Emergency", "RemoteIDSystemFailure"];
/// References of a height.
pub const REFERENCES: [&str; 2] = ["TakeoffLocation", "GroundLevel"];
/// Sources of the operator's position.
pub const PLACE_TYPES: [&str; 3] = ["Takeoff", "Dynamic", "Fixed"];

/// Type of the aircraft.
pub fn ua_type(declared: &Declaration) -> Option<&'static str> {
    UA_TYPES.get(usize::from(declared.ua_type?)).copied()
}

/// Operational status; "Undeclared" for an undefined number.
pub fn status(declared: &Declaration) -> Option<&'static str> {
    Some(STATUSES.get(usize::from(declared.status?)).copied().unwrap_or(STATUSES[0]))
}

/// Registration of the operator.
pub fn operator_id(declared: &Declaration) -> Option<Cow<'_, str>> {
    text(&declared.operator_id)
}

/// Remote ID declarations of a drone, besides identity and position.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "RemoteIdDeclaration")]
pub struct RemoteIdJson<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = UA_TYPES))]
    ua_type: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = STATUSES))]
    operational_status: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<HeightJson>,
    /// Registration of the operator.
    #[serde(skip_serializing_if = "Option::is_none")]
    operator_id: Option<Cow<'a, str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    operator_location: Option<OperatorJson>,
}

/// Height relative to a reference.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[schemars(rename = "RIDHeight")]
pub struct HeightJson {
    /// Height, in metres.
    distance: f64,
    #[schemars(extend("enum" = REFERENCES))]
    reference: &'static str,
}

/// Position of an operator.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[schemars(rename = "OperatorPlace")]
struct OperatorJson {
    /// WGS-84 latitude, in degrees.
    lat: f64,
    /// WGS-84 longitude, in degrees.
    lng: f64,
    /// Height above the ellipsoid, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt: Option<f64>,
    /// Source of the position: take-off point, live position, or fixed.
    #[schemars(extend("enum" = PLACE_TYPES))]
    r#type: &'static str,
}

impl<'a> RemoteIdJson<'a> {
    /// JSON of a declaration; `None` if it is empty.
    pub fn new(declared: &'a Declaration) -> Option<Self> {
        (*declared != Declaration::default()).then(|| Self {
            ua_type: ua_type(declared),
            operational_status: status(declared),
            height: declared.height.map(HeightJson::from),
            operator_id: operator_id(declared),
            operator_location: declared.operator.map(OperatorJson::from),
        })
    }
}

impl From<DeclaredHeight> for HeightJson {
    fn from(height: DeclaredHeight) -> Self {
        let reference = REFERENCES[usize::from(height.is_above_ground)];
        Self { distance: 0.5 * f64::from(height.half_metres), reference }
    }
}

impl From<OperatorPlace> for OperatorJson {
    fn from(operator: OperatorPlace) -> Self {
        let [lat, lng] = degrees(&operator);
        Self { lat, lng, alt: metres(&operator), r#type: place_type(&operator) }
    }
}

/// Latitude and longitude of an operator, in degrees.
pub fn degrees(operator: &OperatorPlace) -> [f64; 2] {
    // The quotient, unlike the product, is the double nearest to the decimal digits.
    operator.place.map(|count| f64::from(count) / 1e7)
}

/// Height of an operator above the ellipsoid, in metres.
pub fn metres(operator: &OperatorPlace) -> Option<f64> {
    operator.half_metres.map(|count| 0.5 * f64::from(count))
}

/// Source of an operator's position.
pub fn place_type(operator: &OperatorPlace) -> &'static str {
    PLACE_TYPES.get(usize::from(operator.kind)).copied().unwrap_or(PLACE_TYPES[0])
}
