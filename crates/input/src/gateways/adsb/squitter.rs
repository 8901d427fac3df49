//! Extended squitters, Mode S broadcasts of aircraft in downlink formats 17 and 18 (ICAO Annex 10 volume IV 3.1.2.8, ICAO
//! document 9871, RTCA DO-260B).

use asterix::cat021::{AddressType, AircraftIdentification, EmitterCategory, PriorityStatus, Standard};

use super::cpr::CprPosition;

/// An extended squitter with correct parity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Squitter {
    /// The 24-bit address, or its substitute.
    pub address: u32,
    /// Type of the address.
    pub address_type: AddressType,
    /// Contents.
    pub contents: SquitterContents,
}

/// Contents of a squitter, by type code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SquitterContents {
    /// 1 to 4: identification.
    Identity {
        /// Absent if it has an invalid character.
        callsign: Option<AircraftIdentification>,
        /// Category of the aircraft.
        category: EmitterCategory,
    },
    /// 5 to 18, 20 to 22: position.
    Position(SquitterPosition),
    /// 19: velocity.
    Velocity(SquitterVelocity),
    /// 28, subtype 1: code and emergency.
    Status {
        /// Mode 3/A code, four octal digits.
        code: u16,
        /// Kind of emergency; an undefined code counts as none.
        priority: PriorityStatus,
    },
    /// 29, subtype 1: accuracy, of version 2.
    Target(Accuracy),
    /// 31: standard and accuracy.
    Operation {
        /// The standard; `None` if unknown.
        standard: Option<Standard>,
        /// Absent in version 0.
        accuracy: Option<Accuracy>,
        /// Supplement A of the integrity category (version 2), or the only supplement (version 1).
        supplement_a: bool,
        /// Supplement C, sent on the ground; absent in the air.
        supplement_c: Option<bool>,
    },
    /// Other contents.
    Other,
}

/// A position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SquitterPosition {
    /// Type code, 5 to 22; with the version it states the integrity of the position.
    pub kind: u8,
    /// Encoded position.
    pub place: CprPosition,
    /// Whether it is on the ground.
    pub on_ground: bool,
    /// Height; `None` on the ground and if unknown.
    pub height: Option<Height>,
    /// Supplement B of the integrity category (version 2), in positions in the air.
    pub supplement_b: bool,
}

/// A transmitted height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Height {
    /// Height in feet.
    pub feet: i32,
    /// Whether it is above the ellipsoid, instead of the level of 1013.25 hPa.
    pub is_geometric: bool,
    /// Whether it is in steps of 100 ft, instead of 25 ft.
    pub is_coarse: bool,
}

/// Velocity of an aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SquitterVelocity {
    /// Ground velocity to the east and north, in knots.
    pub ground_kt: Option<[i32; 2]>,
    /// Climb, in feet per minute.
    pub climb_ft_min: Option<i32>,
    /// Whether the climb is barometric, instead of geometric.
    pub is_climb_barometric: bool,
    /// Geometric minus barometric altitude, in feet.
    pub above_barometric_ft: Option<i32>,
    /// Accuracy category of the velocity: NACv, in version 0 NUCr.
    pub category: u8,
}

/// Accuracy of an aircraft's reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accuracy {
    /// NACp.
    pub position: u8,
    /// NICbaro.
    pub is_altitude_checked: bool,
    /// SIL.
    pub integrity: u8,
    /// SIL supplement: per sample.
    pub is_per_sample: bool,
    /// GVA, in version 2; `None` if not sent.
    pub geometric: Option<u8>,
    /// SDA, in version 2; `None` if not sent.
    pub design: Option<u8>,
}

/// Reason why a long message is not an aircraft's report about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotAdsb {
    /// Wrong parity.
    Damaged,
    /// A report of a ground station from its radar.
    TisB,
    /// Another format: a reply to an interrogator, military, or reserved.
    Other,
}

/// Generator of the parity (Annex 10 volume IV 3.1.2.3.3).
const GENERATOR: u32 = 0x00ff_f409;

