//! Events of the stream: their names, the types of their data, and their encoding.

use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde_json::{Value, json};

use super::event_text::written;
use super::integrity::IdentityJson;
use super::payload::Payload;
use super::sensors::SensorProperties;
use super::slot_json::TrackCollection;
use fusion::time::Time;
use picture::Rfc3339;
use picture::conflicts::ConflictJson;
use service::live::AlertJson;

/// Data of an event with a fixed name.
pub trait EventData: Serialize + JsonSchema {
    /// Name of the event.
    const NAME: &'static str;
}

/// Event with the whole picture, at the start of a stream.
pub const SNAPSHOT: &str = "snapshot";
/// Event with the changes of the picture.
pub const TRACKS: &str = "tracks";

/// Tracks that ended.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Ended")]
pub struct EndedTracks<'a> {
    time: Rfc3339,
    ids: Vec<&'a str>,
}

/// Sent every second with the state of the service.
#[derive(Serialize, JsonSchema)]
pub struct Heartbeat {
    /// Time of the latest slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<Rfc3339>,
    /// Sequence number of the latest slot.
    pub seq: u64,
    /// Time from the start of the slot to its publication, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency_s: Option<f64>,
    /// Delay of the picture, in seconds; present only while it is late.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
}

/// Reason why the stream starts again with a snapshot.
#[derive(Serialize, JsonSchema)]
pub struct Resync<'a> {
    pub reason: &'a str,
}

/// Reason why the stream ends.
#[derive(Serialize, JsonSchema)]
pub struct Closed<'a> {
    pub reason: &'a str,
}

impl EventData for EndedTracks<'_> {
    const NAME: &'static str = "ended";
}

impl EventData for SensorProperties {
    const NAME: &'static str = "sensor";
}

impl EventData for IdentityJson {
    const NAME: &'static str = "integrity";
}

impl EventData for AlertJson {
    const NAME: &'static str = "alert";
}

impl EventData for ConflictJson {
    const NAME: &'static str = "conflict";
}

impl EventData for Heartbeat {
    const NAME: &'static str = "heartbeat";
}

impl EventData for Resync<'_> {
    const NAME: &'static str = "resync";
}

impl EventData for Closed<'_> {
    const NAME: &'static str = "closed";
}

/// Description of an event, for the documents.
#[derive(Clone, Copy, Debug)]
pub struct EventDescription {
    /// Name of the event.
    pub name: &'static str,
    /// Occasion of the event.
    pub summary: &'static str,
    /// Schema of the data.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
}

impl EventDescription {
    const fn named<T: JsonSchema>(name: &'static str, summary: &'static str) -> Self {
        Self { name, summary, schema: SchemaGenerator::subschema_for::<T> }
    }

    const fn of<T: EventData>(summary: &'static str) -> Self {
        Self::named::<T>(T::NAME, summary)
    }
}

/// All events.
pub const ALL: [EventDescription; 10] = [
    EventDescription::named::<TrackCollection<'_>>(
        SNAPSHOT,
        "The picture: first of all, and behind each resync",
    ),
    EventDescription::named::<TrackCollection<'_>>(
        TRACKS,
        "Tracks that changed: one per slot, or per interval_ms",
    ),
    EventDescription::of::<EndedTracks<'_>>("Tracks that have not been shown for 2 s"),
    EventDescription::of::<SensorProperties>("A sensor whose state changed"),
    EventDescription::of::<IdentityJson>("A transponder whose state changed, or what an operator says of it"),
    EventDescription::of::<AlertJson>("An alert that began, changed or ended"),
    EventDescription::of::<ConflictJson>(
        "Two aircraft whose warning began, changed or ended, and each second while it lasts",
    ),
    EventDescription::of::<Heartbeat>("Each second, and when the picture becomes late or is on time again"),
    EventDescription::of::<Resync<'_>>(
        "Something was missed: what was known is void, and a snapshot follows",
    ),
    EventDescription::of::<Closed<'_>>("The last one: the service stops, or the token is no longer known"),
];

/// A message of the WebSocket: one of the events. ([`as_json`](super::event_text::as_json) writes it.)
pub struct StreamMessage;

impl JsonSchema for StreamMessage {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "StreamMessage".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let kinds: Vec<Value> = ALL.iter().map(|kind| kind.message(generator)).collect();
        schemars::json_schema!({ "description": "An event of the stream", "oneOf": kinds })
    }
}

impl EventDescription {
    /// Schema of the message.
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
    event(id, &EndedTracks { time: time.into(), ids: ids.iter().map(|id| &**id).collect() })
}

/// An event of the stream whose data is one line of JSON.
pub fn event<T: EventData>(id: &str, data: &T) -> Payload {
    let data = serde_json::to_vec(data).expect("texts, numbers and lists are written without failing");
    written(id, T::NAME, &data).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event_text::as_json;

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
