//! The text of an event, as Server-Sent Events and WebSocket messages carry it.

/// An event of the stream from data that is JSON already.
pub fn written(id: &str, name: &str, data: &[u8]) -> Vec<u8> {
    [head(id, name).as_bytes(), data, b"\n\n"].concat()
}

/// Lines of an event before its data.
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
    // Names and ids consist of letters, digits and dashes, so they need no escapes.
    [b"{\"event\":\"", name, b"\",\"id\":\"", id, b"\",\"data\":", data, b"}"].concat()
}
