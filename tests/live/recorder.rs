//! The recorder alone: rotation, retention, and failing disks.

use std::fs;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use fusion::Identity;
use fusion::numbering::Given;
use fusion::time::{SECOND, Time};
use jiff::SignedDuration;
use utm_fusion::config::{Config, Record};
use utm_fusion::record::{RecordedContents, Recorder, RecorderQueue, RecordingItem};
use utm_fusion::state::read_numbers;

use crate::common::{Scratch, beside, datagrams, files, only, read};

fn config() -> Config {
    Config::load(concat!(env!("CARGO_MANIFEST_DIR"), "/config/example.toml")).unwrap()
}

const START: Time = Time::from_nanos(1_795_168_800 * SECOND);

fn send(queue: &RecorderQueue, after: SignedDuration, payload: Vec<u8>) {
    let from = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 4711);
    assert!(queue.add(RecordingItem::Input { received: START + after, line: 0, from, payload }));
}

fn millis(millis: i64) -> SignedDuration {
    SignedDuration::from_millis(millis)
}

#[test]
fn files_rotate_and_the_oldest_own_ones_are_removed() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    fs::create_dir(&dir).unwrap();
    let foreign = ["input-holiday.pcap", "input-20200101T000000.pcap", "notes.txt"];
    for name in foreign {
        fs::write(dir.join(name), b"not a recording of ours").unwrap();
    }
    let record = Record { dir: dir.clone(), rotate_mib: 1, keep: 3, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) =
        Recorder::start(&config(), &record, Vec::new(), RecordedContents::Service).unwrap();
    // A little more than 5 MiB, in datagrams of maximum size and empty ones.
    for index in 0..85 {
        send(&queue, millis(index * 10), vec![index as u8; 65_507]);
        send(&queue, millis(index * 10), vec![]);
    }
    // More than an hour later, all recordings are small.
    send(&queue, SignedDuration::from_hours(2), vec![1, 2]);
    drop(queue);
    let counts = recorder.join();
    assert_eq!((counts.unwritten, counts.lost), (0, 0));
    let inputs = files(&dir, "input-20261120", ".pcap");
    assert_eq!((inputs.len(), files(&dir, "output-", ".pcap").len()), (3, 3));
    assert_eq!(files(&dir, "input-20261120", ".site.toml").len(), 3);
    assert_eq!(files(&dir, "input-20261120", ".numbers.json").len(), 3);
    assert!(files(&dir, "", ".part").is_empty());
    assert_eq!(datagrams(&inputs[2]), [(START + SignedDuration::from_hours(2), vec![1, 2])]);
    let size = fs::metadata(&inputs[0]).unwrap().len();
    assert!((1 << 20..(1 << 20) + 70_000).contains(&size), "{size}");
    assert!(datagrams(&inputs[0]).iter().any(|(_, payload)| payload.len() == 65_507));
    assert!(datagrams(&inputs[0]).iter().any(|(_, payload)| payload.is_empty()));
    foreign.iter().for_each(|name| assert!(dir.join(name).exists(), "{name}"));
}

/// A file begins with the state just before its first datagram, or without a state.
#[test]
fn state_from_before_a_loss_begins_no_file() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    let record = Record { dir: dir.clone(), rotate_mib: 1, keep: 9, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) =
        Recorder::start(&config(), &record, Vec::new(), RecordedContents::Service).unwrap();
    let state = |state: &str| assert!(queue.add(RecordingItem::Checkpoint(state.to_owned().into())));
    let hours = SignedDuration::from_hours;
    send(&queue, hours(0), vec![1]);
    // Full after an hour, and a state is available.
    state("two");
    send(&queue, hours(2), vec![2]);
    state("old");
    assert!(queue.add(RecordingItem::Gap(START + hours(3))));
    send(&queue, hours(3) + millis(1), vec![3]);
    // Full, and waiting for the next state, for a minute at most.
    send(&queue, hours(5), vec![4]);
    state("five");
    send(&queue, hours(5) + millis(1), vec![5]);
    send(&queue, hours(7), vec![6]);
    send(&queue, hours(7) + millis(60_001), vec![7]);
    drop(queue);
    recorder.join();
    let begun = |input: &PathBuf| fs::read_to_string(beside(input, "engine")).ok();
    let inputs: Vec<_> = files(&dir, "input-", ".pcap")
        .iter()
        .map(|input| (begun(input), datagrams(input).into_iter().map(|(_, payload)| payload[0]).collect()))
        .collect();
    let expected = [
        (None, vec![1]),
        (Some("two".to_owned()), vec![2]),
        (None, vec![3, 4]),
        (Some("five".to_owned()), vec![5, 6]),
        (None, vec![7]),
    ];
    assert_eq!(inputs, expected);
}

