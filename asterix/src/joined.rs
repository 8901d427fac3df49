//! Keys as text for JSON.

/// A key as a JSON object needs it, with comma, quotes and colon: `,"rho_m":`. It is created once, when the crate is compiled or
/// a table is read, and has a fixed size, which is faster to copy than text of variable length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joined {
    text: [u8; Self::SIZE],
    /// 0 for a key that is too long.
    length: u8,
}

impl Joined {
    /// Length of [`Joined::text`], in octets.
    pub const SIZE: usize = 32;

    /// The text of a key that needs no escapes.
    pub const fn of(key: &str) -> Self {
        let (key, mut text) = (key.as_bytes(), [b' '; Self::SIZE]);
        if key.len() + 4 > Self::SIZE {
            return Self { text, length: 0 };
        }
        (text[0], text[1]) = (b',', b'"');
        let mut index = 0;
        while index < key.len() {
            text[2 + index] = key[index];
            index += 1;
        }
        (text[2 + index], text[3 + index]) = (b'"', b':');
        Self { text, length: key.len() as u8 + 4 }
    }

    /// The text padded with spaces, and its length; `None` for a key of more than 28 octets.
    #[inline]
    pub const fn text(&self) -> Option<(&[u8; Self::SIZE], usize)> {
        if self.length == 0 { None } else { Some((&self.text, self.length as usize)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_joined_as_far_as_they_fit() {
        for key in ["", "v", "rho_m", "airspace_encounter_category", &"k".repeat(28)] {
            let joined = Joined::of(key);
            let (text, length) = joined.text().unwrap();
            assert_eq!(text[..length], *format!(",\"{key}\":").as_bytes());
        }
        assert_eq!(Joined::of(&"k".repeat(29)).text(), None);
    }
}
