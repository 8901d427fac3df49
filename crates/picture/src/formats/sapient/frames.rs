//! Framing of messages on a connection: each is preceded by its length in four octets, little-endian.

use prost::Message;

use super::messages::SapientMessage;

/// Length of the header, in octets.
const HEADER: usize = 4;
/// Maximum length of a received message, in octets. Longer ones are not SAPIENT.
const LONGEST: usize = 1 << 20;

/// Appends a message with its length.
pub fn append(message: &SapientMessage, out: &mut Vec<u8>) {
    let octets = message.encode_to_vec();
    // Messages of this service are far below four gigabytes.
    let length = u32::try_from(octets.len()).unwrap_or(u32::MAX);
    out.extend(length.to_le_bytes());
    out.extend(octets);
}

/// Decoder of messages from octets that may be split anywhere.
#[derive(Debug, Default)]
pub struct SapientFrames(Vec<u8>);

impl SapientFrames {
    /// Adds received octets.
    pub fn take(&mut self, octets: &[u8]) {
        self.0.extend_from_slice(octets);
    }

    /// Next complete message.
    ///
    /// # Errors
    /// The octets are not a SAPIENT message.
    pub fn next_message(&mut self) -> Result<Option<SapientMessage>, String> {
        let Some((header, rest)) = self.0.split_first_chunk::<HEADER>() else { return Ok(None) };
        let length = u32::from_le_bytes(*header) as usize;
        if length > LONGEST {
            return Err(format!("the receiver sends a message of {length} octets, and none is that long"));
        }
        let Some(octets) = rest.get(..length) else { return Ok(None) };
        let message = SapientMessage::decode(octets)
            .map_err(|error| format!("the receiver sends what is no message of SAPIENT: {error}"))?;
        self.0.drain(..HEADER + length);
        Ok(Some(message))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::messages::{RegistrationAck, SapientContent};
    use super::*;

    fn message(reason: &str) -> SapientMessage {
        let ack = RegistrationAck { acceptance: Some(true), ack_response_reason: vec![reason.to_owned()] };
        SapientMessage { content: Some(SapientContent::RegistrationAck(ack)), ..SapientMessage::default() }
    }

    #[test]
    fn frame_begins_with_little_endian_length() {
        let mut octets = Vec::new();
        append(&message("a"), &mut octets);
        assert_eq!(octets, [7, 0, 0, 0, 0x2a, 5, 8, 1, 0x1a, 1, b'a']);
    }

    #[test]
    fn invalid_message_is_rejected() {
        let next = |octets: &[u8]| {
            let mut frames = SapientFrames::default();
            frames.take(octets);
            frames.next_message().map_err(|_| ())
        };
        assert_eq!(next(b"HTTP/1.1 400 Bad Request"), Err(()));
        assert_eq!(next(&[1, 0, 0, 0, 0xff]), Err(()));
        assert_eq!(next(&[1, 0, 0]), Ok(None));
        assert_eq!(next(&[0, 0, 0, 0]), Ok(Some(SapientMessage::default())));
    }

    proptest! {
        #[test]
        fn messages_are_found_at_any_split(
            reasons in prop::collection::vec("[a-z]{0,40}", 0..10), cuts in prop::collection::vec(1..30_usize, 1..20),
        ) {
            let mut octets = Vec::new();
            reasons.iter().for_each(|reason| append(&message(reason), &mut octets));
            let (mut frames, mut found, mut rest) = (SapientFrames::default(), Vec::new(), &octets[..]);
            for cut in cuts.iter().cycle() {
                let (now, later) = rest.split_at((*cut).min(rest.len()));
                frames.take(now);
                while let Some(message) = frames.next_message().unwrap() {
                    found.push(message);
                }
                rest = later;
                if rest.is_empty() {
                    break;
                }
            }
            prop_assert_eq!(found, reasons.iter().map(|reason| message(reason)).collect::<Vec<_>>());
        }

        #[test]
        fn arbitrary_octets_are_rejected_or_pending(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let mut frames = SapientFrames::default();
            frames.take(&octets);
            while let Ok(Some(_)) = frames.next_message() {}
        }
    }
}
