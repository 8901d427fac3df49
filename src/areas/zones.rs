//! UAS zones of ED-318 and ED-269: what a zone says of heights, times, circles and conditions is not honoured yet, and an
//! area that ignored it would be wrong without a word. So a file that says such a thing is refused, by the member's name.

use serde_json::Value;

/// The members that limit a zone, without regard to case, and what they limit. What only describes a zone is not here.
const LIMITS: [(&str, &str); 13] = [
    ("layer", "heights"),
    ("verticalLayer", "heights"),
    ("lowerLimit", "heights"),
    ("upperLimit", "heights"),
    ("extent", "a circle"),
    ("horizontalProjection", "the shape, as ED-269 has it"),
    ("limitedApplicability", "times"),
    ("applicability", "times"),
    ("startDateTime", "times"),
    ("endDateTime", "times"),
    ("validFrom", "times"),
    ("validTo", "times"),
    ("restrictionConditions", "conditions"),
];
/// Of ED-318, `type`; of ED-269, `restriction`: a zone that tracks may be in, always or under conditions. `PROHIBITED` is
/// what an area is.
const PERMITTED: [&str; 4] = ["REQ_AUTHORIZATION", "REQ_AUTHORISATION", "CONDITIONAL", "NO_RESTRICTION"];
/// Members whose values bear the names above by chance only, or not at all.
const PLAIN: [&str; 2] = ["coordinates", "bbox"];

/// What a file says of a zone that cannot be honoured, with the first feature that says it, and what to do; `None` where
/// there is no such thing.
pub(super) fn refused(file: &Value) -> Option<String> {
    let list = |name: &str| file.get(name).and_then(Value::as_array);
    let (features, is_ed_269) = match (list("features"), list("UASZoneList")) {
        (Some(features), _) => (features.as_slice(), false),
        (None, Some(zones)) => (zones.as_slice(), true),
        (None, None) => (&[][..], false),
    };
    let mut parts = Vec::new();
    if is_ed_269 {
        parts.push("UASZoneList (zones of ED-269)".to_owned());
    }
    // Of the file itself, or of its only feature.
    parts.extend(limits(file.as_object().into_iter().flatten().filter(|(name, _)| *name != "features")));
    let mut limited = features.iter().enumerate().filter_map(|(index, feature)| {
        let found = limits(feature.as_object().into_iter().flatten());
        (!found.is_empty()).then(|| format!("feature {}{}: {}", index + 1, name(feature), found.join(", ")))
    });
    parts.extend(limited.next());
    let more = limited.count();
    if more > 0 {
        parts.push(format!("further features with such members: {more}"));
    }
    (!parts.is_empty()).then(|| {
        format!(
            "holds members of UAS zones (ED-318, ED-269) that are not supported: {}. An area of this service is polygons, \
             and holds at every height, at all times and for every track. Where that is wanted, remove these members from a \
             copy of the file, or the features that have them; polygons have to be GeoJSON",
            parts.join("; ")
        )
    })
}

/// Which of these members limit a zone.
fn limits<'a>(members: impl Iterator<Item = (&'a String, &'a Value)>) -> Vec<String> {
    let mut found = Vec::new();
    for (name, value) in members.filter(|(name, _)| *name != "UASZoneList") {
        note(name, name, value, &mut found);
    }
    found.sort();
    found
}

/// Adds the member at `path` to `found` if it limits a zone, or else those inside it.
fn note(path: &str, name: &str, value: &Value, found: &mut Vec<String>) {
    let is = |other: &str| name.eq_ignore_ascii_case(other);
    if is_blank(value) || PLAIN.iter().any(|plain| is(plain)) {
        return;
    }
    if let Some((_, limited)) = LIMITS.iter().find(|(limit, _)| is(limit))
        && is_of_a_zone(path, name, value)
    {
        found.push(format!("{path} ({limited})"));
        return;
    }
    if (is("type") || is("restriction"))
        && let Some(permitted) = value.as_str().filter(|text| PERMITTED.contains(text))
    {
        found.push(format!("{path} {permitted} (conditions)"));
        return;
    }
    match value {
        Value::Object(members) => {
            for (name, value) in members {
                note(&format!("{path}.{name}"), name, value, found);
            }
        }
        Value::Array(values) => {
            for (index, value) in values.iter().enumerate().filter(|(_, value)| value.is_object()) {
                note(&format!("{path}[{index}]"), "", value, found);
            }
        }
        _ => {}
    }
}

/// Whether a member that has the name of a limit is one. Other GeoJSON has a `layer` that is a number or a name, and dates
/// from which on a road is a road.
fn is_of_a_zone(path: &str, name: &str, value: &Value) -> bool {
    let is_one_of = |names: &[&str]| names.iter().any(|other| name.eq_ignore_ascii_case(other));
    if is_one_of(&["layer", "extent"]) {
        return value.is_object();
    }
    !is_one_of(&["validFrom", "validTo"]) || path.to_ascii_lowercase().contains("metadata.")
}

