use serde_json::json;

use super::*;
use fusion::time::SECOND;

const RING: &str = "[[[10.0,60.0],[10.1,60.0],[10.1,60.1],[10.0,60.0]]]";

fn at(second: i64) -> Time {
    Time::from_nanos((1_795_168_800 + second) * SECOND)
}

/// A directory of its own, removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("utm-fusion-zones-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn load(&self) -> (ZoneStore, StateHealth) {
        let health = StateHealth::default();
        (ZoneStore::load(&self.0, &health, at(60)), health)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(ZONES).join(name)
    }

    /// Names of the files of zones, those set aside included.
    fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.join(ZONES)).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn feature(properties: &Value) -> Vec<u8> {
    let geometry = format!("{{\"type\":\"Polygon\",\"coordinates\":{RING}}}");
    format!("{{\"type\":\"Feature\",\"properties\":{properties},\"geometry\":{geometry}}}").into_bytes()
}

fn collection(properties: &Value) -> Vec<u8> {
    let feature = String::from_utf8(feature(properties)).unwrap();
    format!("{{\"type\":\"FeatureCollection\",\"features\":[{feature}]}}").into_bytes()
}

fn names(store: &ZoneStore) -> Vec<&str> {
    store.zones().map(|zone| &*zone.name).collect()
}

#[test]
fn activated_zones_survive_a_restart() {
    let scratch = Scratch::new("restart");
    let (mut store, _) = scratch.load();
    let odd = "../Schule \"№1\"/B";
    let limits = json!({ "name": "ignored", "floor_m": null, "ceiling_m": 120, "colour": "red" });
    let zone = store.activate(odd, &collection(&limits), "tower", at(0)).unwrap();
    assert_eq!((zone.floor_m, zone.ceiling_m, &*zone.activated_by), (None, Some(120.0), "tower"));
    assert_eq!((zone.activated_at, zone.areas.zones().count()), (at(0), 1));
    let (area, one) = zone.areas.zones().next().unwrap();
    assert_eq!((&*one.name, area.alert().unwrap().ceiling_m), (odd, Some(120.0)));
    store.activate("a", &feature(&Value::Null), "desk", at(1)).unwrap();
    // The same name replaces the zone.
    store.activate("a", &feature(&json!({ "floor_m": 30.5 })), "desk", at(2)).unwrap();
    assert_eq!(scratch.files(), ["%2E%2E%2FSchule%20%22%E2%84%961%22%2FB.geojson", "a.geojson"]);

    let (mut again, health) = scratch.load();
    assert_eq!(again.zones, store.zones);
    assert!(health.all().is_empty());
    assert_eq!(again.revoke(odd).unwrap(), zone);
    assert_eq!(again.revoke(odd), Err(ZoneRefusal::Unknown));
    assert_eq!((names(&again), scratch.files()), (vec!["a"], vec!["a.geojson".to_owned()]));
    assert_eq!(names(&scratch.load().0), ["a"]);
}

#[test]
fn damaged_zone_costs_the_others_nothing() {
    let scratch = Scratch::new("damaged");
    let (mut store, _) = scratch.load();
    for name in ["a", "b", "c", "d", "e", "f", "whole"] {
        store.activate(name, &feature(&json!({ "ceiling_m": 50 })), "tower", at(0)).unwrap();
    }
    let text = String::from_utf8(fs::read(scratch.file("a.geojson")).unwrap()).unwrap();
    fs::write(scratch.file("a.geojson"), &text[..text.len() / 2]).unwrap();
    fs::write(scratch.file("b.geojson"), text.replace("tower", "\u{0}\u{1}")).unwrap();
    fs::write(scratch.file("c.geojson"), &text).unwrap();
    fs::remove_file(scratch.file("d.geojson")).unwrap();
    fs::create_dir(scratch.file("d.geojson")).unwrap();
    fs::write(scratch.file("e.geojson"), text.replace("\"a\"", "\"e\"") + &" ".repeat(70_000)).unwrap();
    fs::write(scratch.file("f.geojson"), text.replace("\"a\"", "\"f\"").replace("50", "-900")).unwrap();
    fs::write(scratch.file("whole.geojson.part"), "{").unwrap();
    let (store, health) = scratch.load();
    assert_eq!(names(&store), ["whole"]);
    let damaged: Vec<_> = health.all().into_iter().map(|(name, file)| (name, file.damaged)).collect();
    let expected = ["a", "b", "c", "d", "e", "f"].map(|name| (format!("{name}.geojson"), 1));
    assert_eq!(damaged, expected);
    assert_eq!(scratch.files().iter().filter(|name| name.contains(".geojson.damaged-2")).count(), 6);
    assert!(scratch.load().1.all().is_empty(), "they are reported once");

    fs::remove_dir_all(scratch.0.join(ZONES)).unwrap();
    fs::write(scratch.0.join(ZONES), "no directory").unwrap();
    let (mut store, health) = scratch.load();
    assert_eq!((names(&store), health.all()[ZONES].damaged), (vec![], 1));
    store.activate("a", &feature(&Value::Null), "tower", at(0)).unwrap();
    assert_eq!(names(&scratch.load().0), ["a"]);
}

