//! Frames of a 1090 MHz receiver in a stream of octets: Beast (binary) and AVR (text), as readsb and dump1090 send them.

/// How a receiver hands on what it hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Framing {
    /// An octet 1a, the kind, a stamp of 6 octets, the level, the message; 1a doubled within. Usually port 30005. Kinds that
    /// identify a receiver have neither stamp nor level.
    Beast,
    /// `*`, the message in hexadecimal, `;`; or `@` and a stamp of 12 digits before it. Usually port 30002.
    Avr,
}

/// What a frame carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// A reply in Mode A or C.
    ModeAc,
    /// A short reply or squitter in Mode S.
    Short([u8; 7]),
    /// A long one.
    Long([u8; 14]),
    /// The receiver's settings and state (kind `4`).
    Status([u8; 14]),
    /// The receiver's position (kind `5`).
    ReceiverPlace,
    /// The identity of the receiver that the next frame, or the whole stream, comes from (kinds e3 and e4 of readsb).
    ReceiverId(ReceiverId),
}

/// Identity of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ReceiverId(pub u128);

/// A frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The receiver's stamp at its end, where there is one: a counter of 12 MHz, or seconds of the day and nanoseconds.
    pub stamp: Option<u64>,
    /// What it carries.
    pub message: Message,
}

/// What a stream holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// A whole frame.
    Frame(Frame),
    /// The beginning of one: another began before it ended.
    Cut,
    /// A frame that is none: of a kind, a length or with characters that do not exist.
    Malformed,
}

/// Counts of the stamp in a second.
pub const STAMP_HZ: i64 = 12_000_000;
/// What begins every Beast frame.
const ESCAPE: u8 = 0x1a;
/// Octets of the stamp and the level.
const HEADER: usize = 7;
/// Octets of the longest frame with a message, behind its kind.
const LONGEST: usize = HEADER + 14;
/// Octets of the longest frame behind its kind, escapes undone.
pub(crate) const BODY_MOST: usize = UUID;
/// Octets of a receiver's identity as a number, and as the text of a UUID.
const ID: usize = 8;
const UUID: usize = 36;
/// Characters of the longest line between its marks: stamp, level, message.
const LINE: usize = 12 + 2 + 28;
/// A stamp that says that there is none: `MLAT` behind ff 00.
const NO_STAMP: u64 = 0xff00_4d4c_4154;

/// Takes a stream apart, an octet at a time; holds no more than one frame.
#[derive(Clone, Debug)]
pub struct Deframer {
    framing: Framing,
    state: State,
    held: [u8; LINE],
    length: usize,
    outside: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Between frames.
    Outside,
    /// Behind an escape between frames.
    Kind,
    /// In a Beast frame that ends at this length.
    Inside { kind: u8, end: usize },
    /// Behind an escape in it.
    Escaped { kind: u8, end: usize },
    /// In a line that began with this mark.
    Line(u8),
}

impl Deframer {
    /// Before the first octet.
    pub fn new(framing: Framing) -> Self {
        Self { framing, state: State::Outside, held: [0; LINE], length: 0, outside: 0 }
    }

    /// Octets so far that belong to no frame.
    pub fn outside(&self) -> u64 {
        self.outside
    }

    /// Whether a frame has begun and not ended.
    pub fn is_within(&self) -> bool {
        self.state != State::Outside
    }

    /// Forgets a frame that has begun.
    pub fn restart(&mut self) {
        self.state = State::Outside;
    }

    /// The next octet; what it ends, if anything.
    pub fn take(&mut self, octet: u8) -> Option<Piece> {
        match self.framing {
            Framing::Beast => self.take_beast(octet),
            Framing::Avr => self.take_avr(octet),
        }
    }

