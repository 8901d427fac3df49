//! Special purpose field of the fusion service's own records, with values for which CAT129 has no item.

use deku::DekuReader;
use deku::reader::Reader;

use super::whole_serial::{self, WholeSerial};
use crate::Describe;
use crate::bits::{self, nearest};
use crate::item::words;
use crate::record::{Forward, append};
use crate::{Explicit, Field, Form, Kind, Layout};

/// Start of the field: the letters `UF` and version 1.
const MAGIC: [u8; 3] = *b"UF\x01";
/// Start of version 2, which appends the whole serial number to version 1.
pub(super) const MAGIC_WITH_SERIAL: [u8; 3] = *b"UF\x02";
/// Length of version 1, in octets.
pub(super) const OCTETS: usize = 21;

/// Sensors that contribute to a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// 1: radar and transponder.
    Fused,
    /// 2: radar only.
    Radar,
    /// 3: transponder only.
    Transponder,
    /// 4: cameras only.
    Camera,
}

/// A standard deviation: LSB 0.1 m, 0 to 6553.4 m, or unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Deviation(u16);

impl Deviation {
    /// Unknown.
    pub const UNKNOWN: Self = Self(u16::MAX);

    /// The nearest deviation, limited to 6553.4 m; [`Deviation::UNKNOWN`] for negative numbers and NaN.
    pub fn from_metres(deviation_m: f64) -> Self {
        const LARGEST: u16 = u16::MAX - 1;
        let count = nearest((deviation_m * 10.0).min(f64::from(LARGEST)), 0, LARGEST.into());
        // `min` returns its other argument for NaN, so NaN is checked here.
        if deviation_m.is_nan() {
            Self::UNKNOWN
        } else {
            count.map_or(Self::UNKNOWN, |count| Self(count as u16))
        }
    }

    /// The deviation in metres; `None` if unknown.
    pub fn metres(self) -> Option<f64> {
        (self != Self::UNKNOWN).then_some(f64::from(self.0) / 10.0)
    }
}

/// The radar's probability that the target is an unmanned aircraft: LSB 1/254, or unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct UavProbability(u8);

impl UavProbability {
    /// Unknown, as always without a radar detection.
    pub const UNKNOWN: Self = Self(u8::MAX);

    /// The nearest probability; [`UavProbability::UNKNOWN`] outside 0 to 1.
    pub fn from_probability(probability: f64) -> Self {
        nearest(probability * 254.0, 0, 254).map_or(Self::UNKNOWN, |count| Self(count as u8))
    }

    /// The probability, 0 to 1; `None` if unknown.
    pub fn probability(self) -> Option<f64> {
        (self != Self::UNKNOWN).then_some(f64::from(self.0) / 254.0)
    }
}

/// Flags of a point. Bits that this version does not define are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Flags(pub u8);

impl Flags {
    /// The transponder's position is interpolated.
    pub const INTERPOLATED: Self = Self(0x01);
    /// The position is extrapolated beyond the last report.
    pub const EXTRAPOLATED: Self = Self(0x02);
    /// Integrity checks speak against the transponder.
    pub const INTEGRITY_SUSPECT: Self = Self(0x04);
    /// Integrity checks have refuted the transponder; the flag for suspect is set, too.
    pub const INTEGRITY_FAILED: Self = Self(0x08);
    /// Only radar detects the aircraft, in a place where a transponder would be received.
    pub const UNCOOPERATIVE: Self = Self(0x10);
    /// The radar did not measure the height.
    pub const HEIGHT_NOT_MEASURED: Self = Self(0x20);

    /// Whether all flags of `other` are set.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The union of the flags.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// The special purpose field of an output point, layout `UF` version 1. In version 2 a [`WholeSerial`] follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FusionReport {
    /// Sensors that contribute.
    pub source: Source,
    /// Track number of the service.
    pub track_number: u32,
    /// Track number of the contributing radar (I048/161), if any; 65535 is the same as none.
    pub radar_track: Option<u16>,
    /// Number of the contributing transponder, if any; 2^32 - 1 is the same as none.
    pub transponder: Option<u32>,
    /// Standard deviation of the horizontal position.
    pub horizontal_deviation: Deviation,
    /// Standard deviation of the height.
    pub vertical_deviation: Deviation,
    /// Flags.
    pub flags: Flags,
    /// Probability that the contributing radar detection is an unmanned aircraft.
    pub uav_probability: UavProbability,
}

