//! The shapes in the OpenAPI document: of the picture and of an error.

use serde_json::{Map, Value, json};

use crate::picture::{Class, HORIZONTAL, VERTICAL};

/// The schema of a route's answer, where there is one.
pub(super) fn of(path: &str) -> Option<&'static str> {
    match path {
        "/api/v1/tracks" => Some("Tracks"),
        "/api/v1/tracks/{id}" => Some("Track"),
        _ => None,
    }
}

/// All schemas by name.
pub(super) fn all() -> Value {
    json!({
        "Problem": problem(),
        "Tracks": tracks(),
        "Track": track(),
        "TrackProperties": properties(),
        "Contributor": contributor(),
    })
}

/// An object with no other properties than these; those that are not named as optional are always there.
fn object(description: &str, always: Value, sometimes: Value) -> Value {
    let required: Vec<String> = always.as_object().map_or_else(Vec::new, |all| all.keys().cloned().collect());
    let mut properties = Map::new();
    for fields in [always, sometimes] {
        if let Value::Object(fields) = fields {
            properties.extend(fields);
        }
    }
    json!({
        "type": "object",
        "description": description,
        "required": required,
        "properties": properties,
        "additionalProperties": false,
    })
}

fn number(description: &str) -> Value {
    json!({ "type": "number", "description": description })
}

fn at_least_0(description: &str) -> Value {
    json!({ "type": "number", "minimum": 0, "description": description })
}

fn share(description: &str) -> Value {
    json!({ "type": "number", "minimum": 0, "maximum": 1, "description": description })
}

fn text(description: &str) -> Value {
    json!({ "type": "string", "description": description })
}

fn flag(description: &str) -> Value {
    json!({ "type": "boolean", "description": description })
}

fn whole() -> Value {
    json!({ "type": "integer", "minimum": 0 })
}

fn time(description: &str) -> Value {
    json!({ "type": "string", "format": "date-time", "description": description })
}

fn place() -> Value {
    json!({
        "type": "array",
        "items": { "type": "number" },
        "minItems": 2,
        "maxItems": 3,
        "description": "longitude, latitude, and the height above the ellipsoid where it is known",
    })
}

fn classes(description: &str, classes: &[Class]) -> Value {
    let names: Vec<&str> = classes.iter().map(|class| class.name).collect();
    json!({ "type": "string", "enum": names, "description": description })
}

fn tracks() -> Value {
    object(
        "GeoJSON, RFC 7946",
        json!({
            "type": { "const": "FeatureCollection" },
            "seq": whole(),
            "site": text("its configured name"),
            "numberMatched": whole(),
            "numberReturned": whole(),
            "features": { "type": "array", "items": { "$ref": "#/components/schemas/Track" } },
        }),
        json!({
            "time": time("of the tracks: the centre of the slot"),
            "published_at": time("when the slot was put out"),
            "latency_s": number("from the opening of the slot to its publication"),
        }),
    )
}

fn track() -> Value {
    let geometry = json!({ "type": { "const": "Point" }, "coordinates": place() });
    object(
        "GeoJSON, RFC 7946",
        json!({
            "type": { "const": "Feature" },
            "id": text("as in the properties"),
            "geometry": object("", geometry, json!({})),
            "properties": { "$ref": "#/components/schemas/TrackProperties" },
        }),
        json!({}),
    )
}

fn properties() -> Value {
    let trail = json!({
        "times": { "type": "array", "items": time("") },
        "coordinates": { "type": "array", "items": place() },
    });
    let uas = json!({
        "manufacturer": text(""),
        "model": text(""),
        "registration_country": text("ISO 3166-1 alpha-2"),
    });
    object(
        "What is unknown is left out. In the reference profile that is how it moves and how well that is known.",
        json!({
            "id": text("operational: one an aircraft, U-…; reference: F-…, R-…, T-…, which change with its sources"),
            "source": { "type": "string", "enum": ["fused", "radar", "transponder"] },
            "track_number": whole(),
            "state": { "type": "string", "enum": ["active", "coasting"], "description": "coasting: nothing has been measured since, the place is extrapolated" },
            "time": time("of the position"),
            "age_s": number("from that to its publication"),
            "lat": number("WGS-84, degrees"),
            "lng": number("WGS-84, degrees"),
            "geoid_separation": number("geoid above ellipsoid, metres"),
            "interpolated": flag("operational: the place lies between two measurements; reference: there is a transponder"),
            "extrapolated": flag("the place lies after the last measurement"),
            "first_seen": time("centre of the first slot with it"),
            "contributors": { "type": "array", "items": { "$ref": "#/components/schemas/Contributor" } },
        }),
        json!({
            "alt": number("metres above the ellipsoid, where a height was measured"),
            "alt_msl": number("metres above mean sea level, where a height was measured"),
            "speed": at_least_0("over ground, metres a second"),
            "track": { "type": "number", "minimum": 0, "exclusiveMaximum": 360, "description": "direction over ground, degrees true; left out where it could be any" },
            "vertical_speed": number("metres a second, up"),
            "accuracy_h_m": at_least_0("radius that holds 95 % of the horizontal error, as the filter knows it, metres"),
            "accuracy_v_m": at_least_0("95 % of the vertical error are smaller, metres"),
            "accuracy_h": classes("its class in ASTM F3411", &HORIZONTAL),
            "accuracy_v": classes("its class in ASTM F3411", &VERTICAL),
            "uav_probability": share("that it is a drone, as the radar says"),
            "uas_id": object("", json!({ "serial_number": text("") }), uas),
            "last_measurement": time("the latest one up to time, of whichever sensor"),
            "trail": object("with trail_s", trail, json!({})),
        }),
    )
}

fn contributor() -> Value {
    object(
        "A sensor's part, and of a fused track's radar why",
        json!({
            "kind": { "type": "string", "enum": ["radar", "transponder"] },
            "sensor": text("its configured id"),
            "track_number": whole(),
        }),
        json!({
            "time": time("of its measurement"),
            "weight": share("its share in the position, where that is a fixed one"),
            "height_measured": flag("whether the radar measured a height"),
            "distance_m": at_least_0("between radar and transponder, metres"),
            "threshold_m": at_least_0("reference: within which they have to stay, metres"),
            "ratio": share("reference: of the slots, in how many they did"),
            "within": whole(),
            "co_present": whole(),
            "log_likelihood_ratio": number("operational: natural logarithm of how much better it explains the measurements that they are one than that they are not"),
        }),
    )
}

fn problem() -> Value {
    json!({
        "type": "object",
        "description": "RFC 9457",
        "required": ["type", "title", "status", "detail"],
        "properties": {
            "type": { "type": "string" },
            "title": { "type": "string" },
            "status": { "type": "integer" },
            "detail": { "type": "string" },
            "parameter": { "type": "string", "description": "the parameter at fault" },
            "reasons": { "type": "array", "items": { "type": "string" } },
            "retry_after_s": { "type": "integer" },
        },
    })
}
