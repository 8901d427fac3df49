//! Identities of transponders, which distinguish aircraft.

use std::cmp::Ordering;
use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

/// The identity that a transponder reports: a name in one of the [`Space`]s; a serial number also has a registration
/// country. Text names have no leading or trailing spaces and NULs; binary names ([`Space::octets`]) are complete.
/// Ordered by space, then octets.
///
/// ```
/// use utm_fusion_engine::Identity;
///
/// let identity = Identity::new(b"A12         ", Some(b"NO")).unwrap();
/// assert_eq!((identity.name(), identity.country()), (&b"A12"[..], &b"NO"[..]));
/// assert_eq!(Identity::new(&[b' '; 12], None), None);
/// assert_eq!(Identity::of_address(0x4B_1A_2C).name(), b"4B1A2C");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "UncheckedIdentity")]
pub struct Identity {
    // The space, the name, then the country from `COUNTRY` on, each padded with NULs, which keeps the order of the
    // octets. They fill three 64-bit words, so a comparison is cheap: identities are looked up in every slot.
    octets: [u8; 24],
}

/// Longest name of an identity, octets: a serial number of Remote ID (ASTM F3411).
pub const NAME_MAX: usize = 20;
/// Ranges of the name and the country in an identity's octets; the octets behind them are NUL.
const NAME: Range<usize> = 1..1 + NAME_MAX;
const COUNTRY: Range<usize> = NAME.end..NAME.end + 2;

/// Kind of a name; equal names of different spaces are different aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Space {
    /// Serial number: I129/040, or Remote ID's (ANSI/CTA-2063-A).
    Serial,
    /// ICAO aircraft address, six hexadecimal digits (I021/080).
    Address,
    /// Registration by a civil aviation authority (Remote ID).
    Registration,
    /// Number assigned to a flight by a traffic management service (Remote ID): the 16 octets of a UUID.
    Flight,
    /// Number of a session (Remote ID): 20 octets, the first of which states its kind.
    Session,
}

impl Space {
    /// All spaces.
    pub const ALL: [Self; 5] = [Self::Serial, Self::Address, Self::Registration, Self::Flight, Self::Session];

    /// A short name that stays the same over releases.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Serial => "serial",
            Self::Address => "address",
            Self::Registration => "registration",
            Self::Flight => "flight",
            Self::Session => "session",
        }
    }

    /// Number of octets of a binary name, in which every octet counts; `None` for a text name.
    pub const fn octets(self) -> Option<usize> {
        match self {
            Self::Serial | Self::Address | Self::Registration => None,
            Self::Flight => Some(16),
            Self::Session => Some(NAME_MAX),
        }
    }
}

impl Identity {
    /// The identity of a serial number of at most [`NAME_MAX`] octets and its country; `None` if the number is blank or
    /// longer.
    pub fn new(serial: &[u8], country: Option<&[u8; 2]>) -> Option<Self> {
        let mut identity = Self::of_name(Space::Serial, serial)?;
        let country = trimmed(country.map_or(&[][..], |country| country));
        identity.octets[COUNTRY][..country.len()].copy_from_slice(country);
        Some(identity)
    }

    /// The identity of an ICAO aircraft address, 24 bits.
    pub fn of_address(address: u32) -> Self {
        let mut octets = [0; 24];
        octets[0] = Space::Address as u8;
        for (place, digit) in octets[NAME].iter_mut().zip([20, 16, 12, 8, 4, 0]) {
            *place = b"0123456789ABCDEF"[(address >> digit & 0xF) as usize];
        }
        Self { octets }
    }

    /// The identity of a name in a space; `None` if the name is blank or longer than [`NAME_MAX`] octets. A short
    /// binary name is padded with NULs; excess octets are ignored.
    pub fn of_name(space: Space, name: &[u8]) -> Option<Self> {
        let mut octets = [0; 24];
        octets[0] = space as u8;
        let name = match space.octets() {
            Some(_) if name.len() > NAME_MAX => return None,
            Some(length) => &name[..name.len().min(length)],
            None => trimmed(name),
        };
        octets[NAME].get_mut(..name.len())?.copy_from_slice(name);
        name.iter().any(|&octet| octet != 0).then_some(Self { octets })
    }

    /// Space of the name.
    pub fn space(&self) -> Space {
        Space::ALL[usize::from(self.octets[0])]
    }

    /// The name: a trimmed text, or all octets of a binary name.
    pub fn name(&self) -> &[u8] {
        let name = &self.octets[NAME];
        self.space().octets().map_or_else(|| filled(name), |length| &name[..length])
    }

    /// The trimmed serial number; `None` for other spaces.
    pub fn serial(&self) -> Option<&[u8]> {
        (self.space() == Space::Serial).then(|| self.name())
    }

    /// The trimmed registration country; empty if there is none.
    pub fn country(&self) -> &[u8] {
        filled(&self.octets[COUNTRY])
    }

    fn words(&self) -> [u64; 3] {
        let (words, _) = self.octets.as_chunks::<8>();
        [words[0], words[1], words[2]].map(u64::from_be_bytes)
    }
}

/// An identity as it is deserialised, not yet validated.
#[derive(Deserialize)]
struct UncheckedIdentity {
    octets: [u8; 24],
}

impl TryFrom<UncheckedIdentity> for Identity {
    type Error = &'static str;

