//! Signatures of posted notices, by the convention of Standard Webhooks: HMAC-SHA256 of `id.timestamp.body`.

use std::fmt;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use hmac::{Hmac, Mac};
use sha2::Sha256;

/// What a secret of that convention begins with; the rest is base64.
const PREFIX: &str = "whsec_";
/// The fewest octets of a secret.
const FEWEST: usize = 16;

/// What notices are signed with.
#[derive(Clone)]
pub(super) struct Secret(Hmac<Sha256>);

/// It is not shown.
impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

impl Secret {
    /// Of its text: `whsec_` and base64, or else the octets of the text itself.
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

    /// Whether the libraries of Standard Webhooks take this text for the same key: they always decode base64.
    pub(super) fn is_standard(text: &str) -> bool {
        text.starts_with(PREFIX)
    }

    /// The header's value for a body that is sent at that time, in seconds.
    pub(super) fn sign(&self, id: &str, timestamp_s: i64, body: &[u8]) -> String {
        let head = format!("{id}.{timestamp_s}.");
        let code = self.0.clone().chain_update(head).chain_update(body).finalize().into_bytes();
        format!("v1,{}", BASE64.encode(code))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By Python: `base64.b64encode(hmac.digest(secret, b"%s.%d." % (id, timestamp) + body, "sha256"))`.
    #[test]
    fn a_signature_is_what_another_program_computes() {
        let body = br#"{"change":"began","alert":{"id":"area-7"}}"#;
        let plain = Secret::new("0123456789abcdef0123456789abcdef").unwrap();
        assert_eq!(
            plain.sign("5f-1", 1_763_000_000, body),
            "v1,4mJE8+MzySzUno761lolFpdk3tIhdsW15DJoz1IF/XQ="
        );
        let encoded = Secret::new("whsec_MDEyMzQ1Njc4OWFiY2RlZjAxMjM0NTY3ODlhYmNkZWY=").unwrap();
        assert_eq!(encoded.sign("5f-1", 1_763_000_000, body), plain.sign("5f-1", 1_763_000_000, body));
        assert_ne!(plain.sign("5f-2", 1_763_000_000, body), plain.sign("5f-1", 1_763_000_000, body));
        assert_ne!(plain.sign("5f-1", 1_763_000_001, body), plain.sign("5f-1", 1_763_000_000, body));
    }

    /// The example that the libraries of Standard Webhooks test themselves with.
    #[test]
    fn signature_is_that_of_the_standard_webhooks_example() {
        let secret = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw";
        assert!(Secret::is_standard(secret) && !Secret::is_standard("0123456789abcdef0123456789abcdef"));
        let signature = Secret::new(secret).unwrap().sign(
            "msg_p5jXN8AQM9LWM0D4loKWxJek",
            1_614_265_330,
            br#"{"test": 2432232314}"#,
        );
        assert_eq!(signature, "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
    }

    #[test]
    fn a_secret_that_is_none_is_refused() {
        assert!(Secret::new("whsec_???").is_err());
        assert!(Secret::new("short").is_err());
        assert!(Secret::new("whsec_MDEyMw==").is_err());
    }
}
