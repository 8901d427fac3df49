//! The events of the stream: their names, each with the type of its data, and how they are written.

use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde_json::{Value, json};

use super::integrity::IdentityJson;
use super::payload::Payload;
use super::shown::Tracks;
use super::sites::SensorProperties;
use crate::conflicts::ConflictJson;
use crate::live::AlertJson;
use crate::picture::Rfc3339;
use fusion::time::Time;

/// The data of an event, which go by one name.
pub trait Data: Serialize + JsonSchema {
    /// Of the event.
    const NAME: &'static str;
}

/// The picture as a stream begins.
pub const SNAPSHOT: &str = "snapshot";
/// What has changed in it.
pub const TRACKS: &str = "tracks";

/// Tracks that ended.
#[derive(Serialize, JsonSchema)]
pub struct Ended<'a> {
    time: Rfc3339,
    ids: Vec<&'a str>,
}

/// Each second: that the service lives, and how it is.
#[derive(Serialize, JsonSchema)]
pub struct Heartbeat {
    /// Of the latest slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<Rfc3339>,
    /// Of the latest slot.
    pub seq: u64,
    /// From the opening of the slot to its publication, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency_s: Option<f64>,
    /// While the picture is late: by how much, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
}

/// Why everything begins anew.
#[derive(Serialize, JsonSchema)]
pub struct Resync<'a> {
    pub reason: &'a str,
}

/// Why the stream ends.
#[derive(Serialize, JsonSchema)]
pub struct Closed<'a> {
    pub reason: &'a str,
}

impl Data for Ended<'_> {
    const NAME: &'static str = "ended";
}

impl Data for SensorProperties {
    const NAME: &'static str = "sensor";
}

impl Data for IdentityJson {
    const NAME: &'static str = "integrity";
}

impl Data for AlertJson {
    const NAME: &'static str = "alert";
}

impl Data for ConflictJson {
    const NAME: &'static str = "conflict";
}

impl Data for Heartbeat {
    const NAME: &'static str = "heartbeat";
}

impl Data for Resync<'_> {
    const NAME: &'static str = "resync";
}

impl Data for Closed<'_> {
    const NAME: &'static str = "closed";
}

/// An event as documents describe it.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// When it comes.
    pub summary: &'static str,
    /// Of its data.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
}

impl Kind {
    const fn named<T: JsonSchema>(name: &'static str, summary: &'static str) -> Self {
        Self { name, summary, schema: SchemaGenerator::subschema_for::<T> }
    }

    const fn of<T: Data>(summary: &'static str) -> Self {
        Self::named::<T>(T::NAME, summary)
    }
}

/// All events.
pub const ALL: [Kind; 10] = [
    Kind::named::<Tracks<'_>>(SNAPSHOT, "The picture: first of all, and behind each resync"),
    Kind::named::<Tracks<'_>>(TRACKS, "Tracks that changed: one per slot, or per interval_ms"),
    Kind::of::<Ended<'_>>("Tracks that have not been shown for 2 s"),
    Kind::of::<SensorProperties>("A sensor whose state changed"),
    Kind::of::<IdentityJson>("A transponder whose state changed, or what an operator says of it"),
    Kind::of::<AlertJson>("An alert that began, changed or ended"),
    Kind::of::<ConflictJson>(
        "Two aircraft whose warning began, changed or ended, and each second while it lasts",
    ),
    Kind::of::<Heartbeat>("Each second, and when the picture becomes late or is on time again"),
    Kind::of::<Resync<'_>>("Something was missed: what was known is void, and a snapshot follows"),
    Kind::of::<Closed<'_>>("The last one: the service stops, or the token is no longer known"),
];

/// A message of the WebSocket: any of the events. (It is written as [`as_json`] has it.)
pub struct Message;

impl JsonSchema for Message {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "StreamMessage".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let kinds: Vec<Value> = ALL.iter().map(|kind| kind.message(generator)).collect();
        schemars::json_schema!({ "description": "An event of the stream", "oneOf": kinds })
    }
}

impl Kind {
    /// The schema of the message that it is.
    pub fn message(&self, generator: &mut SchemaGenerator) -> Value {
        let data = (self.schema)(generator);
        json!({
            "type": "object",
            "description": self.summary,
            "properties": { "event": { "const": self.name }, "id": { "type": "string" }, "data": data },
            "required": ["event", "id", "data"],
        })
    }
}

/// The `ended` event.
pub fn ended(id: &str, time: Time, ids: &[Arc<str>]) -> Payload {
    event(id, &Ended { time: time.into(), ids: ids.iter().map(|id| &**id).collect() })
}

/// An event of the stream, of one line of JSON.
pub fn event<T: Data>(id: &str, data: &T) -> Payload {
    let data = serde_json::to_vec(data).expect("texts, numbers and lists are written without failing");
    written(id, T::NAME, &data).into()
}

/// The same, of JSON that was written before.
pub fn written(id: &str, name: &str, data: &[u8]) -> Vec<u8> {
    [head(id, name).as_bytes(), data, b"\n\n"].concat()
}

/// The lines of an event up to its data.
pub fn head(id: &str, name: &str) -> String {
    format!("id: {id}\nevent: {name}\ndata: ")
}

/// An event as one JSON text `{"event":…,"id":…,"data":…}`.
pub fn as_json(event: &[u8]) -> Vec<u8> {
    let lines = event.strip_prefix(b"id: ").and_then(|rest| rest.strip_suffix(b"\n\n"));
    let mut parts = lines.unwrap_or_default().splitn(3, |&octet| octet == b'\n');
    let [id, name, data] = [b"".as_slice(), b"event: ", b"data: "].map(|label| {
        parts.next().and_then(|line| line.strip_prefix(label)).expect("an event has three lines")
    });
    // Names and ids are of letters, digits and dashes.
    [b"{\"event\":\"", name, b"\",\"id\":\"", id, b"\",\"data\":", data, b"}"].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_the_same_as_one_text() {
        let event = event("17-4", &Closed { reason: "id: 5\nevent: \"x\"" }).plain();
        assert_eq!(
            event,
            b"id: 17-4\nevent: closed\ndata: {\"reason\":\"id: 5\\nevent: \\\"x\\\"\"}\n\n".as_slice()
        );
        let json: Value = serde_json::from_slice(&as_json(&event)).unwrap();
        assert_eq!(
            json,
            json!({ "event": "closed", "id": "17-4", "data": { "reason": "id: 5\nevent: \"x\"" } })
        );
    }
}