/// Says nothing: national files have members that are null or empty for "no limit".
fn is_blank(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::String(text) => text.trim().is_empty(),
        Value::Array(values) => values.iter().all(is_blank),
        Value::Object(members) => members.values().all(is_blank),
        Value::Bool(_) | Value::Number(_) => false,
    }
}

/// What a feature calls itself, in brackets.
fn name(feature: &Value) -> String {
    let places = [
        "/properties/identifier",
        "/properties/UASZone/identifier",
        "/identifier",
        "/properties/name",
        "/name",
    ];
    let text = places.iter().find_map(|place| feature.pointer(place).and_then(Value::as_str));
    text.map_or_else(String::new, |text| format!(" ({text:?})"))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn feature(geometry: &Value, properties: &Value) -> Value {
        json!({ "type": "Feature", "geometry": geometry, "properties": properties })
    }

    #[test]
    fn plain_geojson_is_as_it_was() {
        let ring = json!({ "type": "Polygon", "coordinates": [[[10, 50], [11, 50], [11, 51], [10, 50]]] });
        let properties = [
            json!({ "name": "a road", "type": "motorway", "layer": 1, "validFrom": "2019-01-01" }),
            json!({ "layer": "masks", "extent": [10, 50, 11, 51], "reason": "birds", "message": "" }),
            // A zone that says nothing of limits is an area.
            json!({ "identifier": "A1", "type": "PROHIBITED", "restrictionConditions": null,
                "limitedApplicability": [{ "startDateTime": "", "schedule": [] }] }),
            Value::Null,
        ];
        let features: Vec<Value> = properties.iter().map(|properties| feature(&ring, properties)).collect();
        assert_eq!(
            refused(&json!({ "type": "FeatureCollection", "name": "all", "features": features })),
            None
        );
        assert_eq!(refused(&ring), None);
        assert_eq!(refused(&json!({})), None);
    }

    #[test]
    fn each_limit_is_named_with_its_feature() {
        let ring = json!({ "type": "Polygon", "coordinates": [[[10, 50], [11, 50], [11, 51], [10, 50]]] });
        let layered = json!({ "type": "Polygon", "coordinates": ring["coordinates"],
            "layer": { "upper": 120, "upperReference": "AGL", "uom": "m" } });
        let circle = json!({ "type": "Point", "coordinates": [10, 50], "extent": { "subType": "Circle", "radius": 9 } });
        let none = json!({});
        for (feature, told) in [
            (feature(&layered, &none), "feature 1: geometry.layer (heights)."),
            (
                feature(&json!({ "type": "GeometryCollection", "geometries": [ring, layered] }), &none),
                "feature 1: geometry.geometries[1].layer (heights).",
            ),
            (
                feature(&circle, &json!({ "identifier": "C" })),
                "feature 1 (\"C\"): geometry.extent (a circle).",
            ),
            (
                feature(
                    &ring,
                    &json!({ "verticalLayer": { "UOM": "M", "upper": "900" }, "UASZone": { "identifier": "LEBZ45", "type": "CONDITIONAL" } }),
                ),
                "feature 1 (\"LEBZ45\"): properties.UASZone.type CONDITIONAL (conditions), properties.verticalLayer (heights).",
            ),
            (
                feature(
                    &ring,
                    &json!({ "restrictionconditions": "by day", "limitedApplicability": [{ "endDateTime": "2027-01-01T00:00:00Z" }] }),
                ),
                "feature 1: properties.limitedApplicability (times), properties.restrictionconditions (conditions).",
            ),
            (
                json!({ "identifier": "Z", "restriction": "PROHIBITED", "applicability": [{ "permanent": "NO" }],
                    "geometry": [{ "lowerLimit": 0, "horizontalProjection": { "type": "Circle" } }] }),
                "feature 1 (\"Z\"): applicability (times), geometry[0].horizontalProjection (the shape, as ED-269 has it), geometry[0].lowerLimit (heights).",
            ),
        ] {
            let collection = json!({ "type": "FeatureCollection", "features": [feature] });
            let problem = refused(&collection).unwrap_or_else(|| panic!("accepted: {feature}"));
            assert!(problem.contains(told), "{problem}\nhas not: {told}");
        }
        let valid = json!({ "metadata": { "validTo": "2027-01-01" }, "features": [feature(&layered, &none), feature(&layered, &none)] });
        let problem = refused(&valid).unwrap();
        assert!(problem.contains("metadata.validTo (times); feature 1: geometry.layer (heights); further features with such members: 1."), "{problem}");
    }
}
