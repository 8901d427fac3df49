//! ULIDs: 48 bits of milliseconds since 1970 and 80 further bits, in 26 characters. Here the 80 bits are a hash of the object, so
//! that it has the same id on every connection and after every restart.

use sha2::{Digest, Sha256};

use fusion::time::{SECOND, Time};

/// Digits of Crockford's base 32, without I, L, O, U.
const DIGITS: &[u8; 32] = b"0123456789ABCDEFGHJKMNPQRSTVWXYZ";

/// ULID of the object identified by `parts`, with time `time`.
pub(crate) fn ulid(time: Time, parts: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        // The lengths separate the parts.
        hash.update((part.len() as u64).to_be_bytes());
        hash.update(part);
    }
    let hash = hash.finalize();
    let milliseconds = (time.nanos() / (SECOND / 1000)).clamp(0, (1 << 48) - 1) as u128;
    let low = hash.iter().take(10).fold(0_u128, |low, &octet| low << 8 | u128::from(octet));
    let id = milliseconds << 80 | low;
    (0..26).rev().map(|digit| char::from(DIGITS[(id >> (5 * digit) & 31) as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulid_is_time_then_content_hash() {
        let time = Time::from_nanos(1_469_922_850_259 * (SECOND / 1000));
        let id = ulid(time, &[b"node", b"U-70011"]);
        // Time of the example in the ULID specification.
        assert_eq!((&id[..10], id.len()), ("01ARZ3NDEK", 26));
        assert_eq!(id, ulid(time, &[b"node", b"U-70011"]));
        assert_ne!(id, ulid(time, &[b"nodeU", b"-70011"]));
        assert!(id.bytes().all(|digit| DIGITS.contains(&digit)));
    }
}
