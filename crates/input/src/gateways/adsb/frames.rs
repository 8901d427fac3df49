//! Frames of a 1090 MHz receiver in a stream of octets: Beast (binary) and AVR (text), as sent by readsb and dump1090.

/// Framing of a receiver's messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiverFraming {
    /// An octet 1a, the kind, a stamp of 6 octets, the level, the message; 1a is doubled within. Usually port 30005. Kinds
    /// that identify a receiver have neither stamp nor level.
    Beast,
    /// `*`, the message in hexadecimal, `;`; or `@` and a stamp of 12 digits before it. Usually port 30002.
    Avr,
}

/// Contents of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeSMessage {
    /// A reply in Mode A or C.
    ModeAc,
    /// A short reply or squitter in Mode S.
    Short([u8; 7]),
    /// A long reply or squitter in Mode S.
    Long([u8; 14]),
    /// The receiver's settings and state (kind `4`).
    Status([u8; 14]),
    /// The receiver's position (kind `5`).
    ReceiverPlace,
    /// Identity of the receiver of the next frame, or of the whole stream (kinds e3 and e4 of readsb).
    ReceiverId(ReceiverId),
}

/// Identity of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ReceiverId(pub u128);

/// A frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdsbFrame {
    /// Receiver's stamp at the end of the frame, if there is one: a counter at 12 MHz, or seconds of the day and
    /// nanoseconds.
    pub stamp: Option<u64>,
    /// Contents of the frame.
    pub message: ModeSMessage,
}

/// A part of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StreamPart {
    /// A whole frame.
    Frame(AdsbFrame),
    /// The beginning of a frame: another began before it ended.
    Cut,
    /// An invalid frame: of an unknown kind, with a wrong length or invalid characters.
    Malformed,
}

/// Counts of the stamp per second.
pub const STAMP_HZ: i64 = 12_000_000;
/// First octet of each Beast frame.
const ESCAPE: u8 = 0x1a;
/// Octets of the stamp and the level.
const HEADER: usize = 7;
/// Octets of the longest frame with a message, after its kind.
const LONGEST: usize = HEADER + 14;
/// Octets of the longest frame after its kind, without escapes.
pub(crate) const BODY_MOST: usize = UUID;
/// Octets of a receiver's identity, as a number and as the text of a UUID.
const ID: usize = 8;
const UUID: usize = 36;
/// Characters of the longest line between its marks: stamp, level and message.
const LINE: usize = 12 + 2 + 28;
/// Stamp that means that there is none: `MLAT` after ff 00.
const NO_STAMP: u64 = 0xff00_4d4c_4154;

/// Splits a stream into frames, one octet at a time; holds at most one frame.
#[derive(Clone, Debug)]
pub struct Deframer {
    framing: ReceiverFraming,
    state: DeframerState,
    held: [u8; LINE],
    length: usize,
    outside: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DeframerState {
    /// Between frames.
    Outside,
    /// After an escape between frames.
    Kind,
    /// In a Beast frame that ends at this length.
    Inside { kind: u8, end: usize },
    /// After an escape within a frame.
    Escaped { kind: u8, end: usize },
    /// In a line that began with this mark.
    Line(u8),
}

impl Deframer {
    /// Deframer before the first octet.
    pub fn new(framing: ReceiverFraming) -> Self {
        Self { framing, state: DeframerState::Outside, held: [0; LINE], length: 0, outside: 0 }
    }

    /// Number of octets so far that belong to no frame.
    pub fn outside(&self) -> u64 {
        self.outside
    }

    /// Whether a frame has begun and not ended.
    pub fn is_within(&self) -> bool {
        self.state != DeframerState::Outside
    }

    /// Drops an unfinished frame.
    pub fn restart(&mut self) {
        self.state = DeframerState::Outside;
    }

    /// Takes the next octet; returns the part of the stream that it ends, if any.
    pub fn take(&mut self, octet: u8) -> Option<StreamPart> {
        match self.framing {
            ReceiverFraming::Beast => self.take_beast(octet),
            ReceiverFraming::Avr => self.take_avr(octet),
        }
    }

    fn take_beast(&mut self, octet: u8) -> Option<StreamPart> {
        match self.state {
            DeframerState::Outside if octet == ESCAPE => self.state = DeframerState::Kind,
            DeframerState::Outside => self.outside += 1,
            DeframerState::Kind => return self.begin(octet),
            DeframerState::Inside { kind, end } if octet == ESCAPE => {
                self.state = DeframerState::Escaped { kind, end }
            }
            DeframerState::Inside { kind, end } => return self.push(octet, kind, end),
            DeframerState::Escaped { kind, end } if octet == ESCAPE => {
                self.state = DeframerState::Inside { kind, end };
                return self.push(octet, kind, end);
            }
            // The beginning of another frame, or an invalid octet.
            DeframerState::Escaped { .. } => {
                self.begin(octet);
                return Some(StreamPart::Cut);
            }
            DeframerState::Line(_) => self.state = DeframerState::Outside,
        }
        None
    }

