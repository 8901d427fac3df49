//! Messages to a cell from other cells and operators, which are handled in one sequence with the sensor data.

use serde::{Deserialize, Serialize};

use crate::malformed_message::MalformedMessage;
use fusion::frames::Geodetic;
use fusion::integrity;
use fusion::operational::{LabelledTrack, ManualAssociation, SensorValues, TrackHandover};
use fusion::slots::Slot;
use fusion::time::Time;
use fusion::{Identity, RadarTrackKey};
use site::territory::CellName;

/// First octets of a message to a cell.
const LETTER: &[u8; 4] = b"UTL1";

/// A message from one cell to another. Repeated copies have no effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellMessage {
    /// The sender.
    pub from: CellName,
    /// The recipient.
    pub to: CellName,
    /// The slot with which the message was written.
    pub slot: Slot,
    /// Index among the messages of that slot.
    pub index: u16,
    /// Content.
    pub content: CellMessageContent,
}

/// Content of a message to a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CellMessageContent {
    /// Offers an aircraft that has flown into the recipient's cell.
    Offer(AircraftOffer),
    /// Accepts an offer: the sender publishes the aircraft from this slot on.
    Accept {
        /// Id of the aircraft.
        id: String,
        /// First slot of publication by the sender.
        from: Slot,
    },
    /// Rejects an offer: the sender does not see the aircraft.
    Reject {
        /// Id of the aircraft.
        id: String,
    },
    /// Rejects a takeover: another cell has taken the aircraft already.
    TakenElsewhere {
        /// Id of the aircraft.
        id: String,
    },
    /// Asks for the owner of an aircraft that is inside the sender's cell without an offer. The owner offers it or, near the
    /// border, answers that it keeps it.
    AskOwner(Sighting),
    /// Assigns a block of 64 numbers to the recipient.
    Block {
        /// First number of the block.
        first: u32,
    },
    /// Requests a block, because the sender has few numbers left.
    RequestBlock,
    /// States the number of an identity in all cells.
    Number {
        /// The identity.
        identity: Identity,
        /// Its number; `None` if it has none any more.
        number: Option<u32>,
    },
    /// Sends the learned values of a sensor.
    Values {
        /// First slot that uses the values.
        from: Slot,
        /// The values.
        values: Box<SensorValues>,
    },
    /// Sends the state of an aircraft or a radar track that the recipient begins to see.
    Handover(Box<TrackHandover>),
    /// Sends an operator's association decision.
    Correlate {
        /// First slot to which it applies.
        from: Slot,
        /// The decision.
        correlation: ManualAssociation,
    },
    /// Sends an operator's decision on the trust in an identity.
    SetTrust {
        /// First slot to which it applies.
        from: Slot,
        /// The decision.
        decision: integrity::TrustOverride,
    },
    /// States that the sender owns an aircraft near or in the recipient's cell, and keeps it while it is near the border.
    KeepsOwnership(Sighting),
    /// Sends radar tracks in the sender's cell labelled as drones or not, from which the recipient learns the radars'
    /// classification.
    Labelled(Vec<LabelledTrack>),
}

/// An aircraft as its owner publishes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AircraftOffer {
    /// Id of the aircraft.
    pub id: String,
    /// Its track number.
    pub number: u32,
    /// Time of its first publication by any cell.
    pub first_seen: Time,
    /// The number T of its transponder.
    pub transponder_number: Option<u32>,
    /// Its last sighting.
    pub seen: Sighting,
}

/// Features by which two cells recognise the same aircraft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sighting {
    /// Identity of its transponder.
    pub identity: Option<Identity>,
    /// Its radar track, and the time of that track's plot.
    pub radar: Option<(RadarTrackKey, Time)>,
    /// The slot of the position.
    pub slot: Slot,
    /// The time of the position.
    pub time: Time,
    /// Position.
    pub position: Geodetic,
    /// Velocity over ground, east and north, in m/s.
    pub velocity: [f64; 2],
    /// Variances of the position east and north, and their covariance, in m²; `None` in the `reference` profile.
    pub covariance: Option<[f64; 3]>,
}

impl CellMessage {
    /// Serialises the message: `UTL1`, followed by postcard.
    pub fn body(&self) -> Vec<u8> {
        let mut body = LETTER.to_vec();
        body.extend(postcard::to_stdvec(self).expect("every letter can be written down"));
        body
    }

    /// Parses a body.
    ///
    /// # Errors
    /// The body is not such a message, or is truncated.
    pub fn parse(body: &[u8]) -> Result<Self, MalformedMessage> {
        let rest = body.strip_prefix(LETTER).ok_or(MalformedMessage::Beginning)?;
        match postcard::take_from_bytes(rest) {
            Ok((message, [])) => Ok(message),
            Ok(_) | Err(_) => Err(MalformedMessage::Short),
        }
    }

    /// Identifier by which the log recognises copies.
    pub fn id(&self) -> String {
        let Self { from, to, slot, index, .. } = self;
        format!("{from}.{to}.{}.{index}", slot.0)
    }
}