#[test]
fn later_file_begins_with_the_decisions_in_force() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    let record = Record { dir: dir.clone(), rotate_mib: 1, keep: 2, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) =
        Recorder::start(&config(), &record, Vec::new(), RecordedContents::Service).unwrap();
    let correlated = |line: &str| assert!(queue.add(RecordingItem::Decided(line.into())));
    let hours = SignedDuration::from_hours;
    send(&queue, hours(0), vec![1]);
    correlated("one\n");
    correlated("two\n");
    assert!(queue.add(RecordingItem::Correlations("two\n".into())));
    send(&queue, hours(2), vec![2]);
    correlated("three\n");
    let read = |file: &std::path::Path| fs::read_to_string(file).unwrap();
    // No decision is in force any more.
    assert!(queue.add(RecordingItem::Correlations("".into())));
    send(&queue, hours(4), vec![3]);
    drop(queue);
    assert_eq!(recorder.join().unwritten, 0);
    // The first file was removed, with the files beside it; the last has no decisions.
    let inputs = files(&dir, "input-", ".pcap");
    assert_eq!(inputs.len(), 2);
    let second = only(&dir, "input-", ".decisions.jsonl");
    assert_eq!(second, beside(&inputs[0], "decisions.jsonl"));
    assert_eq!(read(&second), "two\nthree\n");
}

/// At a site with many assigned numbers, a recording has only those of transponders in flight, each once.
#[test]
fn recording_holds_only_numbers_in_use() {
    use std::os::unix::fs::MetadataExt;
    let given = |number: u32, heard: Time| {
        let mut serial = [b' '; 12];
        serial[..6].copy_from_slice(format!("{number:06}").as_bytes());
        Given { number, identity: Identity::new(&serial, None).unwrap(), heard: Some(heard) }
    };
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    fs::create_dir(&dir).unwrap();
    let record = Record { dir: dir.clone(), rotate_mib: 256, keep: 4, keep_mib: 0, keep_hours: 0 };
    let mut before: Vec<Given> =
        (1..=50_000).map(|number| given(number, START + SignedDuration::from_hours(-2))).collect();
    before.push(given(60_000, START + SignedDuration::from_mins(-5)));
    let (queue, recorder) = Recorder::start(&config(), &record, before, RecordedContents::Service).unwrap();
    send(&queue, millis(0), vec![1, 2]);
    let file = || files(&dir, "input-", ".numbers.json").pop();
    let until = Instant::now() + Duration::from_secs(20);
    while file().is_none() {
        assert!(Instant::now() < until, "no file");
        std::thread::sleep(Duration::from_millis(20));
    }
    let node = || fs::metadata(file().unwrap()).unwrap().ino();
    let at_first = node();
    for number in (100_000..102_000).chain([60_000, 100_000]) {
        assert!(queue.add(RecordingItem::Numbered(given(number, START))));
    }
    send(&queue, millis(1), vec![3]);
    drop(queue);
    recorder.join();
    assert_eq!(node(), at_first, "the file was written anew");
    let numbers = read_numbers(&file().unwrap()).unwrap();
    let expected: Vec<u32> = std::iter::once(60_000).chain(100_000..102_000).collect();
    assert_eq!(numbers.iter().map(|given| given.number).collect::<Vec<_>>(), expected);
}

