//! Octets damaged at random, the same in every run.

/// A small generator (xorshift64*) that gives the same numbers in every run.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32
    }

    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        self.next() as usize % end
    }

    pub fn octet(&mut self) -> u8 {
        self.next() as u8
    }
}

/// Damages `octets` in a random way; `other` are octets to mix in.
pub fn damage(octets: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let at = random.below(octets.len() + 1);
    match (random.below(7), octets.get_mut(at)) {
        (0 | 1, Some(octet)) => *octet ^= 1 << random.below(8),
        (2, Some(octet)) => *octet = random.octet(),
        (3, Some(_)) => drop(octets.remove(at)),
        (4, _) => octets.insert(at, random.octet()),
        (5, _) => octets.truncate(at),
        _ => {
            octets.truncate(at);
            octets.extend_from_slice(&other[random.below(other.len())..]);
        }
    }
}
