//! Who it is: message type 0 (F3411-22a table 5).

use super::message::{LENGTH, trimmed};

/// Who it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BasicId(pub(crate) [u8; LENGTH]);

/// What kind of identity it states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum IdType {
    /// It says none; some put a serial number there all the same.
    None,
    /// A serial number after ANSI/CTA-2063-A.
    SerialNumber,
    /// A registration that an authority gave.
    Registration,
    /// An identity of one flight that a UTM system gave, a UUID.
    UtmAssigned,
    /// An identity of one session, its first octet says of which kind.
    SpecificSession,
    /// A number without a meaning yet.
    Reserved(u8),
}

/// What kind of aircraft it says it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UaType {
    /// It says none.
    None,
    /// With fixed wings.
    Aeroplane,
    /// A helicopter or multirotor.
    Rotorcraft,
    /// Takes off vertically and flies on wings.
    HybridLift,
    /// Anything else, from gliders to obstacles on the ground, by its number.
    Other(u8),
}

impl BasicId {
    /// Of an identity; what is longer than 20 octets is cut.
    pub fn new(id_type: IdType, ua_type: UaType, id: &[u8]) -> Self {
        let mut octets = [0; LENGTH];
        (octets[0], octets[1]) = (2, id_type.number() << 4 | ua_type.number());
        octets[2..22].iter_mut().zip(id).for_each(|(octet, id)| *octet = *id);
        Self(octets)
    }

    /// What kind of identity it states.
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

    /// Number of the kind of aircraft, 0 (none is declared) to 15.
    pub fn ua_type_number(&self) -> u8 {
        self.0[1] & 0xf
    }

    /// What kind of aircraft it is.
    pub fn ua_type(&self) -> UaType {
        match self.ua_type_number() {
            0 => UaType::None,
            1 => UaType::Aeroplane,
            2 => UaType::Rotorcraft,
            4 => UaType::HybridLift,
            number => UaType::Other(number),
        }
    }

    /// The identity, any octets: of a text, at most 20 octets without the NULs and blanks behind it; of a UUID all 16 octets;
    /// of a session all 20 octets.
    pub fn id(&self) -> &[u8] {
        match self.id_type() {
            IdType::UtmAssigned => &self.0[2..18],
            IdType::SpecificSession => &self.0[2..22],
            _ => trimmed(&self.0[2..22]),
        }
    }

    /// The octets of the identity as they are.
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