/// Remainder of a message divided by the generator: 0 for a correct squitter.
fn remainder(message: &[u8]) -> u32 {
    message.iter().fold(0, |remainder, octet| {
        // Includes the parity in the last three octets.
        (0..8).rev().fold(remainder, |remainder, bit| {
            let next = remainder << 1 | u32::from(octet >> bit & 1);
            if next >> 24 & 1 == 1 { (next ^ GENERATOR) & 0x00ff_ffff } else { next }
        })
    })
}

impl Squitter {
    /// Squitter in a long message.
    ///
    /// # Errors
    /// The message is damaged, or is not an aircraft's report about itself.
    pub fn new(message: &[u8; 14]) -> Result<Self, NotAdsb> {
        let [first, a, b, c, me @ .., _, _, _] = message;
        let field = first & 7;
        if !matches!(first >> 3, 17 | 18) {
            return Err(NotAdsb::Other);
        }
        if remainder(message) != 0 {
            return Err(NotAdsb::Damaged);
        }
        let bits = MessageBits(me.iter().fold(0, |bits, octet| bits << 8 | u64::from(*octet)));
        let address_type = match (first >> 3, field) {
            (17, _) | (18, 0) => AddressType::Icao,
            (18, 1) => AddressType::Anonymous,
            (18, 2 | 3 | 5) => return Err(NotAdsb::TisB),
            // Rebroadcast unchanged by a ground station, except for the bit that states whether it is an ICAO address.
            (18, 6) if bits.imf() => AddressType::Anonymous,
            (18, 6) => AddressType::Icao,
            _ => return Err(NotAdsb::Other),
        };
        let address = u32::from_be_bytes([0, *a, *b, *c]);
        Ok(Self { address, address_type, contents: bits.contents() })
    }
}

/// The 56 bits of a message, numbered from 1 as in the standard.
#[derive(Clone, Copy)]
struct MessageBits(u64);

impl MessageBits {
    fn get(self, from: u32, count: u32) -> u32 {
        (self.0 >> (57 - from - count) & ((1 << count) - 1)) as u32
    }

    fn is_set(self, bit: u32) -> bool {
        self.get(bit, 1) == 1
    }

    fn kind(self) -> u8 {
        self.get(1, 5) as u8
    }

    /// Whether the address of a rebroadcast message is not an ICAO address.
    fn imf(self) -> bool {
        match self.kind() {
            5..=8 => self.is_set(21),
            9..=18 | 20..=22 => self.is_set(8),
            19 => self.is_set(9),
            _ => false,
        }
    }

    fn contents(self) -> SquitterContents {
        match (self.kind(), self.get(6, 3)) {
            (kind @ 1..=4, category) => {
                let octets = (self.0 & 0xffff_ffff_ffff).to_be_bytes();
                let callsign =
                    AircraftIdentification::from_octets(octets[2..].try_into().expect("six octets"));
                let is_sound = !callsign.characters().contains(&b'?')
                    && !callsign.characters().iter().all(|c| *c == b' ');
                SquitterContents::Identity {
                    callsign: is_sound.then_some(callsign),
                    category: emitter_category(kind, category),
                }
            }
            (kind @ (5..=18 | 20..=22), _) => SquitterContents::Position(self.position(kind)),
            (19, subtype @ 1..=4) => SquitterContents::Velocity(self.velocity(subtype)),
            (28, 1) => SquitterContents::Status {
                code: squawk(self.get(12, 13)),
                priority: priority(self.get(9, 3)),
            },
            // The subtype has two bits.
            (29, 2 | 3) => SquitterContents::Target(Accuracy {
                position: self.get(40, 4) as u8,
                is_altitude_checked: self.is_set(44),
                integrity: self.get(45, 2) as u8,
                is_per_sample: self.is_set(8),
                geometric: None,
                design: None,
            }),
            (31, subtype @ 0..=1) => self.operation(subtype == 1),
            _ => SquitterContents::Other,
        }
    }