    fn try_from(UncheckedIdentity { octets }: UncheckedIdentity) -> Result<Self, Self::Error> {
        let read = Self { octets };
        let same = || {
            let space = *Space::ALL.get(usize::from(octets[0]))?;
            let mut made = Self::of_name(space, read.name())?;
            made.octets[COUNTRY].copy_from_slice(&octets[COUNTRY]);
            let country = trimmed(read.country()) == read.country()
                && (space == Space::Serial || read.country().is_empty());
            (country && made == read).then_some(made)
        };
        same().ok_or("the octets are no identity")
    }
}

impl Ord for Identity {
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        self.words().cmp(&other.words())
    }
}

impl PartialOrd for Identity {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The octets without trailing NULs.
fn filled(octets: &[u8]) -> &[u8] {
    let length = octets.iter().rposition(|&octet| octet != 0).map_or(0, |last| last + 1);
    &octets[..length]
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.space() != Space::Serial {
            write!(f, "{}:", self.space().key())?;
        }
        write!(f, "{}/{}", self.name().escape_ascii(), self.octets[COUNTRY].escape_ascii())
    }
}

/// The octets without leading and trailing spaces and NULs.
fn trimmed(octets: &[u8]) -> &[u8] {
    let blank = |octet: &u8| matches!(octet, 0 | b' ');
    let start = octets.iter().position(|octet| !blank(octet)).unwrap_or(octets.len());
    let end = octets.iter().rposition(|octet| !blank(octet)).map_or(start, |last| last + 1);
    &octets[start..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identities_are_trimmed_and_leading_zeros_count() {
        let identity = |serial: &[u8; 12], country| Identity::new(serial, country);
        let plain = identity(b"A12\0\0\0\0\0\0\0\0\0", None).unwrap();
        assert_eq!(identity(b"  A12 \0  \0  ", Some(b"  ")), Some(plain));
        assert_eq!(plain.serial(), Some(&b"A12"[..]));
        assert_ne!(identity(b"0A12        ", None), Some(plain));
        assert_ne!(identity(b"A12         ", Some(b"NO")), Some(plain));
        assert_eq!(identity(b" \0          ", Some(b"NO")), None);
    }

    #[test]
    fn a_name_is_one_aircraft_in_its_space_only() {
        let of = |space| Identity::of_name(space, b"4B1A2C").unwrap();
        assert_eq!(Identity::of_address(0x4B1A2C), of(Space::Address));
        let all = Space::ALL.map(of);
        assert!(all.is_sorted_by(|one, next| one < next));
        assert!(all.iter().zip(Space::ALL).all(|(identity, space)| identity.space() == space));
        assert_eq!(all.map(|identity| identity.serial().is_some()), [true, false, false, false, false]);
        assert_eq!(Identity::of_name(Space::Session, &[b'A'; 21]), None);
    }

    #[test]
    fn binary_names_that_differ_in_nul_or_blank_octets_differ() {
        for (space, length) in [(Space::Flight, 16), (Space::Session, 20)] {
            let mut seen = std::collections::BTreeSet::new();
            for filler in [0x00, b' '] {
                for place in [0, 1, length - 2, length - 1] {
                    let mut name = vec![filler; length];
                    name[place] = 0x11;
                    let identity = Identity::of_name(space, &name).unwrap();
                    assert_eq!(identity.name(), name);
                    assert!(seen.insert(identity), "{identity:?}");
                    let written = serde_json::to_value(identity).unwrap();
                    assert_eq!(serde_json::from_value::<Identity>(written).unwrap(), identity);
                }
            }
            assert_eq!(Identity::of_name(space, &vec![0; length]), None);
        }
        // A message has 20 octets; those behind a UUID are padding.
        assert_eq!(Identity::of_name(Space::Flight, &[1; 20]), Identity::of_name(Space::Flight, &[1; 16]));
    }

    #[test]
    fn invalid_identity_is_not_parsed() {
        let of =
            |octets: [u8; 24]| serde_json::from_value::<Identity>(serde_json::json!({ "octets": octets }));
        let names = Space::ALL.map(|space| Identity::of_name(space, b"A12").unwrap());
        let abroad = Identity::new(b"A12", Some(b"NO")).unwrap();
        for identity in names.into_iter().chain([abroad, Identity::of_address(0x4B_1A_2C)]) {
            assert_eq!(of(identity.octets).unwrap(), identity);
        }
        // An unknown space; no name; a leading blank; a country of a session; an octet behind the country.
        for (place, octet) in [(0, 5), (1, 0), (1, b' '), (21, b' '), (23, 1)] {
            let mut octets = Identity::new(b"A", None).unwrap().octets;
            octets[place] = octet;
            assert!(of(octets).is_err(), "{octets:?}");
        }
        let mut octets = names[4].octets;
        octets[21] = b'N';
        assert!(of(octets).is_err());
    }

    #[test]
    fn identities_are_ordered_by_octets() {
        let identity = |serial, country| Identity::new(serial, country).unwrap();
        let ordered = [
            identity(b"A12         ", None),
            identity(b"A12         ", Some(b"GB")),
            identity(b"A12         ", Some(b"NO")),
            identity(b"A12B        ", None),
            identity(b"A12BCDEFGHI1", Some(b"NO")),
            identity(b"A12BCDEFGHI2", None),
            identity(b"B           ", None),
            identity(b"\xff           ", None),
        ];
        assert!(ordered.is_sorted_by(|one, next| one < next));
    }
}
