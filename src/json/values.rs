//! Octets, texts, numbers and data sources in JSON.

use asterix::DataSource;
use serde::Serialize;

/// Octets in hexadecimal, lower case, two digits each.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Hex(String);

impl Hex {
    /// These octets.
    pub fn new(octets: &[u8]) -> Self {
        const DIGITS: &[u8; 16] = b"0123456789abcdef";
        let digits = octets.iter().flat_map(|octet| [octet >> 4, octet & 0x0f]);
        Self(digits.map(|digit| char::from(DIGITS[usize::from(digit)])).collect())
    }
}

/// Characters: as they are, trailing spaces included, or in hexadecimal where they cannot be.
#[derive(Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(super) enum Text {
    /// Printable ASCII.
    Plain(String),
    /// Anything else.
    Octets {
        /// The octets.
        hex: Hex,
    },
}

impl Text {
    /// A text of ASCII characters.
    pub fn ascii(octets: &[u8]) -> Self {
        match std::str::from_utf8(octets) {
            Ok(text) if octets.iter().all(|octet| matches!(octet, b' '..=b'~')) => {
                Self::Plain(text.to_owned())
            }
            _ => Self::Octets { hex: Hex::new(octets) },
        }
    }
}

/// `value` to 10^-`decimals`, so that JSON shows no more digits than mean something.
pub(crate) fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale
}

/// Whether spare bits are as they should be, and left out.
pub(super) fn is_zero(spare: &u8) -> bool {
    *spare == 0
}

/// I048/010, I129/010.
#[derive(Serialize)]
pub(super) struct Source {
    sac: u8,
    sic: u8,
}

impl From<DataSource> for Source {
    fn from(source: DataSource) -> Self {
        Self { sac: source.sac, sic: source.sic }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(value: &impl Serialize) -> String {
        serde_json::to_string(value).unwrap()
    }

    #[test]
    fn texts_keep_every_character() {
        assert_eq!(json(&Text::ascii(b"A \"~ ")), r#""A \"~ ""#);
        assert_eq!(json(&Text::ascii(b"A\0")), r#"{"hex":"4100"}"#);
        assert_eq!(json(&Text::ascii("é".as_bytes())), r#"{"hex":"c3a9"}"#);
        assert_eq!(json(&Text::ascii(&[0x7f])), r#"{"hex":"7f"}"#);
    }

    #[test]
    fn numbers_show_their_decimals_only() {
        assert_eq!(json(&rounded(1_627.734_375, 1)), "1627.7");
        assert_eq!(json(&rounded(34.980_468_75, 3)), "34.98");
        assert_eq!(json(&rounded(-0.000_000_167, 8)), "-1.7e-7");
    }
}
