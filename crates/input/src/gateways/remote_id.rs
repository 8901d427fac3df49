//! Lines of Remote ID from gateways. Each is a JSON object, with a message of 25 octets or a pack of messages in
//! hexadecimal.
//!
//! ```text
//! {"time":"2023-04-01T16:15:30.1Z","transmitter":"90:3a:e6:5b:c8:a8","rssi":-61,"receiver":"roof","message":"f01901…"}
//! ```
//!
//! `transmitter` and `message` are required; `time` is RFC 3339 or seconds since 1970, `rssi` in dBm, `receiver` the id of
//! a sensor. Radio frames are translated to such lines, too.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write;

use fusion::time::{SECOND, Time};
use jiff::Timestamp;
use remote_id::{Advertisement, French, Link, Listener, NotHeard, Transport};
use schemars::JsonSchema;
use serde::Deserialize;

use super::DropCounts;
use crate::hex;

/// Maximum length of the name of a transmitter or a receiver, in octets.
const NAME_MAX: usize = 64;
/// Maximum length of a line, in octets. It is more than three times that of the largest pack. It is less than the shortest
/// text that could be a block of category 123, which begins like a line (with a length of at least 2,304).
const LINE_MAX: usize = 2_048;
/// Octets of a message, of the header of a pack, and of the largest pack.
const MESSAGE: usize = remote_id::LENGTH;
const PACK_HEADER: usize = 3;
const PACK_MOST: usize = PACK_HEADER + remote_id::PACK_MOST as usize * MESSAGE;

/// A broadcast that a receiver has received.
#[derive(Clone, Debug, PartialEq)]
pub struct BroadcastLine {
    /// Time of reception, if the gateway states it.
    pub time: Option<Time>,
    /// Address of the transmitter, as text.
    pub transmitter: String,
    /// Signal strength, in dBm.
    pub rssi_dbm: Option<f64>,
    /// Id of the receiving sensor, if the gateway states it.
    pub receiver: Option<String>,
    /// The message or the pack.
    pub octets: Vec<u8>,
}

/// Reason for rejecting a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineRefusal {
    /// The line is not a JSON object with the required members.
    #[error("the line is no JSON object with a transmitter and a message")]
    NotAnObject,
    /// The message is not hexadecimal.
    #[error("the message of the line is not hexadecimal")]
    NotHexadecimal,
    /// The name of the transmitter or the receiver is empty, or longer than 64 octets.
    #[error("a name in the line is empty or longer than 64 octets")]
    Name,
    /// The time is neither RFC 3339 nor seconds since 1970.
    #[error("the time of the line is neither RFC 3339 nor seconds since 1970")]
    Time,
    /// The line is longer than 2,048 octets.
    #[error("the line has more than 2048 octets")]
    TooLong,
    /// The receiver is not one of the connection's sensors.
    #[error("the line names a receiver that it may not speak for")]
    Receiver,
}

fusion::interface_names!(LineRefusal {
    NotAnObject = "line_not_an_object",
    NotHexadecimal = "line_not_hexadecimal",
    Name = "line_name",
    Time = "line_time",
    TooLong = "line_too_long",
    Receiver = "line_receiver",
});

/// Names of the reasons, as used by counters.
pub const REFUSALS: [&str; 6] = LineRefusal::NAMES;

/// A broadcast of Remote ID that a gateway received. Other members are ignored.
#[derive(Deserialize, JsonSchema)]
#[schemars(rename = "RemoteIdLine")]
pub struct RemoteIdLine<'a> {
    /// Time of reception; if absent, the time at which the line arrives.
    #[serde(borrow)]
    time: Option<LineTime<'a>>,
    /// Address of the transmitter, or another name of it; at most 64 octets.
    #[serde(borrow)]
    transmitter: Cow<'a, str>,
    /// Signal strength, in dBm.
    rssi: Option<f64>,
    /// Id of the receiving sensor.
    receiver: Option<String>,
    /// The message or the pack, in hexadecimal.
    #[serde(borrow)]
    message: Cow<'a, str>,
}

