//! Keys as texts of JSON have them.

/// A key as a member of an object in JSON begins, with comma, quotes and colon: `,"rho_m":`. It is put together once, when the
/// crate is compiled or a table is read, and has a fixed size, which is copied faster than a text of any length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joined {
    text: [u8; Self::SIZE],
    /// 0 of a key that is too long.
    length: u8,
}

impl Joined {
    /// Octets of [`Joined::text`].
    pub const SIZE: usize = 32;

    /// That of a key, which needs no escapes.
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

    /// Its text, filled up with spaces, and how much of it counts; `None` of a key of more than 28 octets.
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
