//! Answers match the OpenAPI document. Supports the part of JSON Schema that the document uses.

use serde_json::Value;
use utm_fusion::live::SensorState;

use crate::common::Site;

/// Checks `value` against the schema, and panics at the first mismatch.
pub(crate) fn check(document: &Value, schema: &Value, value: &Value, at: &str) {
    if let Err(problem) = differs(document, schema, value, at) {
        panic!("{problem}");
    }
}

fn differs(document: &Value, schema: &Value, value: &Value, at: &str) -> Result<(), String> {
    let hold = |holds: bool, rule: &Value| {
        if holds { Ok(()) } else { Err(format!("{at}: {value} is not {rule}")) }
    };
    let number = || value.as_f64().ok_or_else(|| format!("{at} is no number: {value}"));
    let Some(rules) = schema.as_object() else { return hold(*schema == true, schema) };
    for (keyword, rule) in rules {
        match keyword.as_str() {
            "$ref" => {
                let name = rule.as_str().unwrap();
                let target = document.pointer(&name[1..]).unwrap_or_else(|| panic!("{at}: no {name}"));
                differs(document, target, value, at)?;
            }
            "type" => {
                let is = |kind: &Value| match kind.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    "number" => value.is_number(),
                    "integer" => value.is_u64() || value.is_i64(),
                    other => panic!("{at}: type {other}"),
                };
                hold(rule.as_array().map_or_else(|| is(rule), |kinds| kinds.iter().any(is)), rule)?;
            }
            "const" => hold(value == rule, rule)?,
            "enum" => hold(rule.as_array().unwrap().contains(value), rule)?,
            // Null is within the bounds of a nullable number.
            "minimum" | "maximum" | "exclusiveMaximum" if value.is_null() => {}
            "minimum" => hold(number()? >= rule.as_f64().unwrap(), rule)?,
            "maximum" => hold(number()? <= rule.as_f64().unwrap(), rule)?,
            "exclusiveMaximum" => hold(number()? < rule.as_f64().unwrap(), rule)?,
            "minItems" => hold(value.as_array().unwrap().len() as u64 >= rule.as_u64().unwrap(), rule)?,
            "maxItems" => hold(value.as_array().unwrap().len() as u64 <= rule.as_u64().unwrap(), rule)?,
            "format" if rule == "date-time" => {
                hold(value.as_str().unwrap().parse::<jiff::Timestamp>().is_ok(), rule)?;
            }
            "items" | "prefixItems" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    let of = rule.as_array().map_or(rule, |places| &places[index]);
                    differs(document, of, item, &format!("{at}[{index}]"))?;
                }
            }
            "required" => {
                for name in rule.as_array().unwrap().iter().filter(|_| value.is_object()) {
                    hold(value.get(name.as_str().unwrap()).is_some(), &format!("with {name}").into())?;
                }
            }
            "properties" => {
                for (name, item) in value.as_object().into_iter().flatten() {
                    if let Some(of) = rule.get(name) {
                        differs(document, of, item, &format!("{at}.{name}"))?;
                    }
                }
            }
            // Every object describes its properties; an undescribed one is an error.
            "additionalProperties" => {
                let described = |name: &String| schema["properties"].get(name).is_some();
                for (name, item) in
                    value.as_object().into_iter().flatten().filter(|(name, _)| !described(name))
                {
                    differs(document, rule, item, &format!("{at}.{name} (not described)"))?;
                }
            }
            "oneOf" | "anyOf" => {
                let mut tried = rule.as_array().unwrap().iter().map(|one| differs(document, one, value, at));
                let problems: Vec<String> = tried.by_ref().map_while(Result::err).collect();
                hold(problems.len() < rule.as_array().unwrap().len(), &problems.join("; ").into())?;
            }
            "description" | "format" => {}
            other => panic!("{at}: keyword {other}"),
        }
    }
    Ok(())
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
        site.publish_status(site.status()).await;
        check(&document, &sensors, &site.get("/api/v1/sensors").await.json(), "sensors");
        let trails = site.get("/api/v1/tracks?trail_s=60").await.json();
        check(&document, &tracks, &trails, "trails");
    }
}

/// Routes that need only a path, before and after the first slot, and a problem.
#[tokio::test]
async fn every_answer_is_as_the_document_describes_it() {
    for mut site in [Site::plain(), Site::operational()] {
        let document = site.get("/openapi.json").await.json();
        for round in 0..3 {
            for (path, operations) in document["paths"].as_object().unwrap() {
                if operations.get("get").is_none() || path == "/api/v1/stream" {
                    continue;
                }
                let answer = site.get(&path.replace("{id}", "nobody")).await;
                let responses = &operations["get"]["responses"];
                let schema =
                    &responses[answer.status.as_str()]["content"][answer.header("content-type")]["schema"];
                assert!(!schema.is_null(), "{path}: {}", answer.status);
                if answer.header("content-type").contains("json") {
                    check(&document, schema, &answer.json(), &format!("{path} {round}"));
                }
            }
            let mut status = site.status();
            status.sensors[0].state = SensorState::Degraded;
            site.publish_status(status).await;
            site.publish(4).await;
        }
        assert!(!site.get("/api/v1/alerts").await.json()["alerts"].as_array().unwrap().is_empty());
        let view = "/uss/flights?view=52.49,-0.6,52.51,-0.57&recent_positions_duration=60";
        let flights = site.get(view).await.json();
        let content = &document["paths"]["/uss/flights"]["get"]["responses"]["200"]["content"];
        check(&document, &content["application/json"]["schema"], &flights, view);
    }
}
