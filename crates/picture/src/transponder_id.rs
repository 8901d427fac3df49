//! Identity of a transponder, as JSON.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::texts::{serial_text, text};
use fusion::Identity;

/// Unique identity of a transponder.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct TransponderId {
    /// Serial number.
    serial_number: String,
    /// Country of registration, ISO 3166-1 alpha-2.
    #[serde(skip_serializing_if = "Option::is_none")]
    registration_country: Option<String>,
}

impl TransponderId {
    /// Published form of an identity.
    pub fn new(identity: Identity) -> Self {
        let country = text(identity.country()).map(Cow::into_owned);
        Self { serial_number: serial_text(identity), registration_country: country }
    }
}