#[test]
fn data_is_on_disk_within_a_second_and_directory_recreated() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    let record = Record { dir: dir.clone(), rotate_mib: 1, keep: 3, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) =
        Recorder::start(&config(), &record, Vec::new(), RecordedContents::Service).unwrap();
    send(&queue, millis(0), vec![1]);
    let wait = |done: &dyn Fn() -> bool| {
        let until = Instant::now() + Duration::from_secs(15);
        while !done() {
            assert!(Instant::now() < until, "in vain");
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    let parts = || if dir.exists() { files(&dir, "input-", ".pcap.part") } else { Vec::new() };
    wait(&|| parts().first().is_some_and(|part| read(part).0.len() == 1));

    // A second recorder does not write to the directory.
    let (second, other) = Recorder::start(&config(), &record, Vec::new(), RecordedContents::Service).unwrap();
    send(&second, millis(0), vec![9]);
    drop(second);
    assert_eq!(other.join().unwritten, 1);
    assert_eq!(parts().len(), 1);

    fs::remove_dir_all(&dir).unwrap();
    let mut index = 0;
    wait(&|| {
        recorder.counts().unwritten > 0 || {
            send(&queue, millis(1000), vec![2]);
            false
        }
    });
    wait(&|| {
        !parts().is_empty() || {
            send(&queue, millis(2000), vec![3]);
            false
        }
    });
    index += 1;
    send(&queue, millis(3000), vec![index]);
    drop(queue);
    assert!(recorder.join().unwritten > 0);
    assert_eq!(datagrams(&only(&dir, "input-", ".pcap")).last().unwrap().1, [1]);
}

#[test]
fn quick_restarts_remove_no_recording() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    let record = Record { dir: dir.clone(), rotate_mib: 1, keep: 2, keep_mib: 0, keep_hours: 0 };
    // Files have time stamps of the machine's clock.
    let start = utm_fusion::live::now();
    let run = |after: SignedDuration, octets: usize| {
        let (queue, recorder) =
            Recorder::start(&config(), &record, Vec::new(), RecordedContents::Service).unwrap();
        let from = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 4711);
        for payload in vec![7_u8; octets].chunks(60_000) {
            let (received, payload) = (start + after, payload.to_vec());
            assert!(queue.add(RecordingItem::Input { received, line: 0, from, payload }));
        }
        drop(queue);
        recorder.join().unwritten == 0
    };
    // A process started by another test at this moment may hold the lock of the directory briefly.
    let run = |after, octets| assert!((0..20).any(|_| run(after, octets)), "nothing is recorded");
    run(millis(-10_000), 900_000);
    let first = files(&dir, "input-", ".pcap");
    (0..30).for_each(|index| run(millis(index), 10));
    let left = files(&dir, "input-", ".pcap");
    assert!(first.len() == 1 && left.contains(&first[0]), "{left:?}");
    assert!((10..=20).contains(&left.len()), "those of the restarts are bounded: {}", left.len());
    assert_eq!(files(&dir, "input-", ".site.toml").len(), left.len());
}

/// A power failure leaves a part of the last datagram.
#[test]
fn torn_end_of_a_recording_is_cut_off_at_the_next_start() {
    let scratch = Scratch::new();
    let dir = scratch.path("recordings");
    let record = Record { dir: dir.clone(), rotate_mib: 1, keep: 2, keep_mib: 0, keep_hours: 0 };
    let start = || Recorder::start(&config(), &record, Vec::new(), RecordedContents::Service).unwrap();
    let (queue, recorder) = start();
    (0..5).for_each(|index| send(&queue, millis(index), vec![index as u8; 100]));
    drop(queue);
    recorder.join();
    let whole = only(&dir, "input-", ".pcap");
    let part = whole.with_extension("pcap.part");
    fs::rename(&whole, &part).unwrap();
    let file = fs::OpenOptions::new().write(true).open(&part).unwrap();
    file.set_len(file.metadata().unwrap().len() - 30).unwrap();
    let (queue, recorder) = start();
    drop(queue);
    recorder.join();
    assert_eq!(datagrams(&whole).len(), 4, "the fifth was torn");
    assert!(!part.exists());
}
