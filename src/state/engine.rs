//! All that a picture depends on, at one moment.

/// The end of the name of the file of a recording that holds it, as it was before the first datagram.
pub const ENGINE: &str = "engine";

/// What is known of the aircraft, as octets: [`Pipeline::checkpoint`](crate::pipeline::Pipeline::checkpoint) behind
/// [`Lookout::checkpoint`](crate::integrity::Lookout::checkpoint).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EngineState<'a> {
    /// Of the pipeline, with its engine.
    pub pipeline: &'a [u8],
    /// Of whoever looks out for drones without a transponder.
    pub lookout: &'a [u8],
}

impl<'a> EngineState<'a> {
    /// Begins both as one: what `lookout` says. What the pipeline writes, tens of megabytes maybe, goes straight behind it.
    pub fn begin(lookout: &[u8], octets: &mut Vec<u8>) {
        *octets = postcard::to_extend(lookout, std::mem::take(octets)).expect("octets can be written down");
    }

    /// Both again; `None`: that is something else.
    pub fn parse(octets: &'a [u8]) -> Option<Self> {
        let (lookout, pipeline) = postcard::take_from_bytes(octets).ok()?;
        Some(Self { pipeline, lookout })
    }
}
