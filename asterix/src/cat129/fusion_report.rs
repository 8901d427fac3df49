//! The special purpose field of the fusion service's own records: what CAT129 has no item for.

use deku::DekuReader;
use deku::reader::Reader;

use super::whole_serial::{self, WholeSerial};
use crate::Describe;
use crate::bits::{self, nearest};
use crate::item::words;
use crate::record::{Forward, append};
use crate::{Explicit, Field, Form, Kind, Layout};

/// Marks the layout: the letters `UF` and version 1.
const MAGIC: [u8; 3] = *b"UF\x01";
/// Version 2: as version 1, with the whole serial number behind it.
pub(super) const MAGIC_WITH_SERIAL: [u8; 3] = *b"UF\x02";
/// Octets of version 1.
pub(super) const OCTETS: usize = 21;

/// Which sensors a point comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// 1: radar and transponder.
    Fused,
    /// 2: radar alone.
    Radar,
    /// 3: transponder alone.
    Transponder,
}

/// A standard deviation: LSB 0.1 m, 0 to 6553.4 m, or unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Deviation(u16);

impl Deviation {
    /// Not known.
    pub const UNKNOWN: Self = Self(u16::MAX);

    /// The nearest deviation; above 6553.4 m that, and [`Deviation::UNKNOWN`] for a negative number or none.
    pub fn from_metres(deviation_m: f64) -> Self {
        const LARGEST: u16 = u16::MAX - 1;
        let count = nearest((deviation_m * 10.0).min(f64::from(LARGEST)), 0, LARGEST.into());
        // `min` gives its other argument for a NaN, so that is asked for here.
        if deviation_m.is_nan() {
            Self::UNKNOWN
        } else {
            count.map_or(Self::UNKNOWN, |count| Self(count as u16))
        }
    }

    /// The deviation in metres; `None` when unknown.
    pub fn metres(self) -> Option<f64> {
        (self != Self::UNKNOWN).then_some(f64::from(self.0) / 10.0)
    }
}

/// The probability that the radar saw an unmanned aircraft: LSB 1/254, or unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct UavProbability(u8);

impl UavProbability {
    /// Not known; always so without a radar detection.
    pub const UNKNOWN: Self = Self(u8::MAX);

    /// The nearest probability; [`UavProbability::UNKNOWN`] outside 0 to 1.
    pub fn from_probability(probability: f64) -> Self {
        nearest(probability * 254.0, 0, 254).map_or(Self::UNKNOWN, |count| Self(count as u8))
    }

    /// The probability, 0 to 1; `None` when unknown.
    pub fn probability(self) -> Option<f64> {
        (self != Self::UNKNOWN).then_some(f64::from(self.0) / 254.0)
    }
}

/// What else is known about a point. Bits that this version does not name are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Flags(pub u8);

impl Flags {
    /// The transponder's position is interpolated.
    pub const INTERPOLATED: Self = Self(0x01);
    /// The position is extrapolated beyond the last report.
    pub const EXTRAPOLATED: Self = Self(0x02);
    /// Something speaks against the transponder.
    pub const INTEGRITY_SUSPECT: Self = Self(0x04);
    /// The transponder is not to be believed; it is suspect, too.
    pub const INTEGRITY_FAILED: Self = Self(0x08);
    /// Radar alone sees the aircraft, and where it is a transponder would be heard.
    pub const UNCOOPERATIVE: Self = Self(0x10);
    /// The radar did not measure the height.
    pub const HEIGHT_NOT_MEASURED: Self = Self(0x20);

    /// Whether all flags of `other` are set.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The flags of both.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// The special purpose field of an output point, layout `UF` version 1. Version 2 has a [`WholeSerial`] behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FusionReport {
    /// Which sensors contribute.
    pub source: Source,
    /// The service's number of the track.
    pub track_number: u32,
    /// The radar's number of its track (I048/161), where one contributes; 65535 cannot be told from none.
    pub radar_track: Option<u16>,
    /// The number of the transponder, where one contributes; 2^32 - 1 cannot be told from none.
    pub transponder: Option<u32>,
    /// Standard deviation of the position, horizontally.
    pub horizontal_deviation: Deviation,
    /// Standard deviation of the height.
    pub vertical_deviation: Deviation,
    /// What else is known.
    pub flags: Flags,
    /// The probability that the contributing radar detection is an unmanned aircraft.
    pub uav_probability: UavProbability,
}

words! {
    /// The octets after the length octet, as they stand.
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
    /// The fields, from the first octet after the length octet. The source is 1 fused, 2 radar, 3 transponder.
    pub const FIELDS: &'static [Field] = Contents::FIELDS;

    /// Reads a special purpose field of version 1 or 2. `None` for another magic, version or length, or a source that these
    /// versions do not name: such a field has another layout and stays as it is. The spare octet is not
    /// looked at.
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

    /// The special purpose field that says this, of version 1.
    pub fn to_field(&self) -> Explicit {
        Explicit::new(&self.contents(MAGIC)).expect("21 octets fit a special purpose field")
    }

    /// The special purpose field of version 2: this, and a serial number of more than 12 octets.
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
