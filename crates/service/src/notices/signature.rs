//! Signatures of posted notices, as in Standard Webhooks: HMAC-SHA256 of `id.timestamp.body`.

use std::fmt;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use hmac::{Hmac, Mac};
use sha2::Sha256;

/// Prefix of a secret in Standard Webhooks; base64 follows.
const PREFIX: &str = "whsec_";
/// Minimum number of octets of a secret.
const FEWEST: usize = 16;

/// Key for signing notices.
#[derive(Clone)]
pub(super) struct SigningSecret(Hmac<Sha256>);

/// Hides the key.
impl fmt::Debug for SigningSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

impl SigningSecret {
    /// Key from its text: `whsec_` and base64, or the octets of the text itself.
    pub(super) fn new(text: &str) -> Result<Self, &'static str> {
        let octets = match text.strip_prefix(PREFIX) {
            Some(encoded) => BASE64.decode(encoded).map_err(|_| "what follows whsec_ is not base64")?,
            None => text.as_bytes().to_vec(),
        };
        if octets.len() < FEWEST {
            return Err(
                "the secret is shorter than 16 octets; echo \"whsec_$(openssl rand -base64 32)\" makes a good one",
            );
        }
        Hmac::new_from_slice(&octets).map(Self).map_err(|_| "the secret cannot be used")
    }

    /// Whether the libraries of Standard Webhooks derive the same key from this text: they always decode base64.
    pub(super) fn is_standard(text: &str) -> bool {
        text.starts_with(PREFIX)
    }

    /// Value of the header for a body that is sent at this time, in seconds.
    pub(super) fn sign(&self, id: &str, timestamp_s: i64, body: &[u8]) -> String {
        let head = format!("{id}.{timestamp_s}.");
        let code = self.0.clone().chain_update(head).chain_update(body).finalize().into_bytes();
        format!("v1,{}", BASE64.encode(code))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computed with Python: `base64.b64encode(hmac.digest(secret, b"%s.%d." % (id, timestamp) + body, "sha256"))`.
    #[test]
    fn signature_matches_another_implementation() {
        let body = br#"{"change":"began","alert":{"id":"area-7"}}"#;
        let plain = SigningSecret::new("0123456789abcdef0123456789abcdef").unwrap();
        assert_eq!(
            plain.sign("5f-1", 1_763_000_000, body),
            "v1,4mJE8+MzySzUno761lolFpdk3tIhdsW15DJoz1IF/XQ="
        );
        let encoded = SigningSecret::new("whsec_MDEyMzQ1Njc4OWFiY2RlZjAxMjM0NTY3ODlhYmNkZWY=").unwrap();
        assert_eq!(encoded.sign("5f-1", 1_763_000_000, body), plain.sign("5f-1", 1_763_000_000, body));
        assert_ne!(plain.sign("5f-2", 1_763_000_000, body), plain.sign("5f-1", 1_763_000_000, body));
        assert_ne!(plain.sign("5f-1", 1_763_000_001, body), plain.sign("5f-1", 1_763_000_000, body));
    }

    /// Example from the tests of the Standard Webhooks libraries.
    #[test]
    fn signature_is_that_of_the_standard_webhooks_example() {
        let secret = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw";
        assert!(
            SigningSecret::is_standard(secret)
                && !SigningSecret::is_standard("0123456789abcdef0123456789abcdef")
        );
        let signature = SigningSecret::new(secret).unwrap().sign(
            "msg_p5jXN8AQM9LWM0D4loKWxJek",
            1_614_265_330,
            br#"{"test": 2432232314}"#,
        );
        assert_eq!(signature, "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
    }

    #[test]
    fn invalid_secret_is_rejected() {
        assert!(SigningSecret::new("whsec_???").is_err());
        assert!(SigningSecret::new("short").is_err());
        assert!(SigningSecret::new("whsec_MDEyMw==").is_err());
    }
}
