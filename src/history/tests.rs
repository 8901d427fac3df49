//! What is kept comes back, and no more than the limits allow is kept.

use proptest::prelude::*;

use super::*;
use fusion::time::SECOND;

fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("utm-fusion-store-{}-{name}.redb", std::process::id()));
    let _ = std::fs::remove_file(&path);
    path
}

fn track(id: &str, second: i64) -> SavedTrack {
    SavedTrack {
        id: id.to_owned(),
        source: "radar",
        number: 7,
        latitude_deg: 52.0 + second as f64 * 1e-4,
        longitude_deg: -0.5,
        altitude_amsl_m: (second % 2 == 0).then_some(100.25),
    }
}

fn at(second: i64) -> Time {
    Time::from_nanos(second * SECOND)
}

fn pictures(seconds: std::ops::Range<i64>) -> Vec<Snapshot> {
    seconds
        .map(|second| Snapshot { time: at(second), tracks: vec![track("F-1", second), track("R-2", second)] })
        .collect()
}

#[test]
fn trails_and_snapshots_come_back_also_after_a_restart() {
    let path = scratch("back");
    let limits = Limits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    Store::open(&path, limits).unwrap().keep(&pictures(0..100)).unwrap();
    let store = Store::open(&path, limits).unwrap();
    let trail = store.trail("F-1", at(10), at(20), 1000).unwrap();
    assert_eq!(trail.len(), 11);
    assert_eq!(trail[0].0, at(10));
    assert!((trail[10].1.latitude_deg - 52.002).abs() < 1e-9);
    assert_eq!((trail[0].1.altitude_amsl_m, trail[1].1.altitude_amsl_m), (Some(100.25), None));
    let latest = store.trail("F-1", at(10), at(20), 3).unwrap();
    assert_eq!(latest.iter().map(|place| place.0).collect::<Vec<_>>(), [at(18), at(19), at(20)]);
    assert!(store.trail("F-", at(0), at(99), 10).unwrap().is_empty(), "an id, not its beginning");
    let snapshot = store.snapshot(at(50) + SignedDuration::from_millis(900), SignedDuration::from_secs(2));
    assert_eq!(snapshot.unwrap().map(|snapshot| (snapshot.time, snapshot.tracks.len())), Some((at(50), 2)));
    assert_eq!(store.snapshot(at(200), SignedDuration::from_secs(2)).unwrap(), None);
    assert_eq!(store.span().unwrap(), Some((at(0), at(99))));
    let _ = std::fs::remove_file(&path);
}

#[test]
fn what_is_too_old_or_too_much_is_forgotten() {
    let path = scratch("old");
    let limits = Limits { age: SignedDuration::from_secs(30), octets: 1 << 30 };
    let store = Store::open(&path, limits).unwrap();
    for start in (0..200).step_by(5) {
        store.keep(&pictures(start..start + 5)).unwrap();
    }
    assert_eq!(store.span().unwrap(), Some((at(169), at(199))));
    assert_eq!(store.trail("R-2", at(0), at(300), 1000).unwrap().len(), 31);
    let before = store.octets().unwrap();
    drop(store);
    let store = Store::open(&path, Limits { octets: before / 2, ..limits }).unwrap();
    store.keep(&pictures(200..201)).unwrap();
    assert!(store.octets().unwrap() <= before / 2);
    assert_eq!(store.span().unwrap().map(|span| span.1), Some(at(200)), "the newest stay");
    let _ = std::fs::remove_file(&path);
}

#[test]
fn other_limits_hold_from_then_on() {
    let path = scratch("limits");
    let limits = Limits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    let store = Store::open(&path, limits).unwrap();
    store.keep(&pictures(0..100)).unwrap();
    store.clone().limit(Limits { age: SignedDuration::from_secs(10), ..limits });
    store.keep(&pictures(100..101)).unwrap();
    assert_eq!(store.span().unwrap(), Some((at(90), at(100))));
    let _ = std::fs::remove_file(&path);
}

#[test]
fn a_file_of_something_else_is_told() {
    let path = scratch("else");
    std::fs::write(&path, vec![7; 4096]).unwrap();
    let limits = Limits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    let told = Store::open(&path, limits).unwrap_err().to_string();
    assert!(told.contains("else.redb"), "{told}");
    let _ = std::fs::remove_file(&path);
}

proptest! {
    #[test]
    fn pictures_survive_their_octets(
        tracks in prop::collection::vec(("[A-Za-z0-9.-]{1,40}", 0_usize..3, any::<u32>(), -90.0..90.0, -180.0..180.0,
            prop::option::of(-400.0..9000.0_f64)), 0..20)
    ) {
        let kept: Vec<SavedTrack> = tracks.into_iter().map(|(id, source, number, latitude_deg, longitude_deg, altitude)| SavedTrack {
            id, source: ["fused", "radar", "transponder"][source], number, latitude_deg, longitude_deg,
            altitude_amsl_m: altitude,
        }).collect();
        let back = codec::tracks(&codec::picture(&kept)).unwrap();
        prop_assert_eq!(back.len(), kept.len());
        for (a, b) in kept.iter().zip(&back) {
            prop_assert_eq!((&a.id, a.source, a.number), (&b.id, b.source, b.number));
            prop_assert!((a.latitude_deg - b.latitude_deg).abs() <= 0.51e-7);
            prop_assert!((a.longitude_deg - b.longitude_deg).abs() <= 0.51e-7);
            prop_assert_eq!(a.altitude_amsl_m.is_some(), b.altitude_amsl_m.is_some());
        }
    }
}