/// A time.
#[derive(Deserialize, JsonSchema)]
#[schemars(inline, rename = "RemoteIdTime")]
#[serde(untagged)]
enum LineTime<'a> {
    /// Seconds since 1970.
    Seconds(f64),
    /// RFC 3339.
    #[serde(borrow)]
    Text(Cow<'a, str>),
}

impl BroadcastLine {
    /// Parses a line.
    ///
    /// # Errors
    /// The text is not a valid line.
    pub fn parse(text: &[u8]) -> Result<Self, LineRefusal> {
        if text.len() > LINE_MAX {
            return Err(LineRefusal::TooLong);
        }
        // An array of the members is rejected, because readers recognise a line by its brace.
        if text.trim_ascii_start().first() != Some(&b'{') {
            return Err(LineRefusal::NotAnObject);
        }
        let RemoteIdLine { time, transmitter, rssi, receiver, message } =
            serde_json::from_slice(text).map_err(|_| LineRefusal::NotAnObject)?;
        let is_name = |name: &str| (1..=NAME_MAX).contains(&name.len());
        if !is_name(&transmitter) || !receiver.as_deref().is_none_or(is_name) {
            return Err(LineRefusal::Name);
        }
        let time = time.map(|stamp| time_of(&stamp).ok_or(LineRefusal::Time)).transpose()?;
        let octets = hex::octets(&message).ok_or(LineRefusal::NotHexadecimal)?;
        Ok(Self { time, transmitter: transmitter.into_owned(), rssi_dbm: rssi, receiver, octets })
    }
}

fn time_of(stamp: &LineTime<'_>) -> Option<Time> {
    let nanos = match stamp {
        // Larger values exceed the range of times.
        LineTime::Seconds(seconds) if seconds.is_nan() || seconds.abs() > 9e9 => return None,
        LineTime::Seconds(seconds) => {
            let (whole, rest) = (seconds.trunc() as i128, seconds.fract());
            whole * i128::from(SECOND) + (rest * SECOND as f64).round() as i128
        }
        LineTime::Text(text) => text.parse::<Timestamp>().ok()?.as_nanosecond(),
    };
    i64::try_from(nanos).ok().map(Time::from_nanos)
}

/// Whether a datagram holds a gateway's lines, and not blocks of category 123, which begin alike and are not in use.
pub fn is_lines(payload: &[u8]) -> bool {
    payload.trim_ascii_start().first() == Some(&b'{') && asterix::blocks(payload).any(|block| block.is_err())
}

/// Lines of a datagram, without blank ones.
pub fn lines(payload: &[u8]) -> impl Iterator<Item = &[u8]> {
    payload.split(|octet| *octet == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty())
}

/// Whether a datagram is a message or a pack as broadcast by a drone, and not an ASTERIX block of the same length.
pub fn is_broadcast(payload: &[u8]) -> bool {
    let is_block = payload.get(1..3).is_some_and(|length| length == (payload.len() as u16).to_be_bytes());
    let is_whole = match *payload {
        [0xf0..=0xf2, length, count, ..] => {
            usize::from(length) == MESSAGE && payload.len() == PACK_HEADER + MESSAGE * usize::from(count)
        }
        [first, ..] => payload.len() == MESSAGE && first >> 4 <= 5 && first & 0xf <= 2,
        [] => false,
    };
    is_whole && !is_block
}

/// Lines for a radio frame received at this time, one for each advertisement in it. `listener` keeps state between frames.
///
/// # Errors
/// The frame carries no Remote ID, or was received with errors.
pub fn heard(
    listener: &mut Listener,
    link: Link,
    frame: &[u8],
    at: Option<Time>,
) -> Result<Vec<u8>, NotHeard> {
    let heard = listener.hear(link, frame)?;
    let lines: Vec<String> = heard.iter().filter_map(|heard| line_of(heard, at)).collect();
    if lines.is_empty() { Err(NotHeard::Other) } else { Ok(lines.join("\n").into_bytes()) }
}

