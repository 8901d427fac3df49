//! Letters: what a cell is told by others, in the same order as what its sensors send.

use serde::{Deserialize, Serialize};

use crate::cluster::message::Malformed;
use crate::territory::CellName;
use fusion::frames::Geodetic;
use fusion::integrity;
use fusion::operational::{Acquaintance, Correlation, LabelledTrack, SensorValues};
use fusion::slots::Slot;
use fusion::time::Time;
use fusion::{Identity, RadarTrackKey};

/// What the body of a letter begins with.
const LETTER: &[u8; 4] = b"UTL1";

/// From one cell to another. Twice is as good as once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Letter {
    /// Who writes.
    pub from: CellName,
    /// To whom.
    pub to: CellName,
    /// The slot with which it was written,
    pub slot: Slot,
    /// and which of the letters of that slot it is.
    pub index: u16,
    /// What it says.
    pub word: Word,
}

/// What a letter says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Word {
    /// An aircraft has flown into the recipient's cell.
    Offer(Offer),
    /// The recipient of an offer has the aircraft, and publishes it from this slot on.
    Take {
        /// Which.
        id: String,
        /// From when.
        from: Slot,
    },
    /// The recipient of an offer does not see it.
    Unknown {
        /// Which.
        id: String,
    },
    /// It is somebody else's already.
    Gone {
        /// Which.
        id: String,
    },
    /// An aircraft is inside the writer's cell, and nobody has offered it: whose is it? Who has it offers it or, near the border,
    /// says that it keeps it.
    Ask(Sighting),
    /// 64 numbers from this one on are the recipient's.
    Block {
        /// The first.
        first: u32,
    },
    /// The writer has few numbers left.
    Wanted,
    /// An identity has this number, wherever it comes.
    Number {
        /// Who.
        identity: Identity,
        /// Which; `None`: it has none any more.
        number: Option<u32>,
    },
    /// What is known of a sensor, to be used from this slot on.
    Values {
        /// From when.
        from: Slot,
        /// What.
        values: Box<SensorValues>,
    },
    /// What is known of an aircraft or a radar track that the recipient begins to see.
    Known(Box<Acquaintance>),
    /// An operator's decision, from this slot on.
    Correlate {
        /// From when.
        from: Slot,
        /// What.
        correlation: Correlation,
    },
    /// An operator's word on an identity, from this slot on.
    Say {
        /// From when.
        from: Slot,
        /// What.
        word: integrity::Word,
    },
    /// An aircraft near the recipient's cell, or in it, is the writer's, and stays it while it is near the border.
    Kept(Sighting),
    /// Radar tracks in the writer's cell that are drones, and that are not, for what the recipient learns of the radars' classes.
    Labelled(Vec<LabelledTrack>),
}

/// An aircraft as its owner publishes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Offer {
    /// Its id.
    pub id: String,
    /// Its track number.
    pub number: u32,
    /// When it was published first, by whomever.
    pub first_seen: Time,
    /// The number T of its transponder.
    pub transponder_number: Option<u32>,
    /// Where it was seen last.
    pub seen: Sighting,
}

/// How an aircraft is known to who sees the same one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sighting {
    /// Its transponder.
    pub identity: Option<Identity>,
    /// Its radar track, and the time of that one's plot.
    pub radar: Option<(RadarTrackKey, Time)>,
    /// The slot of its position.
    pub slot: Slot,
    /// The time of that.
    pub time: Time,
    /// Where it is.
    pub position: Geodetic,
    /// Velocity over ground, east and north, metres a second.
    pub velocity: [f64; 2],
    /// Covariance of the position over ground, m²: east, north, both; `None` in the `reference` profile.
    pub covariance: Option<[f64; 3]>,
}

impl Letter {
    /// The body: `UTL1`, then as postcard writes it.
    pub fn body(&self) -> Vec<u8> {
        let mut body = LETTER.to_vec();
        body.extend(postcard::to_stdvec(self).expect("every letter can be written down"));
        body
    }

    /// Reads a body.
    ///
    /// # Errors
    /// It is none, or cut.
    pub fn parse(body: &[u8]) -> Result<Self, Malformed> {
        let rest = body.strip_prefix(LETTER).ok_or(Malformed::Beginning)?;
        match postcard::take_from_bytes(rest) {
            Ok((letter, [])) => Ok(letter),
            Ok(_) | Err(_) => Err(Malformed::Short),
        }
    }

    /// What the log knows copies by.
    pub fn id(&self) -> String {
        let Self { from, to, slot, index, .. } = self;
        format!("{from}.{to}.{}.{index}", slot.0)
    }
}