    fn take_beast(&mut self, octet: u8) -> Option<Piece> {
        match self.state {
            State::Outside if octet == ESCAPE => self.state = State::Kind,
            State::Outside => self.outside += 1,
            State::Kind => return self.begin(octet),
            State::Inside { kind, end } if octet == ESCAPE => self.state = State::Escaped { kind, end },
            State::Inside { kind, end } => return self.push(octet, kind, end),
            State::Escaped { kind, end } if octet == ESCAPE => {
                self.state = State::Inside { kind, end };
                return self.push(octet, kind, end);
            }
            // Another frame begins, or garbage.
            State::Escaped { .. } => {
                self.begin(octet);
                return Some(Piece::Cut);
            }
            State::Line(_) => self.state = State::Outside,
        }
        None
    }

    /// The octet behind an escape that stands for itself.
    fn begin(&mut self, kind: u8) -> Option<Piece> {
        let end = match kind {
            b'1' => HEADER + 2,
            b'2' => HEADER + 7,
            b'3' | b'4' | b'5' => LONGEST,
            0xe3 => ID,
            0xe4 => UUID,
            // Of two escapes the second may begin a frame.
            ESCAPE => {
                self.outside += 1;
                self.state = State::Kind;
                return None;
            }
            _ => {
                self.state = State::Outside;
                return Some(Piece::Malformed);
            }
        };
        self.length = 0;
        self.state = State::Inside { kind, end };
        None
    }

    fn push(&mut self, octet: u8, kind: u8, end: usize) -> Option<Piece> {
        self.held[self.length] = octet;
        self.length += 1;
        if self.length < end {
            return None;
        }
        self.state = State::Outside;
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
            (b'1', _) => Message::ModeAc,
            (b'2', octets) => Message::Short(*octets.first_chunk()?),
            (b'3', octets) => Message::Long(*octets.first_chunk()?),
            (b'4', octets) => Message::Status(*octets.first_chunk()?),
            (b'5', _) => Message::ReceiverPlace,
            _ => Message::ReceiverId(ReceiverId(id())),
        };
        let has_stamp = !matches!(message, Message::ReceiverPlace | Message::ReceiverId(_));
        let stamp = (has_stamp && stamp != 0 && stamp != NO_STAMP).then_some(stamp);
        Some(Piece::Frame(Frame { stamp, message }))
    }

    fn take_avr(&mut self, octet: u8) -> Option<Piece> {
        let State::Line(mark) = self.state else {
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
                Some(Piece::Cut)
            }
            b';' => {
                self.state = State::Outside;
                Some(avr(mark, &self.held[..self.length]).map_or(Piece::Malformed, Piece::Frame))
            }
            b'\r' | b'\n' => {
                self.state = State::Outside;
                Some(Piece::Cut)
            }
            _ if self.length == LINE => {
                self.state = State::Outside;
                Some(Piece::Malformed)
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
        self.state = State::Line(mark);
    }
}

/// The frame of a line.
fn avr(mark: u8, digits: &[u8]) -> Option<Frame> {
    let octets = crate::hex::octets(str::from_utf8(digits).ok()?)?;
    let (stamp, message) = match mark {
        b'*' => (&[][..], &octets[..]),
        b'@' => octets.split_at_checked(6)?,
        // The level stands behind the stamp.
        _ => {
            let (header, message) = octets.split_at_checked(HEADER)?;
            (&header[..6], message)
        }
    };
    let message = match message.len() {
        2 => Message::ModeAc,
        7 => Message::Short(*message.first_chunk()?),
        14 => Message::Long(*message.first_chunk()?),
        _ => return None,
    };
    let stamp = stamp.iter().fold(0, |stamp, octet| stamp << 8 | u64::from(*octet));
    Some(Frame { stamp: (stamp != 0 && stamp != NO_STAMP).then_some(stamp), message })
}

