//! ULIDs: 48 bits of milliseconds since 1970 and 80 more, in 26 characters. Here the 80 are a hash of what the id stands for:
//! the same object has the same id on every connection and after every restart.

use sha2::{Digest, Sha256};

use fusion::time::{SECOND, Time};

/// Crockford's base 32: no I, L, O, U.
const DIGITS: &[u8; 32] = b"0123456789ABCDEFGHJKMNPQRSTVWXYZ";

/// The id of what `parts` say, of `time`.
pub(crate) fn ulid(time: Time, parts: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        // Lengths keep parts apart.
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
    fn time_first_then_what_it_stands_for() {
        let time = Time::from_nanos(1_469_922_850_259 * (SECOND / 1000));
        let id = ulid(time, &[b"node", b"U-70011"]);
        // The time of the example of the ULID specification.
        assert_eq!((&id[..10], id.len()), ("01ARZ3NDEK", 26));
        assert_eq!(id, ulid(time, &[b"node", b"U-70011"]));
        assert_ne!(id, ulid(time, &[b"nodeU", b"-70011"]));
        assert!(id.bytes().all(|digit| DIGITS.contains(&digit)));
    }
}
