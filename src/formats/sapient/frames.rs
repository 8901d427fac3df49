//! Messages on a connection: each behind its length, four octets, the lowest first.

use prost::Message;

use super::messages::SapientMessage;

/// Octets of a length.
const HEADER: usize = 4;
/// No message that is read is longer, octets: a longer one is no SAPIENT.
const LONGEST: usize = 1 << 20;

/// Appends a message.
pub(crate) fn append(message: &SapientMessage, out: &mut Vec<u8>) {
    let octets = message.encode_to_vec();
    // Nothing that this service says comes near four gigabytes.
    let length = u32::try_from(octets.len()).unwrap_or(u32::MAX);
    out.extend(length.to_le_bytes());
    out.extend(octets);
}

/// Messages of octets that come cut anywhere.
#[derive(Debug, Default)]
pub(crate) struct Frames(Vec<u8>);

impl Frames {
    /// Takes octets.
    pub(crate) fn take(&mut self, octets: &[u8]) {
        self.0.extend_from_slice(octets);
    }

    /// The next whole message.
    ///
    /// # Errors
    /// What comes is no message of SAPIENT.
    pub(crate) fn next(&mut self) -> Result<Option<SapientMessage>, String> {
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

    use super::super::messages::{Content, RegistrationAck};
    use super::*;

    fn message(reason: &str) -> SapientMessage {
        let ack = RegistrationAck { acceptance: Some(true), ack_response_reason: vec![reason.to_owned()] };
        SapientMessage { content: Some(Content::RegistrationAck(ack)), ..SapientMessage::default() }
    }

    #[test]
    fn a_length_stands_in_front_the_lowest_octet_first() {
        let mut octets = Vec::new();
        append(&message("a"), &mut octets);
        assert_eq!(octets, [7, 0, 0, 0, 0x2a, 5, 8, 1, 0x1a, 1, b'a']);
    }

    #[test]
    fn what_is_no_message_is_refused() {
        let next = |octets: &[u8]| {
            let mut frames = Frames::default();
            frames.take(octets);
            frames.next().map_err(|_| ())
        };
        assert_eq!(next(b"HTTP/1.1 400 Bad Request"), Err(()));
        assert_eq!(next(&[1, 0, 0, 0, 0xff]), Err(()));
        assert_eq!(next(&[1, 0, 0]), Ok(None));
        assert_eq!(next(&[0, 0, 0, 0]), Ok(Some(SapientMessage::default())));
    }

    proptest! {
        #[test]
        fn messages_are_found_however_they_are_cut(
            reasons in prop::collection::vec("[a-z]{0,40}", 0..10), cuts in prop::collection::vec(1..30_usize, 1..20),
        ) {
            let mut octets = Vec::new();
            reasons.iter().for_each(|reason| append(&message(reason), &mut octets));
            let (mut frames, mut found, mut rest) = (Frames::default(), Vec::new(), &octets[..]);
            for cut in cuts.iter().cycle() {
                let (now, later) = rest.split_at((*cut).min(rest.len()));
                frames.take(now);
                while let Some(message) = frames.next().unwrap() {
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
        fn any_octets_are_refused_or_wait(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let mut frames = Frames::default();
            frames.take(&octets);
            while let Ok(Some(_)) = frames.next() {}
        }
    }
}