/// A frame as a receiver with this framing sends it.
#[cfg(test)]
pub(super) fn written(framing: Framing, stamp: u64, message: &[u8]) -> Vec<u8> {
    let stamp = &stamp.to_be_bytes()[2..];
    match framing {
        Framing::Avr => format!("@{}{};\n", crate::hex::text(stamp), crate::hex::text(message)).into_bytes(),
        Framing::Beast => {
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

    fn pieces(framing: Framing, octets: &[u8]) -> (Vec<Piece>, u64) {
        let mut deframer = Deframer::new(framing);
        let pieces = octets.iter().filter_map(|octet| deframer.take(*octet)).collect();
        (pieces, deframer.outside())
    }

    #[test]
    fn an_escape_within_a_frame_is_doubled() {
        let message = [0x1a, 2, 3, 0x1a, 0x1a, 6, 0x1a];
        let octets = written(Framing::Beast, 0x1a_0000_001a, &message);
        let frame = Frame { stamp: Some(0x1a_0000_001a), message: Message::Short(message) };
        assert_eq!(pieces(Framing::Beast, &octets), (vec![Piece::Frame(frame)], 0));
    }

    #[test]
    fn receiver_frames_are_whole_and_have_no_stamp() {
        let id = [&[ESCAPE, 0xe3, 1, 2, 3, ESCAPE, ESCAPE], &[4_u8; 4][..]].concat();
        let uuid = [&[ESCAPE, 0xe4], &b"38366a5c-c54f-4256-bd0a-1557961f5ad0"[..]].concat();
        let place = [&[ESCAPE, b'5'], &[7_u8; 21][..]].concat();
        let (found, outside) = pieces(Framing::Beast, &[id, uuid, place].concat());
        let piece = |message| Piece::Frame(Frame { stamp: None, message });
        let number = Message::ReceiverId(ReceiverId(0x0102_031a_0404_0404));
        let uuid = Message::ReceiverId(ReceiverId(0x3836_6a5c_c54f_4256_bd0a_1557_961f_5ad0));
        let expected = [number, uuid, Message::ReceiverPlace].map(piece);
        assert_eq!((found, outside), (expected.to_vec(), 0));
    }

    #[test]
    fn lines_with_a_stamp_and_without() {
        let text = b"*5f4001594b0fbb;\r\n@0000000000105F4001594B0FBB;\n*5f40;<000000000010805f4001594b0fbb;\n*5f4;\n*5g40;";
        let short = Message::Short([0x5f, 0x40, 0x01, 0x59, 0x4b, 0x0f, 0xbb]);
        let frame = |stamp, message| Piece::Frame(Frame { stamp, message });
        let expected = [
            frame(None, short),
            frame(Some(16), short),
            frame(None, Message::ModeAc),
            frame(Some(16), short),
            Piece::Malformed,
            Piece::Malformed,
        ];
        assert_eq!(pieces(Framing::Avr, text), (expected.to_vec(), 0));
    }

    #[test]
    fn the_frame_behind_a_cut_one_is_whole() {
        for framing in [Framing::Beast, Framing::Avr] {
            let frame = written(framing, 7, &[9; 14]);
            for length in 1..frame.len() - 1 {
                let (found, _) = pieces(framing, &[&frame[..length], &frame[..]].concat());
                let whole = Piece::Frame(Frame { stamp: Some(7), message: Message::Long([9; 14]) });
                // One escape in front of another begins nothing.
                let expected = if framing == Framing::Beast && length == 1 {
                    vec![whole]
                } else {
                    vec![Piece::Cut, whole]
                };
                assert_eq!(found, expected, "{framing:?}, {length} octets");
            }
        }
    }

    proptest! {
        #[test]
        fn any_octets_hold_at_most_a_frame_and_the_next_one_is_found(octets: Vec<u8>, message: [u8; 14]) {
            for framing in [Framing::Beast, Framing::Avr] {
                // Garbage whose last octets begin a frame takes the next ones with it, up to the end of a frame.
                let message = message.map(|octet| octet | 0x20);
                let mut stream = octets.clone();
                (0..2).for_each(|_| stream.extend(written(framing, 5, &message)));
                let (found, _) = pieces(framing, &stream);
                let whole = Piece::Frame(Frame { stamp: Some(5), message: Message::Long(message) });
                prop_assert_eq!(found.last(), Some(&whole));
            }
        }
    }
}