    /// Handles the octet after a single escape.
    fn begin(&mut self, kind: u8) -> Option<StreamPart> {
        let end = match kind {
            b'1' => HEADER + 2,
            b'2' => HEADER + 7,
            b'3' | b'4' | b'5' => LONGEST,
            0xe3 => ID,
            0xe4 => UUID,
            // The second of two escapes may begin a frame.
            ESCAPE => {
                self.outside += 1;
                self.state = DeframerState::Kind;
                return None;
            }
            _ => {
                self.state = DeframerState::Outside;
                return Some(StreamPart::Malformed);
            }
        };
        self.length = 0;
        self.state = DeframerState::Inside { kind, end };
        None
    }

    fn push(&mut self, octet: u8, kind: u8, end: usize) -> Option<StreamPart> {
        self.held[self.length] = octet;
        self.length += 1;
        if self.length < end {
            return None;
        }
        self.state = DeframerState::Outside;
        let stamp = self.held[..6].iter().fold(0, |stamp, octet| stamp << 8 | u64::from(*octet));
        // A number, or a UUID in hexadecimal with hyphens.
        let id = || match kind {
            0xe3 => self.held[..ID].iter().fold(0, |id, octet| id << 8 | u128::from(*octet)),
            _ => {
                let digits = self.held[..UUID].iter().filter_map(|digit| char::from(*digit).to_digit(16));
                digits.fold(0, |id, digit| id << 4 | u128::from(digit))
            }
        };
        let message = match (kind, &self.held[HEADER..LONGEST]) {
            (b'1', _) => ModeSMessage::ModeAc,
            (b'2', octets) => ModeSMessage::Short(*octets.first_chunk()?),
            (b'3', octets) => ModeSMessage::Long(*octets.first_chunk()?),
            (b'4', octets) => ModeSMessage::Status(*octets.first_chunk()?),
            (b'5', _) => ModeSMessage::ReceiverPlace,
            _ => ModeSMessage::ReceiverId(ReceiverId(id())),
        };
        let has_stamp = !matches!(message, ModeSMessage::ReceiverPlace | ModeSMessage::ReceiverId(_));
        let stamp = (has_stamp && stamp != 0 && stamp != NO_STAMP).then_some(stamp);
        Some(StreamPart::Frame(AdsbFrame { stamp, message }))
    }

    fn take_avr(&mut self, octet: u8) -> Option<StreamPart> {
        let DeframerState::Line(mark) = self.state else {
            match octet {
                b'*' | b'@' | b'<' => self.line(octet),
                b'\r' | b'\n' => {}
                _ => self.outside += 1,
            }
            return None;
        };
        match octet {
            b'*' | b'@' | b'<' => {
                self.line(octet);
                Some(StreamPart::Cut)
            }
            b';' => {
                self.state = DeframerState::Outside;
                Some(avr(mark, &self.held[..self.length]).map_or(StreamPart::Malformed, StreamPart::Frame))
            }
            b'\r' | b'\n' => {
                self.state = DeframerState::Outside;
                Some(StreamPart::Cut)
            }
            _ if self.length == LINE => {
                self.state = DeframerState::Outside;
                Some(StreamPart::Malformed)
            }
            _ => {
                self.held[self.length] = octet;
                self.length += 1;
                None
            }
        }
    }

