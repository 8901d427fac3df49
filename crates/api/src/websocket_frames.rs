//! Frames of RFC 6455. The service sends texts and reads control frames only, so a valid client frame has at most 131 octets.
//! Messages are never assembled, and need no memory.

/// Reason for closing a connection (RFC 6455, 7.4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// The client has finished.
    Normal = 1000,
    /// The service stops.
    GoingAway = 1001,
    /// The client violates the protocol.
    Protocol = 1002,
    /// The client sends messages, which the service does not read.
    Unsupported = 1003,
    /// The client sends too many frames.
    Policy = 1008,
}

/// A control frame of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Control {
    /// A ping, to be answered with the same octets.
    Ping(Vec<u8>),
    /// A pong, solicited or not.
    Pong,
    /// The client has finished.
    Close,
}

const TEXT: u8 = 1;
const CLOSE: u8 = 8;
const PING: u8 = 9;
const PONG: u8 = 10;
/// FIN bit: the last frame of its message, as all frames here.
const FIN: u8 = 0x80;
/// RSV1: the message is compressed (RFC 7692, 6).
const COMPRESSED: u8 = 0x40;
const RESERVED: u8 = 0x70;
const MASKED: u8 = 0x80;
/// Maximum length of a control frame's payload, in octets.
const MOST: usize = 125;

/// A text message; `compressed` as defined by RFC 7692.
pub fn text(octets: &[u8], compressed: bool) -> Vec<u8> {
    frame(if compressed { TEXT | COMPRESSED } else { TEXT }, octets)
}

/// A ping without content.
pub fn ping() -> Vec<u8> {
    frame(PING, b"")
}

/// Answer to a ping.
pub fn pong(octets: &[u8]) -> Vec<u8> {
    frame(PONG, octets)
}

/// Close frame, the last one.
pub fn close(code: Code) -> Vec<u8> {
    frame(CLOSE, &(code as u16).to_be_bytes())
}

fn frame(first: u8, octets: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(octets.len() + 10);
    frame.push(FIN | first);
    match octets.len() {
        short if short <= MOST => frame.push(short as u8),
        medium if medium <= usize::from(u16::MAX) => {
            frame.push(126);
            frame.extend_from_slice(&(medium as u16).to_be_bytes());
        }
        long => {
            frame.push(127);
            frame.extend_from_slice(&(long as u64).to_be_bytes());
        }
    }
    frame.extend_from_slice(octets);
    frame
}

/// Takes the next frame of a client from the received octets; `None` if it is not complete.
///
/// # Errors
/// The code to close the connection with: the frame is unmasked, fragmented, too long or unknown, or it is a message.
pub fn take(came: &mut Vec<u8>) -> Result<Option<Control>, Code> {
    let [first, second, ..] = came[..] else { return Ok(None) };
    let (opcode, length) = (first & 0x0f, usize::from(second & !MASKED));
    if first & RESERVED != 0 || second & MASKED == 0 {
        return Err(Code::Protocol);
    }
    match opcode {
        0..=2 => return Err(Code::Unsupported),
        CLOSE | PING | PONG if first & FIN != 0 && length <= MOST => {}
        _ => return Err(Code::Protocol),
    }
    let Some(rest) = came.get(2..6 + length) else { return Ok(None) };
    let (mask, octets) = rest.split_at(4);
    let octets: Vec<u8> = octets.iter().zip(mask.iter().cycle()).map(|(octet, mask)| octet ^ mask).collect();
    came.drain(..6 + length);
    Ok(Some(match opcode {
        PING => Control::Ping(octets),
        PONG => Control::Pong,
        _ if octets.len() == 1 => return Err(Code::Protocol),
        _ => Control::Close,
    }))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Frame as a client sends it.
    fn masked(first: u8, octets: &[u8], mask: [u8; 4]) -> Vec<u8> {
        let mut frame = vec![first, MASKED | octets.len() as u8];
        frame.extend(mask);
        frame.extend(octets.iter().zip(mask.iter().cycle()).map(|(octet, mask)| octet ^ mask));
        frame
    }

    #[test]
    fn frames_are_those_of_the_rfc() {
        // RFC 6455, 5.7.
        assert_eq!(text(b"Hello", false), b"\x81\x05Hello");
        assert_eq!(pong(b"Hello"), b"\x8a\x05Hello");
        assert_eq!(text(&[7; 256], false)[..6], [0x81, 0x7e, 0x01, 0x00, 7, 7]);
        assert_eq!(text(&[7; 65_536], false)[..11], [0x81, 0x7f, 0, 0, 0, 0, 0, 1, 0, 0, 7]);
        let mut came = b"\x8a\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58".to_vec();
        assert_eq!(take(&mut came), Ok(Some(Control::Pong)));
        // RFC 7692, 7.2.3.1.
        assert_eq!(text(b"\xf2\x48\xcd\xc9\xc9\x07\x00", true), b"\xc1\x07\xf2\x48\xcd\xc9\xc9\x07\x00");
        assert_eq!(close(Code::GoingAway), b"\x88\x02\x03\xe9");
        assert_eq!(ping(), b"\x89\x00");
    }

    #[test]
    fn frames_outside_the_agreement_are_refused() {
        for (frame, code) in [
            (&b"\x81\x85"[..], Code::Unsupported),
            (b"\x82\xff", Code::Unsupported),
            (b"\x00\x80", Code::Unsupported),
            (b"\x89\x05Hello", Code::Protocol),
            (b"\xc9\x80", Code::Protocol),
            (b"\x09\x80", Code::Protocol),
            (b"\x89\xfe", Code::Protocol),
            (b"\x83\x80", Code::Protocol),
            (b"\x8f\x80", Code::Protocol),
            (b"\x88\x81\x00\x00\x00\x00\x03", Code::Protocol),
        ] {
            assert_eq!(take(&mut frame.to_vec()), Err(code), "{frame:?}");
        }
    }

    proptest! {
        /// Frames arrive in any pieces.
        #[test]
        fn control_frames_are_read_back(
            sent in prop::collection::vec((0..3u8, prop::collection::vec(any::<u8>(), 2..126), any::<[u8; 4]>()), 1..8),
            cut in 1..200usize,
        ) {
            let wire: Vec<u8> =
                sent.iter().flat_map(|(kind, octets, mask)| masked(FIN | (CLOSE + kind), octets, *mask)).collect();
            let (mut came, mut taken) = (Vec::new(), Vec::new());
            for slice in wire.chunks(cut) {
                came.extend_from_slice(slice);
                while let Some(control) = take(&mut came).unwrap() {
                    taken.push(control);
                }
            }
            let expected: Vec<Control> = sent
                .into_iter()
                .map(|(kind, octets, _)| match CLOSE + kind {
                    PING => Control::Ping(octets),
                    PONG => Control::Pong,
                    _ => Control::Close,
                })
                .collect();
            prop_assert_eq!(taken, expected);
            prop_assert!(came.is_empty());
        }

        /// Any input gives a result, and at most one frame is kept.
        #[test]
        fn arbitrary_octets_are_answered(wire in prop::collection::vec(any::<u8>(), 0..400)) {
            let mut came = wire.clone();
            while let Ok(Some(_)) = take(&mut came) {}
            prop_assert!(came.len() < 131 || take(&mut came).is_err());
        }
    }
}