/// Line of an advertisement; `None` for a French beacon without any value.
fn line_of(heard: &Advertisement<'_>, at: Option<Time>) -> Option<String> {
    let octets = match heard.transport {
        Transport::WifiFrench => Cow::Owned(french_pack(&heard.octets)?),
        _ => Cow::Borrowed(cut_to_claim(&heard.octets)),
    };
    let mut line = String::with_capacity(2 * octets.len() + 96);
    line.push('{');
    if let Some(stamp) = at.and_then(|at| Timestamp::from_nanosecond(at.nanos().into()).ok()) {
        let _ = write!(line, "\"time\":\"{stamp}\",");
    }
    let [first, rest @ ..] = heard.transmitter;
    let _ = write!(line, "\"transmitter\":\"{first:02x}");
    for octet in rest {
        let _ = write!(line, ":{octet:02x}");
    }
    let _ = write!(line, "\",\"message\":\"{}\"}}", hex::text(&octets));
    Some(line)
}

/// Pack for a French beacon, whose altitude is above mean sea level; it is converted to the ellipsoid with EGM96.
fn french_pack(octets: &[u8]) -> Option<Vec<u8>> {
    let french = French::new(octets)?;
    // Positions out of range are not used.
    let is_place = |[latitude, longitude]: &[f64; 2]| latitude.abs() <= 90.0 && longitude.abs() <= 180.0;
    let place = french.place_deg.filter(is_place);
    let undulation_m =
        place.map(|[latitude, longitude]| egm96::egm96_compute_altitude_offset(latitude, longitude));
    French { altitude_amsl_m: french.altitude_amsl_m.filter(|_| place.is_some()), place_deg: place, ..french }
        .pack(undulation_m.unwrap_or_default())
}

/// Removes octets after the message or pack; a pack that is shorter than its count states is left unchanged.
fn cut_to_claim(octets: &[u8]) -> &[u8] {
    let claim = match octets {
        [first, _, count, ..] if first >> 4 == 0xf => PACK_HEADER + MESSAGE * usize::from(*count),
        _ => MESSAGE,
    };
    &octets[..claim.min(octets.len()).min(PACK_MOST)]
}

/// Ids of the sensors that a connection may report for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReceiverIds(BTreeSet<String>);

impl ReceiverIds {
    /// Receivers with these ids.
    pub fn new(ids: impl IntoIterator<Item = String>) -> Self {
        Self(ids.into_iter().collect())
    }

    /// Ids of the sensors.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(String::as_str)
    }

    fn admit(&self, line: &BroadcastLine) -> Result<(), LineRefusal> {
        let is_admitted = line.receiver.as_ref().is_none_or(|receiver| self.0.contains(receiver));
        if is_admitted { Ok(()) } else { Err(LineRefusal::Receiver) }
    }
}

/// Counts of a gateway's lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RemoteIdLineCounts {
    /// Lines, without blank ones.
    pub lines: u64,
    /// Lines passed on.
    pub taken: u64,
    /// Lines rejected, by [`LineRefusal`].
    pub refused: DropCounts<{ REFUSALS.len() }>,
}

impl Default for RemoteIdLineCounts {
    fn default() -> Self {
        Self { lines: 0, taken: 0, refused: DropCounts::new(&REFUSALS) }
    }
}

impl RemoteIdLineCounts {
    /// Adds the counts of another one.
    pub fn join(&mut self, other: &Self) {
        self.lines += other.lines;
        self.taken += other.taken;
        self.refused.join(&other.refused);
    }

