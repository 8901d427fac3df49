//! Texts of transponders, with what cannot be printed escaped.

use std::borrow::Cow;

use fusion::Identity;
use fusion::report::Space;

/// Name of an identity. In a text, characters other than printable ASCII are escaped. A flight id is a UUID with hyphens; a
/// session id is hexadecimal.
pub fn serial_text(identity: Identity) -> String {
    name(&identity).into_owned()
}

pub(super) fn name(identity: &Identity) -> Cow<'_, str> {
    match identity.space() {
        Space::Serial | Space::Address | Space::Registration => escaped(identity.name()),
        Space::Flight => Cow::Owned(uuid(identity.name())),
        Space::Session => Cow::Owned(input::hex::text(identity.name())),
    }
}

/// Text of a UUID from 16 octets (RFC 9562).
fn uuid(octets: &[u8]) -> String {
    let mut text = input::hex::text(octets);
    [20, 16, 12, 8].into_iter().for_each(|at| text.insert(at, '-'));
    text
}

/// Text without its padding, with characters other than printable ASCII escaped. `None` if nothing is left.
pub fn text(octets: &[u8]) -> Option<Cow<'_, str>> {
    let text = match escaped(octets) {
        Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
        Cow::Owned(text) => Cow::Owned(text.replace("\\x00", " ").trim().to_owned()),
    };
    (!text.is_empty()).then_some(text)
}

/// Text in which quotes, backslashes and characters other than printable ASCII are escaped.
fn escaped(octets: &[u8]) -> Cow<'_, str> {
    let is_plain = |octet: &u8| matches!(octet, b' '..=b'~') && !matches!(octet, b'\'' | b'"' | b'\\');
    match str::from_utf8(octets) {
        Ok(text) if octets.iter().all(is_plain) => Cow::Borrowed(text),
        _ => Cow::Owned(octets.escape_ascii().to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        #[test]
        fn text_is_escaped_where_required(octets: Vec<u8>, ascii in "[ -~]{0,12}") {
            for octets in [&octets[..], ascii.as_bytes()] {
                proptest::prop_assert_eq!(escaped(octets), octets.escape_ascii().to_string());
            }
        }
    }

    #[test]
    fn flight_identity_is_named_as_a_uuid() {
        let octets = *b"\x00\x11\xaa\x11\xbb\x22\xcc\x43\x4d\x8d\x00\x11\x22\x33\x44\x20";
        let flight = Identity::of_name(Space::Flight, &octets).unwrap();
        assert_eq!(serial_text(flight), "0011aa11-bb22-cc43-4d8d-001122334420");
        let session = Identity::of_name(Space::Session, b"\x01XYZ").unwrap();
        assert_eq!(serial_text(session), format!("0158595a{}", "00".repeat(16)));
    }

    #[test]
    fn padding_is_omitted() {
        assert_eq!(
            [text(b" \0 "), text(b"DJI\0"), text(b" N O"), text(b"a\xff ")]
                .map(|text| text.map(Cow::into_owned)),
            [None, Some("DJI".to_owned()), Some("N O".to_owned()), Some("a\\xff".to_owned())]
        );
    }
}