#[test]
fn unusable_zone_is_refused_with_reason() {
    let scratch = Scratch::new("refused");
    let (mut store, _) = scratch.load();
    let geometry = format!("{{\"type\":\"Polygon\",\"coordinates\":{RING}}}");
    let two = String::from_utf8(collection(&Value::Null)).unwrap();
    let two = two.replacen("[{", &format!("[{{\"type\":\"Feature\",\"geometry\":{geometry}}},{{"), 1);
    let ed318 = json!({ "identifier": "X1", "type": "PROHIBITED", "variant": "COMMON", "zoneAuthority": [] });
    for (geojson, why) in [
        (&b"{"[..], "is no GeoJSON"),
        (b"\xff", "is no GeoJSON"),
        (b"[]", "a zone is a GeoJSON Feature"),
        (geometry.as_bytes(), "a zone is a GeoJSON Feature"),
        (b"{\"type\":\"Feature\"}", "holds no polygon"),
        (b"{\"type\":\"FeatureCollection\",\"features\":[]}", "a zone is one feature"),
        (two.as_bytes(), "a zone is one feature"),
        (
            b"{\"type\":\"Feature\",\"geometry\":{\"type\":\"Point\",\"coordinates\":[1,2]}}",
            "it is no polygon",
        ),
        (&feature(&json!({ "ceiling_m": "120" })), "a height is a number of metres"),
        (&feature(&json!({ "ceiling_m": 60_000 })), "between -500 and 50000 metres"),
        (&feature(&json!({ "floor_m": 120, "ceiling_m": 120 })), "the ceiling is not above the floor"),
        (&feature(&json!({ "ceiling_m": 120, "maxAltitude": 90 })), "plain GeoJSON has no heights"),
        (&feature(&ed318), "UAS zones of an authority"),
        (&vec![b' '; MAX_GEOJSON + 1], "at most 65536 octets"),
    ] {
        match store.activate("a", geojson, "tower", at(0)) {
            Err(ZoneRefusal::Invalid(reason)) if reason.contains(why) => {}
            other => panic!("{why}: {other:?}"),
        }
    }
    for name in ["", " a", "a ", "a\nb", "..", &"x".repeat(MAX_ZONE_NAME + 1)] {
        let refused = store.activate(name, &feature(&Value::Null), "tower", at(0));
        assert_eq!(refused, Err(ZoneRefusal::Name), "{name:?}");
    }
    assert!(names(&store).is_empty() && !scratch.0.join(ZONES).exists(), "a refused zone leaves no file");
}

#[test]
fn zones_above_the_maximum_are_refused() {
    let scratch = Scratch::new("maximum");
    let (mut store, _) = scratch.load();
    // The longest names, whose files have the longest names.
    let name = |number: usize| format!("{number:03}{}", " é".repeat(20)) + "a";
    assert_eq!(name(0).len(), MAX_ZONE_NAME);
    for number in 0..MAX_ZONES {
        store.activate(&name(number), &feature(&Value::Null), "tower", at(0)).unwrap();
    }
    let one_more = store.activate("one more", &feature(&Value::Null), "tower", at(0));
    assert_eq!(one_more, Err(ZoneRefusal::Full));
    store.activate(&name(7), &feature(&json!({ "floor_m": 7 })), "tower", at(0)).unwrap();
    store.revoke(&name(8)).unwrap();
    store.activate("one more", &feature(&Value::Null), "tower", at(0)).unwrap();
    assert_eq!(scratch.load().0.zones, store.zones);
}

#[test]
fn zone_that_cannot_be_written_changes_nothing() {
    let scratch = Scratch::new("unwritten");
    let (mut store, _) = scratch.load();
    let zone = store.activate("a", &feature(&Value::Null), "tower", at(0)).unwrap();
    // A directory in the place of the file cannot be removed as a file.
    fs::remove_file(scratch.file("a.geojson")).unwrap();
    fs::create_dir(scratch.file("a.geojson")).unwrap();
    assert!(matches!(store.revoke("a"), Err(ZoneRefusal::Unwritten(_))));
    fs::remove_dir_all(scratch.0.join(ZONES)).unwrap();
    fs::write(scratch.0.join(ZONES), "no directory").unwrap();
    for name in ["a", "b"] {
        let refused = store.activate(name, &feature(&json!({ "floor_m": 9 })), "tower", at(1));
        assert!(matches!(refused, Err(ZoneRefusal::Unwritten(_))), "{refused:?}");
    }
    assert_eq!(store.zones().collect::<Vec<_>>(), [&zone]);
    // Without the directory there is no file that would return after a restart.
    fs::remove_file(scratch.0.join(ZONES)).unwrap();
    assert_eq!(store.revoke("a").unwrap(), zone);
}
