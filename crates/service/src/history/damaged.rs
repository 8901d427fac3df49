//! A history continues with a new file after its file was damaged.

use std::fs;

use super::*;
use crate::state::damage::{Random, damage};
use fusion::time::SECOND;

const LIMITS: HistoryLimits = HistoryLimits { age: SignedDuration::from_hours(1), octets: 1 << 30 };

fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("utm-fusion-damaged-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn pictures(seconds: std::ops::Range<i64>) -> Vec<HistoryPicture> {
    let track = |second: i64, number: u32| HistoryTrack {
        id: format!("F-{number}"),
        source: "radar",
        number,
        latitude_deg: 52.0 + (second % 97) as f64 * 1e-4,
        longitude_deg: -0.5,
        altitude_amsl_m: Some(100.0),
    };
    let of = |second: i64| HistoryPicture {
        time: Time::from_nanos(second * SECOND),
        tracks: (0..20).map(|number| track(second, number)).collect(),
    };
    seconds.map(of).collect()
}

/// Octets of a file with minutes and pictures: after a regular close, and after the service was killed.
fn files(directory: &Path) -> [Vec<u8>; 2] {
    let path = directory.join(NAME);
    let store = HistoryStore::open(&path, LIMITS).unwrap();
    for second in (0..900).step_by(5) {
        store.keep(&pictures(second..second + 5)).unwrap();
    }
    let killed = fs::read(&path).unwrap();
    drop(store);
    [fs::read(&path).unwrap(), killed]
}

/// Opens and uses a damaged history. With any damage nothing panics, and pictures kept afterwards can be read. Returns
/// whether the file was set aside.
fn goes_on(directory: &Path, how: &str) -> bool {
    let health = StateHealth::default();
    let store = HistoryStore::closed(directory, LIMITS, health.clone());
    store.open_or_replace().unwrap_or_else(|error| panic!("{how}: {error}"));
    // The writer sets aside a file that a reader finds damaged.
    let _ = (store.span(), store.octets(), store.trail("F-7", Time::default(), Time::from_nanos(SECOND), 9));
    let mut kept = store.keep(&pictures(2000..2005));
    if store.is_damaged() {
        kept = store.open_or_replace().and_then(|()| store.keep(&pictures(2000..2005)));
    }
    kept.unwrap_or_else(|error| panic!("{how}: {error}"));
    store.keep(&pictures(2005..2010)).unwrap_or_else(|error| panic!("{how}: {error}"));
    let at = Time::from_nanos(2007 * SECOND);
    let back = store.snapshot(at, SignedDuration::from_secs(1)).unwrap().unwrap();
    assert_eq!((back.time, back.tracks.len()), (at, 20), "{how}");
    drop(store);
    HistoryStore::open(&directory.join(NAME), LIMITS).unwrap_or_else(|error| panic!("{how}: {error}"));
    let file = health.all().remove(NAME);
    assert!(file.as_ref().is_none_or(|file| file.aside.is_some()));
    file.is_some()
}

#[test]
fn damaged_file_is_set_aside_and_history_continues() {
    let directory = scratch("random");
    let path = directory.join(NAME);
    let files = files(&directory);
    let mut random = Random::new(3);
    let mut set_aside = 0;
    for number in 0..400 {
        let how = damage(&path, &files[number % 2], &mut random);
        set_aside += u32::from(goes_on(&directory, &format!("{number}: {how}")));
    }
    assert!(set_aside > 150, "{set_aside}");
    let kept = fs::read_dir(&directory).unwrap().count();
    assert!(kept <= 4, "{kept} files: the damaged ones are bounded");
    fs::remove_dir_all(&directory).unwrap();
}

/// The head of the file states the sizes of its parts.
#[test]
fn damage_to_any_octet_of_the_head_is_survived() {
    let directory = scratch("head");
    let path = directory.join(NAME);
    let files = files(&directory);
    for place in 0..320 {
        for (file, octets) in files.iter().enumerate() {
            let mut damaged = octets.clone();
            damaged[place] = if place % 2 == file { 0xff } else { damaged[place] ^ 0x40 };
            fs::write(&path, damaged).unwrap();
            goes_on(&directory, &format!("octet {place} of file {file}"));
        }
    }
    fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn full_disk_is_no_damage() {
    let full = redb::Error::Io(std::io::Error::from(std::io::ErrorKind::StorageFull));
    let denied = redb::Error::Io(std::io::Error::from(std::io::ErrorKind::PermissionDenied));
    for error in [full, denied, redb::Error::DatabaseAlreadyOpen, redb::Error::PreviousIo] {
        assert!(!guard::is_damage(&error), "{error}");
    }
    let panicked = guard::guarded::<()>(|| panic!("page {}", 7)).unwrap_err();
    assert!(guard::is_damage(&panicked) && panicked.to_string().contains("page 7"), "{panicked}");
}

/// The file is damaged while the service writes it.
#[test]
fn writer_continues_in_a_new_file_after_damage() {
    let directory = scratch("running");
    let path = directory.join(NAME);
    let whole = &files(&directory)[0];
    let mut random = Random::new(5);
    for number in 0..12 {
        fs::write(&path, whole).unwrap();
        let store = HistoryStore::closed(&directory, LIMITS, StateHealth::default());
        store.open_or_replace().unwrap();
        let mut damaged = whole.clone();
        let from = random.below(damaged.len());
        let until = (from + 1 + random.below(100_000)).min(damaged.len());
        damaged[from..until].iter_mut().for_each(|octet| *octet = random.next() as u8);
        fs::write(&path, damaged).unwrap();
        for second in (2000..2100).step_by(5) {
            let _ = store.snapshot(Time::from_nanos(300 * SECOND), SignedDuration::from_secs(9));
            let kept = store.keep(&pictures(second..second + 5));
            if store.is_damaged() {
                store.open_or_replace().unwrap();
            } else {
                kept.unwrap_or_else(|error| panic!("{number}: {error}"));
            }
        }
        store.keep(&pictures(2100..2101)).unwrap();
    }
    fs::remove_dir_all(&directory).unwrap();
}
