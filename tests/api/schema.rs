//! What the OpenAPI document says of the picture is what is answered. Of JSON Schema what the document uses.

use serde_json::Value;

use crate::common::Site;

/// What of `value` is not as the schema says.
pub(crate) fn check(document: &Value, schema: &Value, value: &Value, at: &str) {
    let schema = match schema["$ref"].as_str() {
        Some(name) => document.pointer(&name[1..]).unwrap_or_else(|| panic!("{at}: no {name}")),
        None => schema,
    };
    let keywords: Vec<&str> = schema.as_object().unwrap().keys().map(String::as_str).collect();
    for keyword in keywords {
        let rule = &schema[keyword];
        let number = || value.as_f64().unwrap_or_else(|| panic!("{at} is no number: {value}"));
        match keyword {
            "type" => match rule.as_str().unwrap() {
                "object" => assert!(value.is_object(), "{at}: {value}"),
                "array" => assert!(value.is_array(), "{at}: {value}"),
                "string" => assert!(value.is_string(), "{at}: {value}"),
                "boolean" => assert!(value.is_boolean(), "{at}: {value}"),
                "number" => assert!(value.is_number(), "{at}: {value}"),
                "integer" => assert!(value.is_u64() || value.is_i64(), "{at}: {value}"),
                other => panic!("{at}: type {other}"),
            },
            "const" => assert_eq!(value, rule, "{at}"),
            "enum" => assert!(rule.as_array().unwrap().contains(value), "{at}: {value} is not of {rule}"),
            "minimum" => assert!(number() >= rule.as_f64().unwrap(), "{at}: {value}"),
            "maximum" => assert!(number() <= rule.as_f64().unwrap(), "{at}: {value}"),
            "exclusiveMaximum" => assert!(number() < rule.as_f64().unwrap(), "{at}: {value}"),
            "minItems" => assert!(value.as_array().unwrap().len() as u64 >= rule.as_u64().unwrap(), "{at}"),
            "maxItems" => assert!(value.as_array().unwrap().len() as u64 <= rule.as_u64().unwrap(), "{at}"),
            "format" => {
                assert_eq!(rule, "date-time");
                assert!(value.as_str().unwrap().parse::<jiff::Timestamp>().is_ok(), "{at}: {value}");
            }
            "items" => {
                for (index, item) in value.as_array().unwrap().iter().enumerate() {
                    check(document, rule, item, &format!("{at}[{index}]"));
                }
            }
            "required" => {
                for name in rule.as_array().unwrap() {
                    assert!(value.get(name.as_str().unwrap()).is_some(), "{at} has no {name}: {value}");
                }
            }
            "properties" => {
                for (name, item) in value.as_object().unwrap() {
                    let schema = rule.get(name).unwrap_or_else(|| panic!("{at}.{name} is not described"));
                    check(document, schema, item, &format!("{at}.{name}"));
                }
            }
            "description" | "additionalProperties" => {}
            other => panic!("{at}: keyword {other}"),
        }
    }
}

#[tokio::test]
async fn the_picture_is_as_the_document_describes_it() {
    for mut site in [Site::plain(), Site::operational()] {
        let document = site.get("/openapi.json").await.json();
        let schema = |path: &str| {
            document["paths"][path]["get"]["responses"]["200"]["content"]["application/geo+json"]["schema"]
                .clone()
        };
        let tracks = schema("/api/v1/tracks");
        assert!(tracks.get("$ref").is_some());
        check(&document, &tracks, &site.get("/api/v1/tracks").await.json(), "empty");
        for _ in 0..30 {
            site.publish(1).await;
            let picture = site.get("/api/v1/tracks").await.json();
            check(&document, &tracks, &picture, "tracks");
            let id = picture["features"][0]["id"].as_str().unwrap();
            let one = site.get(&format!("/api/v1/tracks/{id}")).await.json();
            check(&document, &schema("/api/v1/tracks/{id}"), &one, "track");
        }
        let sensors = schema("/api/v1/sensors");
        assert!(sensors.get("$ref").is_some());
        check(&document, &sensors, &site.get("/api/v1/sensors").await.json(), "no status yet");
        site.tell(site.status()).await;
        check(&document, &sensors, &site.get("/api/v1/sensors").await.json(), "sensors");
        let trails = site.get("/api/v1/tracks?trail_s=60").await.json();
        check(&document, &tracks, &trails, "trails");
    }
}