    fn position(self, kind: u8) -> SquitterPosition {
        let on_ground = kind <= 8;
        let height = if on_ground { None } else { altitude(self.get(9, 12), kind >= 20) };
        SquitterPosition {
            kind,
            place: CprPosition {
                odd: self.is_set(22),
                latitude: self.get(23, 17),
                longitude: self.get(40, 17),
            },
            on_ground,
            height,
            supplement_b: !on_ground && self.is_set(8),
        }
    }

    fn velocity(self, subtype: u32) -> SquitterVelocity {
        // 0 means unknown; supersonic aircraft use steps of four.
        let signed = |sign: u32, from: u32, count: u32, step: i32| {
            let magnitude =
                (self.get(from, count) as i32).checked_sub(1).filter(|magnitude| *magnitude >= 0)?;
            Some(if self.is_set(sign) { -step * magnitude } else { step * magnitude })
        };
        let step = if subtype.is_multiple_of(2) { 4 } else { 1 };
        let over_ground =
            signed(14, 15, 10, step).zip(signed(25, 26, 10, step)).map(|(east, north)| [east, north]);
        SquitterVelocity {
            ground_kt: over_ground.filter(|_| subtype <= 2),
            climb_ft_min: signed(37, 38, 9, 64),
            is_climb_barometric: self.is_set(36),
            above_barometric_ft: signed(49, 50, 7, 25),
            category: self.get(11, 3) as u8,
        }
    }

    fn operation(self, on_ground: bool) -> SquitterContents {
        let version = self.get(41, 3);
        let standard = match version {
            0 => Some(Standard::Do260),
            1 => Some(Standard::Do260A),
            2 => Some(Standard::Do260B),
            3 => Some(Standard::Do260C),
            _ => None,
        };
        let is_second = version >= 2;
        let accuracy = Accuracy {
            position: self.get(45, 4) as u8,
            is_altitude_checked: !on_ground && self.is_set(53),
            integrity: self.get(51, 2) as u8,
            is_per_sample: is_second && self.is_set(55),
            geometric: (is_second && !on_ground).then(|| self.get(49, 2) as u8),
            design: is_second.then(|| self.get(31, 2) as u8),
        };
        SquitterContents::Operation {
            standard,
            accuracy: (version > 0).then_some(accuracy),
            supplement_a: self.is_set(44),
            supplement_c: on_ground.then(|| self.is_set(20)),
        }
    }
}

/// Emitter category from type code and category: sets D to A.
fn emitter_category(kind: u8, category: u32) -> EmitterCategory {
    match (kind, category) {
        (4, 1) => EmitterCategory::Light,
        (4, 2) => EmitterCategory::Small,
        (4, 3) => EmitterCategory::Medium,
        (4, 4) => EmitterCategory::HighVortex,
        (4, 5) => EmitterCategory::Heavy,
        (4, 6) => EmitterCategory::HighPerformance,
        (4, 7) => EmitterCategory::Rotorcraft,
        (3, 1) => EmitterCategory::Glider,
        (3, 2) => EmitterCategory::LighterThanAir,
        (3, 3) => EmitterCategory::Parachutist,
        (3, 4) => EmitterCategory::Ultralight,
        (3, 6) => EmitterCategory::Unmanned,
        (3, 7) => EmitterCategory::Space,
        (2, 1) => EmitterCategory::EmergencyVehicle,
        (2, 2) => EmitterCategory::ServiceVehicle,
        (2, 3) => EmitterCategory::Obstruction,
        (2, 4) => EmitterCategory::ObstacleCluster,
        (2, 5) => EmitterCategory::ObstacleLine,
        _ => EmitterCategory::Unknown,
    }
}

fn priority(code: u32) -> PriorityStatus {
    match code {
        1 => PriorityStatus::General,
        2 => PriorityStatus::Medical,
        3 => PriorityStatus::MinimumFuel,
        4 => PriorityStatus::NoCommunications,
        5 => PriorityStatus::UnlawfulInterference,
        6 => PriorityStatus::Downed,
        _ => PriorityStatus::None,
    }
}

