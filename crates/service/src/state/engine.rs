//! State of the engine at one moment: all data that later pictures depend on.

/// End of the name of a recording's file with this state, before its first datagram.
pub const ENGINE: &str = "engine";

/// The encoded state: [`Pipeline::checkpoint`](input::pipeline::Pipeline::checkpoint) after
/// [`UncooperativeDetector::checkpoint`](picture::UncooperativeDetector::checkpoint).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EngineState<'a> {
    /// State of the pipeline, with its engine.
    pub pipeline: &'a [u8],
    /// State of the detection of drones without a transponder.
    pub detector: &'a [u8],
}

impl<'a> EngineState<'a> {
    /// Begins the encoded state with `detector`. The pipeline's state, possibly tens of megabytes, is appended directly.
    pub fn begin(detector: &[u8], octets: &mut Vec<u8>) {
        *octets = postcard::to_extend(detector, std::mem::take(octets)).expect("octets can be written down");
    }

    /// Both parts of an encoded state; `None` if the octets are invalid.
    pub fn parse(octets: &'a [u8]) -> Option<Self> {
        let (detector, pipeline) = postcard::take_from_bytes(octets).ok()?;
        Some(Self { pipeline, detector })
    }
}
