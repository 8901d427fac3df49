//! State that survives a restart. `numbers.json` has the transponder numbers assigned so far, `registration.json` the
//! misalignment of each radar ([`SavedRegistrations`]), `decisions.jsonl` the operators' decisions ([`RecordedDecisions`]), and
//! `shelved.jsonl` the shelved alerts ([`AlertDecision`]). `zones/` has the zones of operators ([`ZoneStore`]). `engine.warm` has
//! the whole state of the engine, for a restart within seconds ([`WarmState`]).
//!
//! ```json
//! {"version":1,"numbers":[
//! {"number":1,"serial":"1581F6GKB23C003","country":"NO","heard":"2026-11-20T10:00:00.000Z"}
//! ]}
//! ```
//!
//! `heard`: the time of the transponder's latest point, or of one at most ten minutes before it; absent in files of earlier
//! versions. Serial and country are trimmed; octets other than printable ASCII, `\`, `'` and `"` are escaped as in Rust
//! (`\x80`). A recording's file (`<name>.numbers.json`) has the same format.

mod alerts;
mod aside;
mod atomic;
mod correlations;
#[cfg(test)]
pub(crate) mod damage;
mod engine;
mod health;
mod keeper;
mod lock;
mod registration;
mod relocations;
mod sources;
mod warm;
mod zones;

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use fusion::Identity;
use fusion::numbering::{Given, LARGEST_TRANSPONDER_NUMBER};
use fusion::report::{NAME_MAX, Space};
use fusion::time::Time;

pub use alerts::{AlertAct, AlertDecision, SHELVED, alert_line};
pub use atomic::write_atomically;
pub use correlations::{
    CORRELATIONS, CorrelationPlan, RecordedDecisions, correlation_line, kept_lines, parse_decisions,
    read_correlations, word_line,
};
pub use engine::{ENGINE, EngineState};
pub use health::{FileHealth, StateHealth};
pub use keeper::{StateContents, StateFile, StateKeeper};
pub use lock::{StateInUse, StateLock};
pub use registration::{
    REGISTRATION, SavedRegistrations, parse_registration, read_registration, registration_text,
};
pub use relocations::{relocation_line, relocation_lines};
pub use sources::{SavedState, read_beside, read_kept, read_numbers_beside};
pub use warm::{WarmFrame, WarmKeeper, WarmQueue, WarmState};
pub use zones::{MAX_ZONE_NAME, MAX_ZONES, OperatorZone, ZONES, ZoneRefusal, ZoneStore};

/// Name of the file in the directory of `[state]`.
pub const NUMBERS: &str = "numbers.json";
/// End of such a file, after the last line.
pub const NUMBERS_END: &str = "\n]}\n";
/// The only version so far.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NumbersJson {
    version: u32,
    numbers: Vec<NumberEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NumberEntry {
    number: u32,
    #[serde(default = "serial_space", skip_serializing_if = "is_serial_space")]
    space: String,
    serial: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    country: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    heard: Option<String>,
}

/// Text of a file with these numbers, one per line.
pub fn numbers_text(numbers: &[Given]) -> String {
    let lines: Vec<String> = numbers.iter().map(number_line).collect();
    format!("{{\"version\":{VERSION},\"numbers\":[\n{}{NUMBERS_END}", lines.join(",\n"))
}

/// Line of a number in such a file, without the following separator.
pub fn number_line(given: &Given) -> String {
    let entry = NumberEntry {
        number: given.number,
        space: given.identity.space().key().to_owned(),
        serial: given.identity.name().escape_ascii().to_string(),
        country: given.identity.country().escape_ascii().to_string(),
        heard: given.heard.map(|time| time.to_string()),
    };
    serde_json::to_string(&entry).expect("numbers and text are JSON")
}

/// Numbers in a file's text.
///
/// # Errors
/// What is wrong with the text: it is not JSON, of another version, or an entry is invalid.
pub fn parse_numbers(text: &str) -> Result<Vec<Given>, String> {
    let contents: NumbersJson = serde_json::from_str(text).map_err(|error| error.to_string())?;
    if contents.version != VERSION {
        return Err(format!("its version is {}, and only {VERSION} is known", contents.version));
    }
    contents.numbers.iter().map(given).collect()
}

fn given(entry: &NumberEntry) -> Result<Given, String> {
    let NumberEntry { number, space, serial, country, heard } = entry;
    let heard = match heard.as_deref().map(str::parse::<jiff::Timestamp>) {
        None => None,
        Some(Ok(stamp)) => Some(Time::from_nanos(i64::try_from(stamp.as_nanosecond()).unwrap_or(i64::MAX))),
        Some(Err(error)) => return Err(format!("number {number} of {serial:?}: \"heard\": {error}")),
    };
    match identity(space, serial, country) {
        Some(identity) if (1..=LARGEST_TRANSPONDER_NUMBER).contains(number) => {
            Ok(Given { number: *number, identity, heard })
        }
        Some(_) => Err(format!("number {number} of {serial:?} is not 1 to {LARGEST_TRANSPONDER_NUMBER}")),
        None => Err(format!("serial {serial:?} with country {country:?} is no identity")),
    }
}