/// The digits A, B, C and D of 13 bits in the order C1 A1 C2 A2 C4 A4 - B1 D1 B2 D2 B4 D4, three bits each.
fn digits(field: u32) -> [u32; 4] {
    let bit = |place: u32| field >> place & 1;
    let digit = |one, two, four| bit(four) << 2 | bit(two) << 1 | bit(one);
    [digit(11, 9, 7), digit(5, 3, 1), digit(12, 10, 8), digit(4, 2, 0)]
}

fn squawk(field: u32) -> u16 {
    digits(field).iter().fold(0, |code, digit| code << 3 | digit) as u16
}

/// Height from the 12 bits of an altitude (Annex 10 volume IV 3.1.2.6.5.4, without the bit for metres).
fn altitude(field: u32, is_geometric: bool) -> Option<Height> {
    let is_coarse = field & 0x10 == 0;
    let feet = if is_coarse {
        hundreds(field)?.checked_mul(100)?
    } else {
        25 * (field >> 1 & 0x7f0 | field & 0xf) as i32 - 1000
    };
    Some(Height { feet, is_geometric, is_coarse })
}

/// Hundreds of feet in the Gillham code (Annex 10 volume IV, appendix to chapter 3).
fn hundreds(field: u32) -> Option<i32> {
    let with_gap = (field & 0xfc0) << 1 | field & 0x3f;
    let [a, b, c, d] = digits(with_gap);
    // D1 is not used; multiples of 500 ft are in the Gray code of D2 D4 A1 A2 A4 B1 B2 B4.
    if d & 1 == 1 || c == 0 {
        return None;
    }
    let reversed = |digit: u32| (digit & 1) << 2 | digit & 2 | digit >> 2;
    let five_hundreds = binary(((d >> 1 & 1) << 1 | d >> 2) << 6 | reversed(a) << 3 | reversed(b)) as i32;
    let step = match binary(reversed(c)) {
        step @ 1..=4 => step as i32,
        7 => 5,
        _ => return None,
    };
    // Every other multiple of 500 ft counts downwards.
    let step = if five_hundreds % 2 == 1 { 6 - step } else { step };
    Some(5 * five_hundreds + step - 13)
}

/// Number from its Gray code of at most eleven bits.
fn binary(gray: u32) -> u32 {
    let folded = gray ^ gray >> 1;
    let folded = folded ^ folded >> 2;
    let folded = folded ^ folded >> 4;
    folded ^ folded >> 8
}

