//! OGC API – Features: what geographic information systems read.

use std::collections::BTreeSet;

use axum::http::{Request, StatusCode};
use serde_json::Value;
use utm_fusion::api::Options;
use utm_fusion::config::{AlertArea, Area, AreaKind};

use crate::common::Site;

/// The path of a link of this kind, which is on the host of the request.
fn path(answer: &Value, rel: &str) -> Option<String> {
    let link = answer["links"].as_array()?.iter().find(|link| link["rel"] == rel)?;
    Some(
        link["href"]
            .as_str()?
            .strip_prefix("https://fusion.example:8443")
            .expect("the asked host")
            .to_owned(),
    )
}

async fn get(site: &Site, path: &str) -> (StatusCode, Value) {
    let request =
        Request::get(path).header("host", "fusion.example:8443").header("x-forwarded-proto", "https");
    let answer = site.ask(request).await;
    (answer.status, answer.json())
}

fn with_areas() -> Site {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config/areas");
    Site::with(Options::default(), |config| {
        config.http.hosts.push("fusion.example".to_owned());
        for (kind, name) in
            [(AreaKind::Mask, "motorway"), (AreaKind::Alert(AlertArea::default()), "airfield")]
        {
            config.areas.push(Area { kind, file: folder.join(format!("{name}.geojson")) });
        }
    })
}

#[tokio::test]
async fn each_link_from_the_landing_page_leads_somewhere() {
    let mut site = with_areas();
    site.publish(1).await;
    let (_, landing) = get(&site, "/ogc").await;
    let (_, conformance) = get(&site, &path(&landing, "conformance").unwrap()).await;
    assert!(
        conformance["conformsTo"]
            .as_array()
            .unwrap()
            .iter()
            .any(|class| class.as_str().unwrap().ends_with("/core"))
    );
    for rel in ["self", "service-desc"] {
        assert_eq!(get(&site, &path(&landing, rel).unwrap()).await.0, StatusCode::OK, "{rel}");
    }
    let (_, collections) = get(&site, &path(&landing, "data").unwrap()).await;
    let mut ids = Vec::new();
    for collection in collections["collections"].as_array().unwrap() {
        let (_, same) = get(&site, &path(collection, "self").unwrap()).await;
        assert_eq!(same, *collection);
        let items = path(collection, "items").unwrap();
        let (status, all) = get(&site, &items).await;
        assert_eq!((status, path(&all, "self")), (StatusCode::OK, Some(items.clone())));
        let features = all["features"].as_array().unwrap();
        assert!(
            !features.is_empty()
                && all["numberReturned"] == features.len()
                && all["numberMatched"] == features.len()
        );
        for feature in features {
            let (status, one) = get(&site, &format!("{items}/{}", feature["id"].as_str().unwrap())).await;
            assert_eq!((status, &one["geometry"]), (StatusCode::OK, &feature["geometry"]));
        }
        assert_eq!(get(&site, &format!("{items}/nothing")).await.0, StatusCode::NOT_FOUND);
        ids.push(collection["id"].clone());
    }
    assert_eq!(ids, ["tracks", "areas"]);
}

#[tokio::test]
async fn pages_and_boxes_are_those_of_the_picture() {
    let mut site = with_areas();
    site.publish(1).await;
    let (_, picture) = get(&site, "/api/v1/tracks").await;
    let ids = |answer: &Value| -> BTreeSet<String> {
        answer["features"].as_array().unwrap().iter().map(|f| f["id"].as_str().unwrap().to_owned()).collect()
    };
    let (mut seen, mut next) = (BTreeSet::new(), Some("/ogc/collections/tracks/items?limit=3".to_owned()));
    while let Some(page) = next {
        let (_, answer) = get(&site, &page).await;
        assert_eq!(answer["numberMatched"], ids(&picture).len());
        for id in ids(&answer) {
            assert!(seen.insert(id), "a track is on two pages");
        }
        next = path(&answer, "next");
    }
    assert_eq!(seen, ids(&picture));

    let place = &picture["features"][0]["geometry"]["coordinates"];
    let (lng, lat) = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    let [west, south, east, north] = [lng - 0.004, lat - 0.002, lng + 0.004, lat + 0.002];
    let (_, wanted) = get(&site, &format!("/api/v1/tracks?bbox={west},{south},{east},{north}")).await;
    assert!((1..ids(&picture).len()).contains(&ids(&wanted).len()), "{wanted}");
    for bbox in [format!("{west},{south},{east},{north}"), format!("{west},{south},0,{east},{north},1000")] {
        let (_, found) = get(&site, &format!("/ogc/collections/tracks/items?bbox={bbox}")).await;
        assert_eq!(ids(&found), ids(&wanted), "{bbox}");
    }
}

#[tokio::test]
async fn features_of_another_time_or_place_are_left_out() {
    let mut site = with_areas();
    site.publish(1).await;
    let (_, all) = get(&site, "/ogc/collections/tracks/items").await;
    let time = all["timeStamp"].as_str().unwrap();
    let count = async |query: String| {
        let (status, answer) = get(&site, &format!("/ogc/collections/{query}")).await;
        assert_eq!(status, StatusCode::OK, "{query}: {answer}");
        answer["features"].as_array().unwrap().len()
    };
    let tracks = all["features"].as_array().unwrap().len();
    for (datetime, expected) in [
        (time.to_owned(), tracks),
        (format!("2000-01-01T00:00:00Z/{time}"), tracks),
        (format!("{time}/.."), tracks),
        ("../2000-01-01T00:00:00Z".to_owned(), 0),
        ("2000-01-01T00:00:00Z".to_owned(), 0),
    ] {
        assert_eq!(count(format!("tracks/items?datetime={datetime}")).await, expected, "{datetime}");
    }
    assert_eq!(count("areas/items?bbox=-0.7,52.4,-0.5,52.6".to_owned()).await, 2);
    assert_eq!(count("areas/items?bbox=10,52.4,11,52.6".to_owned()).await, 0);
    assert_eq!(count("areas/items?bbox=170,52.4,0,52.6".to_owned()).await, 2);
    assert_eq!(count("areas/items?limit=1&after=1".to_owned()).await, 1);
    for wrong in [
        "datetime=../..",
        "datetime=now",
        "datetime=2001-01-01T00:00:00Z/2000-01-01T00:00:00Z",
        "bbox=1,2,3",
        "bbox=0,10,1,5",
        "limit=0",
        "other=1",
    ] {
        let (status, problem) = get(&site, &format!("/ogc/collections/tracks/items?{wrong}")).await;
        assert_eq!(status, StatusCode::BAD_REQUEST, "{wrong}: {problem}");
    }
}