fn serial_space() -> String {
    Space::Serial.key().to_owned()
}

fn is_serial_space(space: &str) -> bool {
    space == Space::Serial.key()
}

/// Identity from its space, name and country in a file.
fn identity(space: &str, name: &str, country: &str) -> Option<Identity> {
    let space = Space::ALL.into_iter().find(|known| known.key() == space)?;
    // Trailing NULs are not part of it.
    let (name, country) = (octets::<NAME_MAX>(name)?, octets::<2>(country)?);
    match space {
        Space::Serial => Identity::new(&name, Some(&country)),
        _ => Identity::of_name(space, &name).filter(|_| country == [0; 2]),
    }
}

/// Octets from the output of `escape_ascii`; `None` if there are more than `N`, or the text is something else.
fn octets<const N: usize>(text: &str) -> Option<[u8; N]> {
    let mut octets = [0; N];
    let mut places = octets.iter_mut();
    let mut rest = text.bytes();
    while let Some(octet) = rest.next() {
        let octet = match octet {
            b'\\' => match rest.next()? {
                b't' => b'\t',
                b'r' => b'\r',
                b'n' => b'\n',
                b'x' => {
                    let digit = |octet: u8| char::from(octet).to_digit(16);
                    (digit(rest.next()?)? * 16 + digit(rest.next()?)?) as u8
                }
                escaped @ (b'\\' | b'\'' | b'"') => escaped,
                _ => return None,
            },
            plain if plain.is_ascii() => plain,
            _ => return None,
        };
        *places.next()? = octet;
    }
    Some(octets)
}

/// Reads the numbers from a directory, or from such a file itself.
///
/// # Errors
/// The file cannot be read (or does not exist), or is invalid; the error names it.
pub fn read_numbers(path: &Path) -> io::Result<Vec<Given>> {
    let path = if path.is_dir() { path.join(NUMBERS) } else { path.to_owned() };
    read(&path, parse_numbers)
}

/// Maximum size of a file that is read, in octets; all transponder numbers together take less than a fifth of it.
const LARGEST: u64 = 256 << 20;

/// Reads a file; errors name it. Anything but a regular file, and larger files, are rejected: a pipe would never end, and
/// memory would not suffice.
fn read<T>(path: &Path, parse: impl FnOnce(&str) -> Result<T, String>) -> io::Result<T> {
    let named = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    let invalid = |error: &str| io::Error::new(io::ErrorKind::InvalidData, error);
    let metadata = fs::metadata(path).map_err(named)?;
    if !metadata.is_file() {
        return Err(named(invalid("it is no file")));
    }
    if metadata.len() > LARGEST {
        return Err(named(invalid("it is larger than 256 MiB")));
    }
    #[expect(clippy::disallowed_methods, reason = "the state is a file")]
    let text = fs::read_to_string(path).map_err(named)?;
    parse(&text).map_err(|error| named(invalid(&error)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_survive_any_identity_octets() {
        let given = |number, serial: &[u8; 12], country: &[u8; 2]| Given {
            number,
            identity: Identity::new(serial, Some(country)).unwrap(),
            heard: (number == 7).then_some(Time::from_nanos(1_795_168_800_250_000_000)),
        };
        let numbers = [
            given(1, b"PLAIN\0\0\0\0\0\0\0", b"NO"),
            given(429_496, b"a\"b\\c'd\n\x00\x80\xff ", b"\xff "),
            given(7, b"no country  ", b"\0\0"),
        ];
        let text = numbers_text(&numbers);
        assert!(text.contains("{\"number\":1,\"serial\":\"PLAIN\",\"country\":\"NO\"}"), "{text}");
        assert_eq!(parse_numbers(&text).unwrap(), numbers);
        assert_eq!(parse_numbers(&numbers_text(&[])).unwrap(), []);
    }

    #[test]
    fn invalid_numbers_file_is_reported() {
        let entry = |entry: &str| parse_numbers(&format!("{{\"version\":1,\"numbers\":[{entry}]}}"));
        for bad in [
            r#"{"number":0,"serial":"A"}"#,
            r#"{"number":429497,"serial":"A"}"#,
            r#"{"number":1,"serial":""}"#,
            r#"{"number":1,"serial":"0123456789abcdefghijk"}"#,
            r#"{"number":1,"space":"elsewhere","serial":"A"}"#,
            r#"{"number":1,"space":"address","serial":"4B1A2C","country":"NO"}"#,
            r#"{"number":1,"serial":"A","country":"NOR"}"#,
            r#"{"number":1,"serial":"\\q"}"#,
            r#"{"number":1,"serial":"\\x4"}"#,
            r#"{"number":1,"serial":"å"}"#,
            r#"{"number":1,"serial":"A","colour":"red"}"#,
            r#"{"number":1,"serial":"A","heard":"at ten"}"#,
        ] {
            assert!(entry(bad).is_err(), "{bad}");
        }
        assert!(entry(r#"{"number":1,"serial":"A"}"#).is_ok());
        assert!(parse_numbers("").is_err());
        let other = parse_numbers(r#"{"version":2,"numbers":[]}"#).unwrap_err();
        assert!(other.contains("version is 2"), "{other}");
    }
}
