//! Composition of the track from tracks of several units: I062/510.

use deku::DekuError;
use deku::no_std_io::{Read, Seek};
use deku::reader::Reader;
use smallvec::SmallVec;

use crate::item::{in_place, items};
use crate::octets::read_octets;
use crate::{Describe, Field, Layout};

items! {
    /// A part of I062/510: the track of a unit.
    pub struct UnitTrack(3) {
        /// The unit, 0 to 255.
        count 8 "unit" unit / with_unit: u8;
        /// Track number of the unit, 0 to 32767.
        count 15 "track_number" track_number / with_track_number: u16;
        spare 1 "fx";
    }
}

/// I062/510, composed track number: the track of the master unit, then those of other units.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ComposedTrackNumber(SmallVec<[UnitTrack; 4]>);

impl ComposedTrackNumber {
    /// These tracks in this order; `None` if there are none.
    pub fn new(tracks: &[UnitTrack]) -> Option<Self> {
        let all = || tracks.iter().map(|track| track.extended(false)).collect();
        (!tracks.is_empty()).then(|| Self(all()))
    }

    /// The tracks in the order sent.
    pub fn tracks(&self) -> &[UnitTrack] {
        &self.0
    }

    fn read<R: Read + Seek>(reader: &mut Reader<R>) -> Result<Self, DekuError> {
        let mut tracks = SmallVec::new();
        loop {
            let octets: [u8; 3] = read_octets(reader)?;
            tracks.push(UnitTrack(octets).extended(false));
            if octets[2] & 1 == 0 {
                return Ok(Self(tracks));
            }
        }
    }
}

impl UnitTrack {
    /// The track with FX, which states that another one follows.
    const fn extended(self, extends: bool) -> Self {
        let [unit, high, low] = self.0;
        Self([unit, high, low & !1 | extends as u8])
    }
}

impl Describe for ComposedTrackNumber {
    const LAYOUT: Layout = {
        const PART: &[Field] = match UnitTrack::FIELDS {
            [part @ .., _] => part,
            [] => &[],
        };
        Layout::Chained(PART)
    };
}

in_place! {
    ComposedTrackNumber () reader => Self::read(reader),
    self writer => {
        for (index, track) in self.0.iter().enumerate() {
            writer.write_bytes(&track.extended(index + 1 < self.0.len()).0)?;
        }
        Ok(())
    }
}
