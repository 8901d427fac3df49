//! The shapes in the OpenAPI document: of the picture and of an error.

use serde_json::{Map, Value, json};

use super::sites::REGISTERED;
use crate::picture::{Class, HORIZONTAL, VERTICAL};
use fusion::operational::Verdict;

/// The schema of a route's answer, where there is one.
pub(super) fn of(path: &str) -> Option<&'static str> {
    match path {
        "/api/v1/tracks" => Some("Tracks"),
        "/api/v1/tracks/{id}" => Some("Track"),
        "/api/v1/sensors" => Some("Sensors"),
        "/api/v1/correlations" => Some("Correlations"),
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
        "Competitor": competitor(),
        "Correlations": correlations(),
        "Sensors": sensors(),
        "SensorProperties": sensor(),
        "Registration": registration(),
        "RegistrationValue": registration_value(),
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
            "last_measurement": time("the latest one up to time, of whichever sensor; absent before the first"),
            "trail": object("with trail_s", trail, json!({})),
        }),
    )
}

fn contributor() -> Value {
    let threshold = json!({
        "join": number("a pair begins above it"),
        "part": number("and ends below it"),
    });
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
            "threshold": object("operational: of that logarithm", threshold, json!({})),
            "manual": flag("operational: an operator has said that they are one"),
            "competitors": {
                "type": "array",
                "items": { "$ref": "#/components/schemas/Competitor" },
                "maxItems": 3,
                "description": "operational, of a single track or with include=competitors: who else could be it, the likeliest first: of a radar track transponders, of a transponder radar tracks",
            },
        }),
    )
}

fn competitor() -> Value {
    object(
        "Who came near without being it",
        json!({
            "sensor": text("its configured id"),
            "log_likelihood_ratio": number("natural logarithm of how much better it explains the measurements that they are one than that they are not"),
        }),
        json!({
            "track_number": whole(),
            "uas_id": who(),
            "decorrelated": flag("an operator has said that it is not"),
        }),
    )
}

fn who() -> Value {
    let country = json!({ "registration_country": text("ISO 3166-1 alpha-2") });
    object("a transponder", json!({ "serial_number": text("") }), country)
}

fn correlations() -> Value {
    let verdicts = [Verdict::Correlated, Verdict::Decorrelated].map(Verdict::name);
    let correlation = json!({
        "sensor": text("id of the radar"),
        "track_number": whole(),
        "uas_id": who(),
        "verdict": { "type": "string", "enum": verdicts },
        "since": time("of the first slot that was put out by it"),
    });
    let list = json!({ "type": "array", "items": object("", correlation, json!({})) });
    object("What operators have decided, and is in force", json!({ "correlations": list }), json!({}))
}

fn sensors() -> Value {
    let feature = json!({
        "type": { "const": "Feature" },
        "id": text("as in the properties"),
        "geometry": { "description": "a radar's place; null for a transponder receiver" },
        "properties": { "$ref": "#/components/schemas/SensorProperties" },
    });
    let unknown = json!({
        "category": whole(),
        "sac": whole(),
        "sic": whole(),
        "own": flag("the service's own output comes back"),
        "records": whole(),
        "last_seen": time(""),
    });
    object(
        "GeoJSON, RFC 7946",
        json!({
            "type": { "const": "FeatureCollection" },
            "features": { "type": "array", "items": object("", feature, json!({})) },
            "unknown": { "type": "array", "items": object("A source that no sensor is", unknown, json!({})) },
        }),
        json!({ "time": time("of what is said of the sensors") }),
    )
}

fn sensor() -> Value {
    object(
        "What is unknown is left out",
        json!({ "id": text("as configured"), "kind": { "type": "string", "enum": ["radar", "transponder"] } }),
        json!({
            "sac": whole(),
            "sic": whole(),
            "state": { "type": "string", "enum": ["operational", "degraded", "outage"] },
            "reasons": { "type": "array", "items": text("why it is not operational") },
            "rate_hz": at_least_0("reports a second, over the last 10 s"),
            "accepted": whole(),
            "refused": { "type": "object", "additionalProperties": whole() },
            "lines": { "type": "array", "items": { "type": "object" } },
            "last_seen": time("of its last record of any kind"),
            "clock_offset_s": number("from the times it says to their reception: the least of the last ones"),
            "contested": { "type": "array", "items": contested() },
            "registration": { "$ref": "#/components/schemas/Registration" },
        }),
    )
}

fn contested() -> Value {
    let members = json!({
        "counts": text("address and port of the sender that was heard first and counts"),
        "refused": text("address and port of the sender that is refused while the other one speaks"),
        "transponders": { "type": "array", "items": text("serial number of a transponder that both report") },
    });
    object("two senders that say different things under its SAC/SIC", members, json!({}))
}

fn registration() -> Value {
    let values = |description: &str| {
        let value =
            |name: &str| (name.to_owned(), json!({ "$ref": "#/components/schemas/RegistrationValue" }));
        object(description, Value::Object(REGISTERED.into_iter().map(value).collect()), json!({}))
    };
    let mut sometimes = values("")["properties"].clone();
    let step = json!({
        "time": time("when it was found out"),
        "before": values("without the latest tracks"),
        "after": values("with them alone"),
    });
    sometimes["tracks"] = at_least_0("it rests upon, the older ones in part");
    sometimes["residual"] =
        at_least_0("1: tracks differ as the configured errors let expect; above 4: doubtful");
    sometimes["alarm"] = text("what to look at after a step, until it is an hour old");
    sometimes["hint"] = text("what to look at where it is doubtful");
    sometimes["step"] = object("the latest since the start: the radar may have been moved", step, json!({}));
    object(
        "How a radar is set up wrongly, as its tracks tell; operational profile only, and without values where it is off",
        json!({
            "mode": { "type": "string", "enum": ["off", "propose", "apply"] },
            "applied": flag("whether plots are put right by any of it"),
        }),
        sometimes,
    )
}

fn registration_value() -> Value {
    object(
        "A bias: measured minus true",
        json!({
            "value": number("0 where a tilt is not observable"),
            "deviation": at_least_0("one standard deviation"),
            "observable": flag("whether the tracks tell it well enough to be of use; only then it is applied"),
        }),
        json!({}),
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
