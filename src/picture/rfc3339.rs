//! Times as JSON.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use fusion::time::Time;

/// A time, RFC 3339, UTC.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema)]
#[schemars(inline, extend("format" = "date-time"))]
pub struct Rfc3339(#[schemars(with = "String")] pub Time);

impl From<Time> for Rfc3339 {
    fn from(time: Time) -> Self {
        Self(time)
    }
}

impl Serialize for Rfc3339 {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0)
    }
}
