//! Disks that are full, and disks that hang.

use std::fs;
use std::io::Write;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use fusion::time::Time;
use jiff::SignedDuration;
use utm_fusion::config::{Config, Profile, Record};
use utm_fusion::live::now;
use utm_fusion::record::{RecordedContents, Recorder, RecordingItem};

use crate::common::{Scratch, files, read};
use crate::http::{Stream, address, get, metric, troubled, until};
use crate::inside::{is_inside, must};
use crate::recorded::{is_exact, pairs};
use crate::stage::Stage;
use crate::{quick, scenario};

fn pause_until(time: Time) {
    if let Ok(early) = Duration::try_from(time - now()) {
        std::thread::sleep(early);
    }
}

/// Fills a disk to the last octet.
fn fill(file: &Path) {
    let mut filler = fs::File::create(file).unwrap();
    for size in [1 << 16, 1 << 12, 1] {
        while filler.write_all(&vec![0; size]).is_ok() {}
    }
}

#[test]
fn full_disk_stops_no_slot_and_recording_resumes() {
    let test = "disk::full_disk_stops_no_slot_and_recording_resumes";
    if !is_inside(&["unshare", "-rm"], test) {
        return;
    }
    let stage = Stage::new(&scenario(28), 23_000, |config, scratch| {
        quick(config);
        // State that the other profile learned from unrecorded reports would not be in the file either.
        config.fusion.profile = Profile::Reference;
        let disk = scratch.path("disk");
        fs::create_dir(&disk).unwrap();
        must(&format!("mount -t tmpfs -o size=4m none {}", disk.display()));
        config.state.dir = disk.join("state");
        config.output.record.as_mut().unwrap().dir = disk.join("recordings");
    });
    let disk = stage.scratch.path("disk");
    let at = |second: i64| stage.start() + SignedDuration::from_secs(second);
    let (stop, listener) = stage.listen();
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    let stream = Stream::open(address);
    stage.send(0.0, 6.5);
    let early = format!("/api/v1/snapshot?time={}", at(-1));
    assert_eq!(get(address, &early).0, 200, "nothing is in the history");

    fill(&disk.join("filler"));
    stage.send(6.5, 11.0);
    service.says("cannot be recorded");
    service.says("the history cannot be written");
    // The other state files are written at other times.
    let troubled = |address| {
        let parts = troubled(address).into_iter();
        parts.filter(|part| part != "state").collect::<Vec<_>>()
    };
    until("alerts", Duration::from_secs(10), || troubled(address) == ["history", "recorder"]);
    assert_eq!(metric(address, "utm_fusion_recorder_failing", ""), 1.0);
    assert_eq!(metric(address, "utm_fusion_history_failing", ""), 1.0);
    // The picture does not need the disk. The sensors may have been silent for too long by now.
    let (code, why) = get(address, "/readyz");
    assert!(code == 200 || why.contains("[\"no sensor delivers data\"]"), "{why}");
    assert_eq!(get(address, &early).0, 200, "what was in the history can still be read");

    // No input arrives when there is space again: the recorder has to resume by itself.
    fs::remove_file(disk.join("filler")).unwrap();
    service.says("recording again");
    stage.send(17.0, 28.0);
    service.says("the history is written again");
    until("alerts end", Duration::from_secs(10), || troubled(address).is_empty());
    assert!(metric(address, "utm_fusion_recorder_unwritten_total", "") > 20.0);
    assert_eq!(metric(address, "utm_fusion_failed_sends_total", ""), 0.0);
    assert!(metric(address, "utm_fusion_lateness_seconds", "0.99") < 1.0);
    pause_until(at(29));
    assert!(stream.is_unbroken(Duration::from_secs(2)) > 100);
    assert_eq!(get(address, &early).0, 200);
    assert_eq!(get(address, &format!("/api/v1/snapshot?time={}", at(24))).0, 200);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    for once in ["cannot be recorded", "the history cannot be written"] {
        assert_eq!(log.matches(once).count(), 1, "{log}");
    }
    stop.store(true, Ordering::Relaxed);
    assert!(listener.join().unwrap().len() > 40, "no slots were sent:\n{log}");

    let pairs = pairs(&disk.join("recordings"));
    assert_eq!(pairs.len(), 2, "trials leave nothing: {pairs:?}");
    assert!(is_exact(&stage.config, &pairs[0], false) > 10);
    assert!(is_exact(&stage.config, &pairs[1], true) > 10);
}

