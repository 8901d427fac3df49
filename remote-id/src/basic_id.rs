//! Basic ID: the identity of the aircraft, message type 0 (F3411-22a table 5).

use super::octets::{LENGTH, trimmed};

/// Identity of the aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BasicId(pub(crate) [u8; LENGTH]);

/// Kind of identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum IdType {
    /// None; some senders state a serial number nevertheless.
    None,
    /// Serial number (ANSI/CTA-2063-A).
    SerialNumber,
    /// Registration issued by an authority.
    Registration,
    /// Identity of one flight, assigned by a UTM system: a UUID.
    UtmAssigned,
    /// Identity of one session; its first octet states its kind.
    SpecificSession,
    /// A reserved number.
    Reserved(u8),
}

/// Kind of aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UaType {
    /// None declared.
    None,
    /// Fixed wing.
    Aeroplane,
    /// A helicopter or multirotor.
    Rotorcraft,
    /// Takes off vertically and flies on wings.
    HybridLift,
    /// Any other kind, from gliders to ground obstacles, by number.
    Other(u8),
}

impl BasicId {
    /// A message with this identity; identities are cut to 20 octets.
    pub fn new(id_type: IdType, ua_type: UaType, id: &[u8]) -> Self {
        let mut octets = [0; LENGTH];
        (octets[0], octets[1]) = (2, id_type.number() << 4 | ua_type.number());
        octets[2..22].iter_mut().zip(id).for_each(|(octet, id)| *octet = *id);
        Self(octets)
    }

    /// Kind of identity.
    pub fn id_type(&self) -> IdType {
        match self.0[1] >> 4 {
            0 => IdType::None,
            1 => IdType::SerialNumber,
            2 => IdType::Registration,
            3 => IdType::UtmAssigned,
            4 => IdType::SpecificSession,
            number => IdType::Reserved(number),
        }
    }

    /// Number of the kind of aircraft, 0 (none declared) to 15.
    pub fn ua_type_number(&self) -> u8 {
        self.0[1] & 0xf
    }

    /// Kind of aircraft.
    pub fn ua_type(&self) -> UaType {
        match self.ua_type_number() {
            0 => UaType::None,
            1 => UaType::Aeroplane,
            2 => UaType::Rotorcraft,
            4 => UaType::HybridLift,
            number => UaType::Other(number),
        }
    }

    /// The identity. Text has at most 20 octets, without trailing NULs and blanks; a UUID has 16 octets, a session 20. The octets
    /// may have any value.
    pub fn id(&self) -> &[u8] {
        match self.id_type() {
            IdType::UtmAssigned => &self.0[2..18],
            IdType::SpecificSession => &self.0[2..22],
            _ => trimmed(&self.0[2..22]),
        }
    }

    /// The 20 octets of the identity, unchanged.
    pub fn id_octets(&self) -> &[u8; 20] {
        self.0[2..].first_chunk().expect("25 octets")
    }
}

impl IdType {
    fn number(self) -> u8 {
        match self {
            Self::None => 0,
            Self::SerialNumber => 1,
            Self::Registration => 2,
            Self::UtmAssigned => 3,
            Self::SpecificSession => 4,
            Self::Reserved(number) => number & 0xf,
        }
    }
}

impl UaType {
    fn number(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Aeroplane => 1,
            Self::Rotorcraft => 2,
            Self::HybridLift => 4,
            Self::Other(number) => number & 0xf,
        }
    }
}
