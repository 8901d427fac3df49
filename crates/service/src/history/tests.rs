//! Kept pictures can be read again, and the limits hold.

use proptest::prelude::*;

use super::*;
use fusion::time::SECOND;

fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("utm-fusion-store-{}-{name}.redb", std::process::id()));
    let _ = std::fs::remove_file(&path);
    path
}

fn track(id: &str, second: i64) -> HistoryTrack {
    HistoryTrack {
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

fn pictures(seconds: std::ops::Range<i64>) -> Vec<HistoryPicture> {
    seconds
        .map(|second| HistoryPicture {
            time: at(second),
            tracks: vec![track("F-1", second), track("R-2", second)],
        })
        .collect()
}

#[test]
fn trails_and_snapshots_survive_a_restart() {
    let path = scratch("back");
    let limits = HistoryLimits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    HistoryStore::open(&path, limits).unwrap().keep(&pictures(0..100)).unwrap();
    let store = HistoryStore::open(&path, limits).unwrap();
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
fn pictures_beyond_age_or_size_are_removed() {
    let path = scratch("old");
    let limits = HistoryLimits { age: SignedDuration::from_secs(30), octets: 1 << 30 };
    let store = HistoryStore::open(&path, limits).unwrap();
    for start in (0..200).step_by(5) {
        store.keep(&pictures(start..start + 5)).unwrap();
    }
    // A minute that is over is removed only when all of it is too old.
    assert_eq!(store.span().unwrap(), Some((at(149), at(199))));
    assert_eq!(store.trail("R-2", at(0), at(300), 1000).unwrap().len(), 51);
    let before = store.octets().unwrap();
    drop(store);
    let store = HistoryStore::open(&path, HistoryLimits { octets: before / 2, ..limits }).unwrap();
    store.keep(&pictures(200..201)).unwrap();
    assert!(store.octets().unwrap() <= before / 2);
    assert_eq!(store.span().unwrap().map(|span| span.1), Some(at(200)), "the newest stay");
    let _ = std::fs::remove_file(&path);
}

#[test]
fn changed_limits_apply_at_once() {
    let path = scratch("limits");
    let limits = HistoryLimits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    let store = HistoryStore::open(&path, limits).unwrap();
    store.keep(&pictures(0..100)).unwrap();
    store.clone().limit(HistoryLimits { age: SignedDuration::from_secs(10), ..limits });
    store.keep(&pictures(100..101)).unwrap();
    assert_eq!(store.span().unwrap(), Some((at(90), at(100))));
    store.clone().limit(HistoryLimits { octets: 1, ..limits });
    store.keep(&pictures(101..102)).unwrap();
    assert_eq!(store.span().unwrap(), Some((at(101), at(101))), "the newest one stays");
    let _ = std::fs::remove_file(&path);
}

/// At any times, even after a clock was set back, each picture is as it was last kept.
#[test]
fn pictures_are_unchanged_by_folding() {
    let path = scratch("folded");
    let limits = HistoryLimits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    let store = HistoryStore::open(&path, limits).unwrap();
    let moment = |second: i64| at(second) + SignedDuration::from_millis(125 + second % 7);
    // Tracks that come and go, change their source, and have a height only at times.
    let picture = |second: i64, shift: i64| {
        let of = |index: i64| {
            let mut track = track(&format!("T-{index}"), second + index + shift);
            track.source = if (second / 20 + index) % 2 == 0 { "fused" } else { "transponder" };
            track.number = 10_000 * index as u32;
            track.altitude_amsl_m = (second % 11 != index).then_some(-3.5 * second as f64);
            track
        };
        let mut tracks: Vec<_> = (1..6).filter(|index| (second / 13) % 5 != *index).map(of).collect();
        tracks.sort_by_key(|track| (track.source != "fused", track.number));
        HistoryPicture { time: moment(second), tracks }
    };
    let mut kept = std::collections::BTreeMap::new();
    let mut keep = |seconds: std::ops::Range<i64>, shift| {
        for second in seconds {
            let picture = picture(second, shift);
            store.keep(std::slice::from_ref(&picture)).unwrap();
            kept.insert(picture.time, picture);
        }
    };
    keep(10..200, 0);
    keep(80..95, 9);
    keep(95..230, 0);
    for (time, picture) in &kept {
        let back = store.snapshot(*time, SignedDuration::ZERO).unwrap().unwrap();
        assert_eq!(back.tracks.len(), picture.tracks.len(), "{time}");
        for (a, b) in back.tracks.iter().zip(&picture.tracks) {
            assert_eq!((&a.id, a.source, a.number), (&b.id, b.source, b.number));
            assert!((a.latitude_deg - b.latitude_deg).abs() < 1e-7, "{time}");
            assert_eq!(a.altitude_amsl_m.is_some(), b.altitude_amsl_m.is_some());
        }
    }
    let trail = store.trail("T-3", moment(50), moment(215), 1000).unwrap();
    let expected: Vec<Time> = kept
        .range(moment(50)..=moment(215))
        .filter(|(_, picture)| picture.tracks.iter().any(|track| track.id == "T-3"))
        .map(|(time, _)| *time)
        .collect();
    assert_eq!(trail.iter().map(|place| place.0).collect::<Vec<_>>(), expected);
    let latest = store.trail("T-3", moment(0), moment(215), 100).unwrap();
    assert_eq!(latest, trail[trail.len() - 100..]);
    assert_eq!(store.span().unwrap(), Some((moment(10), moment(229))));
    let _ = std::fs::remove_file(&path);
}

/// A file of version 0.6 is continued.
#[test]
fn pictures_of_an_earlier_version_are_folded() {
    let path = scratch("earlier");
    let database = Database::create(&path).unwrap();
    let writing = database.begin_write().unwrap();
    for picture in pictures(0..900) {
        let whole = codec::picture(&picture.tracks);
        writing.open_table(PICTURES).unwrap().insert(picture.time.nanos(), whole.as_slice()).unwrap();
    }
    writing.open_table(TRAILS).unwrap().insert(("F-1", 0), [0; 17].as_slice()).unwrap();
    writing.open_table(SIZES).unwrap().insert(0, 1 << 40).unwrap();
    writing.commit().unwrap();
    drop(database);
    let limits = HistoryLimits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    let store = HistoryStore::open(&path, limits).unwrap();
    let trail = |store: &HistoryStore| store.trail("F-1", at(0), at(1000), 1000).unwrap();
    assert_eq!(trail(&store).len(), 900);
    let before = store.octets().unwrap();
    for second in 900..905 {
        store.keep(&pictures(second..second + 1)).unwrap();
    }
    assert_eq!((trail(&store).len(), store.span().unwrap()), (905, Some((at(0), at(904)))));
    let after = store.octets().unwrap();
    assert!(after * 2 < before, "{after} of {before} octets");
    let _ = std::fs::remove_file(&path);
}

/// The stated size is that of the file, and small for tracks in steady flight.
#[test]
fn folded_minute_bounds_the_file_size() {
    let path = scratch("size");
    let limits = HistoryLimits { age: SignedDuration::from_hours(9), octets: 1 << 30 };
    let store = HistoryStore::open(&path, limits).unwrap();
    let (tracks, seconds) = (300, 7200);
    for start in (0..seconds).step_by(5) {
        let picture = |second: i64| {
            let of = |index: i64| {
                let turn = (second + 17 * index) as f64 * 0.05;
                HistoryTrack {
                    latitude_deg: 52.0 + index as f64 * 1e-3 + 1e-3 * turn.sin(),
                    longitude_deg: -0.5 + 1e-3 * turn.cos(),
                    altitude_amsl_m: Some(100.0 + 10.0 * turn.sin()),
                    ..track(&format!("F-{index:05}"), 0)
                }
            };
            HistoryPicture { time: at(second), tracks: (0..tracks).map(of).collect() }
        };
        store.keep(&(start..start + 5).map(picture).collect::<Vec<_>>()).unwrap();
    }
    let kept = store.octets().unwrap() as f64;
    drop(store);
    let file = std::fs::metadata(&path).unwrap().len() as f64;
    let each = file / (tracks * seconds) as f64;
    println!("{kept} octets are kept, the file has {file}: {each:.1} a place");
    assert!(each < 12.0 && file < 1.3 * kept, "{kept} octets are kept, the file has {file}: {each} a place");
    let _ = std::fs::remove_file(&path);
}

#[test]
fn foreign_file_is_reported() {
    let path = scratch("else");
    std::fs::write(&path, vec![7; 4096]).unwrap();
    let limits = HistoryLimits { age: SignedDuration::from_hours(1), octets: 1 << 30 };
    let told = HistoryStore::open(&path, limits).unwrap_err().to_string();
    assert!(told.contains("else.redb"), "{told}");
    let _ = std::fs::remove_file(&path);
}

proptest! {
    #[test]
    fn numbers_survive_delta_encoding(numbers in prop::collection::vec(any::<i64>(), 0..40)) {
        let bends = minute::bends(numbers.iter().copied());
        prop_assert_eq!(minute::straightened(&bends).collect::<Vec<_>>(), numbers);
    }

    #[test]
    fn arbitrary_octets_decode_to_a_minute_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = minute::rows("X", &octets);
    }

    #[test]
    fn pictures_survive_encoding(
        tracks in prop::collection::vec(("[A-Za-z0-9.-]{1,40}", 0_usize..3, any::<u32>(), -90.0..90.0, -180.0..180.0,
            prop::option::of(-400.0..9000.0_f64)), 0..20)
    ) {
        let kept: Vec<HistoryTrack> = tracks.into_iter().map(|(id, source, number, latitude_deg, longitude_deg, altitude)| HistoryTrack {
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