#[test]
fn hanging_disk_losses_are_counted_and_marked_as_a_gap() {
    let stage = Stage::new(&scenario(20), 23_100, |config, _| quick(config));
    let directory = stage.scratch.path("recordings");
    fs::create_dir(&directory).unwrap();
    // Opening a pipe blocks until its other end is opened.
    let lock = directory.join(".recorder.lock");
    must(&format!("mkfifo {}", lock.display()));
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    let stream = Stream::open(address);
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 20.0));
        // More datagrams than fit into the queue, none of them ASTERIX.
        let sender = stage.sender();
        for count in 0..20_000_u32 {
            sender.send_to(&count.to_be_bytes(), stage.to(0)).unwrap();
            if count % 100 == 0 {
                std::thread::sleep(Duration::from_millis(10));
            }
        }
        let lost = || metric(address, "utm_fusion_recorder_lost_total", "");
        until("an overflow", Duration::from_secs(5), || lost() > 100.0);
        let reader = fs::OpenOptions::new().read(true).write(true).open(&lock).unwrap();
        service.says("the recorder did not keep up");
        drop(reader);
    });
    std::thread::sleep(Duration::from_secs(1));
    assert!(stream.is_unbroken(Duration::from_secs(2)) > 60);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    let pairs = pairs(&directory);
    assert_eq!(pairs.len(), 2, "{pairs:?}\n{log}");
    is_exact(&stage.config, &pairs[0], false);
    assert!(is_exact(&stage.config, &pairs[1], true) > 10);
}

#[test]
fn retries_on_a_full_disk_remove_no_good_recording() {
    let test = "disk::retries_on_a_full_disk_remove_no_good_recording";
    if !is_inside(&["unshare", "-rm"], test) {
        return;
    }
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    fs::create_dir(&dir).unwrap();
    must(&format!("mount -t tmpfs -o size=3m none {}", dir.display()));
    let config = Config::load(concat!(env!("CARGO_MANIFEST_DIR"), "/config/example.toml")).unwrap();
    let record = Record { dir: dir.clone(), rotate_mib: 1, keep: 2, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) = Recorder::start(&config, &record, Vec::new(), RecordedContents::Service).unwrap();
    let start = now();
    let send = |after_s: i64, octets: usize| {
        let received = start + SignedDuration::from_secs(after_s);
        let from = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 4711);
        assert!(queue.add(RecordingItem::Input { received, line: 0, from, payload: vec![1; octets] }));
    };
    let good = || files(&dir, "input-", ".pcap");
    // After some hours there is one file, and another is being written.
    send(0, 100);
    send(2 * 3600, 100);
    let being_written = || files(&dir, "input-", ".pcap.part").iter().all(|part| read(part).0.len() == 1);
    until("two good files", Duration::from_secs(5), || good().len() == 1 && being_written());
    let first = good();
    // Space for the beginning of a file, and not for any datagrams.
    fill(&dir.join("filler"));
    let filler = fs::OpenOptions::new().write(true).open(dir.join("filler")).unwrap();
    filler.set_len(filler.metadata().unwrap().len() - (40 << 10)).unwrap();
    for second in 0..13 {
        send(2 * 3600 + 1 + second, 60_000);
        std::thread::sleep(Duration::from_secs(1));
    }
    let counts = recorder.counts();
    assert!(counts.failing && counts.unwritten >= 12, "{counts:?}");
    assert!(good().starts_with(&first) && good().len() == 2, "{:?}", good());
    drop(filler);
    fs::remove_file(dir.join("filler")).unwrap();
    until("it records again", Duration::from_secs(9), || !recorder.counts().failing);
    send(3 * 3600, 100);
    drop(queue);
    let counts = recorder.join();
    assert_eq!((counts.written, counts.unwritten), (3, 13));
}
