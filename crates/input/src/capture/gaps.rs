//! Octets that could not be read, counted by stretch.

use std::fmt;

/// Octets that could not be read, added in the order of the file. `Display`: `17 octets in 2 places (the first at offset
/// 345)`.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Gaps {
    /// Number of octets.
    pub octets: u64,
    /// Number of contiguous stretches.
    pub places: u64,
    /// Offset in the file of the first octet.
    pub first_offset: Option<u64>,
    /// Offset after the last octet.
    #[serde(skip)]
    end: u64,
}

impl Gaps {
    /// Counts `octets` at this offset of the file.
    pub fn add(&mut self, offset: u64, octets: usize) {
        if octets == 0 {
            return;
        }
        if self.places == 0 || offset != self.end {
            self.places += 1;
        }
        self.octets += octets as u64;
        self.first_offset.get_or_insert(offset);
        self.end = offset + octets as u64;
    }

    /// Whether there are no gaps.
    pub fn is_empty(&self) -> bool {
        self.octets == 0
    }
}

impl fmt::Display for Gaps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = |count: u64| if count == 1 { "" } else { "s" };
        let Self { octets, places, .. } = *self;
        write!(f, "{octets} octet{} in {places} place{}", plural(octets), plural(places))?;
        match self.first_offset {
            Some(offset) if places == 1 => write!(f, " (at offset {offset})"),
            Some(offset) => write!(f, " (the first at offset {offset})"),
            None => Ok(()),
        }
    }
}