    fn line(&mut self, mark: u8) {
        self.length = 0;
        self.state = DeframerState::Line(mark);
    }
}

/// The frame of a line.
fn avr(mark: u8, digits: &[u8]) -> Option<AdsbFrame> {
    let octets = crate::hex::octets(str::from_utf8(digits).ok()?)?;
    let (stamp, message) = match mark {
        b'*' => (&[][..], &octets[..]),
        b'@' => octets.split_at_checked(6)?,
        // The level follows the stamp.
        _ => {
            let (header, message) = octets.split_at_checked(HEADER)?;
            (&header[..6], message)
        }
    };
    let message = match message.len() {
        2 => ModeSMessage::ModeAc,
        7 => ModeSMessage::Short(*message.first_chunk()?),
        14 => ModeSMessage::Long(*message.first_chunk()?),
        _ => return None,
    };
    let stamp = stamp.iter().fold(0, |stamp, octet| stamp << 8 | u64::from(*octet));
    Some(AdsbFrame { stamp: (stamp != 0 && stamp != NO_STAMP).then_some(stamp), message })
}

/// Encodes a frame in this framing.
#[cfg(test)]
pub(super) fn written(framing: ReceiverFraming, stamp: u64, message: &[u8]) -> Vec<u8> {
    let stamp = &stamp.to_be_bytes()[2..];
    match framing {
        ReceiverFraming::Avr => {
            format!("@{}{};\n", crate::hex::text(stamp), crate::hex::text(message)).into_bytes()
        }
        ReceiverFraming::Beast => {
            let kind = if message.len() == 2 {
                b'1'
            } else if message.len() == 7 {
                b'2'
            } else {
                b'3'
            };
            let body = stamp.iter().chain(&[0x80]).chain(message);
            let escaped =
                body.flat_map(|octet| std::iter::repeat_n(*octet, 1 + usize::from(*octet == ESCAPE)));
            [ESCAPE, kind].into_iter().chain(escaped).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pieces(framing: ReceiverFraming, octets: &[u8]) -> (Vec<StreamPart>, u64) {
        let mut deframer = Deframer::new(framing);
        let pieces = octets.iter().filter_map(|octet| deframer.take(*octet)).collect();
        (pieces, deframer.outside())
    }

    #[test]
    fn escape_within_a_frame_is_doubled() {
        let message = [0x1a, 2, 3, 0x1a, 0x1a, 6, 0x1a];
        let octets = written(ReceiverFraming::Beast, 0x1a_0000_001a, &message);
        let frame = AdsbFrame { stamp: Some(0x1a_0000_001a), message: ModeSMessage::Short(message) };
        assert_eq!(pieces(ReceiverFraming::Beast, &octets), (vec![StreamPart::Frame(frame)], 0));
    }

    #[test]
    fn receiver_frames_are_whole_and_have_no_stamp() {
        let id = [&[ESCAPE, 0xe3, 1, 2, 3, ESCAPE, ESCAPE], &[4_u8; 4][..]].concat();
        let uuid = [&[ESCAPE, 0xe4], &b"38366a5c-c54f-4256-bd0a-1557961f5ad0"[..]].concat();
        let place = [&[ESCAPE, b'5'], &[7_u8; 21][..]].concat();
        let (found, outside) = pieces(ReceiverFraming::Beast, &[id, uuid, place].concat());
        let piece = |message| StreamPart::Frame(AdsbFrame { stamp: None, message });
        let number = ModeSMessage::ReceiverId(ReceiverId(0x0102_031a_0404_0404));
        let uuid = ModeSMessage::ReceiverId(ReceiverId(0x3836_6a5c_c54f_4256_bd0a_1557_961f_5ad0));
        let expected = [number, uuid, ModeSMessage::ReceiverPlace].map(piece);
        assert_eq!((found, outside), (expected.to_vec(), 0));
    }

    #[test]
    fn avr_lines_parse_with_and_without_stamp() {
        let text = b"*5f4001594b0fbb;\r\n@0000000000105F4001594B0FBB;\n*5f40;<000000000010805f4001594b0fbb;\n*5f4;\n*5g40;";
        let short = ModeSMessage::Short([0x5f, 0x40, 0x01, 0x59, 0x4b, 0x0f, 0xbb]);
        let frame = |stamp, message| StreamPart::Frame(AdsbFrame { stamp, message });
        let expected = [
            frame(None, short),
            frame(Some(16), short),
            frame(None, ModeSMessage::ModeAc),
            frame(Some(16), short),
            StreamPart::Malformed,
            StreamPart::Malformed,
        ];
        assert_eq!(pieces(ReceiverFraming::Avr, text), (expected.to_vec(), 0));
    }

    #[test]
    fn frame_after_a_truncated_one_is_whole() {
        for framing in [ReceiverFraming::Beast, ReceiverFraming::Avr] {
            let frame = written(framing, 7, &[9; 14]);
            for length in 1..frame.len() - 1 {
                let (found, _) = pieces(framing, &[&frame[..length], &frame[..]].concat());
                let whole =
                    StreamPart::Frame(AdsbFrame { stamp: Some(7), message: ModeSMessage::Long([9; 14]) });
                // A lone escape before another one begins no frame.
                let expected = if framing == ReceiverFraming::Beast && length == 1 {
                    vec![whole]
                } else {
                    vec![StreamPart::Cut, whole]
                };
                assert_eq!(found, expected, "{framing:?}, {length} octets");
            }
        }
    }

    proptest! {
        #[test]
        fn arbitrary_octets_hide_no_following_frame(octets: Vec<u8>, message: [u8; 14]) {
            for framing in [ReceiverFraming::Beast, ReceiverFraming::Avr] {
                // Garbage whose last octets begin a frame swallows the following octets, up to the end of a frame.
                let message = message.map(|octet| octet | 0x20);
                let mut stream = octets.clone();
                (0..2).for_each(|_| stream.extend(written(framing, 5, &message)));
                let (found, _) = pieces(framing, &stream);
                let whole = StreamPart::Frame(AdsbFrame { stamp: Some(5), message: ModeSMessage::Long(message) });
                prop_assert_eq!(found.last(), Some(&whole));
            }
        }
    }
}
