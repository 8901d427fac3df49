//! Random damage to files, for tests.

use std::fs;
use std::path::Path;

/// Random numbers from a seed (splitmix64).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    /// Random number less than `limit`, which is not 0.
    pub fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

/// Writes a damaged file with these octets to `path`; returns a description of the damage.
pub fn damage(path: &Path, octets: &[u8], random: &mut Random) -> String {
    if fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_dir()) {
        fs::remove_dir_all(path).unwrap();
    }
    let mut damaged = octets.to_vec();
    let length = octets.len().max(1);
    let noise =
        |random: &mut Random, count: usize| (0..count).map(|_| random.next() as u8).collect::<Vec<_>>();
    let how = match random.below(9) {
        0 => {
            damaged.truncate(random.below(length));
            format!("truncated to {}", damaged.len())
        }
        1 => {
            let count = 1 + random.below(5000);
            damaged.extend(noise(random, count));
            format!("{count} octets appended")
        }
        2 => {
            let count = 1 + random.below(16);
            for _ in 0..count {
                let place = random.below(length);
                damaged[place] ^= 1 << random.below(8);
            }
            format!("{count} bits flipped")
        }
        // Within the head, where most formats have their identification.
        3 => {
            let place = random.below(length.min(512));
            damaged[place] = random.next() as u8;
            format!("octet {place} replaced")
        }
        4 => {
            let from = random.below(length);
            let until = (from + 1 + random.below(8192)).min(damaged.len());
            damaged[from..until].fill(0);
            format!("octets {from} to {until} are zeros")
        }
        5 => {
            let from = random.below(length);
            let until = (from + 1 + random.below(8192)).min(damaged.len());
            let block = noise(random, until - from);
            damaged[from..until].copy_from_slice(&block);
            format!("octets {from} to {until} are noise")
        }
        6 => {
            let (from, count) = (random.below(length), 1 + random.below(64));
            damaged.drain(from..(from + count).min(octets.len()));
            format!("{count} octets from {from} on removed")
        }
        7 => {
            damaged = if random.below(2) == 0 { Vec::new() } else { noise(random, 4096) };
            format!("{} octets of something else", damaged.len())
        }
        _ => {
            let _ = fs::remove_file(path);
            fs::create_dir_all(path.join("inner")).unwrap();
            return "a directory".to_owned();
        }
    };
    fs::write(path, damaged).unwrap();
    how
}