words! {
    /// The octets after the length octet.
    struct Contents {
        magic: [u8; 3] { constant 24 "magic" = bits::get(&MAGIC, 0, 24); }
        source: u8 { count 8 "source"; }
        track_number: u32 { count 32 "track_number"; }
        radar_track: u16 { count_or 16 "radar_track" = 0xffff; }
        transponder: u32 { count_or 32 "transponder" = 0xffff_ffff; }
        horizontal_deviation: u16 { known 16 "horizontal_deviation_m" = 0.1, 1; }
        vertical_deviation: u16 { known 16 "vertical_deviation_m" = 0.1, 1; }
        flags: u8 {
            spare 2 "spare";
            count 1 "height_not_measured";
            count 1 "uncooperative";
            count 1 "integrity_failed";
            count 1 "integrity_suspect";
            count 1 "extrapolated";
            count 1 "interpolated";
        }
        uav_probability: u8 { known 8 "uav_probability" = 1.0 / 254.0, 3; }
        spare: u8 { spare 8 "spare_2"; }
    }
}

impl Describe for FusionReport {
    const LAYOUT: Layout = Layout::Explicit(crate::Contents::Known(&[
        Form { key: "uf", fields: Self::FIELDS },
        Form { key: "uf", fields: &WITH_SERIAL },
        Form { key: "uf", fields: WholeSerial::FIELDS },
    ]));
}

/// The fields of version 2.
const WITH_SERIAL: [Field; FusionReport::FIELDS.len() + 1] = {
    const LAST: usize = FusionReport::FIELDS.len();
    let mut fields = [whole_serial::FIELD; LAST + 1];
    let mut at = 1;
    while at < LAST {
        fields[at] = FusionReport::FIELDS[at];
        at += 1;
    }
    fields[0] = Field::new("magic", 24, Kind::Constant(bits::get(&MAGIC_WITH_SERIAL, 0, 24)));
    fields
};

impl FusionReport {
    /// The fields after the length octet. The source is 1 fused, 2 radar, 3 transponder, 4 camera.
    pub const FIELDS: &'static [Field] = Contents::FIELDS;

    /// Decodes a special purpose field of version 1 or 2. `None` for another start, version or length, or an undefined source:
    /// such a field has another layout and is kept as octets. The spare octet is ignored.
    pub fn read(field: &Explicit) -> Option<Self> {
        let magic = *field.contents().first_chunk()?;
        let octets = match magic {
            MAGIC => field.contents(),
            MAGIC_WITH_SERIAL => field.contents().strip_suffix(WholeSerial::read(field)?.octets())?,
            _ => return None,
        };
        let mut octets = Forward(octets);
        let words = Contents::from_reader_with_ctx(&mut Reader::new(&mut octets), ()).ok()?;
        if words.magic != magic || !octets.0.is_empty() {
            return None;
        }
        Some(Self {
            source: match words.source {
                1 => Source::Fused,
                2 => Source::Radar,
                3 => Source::Transponder,
                4 => Source::Camera,
                _ => return None,
            },
            track_number: words.track_number,
            radar_track: (words.radar_track != u16::MAX).then_some(words.radar_track),
            transponder: (words.transponder != u32::MAX).then_some(words.transponder),
            horizontal_deviation: Deviation(words.horizontal_deviation),
            vertical_deviation: Deviation(words.vertical_deviation),
            flags: Flags(words.flags),
            uav_probability: UavProbability(words.uav_probability),
        })
    }

    /// The special purpose field of version 1 with these values.
    pub fn to_field(&self) -> Explicit {
        Explicit::new(&self.contents(MAGIC)).expect("21 octets fit a special purpose field")
    }

    /// The special purpose field of version 2 with these values and a serial number of more than 12 octets.
    pub fn to_field_with(&self, serial: &WholeSerial) -> Explicit {
        let mut contents = [0; OCTETS + WholeSerial::OCTETS];
        let (report, rest) = contents.split_at_mut(OCTETS);
        report.copy_from_slice(&self.contents(MAGIC_WITH_SERIAL));
        rest.copy_from_slice(serial.octets());
        Explicit::new(&contents).expect("41 octets fit a special purpose field")
    }

    fn contents(&self, magic: [u8; 3]) -> [u8; OCTETS] {
        let words = Contents {
            magic,
            source: match self.source {
                Source::Fused => 1,
                Source::Radar => 2,
                Source::Transponder => 3,
                Source::Camera => 4,
            },
            track_number: self.track_number,
            radar_track: self.radar_track.unwrap_or(u16::MAX),
            transponder: self.transponder.unwrap_or(u32::MAX),
            horizontal_deviation: self.horizontal_deviation.0,
            vertical_deviation: self.vertical_deviation.0,
            flags: self.flags.0,
            uav_probability: self.uav_probability.0,
            spare: 0,
        };
        let mut contents = [0; OCTETS];
        append(&words, &mut contents[..]);
        contents
    }
}