    /// Passes each valid line of a text to `out`, as a datagram, and counts all lines. Blank lines are ignored. A line with
    /// a receiver that is not in `receivers` is rejected.
    pub fn lines<'a>(&mut self, text: &'a [u8], receivers: &ReceiverIds, mut out: impl FnMut(&'a [u8])) {
        for line in lines(text) {
            self.lines += 1;
            match BroadcastLine::parse(line).and_then(|line| receivers.admit(&line)) {
                Ok(()) => {
                    self.taken += 1;
                    out(line);
                }
                Err(refusal) => self.refused.add(refusal as usize),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn refusal(text: &str) -> Result<(), &'static str> {
        BroadcastLine::parse(text.as_bytes()).map(|_| ()).map_err(LineRefusal::name)
    }

    #[test]
    fn invalid_lines_are_rejected_by_reason() {
        let line = BroadcastLine::parse(br#"{"time": 1680365730.25, "transmitter": "a", "rssi": -61, "receiver": "roof", "message": "10Ff"}"#);
        let expected = BroadcastLine {
            time: Some(Time::from_nanos(1_680_365_730_250_000_000)),
            transmitter: "a".to_owned(),
            rssi_dbm: Some(-61.0),
            receiver: Some("roof".to_owned()),
            octets: vec![0x10, 0xff],
        };
        assert_eq!(line, Ok(expected));
        let stamp = BroadcastLine::parse(
            br#"{"time":"2023-04-01T16:15:30.25Z","transmitter":"a","message":"10","more":[]}"#,
        );
        assert_eq!(stamp.unwrap().time, Some(Time::from_nanos(1_680_365_730_250_000_000)));
        assert_eq!(refusal(r#"{"transmitter":"a","message":"10","rssi":null,"time":null}"#), Ok(()));
        for (text, reason) in [
            ("", "line_not_an_object"),
            ("[]", "line_not_an_object"),
            ("{", "line_not_an_object"),
            (r#"[null,"a",null,null,"10"]"#, "line_not_an_object"),
            (r#"{"message":"10"}"#, "line_not_an_object"),
            (r#"{"transmitter":"","message":"10"}"#, "line_name"),
            (r#"{"transmitter":"a","receiver":"","message":"10"}"#, "line_name"),
            (r#"{"transmitter":7,"message":"10"}"#, "line_not_an_object"),
            (r#"{"transmitter":"a","message":"1"}"#, "line_not_hexadecimal"),
            (r#"{"transmitter":"a","message":"10","time":"now"}"#, "line_time"),
            (r#"{"transmitter":"a","message":"10","time":1e300}"#, "line_time"),
            (r#"{"transmitter":"a","message":"10","rssi":"-61"}"#, "line_not_an_object"),
        ] {
            assert_eq!(refusal(text), Err(reason), "{text}");
        }
        let more = |octets: usize| {
            format!(
                "{}\"}}",
                r#"{"transmitter":"a","message":"10","more":""#.to_owned() + &"x".repeat(octets)
            )
        };
        let longest = LINE_MAX - more(0).len();
        assert_eq!(
            [longest, longest + 1].map(|octets| refusal(&more(octets))),
            [Ok(()), Err("line_too_long")]
        );
    }

    #[test]
    fn pack_is_cut_to_its_claimed_length() {
        let pack = |count: u8, there: usize| [&[0xf0, 25, count][..], &vec![1; there]].concat();
        for (octets, length) in
            [(pack(1, 80), 28), (pack(2, 30), 33), (pack(0, 9), 3), (vec![0x10; 40], 25), (vec![0x10; 7], 7)]
        {
            assert_eq!(cut_to_claim(&octets).len(), length);
        }
        assert_eq!(cut_to_claim(&pack(255, 7000)).len(), PACK_MOST);
    }

    proptest! {
        /// A recorded line is recognised as such, whatever follows the brace.
        #[test]
        fn valid_line_is_a_datagram_of_lines(
            space in "[ \t\r]{0,3}",
            key in "[a-z \u{0}-\u{20}]{0,3}",
            octets in 0..LINE_MAX,
        ) {
            let fill = "x".repeat(octets);
            let text = format!(r#"{{{space}"{key}":"{fill}","transmitter":"a","message":"10"}}"#);
            if BroadcastLine::parse(text.as_bytes()).is_ok() {
                prop_assert!(is_lines(text.as_bytes()) && !is_broadcast(text.as_bytes()));
            }
        }

        #[test]
        fn invalid_line_affects_no_neighbour(bad: Vec<u8>, at in 0..4_usize) {
            let good = br#"{"transmitter":"a","message":"10"}"#;
            let mut lines = vec![&good[..]; 3];
            lines.insert(at, &bad);
            let text = lines.join(&b'\n');
            let (mut counts, mut taken) = (RemoteIdLineCounts::default(), 0);
            counts.lines(&text, &ReceiverIds::default(), |line| taken += u64::from(line == good));
            prop_assert!(taken >= 3);
            prop_assert_eq!(counts.lines, counts.taken + counts.refused.total());
        }
    }
}
