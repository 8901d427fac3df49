//! The octets of a message.

/// Length of a message, in octets.
pub const LENGTH: usize = 25;

/// The octets without trailing NULs and blanks.
pub(crate) fn trimmed(octets: &[u8]) -> &[u8] {
    let length = octets.iter().rposition(|octet| !matches!(octet, 0 | b' ')).map_or(0, |last| last + 1);
    &octets[..length]
}
