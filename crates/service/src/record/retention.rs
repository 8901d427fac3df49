//! Retention of recordings: limits by number, age and size.
//!
//! A recording is full at `rotate_mib` or after an hour. One that a restart ended earlier counts as a fraction, so that a
//! service which crashes repeatedly does not displace earlier recordings.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;
use std::time::UNIX_EPOCH;

use jiff::SignedDuration;

use super::names;
use fusion::time::Time;
use site::config::Record;

/// Maximum duration of a recording: operators ask for "what happened at ten", and a file opens in seconds.
pub(super) const LONGEST: SignedDuration = SignedDuration::from_hours(1);
/// Fraction of a full recording below which one counts as short: a minute.
const SHORT: f64 = 1.0 / 60.0;
/// Number of short recordings kept beside the others.
const SHORT_KEPT: usize = 16;

/// Limits of the recordings kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Retention {
    /// Size of a full recording: octets of its larger file.
    rotate: u64,
    /// Number of full recordings.
    full: u32,
    /// Size of all recordings, in octets; `None`: no limit.
    octets: Option<u64>,
    /// Time since the end of a recording; `None`: no limit.
    age: Option<SignedDuration>,
}

impl Retention {
    pub(super) fn of(record: &Record) -> Self {
        let limit = |value: u32| (value > 0).then_some(value);
        Self {
            rotate: u64::from(record.rotate_mib) << 20,
            full: record.keep,
            octets: limit(record.keep_mib).map(|mib| u64::from(mib) << 20),
            age: limit(record.keep_hours).map(|hours| SignedDuration::from_hours(hours.into())),
        }
    }
}

/// A recording: the files with the same stamp.
#[derive(Clone, Debug)]
struct StoredRecording {
    stamp: String,
    began: Time,
    /// Time of the last write to one of its captures.
    ended: Time,
    /// Octets of all its files, and of the larger capture.
    octets: u64,
    larger: u64,
    is_being_written: bool,
    /// Fraction of a full recording, up to 1.
    share: f64,
}

impl StoredRecording {
    fn is_short(&self) -> bool {
        self.share < SHORT
    }
}

/// Removes recordings beyond the limits at `now`, with all their files. The recording being written is kept, and other
/// files are not touched.
///
/// # Errors
/// The directory cannot be read.
pub(super) fn remove_oldest(directory: &Path, retention: &Retention, now: Time) -> io::Result<()> {
    for stamp in superfluous(&all(directory, retention)?, retention, now) {
        names::remove(directory, &stamp);
    }
    Ok(())
}

/// Recordings in a directory, the oldest first.
fn all(directory: &Path, retention: &Retention) -> io::Result<Vec<StoredRecording>> {
    let mut found = BTreeMap::<String, StoredRecording>::new();
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        let name = entry.file_name();
        let Some((_, stamp, extension)) = name.to_str().and_then(names::parts) else { continue };
        // The file was removed meanwhile.
        let Ok(metadata) = entry.metadata() else { continue };
        let Some(began) = names::time(stamp).filter(|_| metadata.is_file()) else { continue };
        let recording = found.entry(stamp.to_owned()).or_insert_with(|| StoredRecording {
            stamp: stamp.to_owned(),
            began,
            ended: began,
            octets: 0,
            larger: 0,
            is_being_written: false,
            share: 0.0,
        });
        recording.octets += metadata.len();
        if matches!(extension, "pcap" | "pcap.part") {
            recording.larger = recording.larger.max(metadata.len());
            recording.is_being_written |= extension == "pcap.part";
            let modified = metadata.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
            let modified = Time::from_nanos(i64::try_from(modified.as_nanos()).unwrap_or(i64::MAX));
            recording.ended = recording.ended.max(modified);
        }
    }
    // A file whose capture was moved elsewhere is not a recording.
    let mut all: Vec<StoredRecording> =
        found.into_values().filter(|recording| recording.larger > 0).collect();
    for index in 0..all.len() {
        let next = all.get(index + 1).map(|next| next.began);
        let recording = &mut all[index];
        // The files may be copies, written much later than recorded.
        recording.ended = next.map_or(recording.ended, |next| recording.ended.min(next));
        let by_time = (recording.ended - recording.began).as_secs_f64() / LONGEST.as_secs_f64();
        let by_size = recording.larger as f64 / retention.rotate as f64;
        recording.share = by_time.max(by_size).clamp(0.0, 1.0);
    }
    Ok(all)
}