/// Squitter with these 56 bits and correct parity.
#[cfg(test)]
pub(super) fn sealed(first: u8, address: u32, me: u64) -> [u8; 14] {
    let mut message = [0; 14];
    message[0] = first;
    message[1..4].copy_from_slice(&address.to_be_bytes()[1..]);
    message[4..11].copy_from_slice(&me.to_be_bytes()[1..]);
    let parity = remainder(&message);
    message[11..].copy_from_slice(&parity.to_be_bytes()[1..]);
    message
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::hex;

    fn squitter(digits: &str) -> Result<Squitter, NotAdsb> {
        Squitter::new(hex::octets(digits).unwrap().first_chunk().unwrap())
    }

    /// Messages and their meaning from the Mode S book (mode-s.org/1090mhz).
    #[test]
    fn published_messages_decode_to_their_values() {
        let identity = squitter("8D4840D6202CC371C32CE0576098").unwrap();
        assert_eq!((identity.address, identity.address_type), (0x0048_40d6, AddressType::Icao));
        let SquitterContents::Identity { callsign, category } = identity.contents else { panic!() };
        assert_eq!((callsign.unwrap().to_string().as_str(), category), ("KLM1023", EmitterCategory::Unknown));
        let SquitterContents::Position(position) = squitter("8D40621D58C382D690C8AC2863A7").unwrap().contents
        else {
            panic!()
        };
        assert_eq!(position.height, Some(Height { feet: 38_000, is_geometric: false, is_coarse: false }));
        assert_eq!(position.place, CprPosition { odd: false, latitude: 93_000, longitude: 51_372 });
        let SquitterContents::Velocity(velocity) = squitter("8D485020994409940838175B284F").unwrap().contents
        else {
            panic!()
        };
        assert_eq!(velocity.ground_kt, Some([-8, -159]));
        assert_eq!((velocity.climb_ft_min, velocity.is_climb_barometric), (Some(-832), false));
        assert_eq!(velocity.above_barometric_ft, Some(550));
        // Airspeed and heading: no velocity over ground.
        let SquitterContents::Velocity(velocity) = squitter("8DA05F219B06B6AF189400CBC33F").unwrap().contents
        else {
            panic!()
        };
        assert_eq!((velocity.ground_kt, velocity.climb_ft_min), (None, Some(-2304)));
        assert!(velocity.is_climb_barometric);
    }

    #[test]
    fn formats_of_other_emitters_are_rejected() {
        let with = |first| Squitter::new(&sealed(first, 1, 0x0058_c382_d690_c8ac));
        for (first, expected) in [
            (18 << 3, Ok(AddressType::Icao)),
            (18 << 3 | 1, Ok(AddressType::Anonymous)),
            (18 << 3 | 2, Err(NotAdsb::TisB)),
            (18 << 3 | 3, Err(NotAdsb::TisB)),
            (18 << 3 | 5, Err(NotAdsb::TisB)),
            (18 << 3 | 4, Err(NotAdsb::Other)),
            (18 << 3 | 6, Ok(AddressType::Icao)),
            (19 << 3, Err(NotAdsb::Other)),
            (20 << 3, Err(NotAdsb::Other)),
        ] {
            assert_eq!(with(first).map(|squitter| squitter.address_type), expected, "{first}");
        }
        // The bit that marks the address of a rebroadcast message as not an ICAO address.
        let anonymous = Squitter::new(&sealed(18 << 3 | 6, 1, 0x0059_c382_d690_c8ac)).unwrap();
        assert_eq!(anonymous.address_type, AddressType::Anonymous);
    }

    #[test]
    fn altitudes_decode_in_both_codings() {
        let feet = |field| altitude(field, false).map(|height| height.feet);
        // 25 ft steps from -1000 ft.
        assert_eq!(
            [0x010, 0x011, 0x038, 0xfff].map(feet),
            [Some(-1000), Some(-975), Some(-400), Some(50_175)]
        );
        // No altitude, and an invalid code.
        assert_eq!([0, 0x001].map(feet), [None, None]);
        // Each code of the Gillham table occurs once, from -1200 to 126,700 ft in steps of 100.
        let mut all: Vec<i32> = (0..4096).filter(|field| field & 0x10 == 0).filter_map(feet).collect();
        all.sort_unstable();
        assert!(all.iter().copied().eq((-12..=1267).map(|hundreds| 100 * hundreds)), "{all:?}");
        // C4 alone.
        assert_eq!(feet(1 << 7), Some(-1200));
        // Neighbouring codes differ in one bit.
        let code = |wanted: i32| {
            (0..4096_u32).find(|field| field & 0x10 == 0 && feet(*field) == Some(wanted)).unwrap()
        };
        for step in -12..1267 {
            assert_eq!((code(100 * step) ^ code(100 * step + 100)).count_ones(), 1, "{step}");
        }
    }

    #[test]
    fn mode_a_codes_decode_to_octal_digits() {
        let SquitterContents::Status { code, priority } =
            squitter("8f400159e1181500000000d94095").unwrap().contents
        else {
            panic!()
        };
        assert_eq!((code, priority), (0o1017, PriorityStatus::None));
    }

    proptest! {
        #[test]
        fn one_to_five_flipped_bits_are_detected(me: u64, address in 0..1_u32 << 24, flips in prop::collection::btree_set(0..112_usize, 1..=5)) {
            let mut message = sealed(17 << 3 | 5, address, me);
            prop_assert!(Squitter::new(&message).is_ok());
            for flip in &flips {
                message[flip / 8] ^= 0x80 >> (flip % 8);
            }
            prop_assert!(Squitter::new(&message).is_err());
        }

        #[test]
        fn any_message_is_decoded_or_rejected(message: [u8; 14], me: u64, first: u8) {
            let _ = Squitter::new(&message);
            let _ = Squitter::new(&sealed(first, 7, me));
        }
    }
}
