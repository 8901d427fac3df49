//! Trails from the history, in each format.

use std::path::Path;

use jiff::SignedDuration;
use utm_fusion::api::Options;
use utm_fusion::history::{Historian, HistoryLimits, HistoryStore};
use utm_fusion::live::Archive;

use crate::common::{Site, flown};

/// Number of seconds in the trail. Those from `BLIND.0` to `BLIND.1` have no height.
const SECONDS: usize = 12;
const BLIND: (usize, usize) = (4, 7);

/// A history with a track that has a position every second, without a height for a while, and the id of the track.
fn history(name: &str) -> (HistoryStore, String) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("api-history");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(name);
    let _ = std::fs::remove_file(&file);
    let limits = HistoryLimits { age: SignedDuration::from_hours(1_000_000), octets: 1 << 24 };
    let store = HistoryStore::open(&file, limits).unwrap();
    let mut historian = Historian::start(store.clone()).unwrap();
    let is_seen = |frame: &&utm_fusion::live::PublishedPicture| !frame.picture.tracks.is_empty();
    let first = flown().frames.iter().rfind(is_seen).unwrap();
    let mut picture = first.picture.clone();
    picture.tracks.truncate(1);
    let id = flown().maker.track_id(&picture.tracks[0]);
    for second in 0..SECONDS {
        let is_blind = (BLIND.0..BLIND.1).contains(&second);
        picture.tracks[0].altitude_amsl_m = (!is_blind).then_some(100.0);
        historian.note(&picture, &flown().maker);
        picture.time = picture.time + SignedDuration::from_secs(1);
    }
    drop(historian); // writes everything
    (store, id)
}

/// Texts between `open` and `close`, in order.
fn between<'a>(text: &'a str, open: &str, close: &str) -> Vec<&'a str> {
    text.split(open).skip(1).map(|rest| rest.split_once(close).unwrap().0).collect()
}

#[tokio::test]
async fn unknown_height_is_zero_in_no_format() {
    let (store, id) = history("heights.redb");
    let site = Site::with(Options { history: Some(store), ..Options::default() }, |_| {});
    let asked = async |format: &str| {
        let span = "since=2000-01-01T00:00:00Z&until=2100-01-01T00:00:00Z";
        let answer = site.get(&format!("/api/v1/tracks/{id}/trail?{span}&format={format}")).await;
        assert_eq!(answer.status, 200, "{}", answer.text);
        answer.text
    };
    let kml = asked("kml").await;
    let parts: Vec<(&str, Vec<usize>)> = between(&kml, "<gx:Track>", "</gx:Track>")
        .into_iter()
        .map(|part| {
            let mode = between(part, "<altitudeMode>", "</altitudeMode>")[0];
            let coordinates = between(part, "<gx:coord>", "</gx:coord>");
            assert_eq!(between(part, "<when>", "</when>").len(), coordinates.len(), "{part}");
            (mode, coordinates.iter().map(|text| text.split(' ').count()).collect())
        })
        .collect();
    let (high, low) = (BLIND.0, SECONDS - BLIND.1);
    let expected = [
        ("absolute", vec![3; high]),
        ("clampToGround", vec![2; BLIND.1 - BLIND.0]),
        ("absolute", vec![3; low]),
    ];
    assert_eq!(parts, expected, "{kml}");
    assert_eq!(between(&kml, "<gx:MultiTrack>", "</gx:MultiTrack>").len(), 1, "{kml}");
    assert_eq!(between(&kml, " 100.00</gx:coord", ">").len(), high + low, "{kml}");

    let gpx = asked("gpx").await;
    assert_eq!(between(&gpx, "<trkpt", "</trkpt>").len(), SECONDS);
    assert_eq!(between(&gpx, "<ele>", "</ele>"), vec!["100.00"; high + low]);
    let csv = asked("csv").await;
    assert_eq!(csv.lines().skip(1).filter(|line| line.ends_with(',')).count(), BLIND.1 - BLIND.0, "{csv}");
    let geojson: serde_json::Value = serde_json::from_str(&asked("geojson").await).unwrap();
    let heights = geojson["properties"]["alt_msl"].as_array().unwrap();
    assert_eq!(heights.iter().filter(|height| height.is_null()).count(), BLIND.1 - BLIND.0);
    let positions = geojson["geometry"]["coordinates"].as_array().unwrap();
    assert!(positions.iter().all(|position| position.as_array().unwrap().len() == 2));
}