/// Stamps of the recordings beyond the limits.
fn superfluous(all: &[StoredRecording], retention: &Retention, now: Time) -> Vec<String> {
    let is_open = all.iter().any(|recording| recording.is_being_written);
    let mut kept: Vec<&StoredRecording> =
        all.iter().filter(|recording| !recording.is_being_written).collect();
    // The newest first. The recording being written counts as full.
    let (mut full, mut short) = (f64::from(u8::from(is_open)), 0);
    kept.reverse();
    kept.retain(|recording| {
        let is_young = retention.age.is_none_or(|age| now - recording.ended <= age);
        let has_place = match recording.is_short() {
            true => {
                short += 1;
                short <= SHORT_KEPT
            }
            false => {
                full += recording.share;
                full <= f64::from(retention.full)
            }
        };
        is_young && has_place
    });
    if let Some(limit) = retention.octets {
        let mut octets: u64 = all.iter().filter(|one| one.is_being_written).map(|one| one.octets).sum();
        octets += kept.iter().map(|recording| recording.octets).sum::<u64>();
        for is_short in [true, false] {
            while octets > limit
                && let Some(oldest) = kept.iter().rposition(|recording| recording.is_short() == is_short)
            {
                octets -= kept.remove(oldest).octets;
            }
        }
    }
    let is_kept =
        |one: &StoredRecording| one.is_being_written || kept.iter().any(|kept| kept.stamp == one.stamp);
    all.iter().filter(|one| !is_kept(one)).map(|one| one.stamp.clone()).collect()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::time::Duration;

    use super::names::Series;
    use super::*;
    use fusion::time::SECOND;

    const START: i64 = 1_795_168_800;

    fn scratch(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("utm-fusion-kept-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        path
    }

    /// Writes a recording from one second to another, with this number of octets in each capture.
    fn record(directory: &Path, from: i64, until: i64, octets: usize) {
        let stamp = names::stamp(Time::from_nanos((START + from) * SECOND));
        for series in [Series::Input, Series::Output] {
            let path = directory.join(series.name(&stamp) + ".pcap");
            fs::write(&path, vec![0; octets]).unwrap();
            let file = fs::OpenOptions::new().write(true).open(path).unwrap();
            file.set_modified(UNIX_EPOCH + Duration::from_secs((START + until) as u64)).unwrap();
        }
        fs::write(directory.join(Series::Input.name(&stamp) + ".site.toml"), "site").unwrap();
    }

    /// Start times of the remaining recordings, in seconds.
    fn left(directory: &Path, record: &Record, now: i64) -> Vec<i64> {
        let (retention, now) = (Retention::of(record), Time::from_nanos((START + now) * SECOND));
        remove_oldest(directory, &retention, now).unwrap();
        let all = all(directory, &retention).unwrap();
        all.iter().map(|one| one.began.nanos() / SECOND - START).collect()
    }

    fn limits() -> Record {
        Record { rotate_mib: 1, keep: 3, ..super::super::record_into(Path::new("")) }
    }

    #[test]
    fn crash_loop_removes_no_earlier_recording() {
        let directory = scratch("loop");
        (0..3).for_each(|hour| record(&directory, hour * 3600, (hour + 1) * 3600, 1000));
        (0..200).for_each(|start| record(&directory, 10_800 + 2 * start, 10_801 + 2 * start, 24));
        let left = left(&directory, &limits(), 12_000);
        assert_eq!(left[..3], [0, 3600, 7200]);
        assert_eq!(left.len(), 3 + SHORT_KEPT, "the newest short ones: {left:?}");
        assert_eq!(left[3], 10_800 + 2 * (200 - SHORT_KEPT as i64));
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn partial_recordings_count_as_what_they_hold() {
        let directory = scratch("partial");
        // Half an hour each: two count as one full recording.
        (0..12).for_each(|half| record(&directory, half * 1800, (half + 1) * 1800, 1000));
        assert_eq!(left(&directory, &limits(), 30_000).len(), 6);
        // One that is full by its size, in ten seconds.
        record(&directory, 30_000, 30_010, 1 << 20);
        assert_eq!(left(&directory, &limits(), 30_010).len(), 5);
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn old_recordings_are_removed_by_age() {
        let directory = scratch("age");
        (0..3).for_each(|hour| record(&directory, hour * 3600, (hour + 1) * 3600, 1000));
        let record = Record { keep_hours: 2, ..limits() };
        assert_eq!(left(&directory, &record, 3 * 3600), [0, 3600, 7200]);
        assert_eq!(left(&directory, &record, 3 * 3600 + 1), [3600, 7200]);
        assert_eq!(left(&directory, &record, 9 * 3600), [] as [i64; 0]);
        assert!(fs::read_dir(&directory).unwrap().next().is_none(), "what stands beside is gone, too");
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn total_size_removes_short_ones_then_the_oldest() {
        let directory = scratch("size");
        (0..3).for_each(|hour| record(&directory, hour * 3600, (hour + 1) * 3600, 600_000));
        record(&directory, 10_800, 10_801, 10_000);
        assert_eq!(left(&directory, &Record { keep_mib: 4, ..limits() }, 12_000), [0, 3600, 7200, 10_800]);
        assert_eq!(left(&directory, &Record { keep_mib: 3, ..limits() }, 12_000), [3600, 7200]);
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn foreign_files_and_moved_captures_are_left_alone() {
        let directory = scratch("foreign");
        for name in ["input-20200101T000000.000Z.pcap.gz", "input-20200101T000000.000Z.site.toml", "notes"] {
            fs::write(directory.join(name), "x").unwrap();
        }
        fs::create_dir(directory.join("input-20200101T000000.000Z.pcap")).unwrap();
        let record = Record { keep: 1, keep_mib: 1, keep_hours: 1, ..limits() };
        assert!(left(&directory, &record, 0).is_empty());
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 4);
        fs::remove_dir_all(&directory).unwrap();
    }
}
