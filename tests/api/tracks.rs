//! The picture: format, filters and ETag.

use axum::http::{Request, StatusCode};
use serde_json::Value;
use utm_fusion::api::Options;

use crate::common::{Site, flown};

fn features(collection: &Value) -> &Vec<Value> {
    collection["features"].as_array().unwrap()
}

#[tokio::test]
async fn before_the_first_slot_the_picture_is_empty() {
    let site = Site::plain();
    let answer = site.get("/api/v1/tracks").await.json();
    assert_eq!((answer["seq"].as_u64(), features(&answer).len()), (Some(0), 0));
    assert!(answer.get("time").is_none());
}

#[tokio::test]
async fn the_picture_is_geojson_and_says_what_it_is_of() {
    let mut site = Site::plain();
    site.publish(3).await;
    let answer = site.get("/api/v1/tracks").await;
    assert_eq!(answer.header("content-type"), "application/geo+json");
    let json = answer.json();
    let count = features(&json).len();
    assert!(count >= 8, "{count} tracks");
    assert_eq!(json["numberMatched"], count);
    assert_eq!(json["numberReturned"], count);
    assert_eq!(json["latency_s"], 6.25, "from the opening of the slot");
    assert_eq!(json["site"], flown().config.site.name);
    for feature in features(&json) {
        let (properties, place) = (&feature["properties"], &feature["geometry"]["coordinates"]);
        assert_eq!(feature["id"], properties["id"]);
        assert_eq!(feature["geometry"]["type"], "Point");
        assert_eq!((&place[0], &place[1]), (&properties["lng"], &properties["lat"]));
        assert_eq!(place.get(2), properties.get("alt"));
        assert_eq!(properties["age_s"], 6.125, "from the slot's centre");
        let id = properties["id"].as_str().unwrap();
        let one = site.get(&format!("/api/v1/tracks/{id}")).await;
        assert_eq!(one.json(), *feature);
        assert!(!one.json()["properties"]["contributors"].as_array().unwrap().is_empty());
    }
    assert_eq!(site.get("/api/v1/tracks/nobody").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn each_filter_gives_what_it_says() {
    let mut site = Site::plain();
    site.publish(1).await;
    let all = site.get("/api/v1/tracks").await.json();
    let chosen = async |query: &str, keep: &dyn Fn(&Value) -> bool| {
        let json = site.get(&format!("/api/v1/tracks?{query}")).await.json();
        let expected: Vec<&Value> = features(&all).iter().filter(|f| keep(&f["properties"])).collect();
        assert_eq!(features(&json).iter().collect::<Vec<_>>(), expected, "{query}");
        assert_eq!(json["numberMatched"], expected.len());
        expected.len()
    };
    let at = |p: &Value, key: &str| p[key].as_f64().unwrap_or(f64::NAN);
    let first = &features(&all)[0]["properties"];
    let (lng, lat, alt) = (at(first, "lng"), at(first, "lat"), at(first, "alt_msl"));
    assert!(chosen("source=fused", &|p| p["source"] == "fused").await > 0);
    chosen("source=radar,transponder", &|p| p["source"] != "fused").await;
    assert!(chosen(&format!("bbox={lng},-90,180,90"), &|p| at(p, "lng") >= lng).await > 0);
    chosen(&format!("bbox=-180,{lat},180,90"), &|p| at(p, "lat") >= lat).await;
    // The other way around the world: everything outside the interval.
    let across = format!("bbox={},-90,{},90", lng + 1e-9, lng - 1e-9);
    assert_eq!(chosen(&across, &|p| p["id"] != first["id"]).await, features(&all).len() - 1);
    chosen(&format!("alt_min={alt}"), &|p| at(p, "alt_msl") >= alt).await;
    chosen(&format!("alt_max={alt}"), &|p| at(p, "alt_msl") <= alt).await;
    let uav = |p: &Value| p.get("uav_probability").map(|p| p.as_f64().unwrap());
    let has_transponder = |p: &Value| p["source"] != "radar";
    assert!(chosen("class=drone", &|p| has_transponder(p) || uav(p).is_some_and(|p| p >= 0.5)).await > 0);
    assert!(chosen("class=other", &|p| !has_transponder(p) && uav(p).is_some_and(|p| p < 0.5)).await > 0);
    chosen("class=unknown", &|p| !has_transponder(p) && uav(p).is_none()).await;
    chosen("class=drone,other,unknown", &|_| true).await;
    let id = first["id"].as_str().unwrap().to_owned();
    assert_eq!(chosen(&format!("ids={id},nobody"), &|p| p["id"] == id.as_str()).await, 1);
    let radar = &flown().config.sensors[0].id;
    let took_part =
        |p: &Value| p["contributors"].as_array().unwrap().iter().any(|c| c["sensor"] == radar.as_str());
    assert!(chosen(&format!("sensor={radar}"), &took_part).await > 0);
    let two = site.get("/api/v1/tracks?limit=2").await.json();
    assert_eq!((&two["numberMatched"], &two["numberReturned"]), (&all["numberMatched"], &Value::from(2)));
}

#[tokio::test]
async fn tracks_are_chosen_by_what_is_known_of_their_transponder() {
    let mut site = Site::operational();
    site.publish(1).await;
    let all = site.get("/api/v1/tracks").await.json();
    let mut counts = Vec::new();
    for state in ["unverified", "verified", "suspect", "failed", "none", "verified,none"] {
        let chosen = site.get(&format!("/api/v1/tracks?integrity={state}")).await.json();
        let is_wanted = |track: &&Value| {
            state.split(',').any(|s| s == track["properties"]["integrity"].as_str().unwrap_or("none"))
        };
        let expected: Vec<&Value> = features(&all).iter().filter(is_wanted).collect();
        assert_eq!(features(&chosen).iter().collect::<Vec<_>>(), expected, "{state}");
        counts.push(expected.len());
    }
    // Tracks with and without transponders exist, and no two lists are equal.
    assert!(counts[0] + counts[1] > 0 && counts[4] > 0, "{counts:?}");
    assert_eq!(counts[..5].iter().sum::<usize>(), features(&all).len());
    let wrong = site.get("/api/v1/tracks?integrity=trusted").await;
    assert_eq!(
        (wrong.status, &wrong.json()["parameter"]),
        (StatusCode::BAD_REQUEST, &Value::from("integrity"))
    );
}

/// A crewed aircraft is not a drone, on either interface.
#[tokio::test]
async fn crewed_aircraft_is_known_by_serial_number() {
    let serial_of =
        |track: &Value| track["properties"]["uas_id"]["serial_number"].as_str().map(str::to_owned);
    let mut site = Site::plain();
    site.publish(1).await;
    let picture = site.get("/api/v1/tracks").await.json();
    let pilot = features(&picture).iter().find_map(serial_of).unwrap();
    let crewed = pilot.clone();
    let mut site = Site::with(Options::default(), |config| config.conflicts.crewed = vec![crewed]);
    site.publish(1).await;
    let chosen = async |class: &str| -> Vec<Option<String>> {
        let json = site.get(&format!("/api/v1/tracks?class={class}")).await.json();
        features(&json).iter().map(serial_of).collect()
    };
    let crewed = chosen("crewed").await;
    assert!(!crewed.is_empty() && crewed.iter().all(|serial| *serial == Some(pilot.clone())), "{crewed:?}");
    assert!(!chosen("drone").await.contains(&Some(pilot.clone())));
    let aircraft = site.get("/data/aircraft.json").await.json();
    for craft in aircraft["aircraft"].as_array().unwrap().iter().filter(|craft| craft["type"] == "other") {
        assert_eq!(craft.get("category").is_none(), craft["flight"] == pilot.as_str(), "{craft}");
    }
}

#[tokio::test]
async fn pages_are_the_whole_picture_once() {
    let mut site = Site::plain();
    site.publish(1).await;
    let all = site.get("/api/v1/tracks").await.json();
    let mut ids: Vec<&str> = features(&all).iter().map(|track| track["id"].as_str().unwrap()).collect();
    ids.sort_unstable();
    assert!(ids.len() > 3 && all.get("next").is_none(), "{ids:?}");
    for limit in 1..=ids.len() + 1 {
        let (mut turned, mut after) = (Vec::new(), String::new());
        loop {
            let page = site.get(&format!("/api/v1/tracks?limit={limit}{after}")).await.json();
            assert_eq!(page["numberMatched"], all["numberMatched"]);
            assert_eq!(page["numberReturned"], features(&page).len());
            assert!((1..=limit).contains(&features(&page).len()), "{page}");
            turned.extend(features(&page).to_vec());
            let Some(next) = page.get("next") else { break };
            after = format!("&after={}", next.as_str().unwrap());
        }
        assert_eq!(turned.iter().map(|track| track["id"].as_str().unwrap()).collect::<Vec<_>>(), ids);
        turned.iter().for_each(|track| assert!(features(&all).contains(track), "{track}"));
    }
    // A page after a track that has ended since continues at its position.
    let behind = site.get(&format!("/api/v1/tracks?after={}.", ids[0])).await.json();
    assert_eq!(features(&behind).len(), ids.len() - 1);
    let none = site.get("/api/v1/tracks?after=~&limit=1").await.json();
    assert_eq!((features(&none).len(), none.get("next")), (0, None));
    assert_eq!(site.get("/api/v1/tracks?after=").await.status, StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn an_unchanged_picture_is_not_sent_again() {
    let mut site = Site::plain();
    site.publish(1).await;
    let tag = site.get("/api/v1/tracks").await.header("etag").to_owned();
    assert!(tag.starts_with("W/\""), "{tag}");
    for tags in
        [tag.clone(), "*".to_owned(), format!("\"x\", {tag}"), tag.trim_start_matches("W/").to_owned()]
    {
        let again = site.ask(Request::get("/api/v1/tracks").header("if-none-match", &tags)).await;
        assert_eq!((again.status, again.text.as_str()), (StatusCode::NOT_MODIFIED, ""), "{tags}");
        assert_eq!(again.header("etag"), tag);
    }
    site.publish(1).await;
    let next = site.ask(Request::get("/api/v1/tracks").header("if-none-match", &tag)).await;
    assert_eq!(next.status, StatusCode::OK);
}

#[tokio::test]
async fn a_trail_is_where_the_track_was_each_second() {
    let mut site = Site::plain();
    let mut seen: Vec<Value> = Vec::new();
    for _ in 0..40 {
        site.publish(1).await;
        seen.push(site.get("/api/v1/tracks").await.json());
    }
    let picture = site.get("/api/v1/tracks?trail_s=5&source=fused").await.json();
    assert!(!features(&picture).is_empty());
    let now = &picture["time"].as_str().unwrap().parse::<jiff::Timestamp>().unwrap();
    let mut longest = 0;
    for feature in features(&picture) {
        let trail = &feature["properties"]["trail"];
        let (times, places) = (trail["times"].as_array().unwrap(), trail["coordinates"].as_array().unwrap());
        assert_eq!(times.len(), places.len());
        longest = longest.max(times.len());
        for (time, place) in times.iter().zip(places) {
            let then = seen.iter().find(|then| then["time"] == *time).unwrap();
            let was = features(then).iter().find(|was| was["id"] == feature["id"]).unwrap();
            for (axis, close) in [(0, 1e-7), (1, 1e-7), (2, 0.051)] {
                let was = was["geometry"]["coordinates"][axis].as_f64();
                assert_eq!(place[axis].as_f64().is_some(), was.is_some());
                assert!((place[axis].as_f64().unwrap_or(0.0) - was.unwrap_or(0.0)).abs() <= close);
            }
            let age_s = now.duration_since(time.as_str().unwrap().parse().unwrap()).as_secs_f64();
            assert!(age_s > 0.0 && age_s <= 5.0, "{age_s}");
        }
    }
    assert_eq!(longest, 5, "a place a second");
}
