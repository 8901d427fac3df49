//! All that a picture depends on, at one moment.

use serde::{Deserialize, Serialize};

/// The end of the name of the file of a recording that holds it, as it was before the first datagram.
pub const ENGINE: &str = "engine";

/// What is known of the aircraft, as octets: [`Pipeline::checkpoint`](crate::pipeline::Pipeline::checkpoint) and
/// [`Lookout::checkpoint`](crate::integrity::Lookout::checkpoint).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EngineState {
    /// Of the pipeline, with its engine.
    pub pipeline: Vec<u8>,
    /// Of whoever looks out for drones without a transponder.
    pub lookout: Vec<u8>,
}

impl EngineState {
    /// Both as one.
    pub fn octets(&self) -> Vec<u8> {
        postcard::to_stdvec(self).expect("octets can be written down")
    }

    /// Both again; `None`: that is something else.
    pub fn parse(octets: &[u8]) -> Option<Self> {
        postcard::from_bytes(octets).ok()
    }
}
