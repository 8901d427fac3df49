//! Inputs: files without reception times, damaged files, foreign files, and a part of a flight.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use asterix::blocks;
use flate2::Compression;
use flate2::write::GzEncoder;
use fusion::time::{SECOND, Time};
use jiff::SignedDuration;
use utm_fusion::capture::CapturedDatagram;

use super::common::{Flight, Scratch, csv_lines, datagrams, demo, pcap, ran, utm_fusion};

/// Midnight in the demonstration, seconds UTC since the epoch; the flight lasts from 30 s before to 45 s after.
const MIDNIGHT: f64 = 1_782_000_000.0;

/// Writes the whole blocks of a flight's capture, one file per category: recordings without reception times.
fn raw_files(flight: &Flight, scratch: &Scratch) -> [PathBuf; 2] {
    let datagrams = datagrams(&flight.capture());
    [(48, "radar.ast"), (129, "transponder.ast")].map(|(category, name)| {
        let whole = datagrams.iter().flat_map(|datagram| blocks(&datagram.payload).filter_map(Result::ok));
        let octets: Vec<_> = whole.filter(|block| block.category == category).map(|b| b.octets).collect();
        scratch.file(name, octets.concat())
    })
}

fn time(line: &str) -> f64 {
    line.split(',').next().unwrap().parse().unwrap()
}

/// Columns other than time and id, which differ on another day.
fn but_for_the_day(line: &str) -> Vec<&str> {
    line.split(',').skip(2).collect()
}

#[test]
fn files_without_reception_times_fly_on_the_day_that_is_given() {
    let flight = demo();
    let scratch = Scratch::new();
    let [radar, transponder] = raw_files(&flight, &scratch);
    let on = |date: &[&str]| {
        let file = scratch.path("out.csv");
        let ran = ran(flight.replay(&[&radar, &transponder]).args(date).arg("-o").arg(&file));
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        assert!(ran.stderr.contains("radar.ast\" format=\"raw ASTERIX\""), "{}", ran.stderr);
        // Without a date, a warning for each file states the assumed day and the option.
        let told: Vec<_> = ran.stderr.lines().filter(|line| line.contains("--date YYYY-MM-DD")).collect();
        assert_eq!(told.len(), if date.is_empty() { 2 } else { 0 }, "{}", ran.stderr);
        assert!(told.iter().all(|line| line.contains("WARN") && line.contains("1970-01-01")), "{told:?}");
        csv_lines(fs::read(&file).unwrap())
    };
    let dated = on(&["--date", "2026-06-20"]);
    assert!(dated.iter().all(|line| (MIDNIGHT - 30.0..MIDNIGHT + 45.0).contains(&time(line))));
    let before = dated.iter().filter(|line| time(line) < MIDNIGHT).count();
    assert!(before > 100 && dated.len() - before > 100, "on both sides of midnight: {before}");

    let undated = on(&[]);
    assert_eq!(undated.len(), dated.len());
    for (undated, dated) in undated.iter().zip(&dated) {
        assert_eq!(time(dated) - time(undated), MIDNIGHT - 86_400.0, "from 1970-01-01 to the next day");
        assert_eq!(but_for_the_day(undated), but_for_the_day(dated));
    }

    // The latency is unknown here, so a few points may differ from those of the capture.
    let captured = flight.csv();
    let same = captured.iter().filter(|line| dated.contains(line)).count();
    assert!(same * 100 >= captured.len() * 95, "{same} of {}", captured.len());
}

/// A FINAL recording has times of day in hundredths of a second; midnight is crossed in the middle.
#[test]
fn a_recording_flies_from_the_day_that_is_given() {
    let flight = demo();
    let scratch = Scratch::new();
    let record = |datagram: &CapturedDatagram| {
        let hundredths = datagram.received.unwrap().since_midnight() / (SECOND / 100);
        let length = (datagram.payload.len() as u16 + 12).to_be_bytes();
        let time = &(hundredths as u32).to_be_bytes()[1..];
        [&length[..], &[0, 0, 0], time, &datagram.payload, &[0xA5; 4]].concat()
    };
    let recording: Vec<u8> = datagrams(&flight.capture()).iter().flat_map(record).collect();
    let recording = scratch.file("capture.final", &recording);
    let file = scratch.path("out.csv");
    let ran = ran(flight.replay(&[&recording]).args(["--date", "2026-06-20"]).arg("-o").arg(&file));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stderr.contains("capture.final\" format=\"FINAL recording\""), "{}", ran.stderr);
    assert!(csv_lines(fs::read(&file).unwrap()) == flight.csv());
}

/// A capture contains its dates.
#[test]
fn a_capture_needs_no_date() {
    let flight = demo();
    let ran = ran(&mut flight.replay(&[&flight.capture()]));
    assert!(ran.code == 0 && !ran.stderr.contains("--date"), "{}", ran.stderr);
}

/// A lost octet affects only its own block: the skipped part is logged, counted in the summary, and visible to a
/// script.
#[test]
fn behind_a_lost_octet_the_flight_goes_on() {
    let flight = demo();
    let scratch = Scratch::new();
    let [radar, transponder] = raw_files(&flight, &scratch);
    let wanted = flight.output(&[&radar, &transponder], "csv");
    let mut octets = fs::read(&radar).unwrap();
    let block = blocks(&octets).map(Result::unwrap).find(|block| block.offset > octets.len() / 2).unwrap();
    let (at, length) = (block.offset, block.octets.len());
    octets.remove(at + length / 2);
    let damaged = scratch.file("damaged.ast", &octets);
    let out = scratch.path("out.csv");
    let ran = ran(flight.replay(&[&damaged, &transponder]).arg("-o").arg(&out));
    assert_eq!(ran.code, 4, "{}", ran.stderr);
    let gap = format!("{} octets in 1 place (at offset {at})", length - 1);
    assert!(
        ran.stderr.contains(&format!(
            "that belong to no block were skipped capture=\"{}\" octets={gap}",
            damaged.display()
        )),
        "{}",
        ran.stderr
    );
    let summary = format!("skipped    {gap} of {}, which belong to no block\n", damaged.display());
    assert!(ran.text().contains(&summary), "{}", ran.text());
    let (wanted, got) = (csv_lines(wanted), csv_lines(fs::read(&out).unwrap()));
    let same = wanted.iter().filter(|line| got.contains(line)).count();
    assert!(same * 100 >= wanted.len() * 97, "{same} of {}", wanted.len());
}

/// A counter and a time after the blocks of each datagram change nothing, whether detected or configured.
#[test]
fn trailers_change_nothing() {
    let flight = demo();
    let scratch = Scratch::new();
    let all = datagrams(&flight.capture());
    let sound = |datagram: &&CapturedDatagram| blocks(&datagram.payload).all(|block| block.is_ok());
    let plain: Vec<_> =
        all.iter().filter(sound).map(|one| (one.received.unwrap(), one.payload.clone())).collect();
    let with: Vec<_> = plain
        .iter()
        .zip(0_u64..)
        .map(|((time, payload), count)| (*time, [&payload[..], &count.to_be_bytes()].concat()))
        .collect();
    let file = |name: &str, all: &[(Time, Vec<u8>)]| {
        scratch.file(name, pcap(all.iter().map(|(time, payload)| (*time, payload.as_slice()))))
    };
    let (plain, few) = (file("plain.pcap", &plain), file("few.pcap", &with[..3]));
    let with = file("with.pcap", &with);
    assert!(flight.output(&[&with], "csv") == flight.output(&[&plain], "csv"));
    let faults = |site: &Path, capture: &Path| {
        let ran = ran(utm_fusion("replay").arg(capture).arg("--config").arg(site));
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let told = ran.stderr.matches("a trailer of 8 octets follows the blocks of each datagram").count();
        (told, ran.text().lines().filter(|line| line.contains("unreadable")).count())
    };
    assert_eq!(faults(&flight.site(), &with), (1, 0));
    assert_eq!(faults(&flight.site(), &few), (0, 1), "too few to tell");
    let site = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap();
    let line = r#"inputs = [{ group = "239.192.70.48", port = 8048, interface = "127.0.0.1" }]"#;
    let here =
        r#"inputs = [{ group = "239.192.0.1", port = 8000, interface = "127.0.0.1", trailer_octets = "#;
    assert!(site.contains(line));
    let configured =
        |octets: &str| scratch.file("site.toml", site.replace(line, &format!("{here}{octets} }}]")));
    assert_eq!(faults(&configured("8"), &few), (1, 0));
    assert_eq!(faults(&configured("0"), &with), (0, 1), "there is none, it says");
}

#[test]
fn a_compressed_capture_gives_the_same() {
    let flight = demo();
    let scratch = Scratch::new();
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&fs::read(flight.capture()).unwrap()).unwrap();
    let packed = scratch.file("capture.pcap.gz", encoder.finish().unwrap());
    assert!(csv_lines(flight.output(&[&packed], "csv")) == flight.csv());
    let ran = ran(&mut flight.replay(&[&packed]));
    assert!(
        ran.stderr.contains("capture.pcap.gz\" format=\"pcap (Ethernet, microseconds)\" gzip=true"),
        "{}",
        ran.stderr
    );
}

#[test]
fn cut_raw_file_is_used_up_to_the_cut_which_is_located() {
    let flight = demo();
    let scratch = Scratch::new();
    let [radar, transponder] = raw_files(&flight, &scratch);
    let octets = fs::read(&radar).unwrap();
    let block = blocks(&octets).map(Result::unwrap).find(|block| block.offset > octets.len() / 2).unwrap();
    let whole = scratch.file("whole.ast", &octets[..block.offset]);
    let wanted = flight.output(&[&whole, &transponder], "csv");
    // In its records, in its header, and after its first octet.
    for kept in [block.octets.len() - 1, 5, 2, 1] {
        let cut = scratch.file("cut.ast", &octets[..block.offset + kept]);
        let out = scratch.path("out.csv");
        let ran = ran(flight.replay(&[&cut, &transponder]).arg("-o").arg(&out));
        assert!(fs::read(&out).unwrap() == wanted, "{kept} octets of it");
        let place = format!("unreadable ASTERIX octet={} ", block.offset);
        assert!(
            ran.stderr.contains("the block runs past the end of the datagram") && ran.stderr.contains(&place),
            "{place}\n{}",
            ran.stderr
        );
        assert!(ran.text().contains("block_past_end"), "{}", ran.text());
        assert_eq!(ran.code, 4, "octets of a raw file could not be read");
    }
}

#[test]
fn cut_pcap_is_used_up_to_the_cut_and_fails() {
    let flight = demo();
    let scratch = Scratch::new();
    let octets = fs::read(flight.capture()).unwrap();
    // A record is a header of 16 octets, Ethernet, IPv4 and UDP headers of 42, and the payload.
    let records: Vec<_> =
        datagrams(&flight.capture()).iter().map(|datagram| datagram.origin as usize - 58).collect();
    let [start, end] = records[200..202] else { panic!() };
    let whole = scratch.file("whole.pcap", &octets[..start]);
    let wanted = flight.output(&[&whole], "csv");
    for at in [start + 1, start + 16, start + 40, end - 1] {
        let cut = scratch.file("cut.pcap", &octets[..at]);
        let out = scratch.path("out.csv");
        let ran = ran(flight.replay(&[&cut]).arg("-o").arg(&out));
        assert_eq!(ran.code, 1, "{}", ran.stderr);
        assert!(fs::read(&out).unwrap() == wanted);
        let place = format!("cut.pcap: at offset {start}: the file ends in the middle of a pcap record (");
        assert!(ran.stderr.contains(&place), "{place}\n{}", ran.stderr);
        assert!(ran.text().starts_with("received   200 datagrams"), "{}", ran.text());
    }
}

/// Other inputs continue if one is damaged.
#[test]
fn damage_ends_its_own_input_only() {
    let flight = demo();
    let scratch = Scratch::new();
    let octets = fs::read(flight.capture()).unwrap();
    let cut = scratch.file("cut.pcap", &octets[..octets.len() / 3]);
    let out = scratch.path("out.csv");
    let ran = ran(flight.replay(&[&cut, &flight.capture()]).arg("-o").arg(&out));
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    // The copies in the first third are a redundant line.
    assert!(csv_lines(fs::read(&out).unwrap()) == flight.csv());
}

#[test]
fn file_that_is_no_capture_is_recognised() {
    let flight = demo();
    let scratch = Scratch::new();
    let site = fs::read(flight.site()).unwrap();
    for (name, contents, message) in [
        ("a.png", &b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], "it looks like a PNG image"),
        ("a.toml", &site, "is a configuration and no capture"),
        ("a.pcap.gz", b"\x1f\x8b\x08\0\0\0\0\0\0\x03", "the gzip-compressed file ends too early"),
        ("a.pcap.xz", b"\xfd7zXZ\0\0\x04\xe6\xd6\xb4\x46", "it looks like xz-compressed data"),
        ("a.bin", b"\0\0\0\0\0\0\0\0\0\0\0\0", "it looks like nothing known (first octets 00 00"),
        ("short.pcap", b"\xd4\xc3\xb2\xa1\x02\0", "cut inside its file header"),
        ("empty.pcap", b"", "is empty"),
    ] {
        let file = scratch.file(name, contents);
        let out = scratch.path("out.csv");
        // Also together with a good input.
        for inputs in [vec![&*file], vec![&*flight.capture(), &*file]] {
            let ran = ran(flight.replay(&inputs).arg("-o").arg(&out));
            // A configuration among the captures is wrong usage.
            let (code, sign) = if name == "a.toml" { (2, " ") } else { (1, ": ") };
            assert_eq!(ran.code, code, "{name}: {}", ran.stderr);
            let told = ran.stderr.starts_with(&format!("utm-fusion: {}{sign}", file.display()));
            assert!(told && ran.stderr.contains(message), "{name}: {}", ran.stderr);
            assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
            assert!(ran.stdout.is_empty() && !out.exists(), "{name}: nothing was begun");
        }
    }
    for (name, message) in [("missing.pcap", "cannot be opened: "), ("", "is a directory")] {
        let path = scratch.path(name);
        let ran = ran(&mut flight.replay(&[&path]));
        assert_eq!(ran.code, 1);
        let told = format!("utm-fusion: {}: {message}", path.display());
        assert!(ran.stderr.starts_with(&told), "{}", ran.stderr);
    }
}

#[test]
fn a_part_of_the_flight_is_that_part_of_the_output() {
    let flight = demo();
    let whole = flight.csv();
    // The first reception is 23:59:30.279599.
    let first = MIDNIGHT - 30.0 + 0.279_599;
    let part = |args: &[&str]| {
        let ran =
            ran(flight.replay(&[&flight.capture()]).args(["-o", "-", "--output-format", "csv"]).args(args));
        assert_eq!(ran.code, 0, "{args:?}: {}", ran.stderr);
        csv_lines(ran.stdout)
    };
    for (args, from, to) in [
        (&["--start", "+20s"][..], first + 20.0, f64::MAX),
        (&["--start", "2026-06-21T00:00:10Z"], MIDNIGHT + 10.0, f64::MAX),
        (&["--end", "00:00:10"], 0.0, MIDNIGHT + 10.0),
        (&["--end", "23:59:50"], 0.0, MIDNIGHT - 10.0),
        (&["--start", "23:59:50", "--end", "+0.5m"], MIDNIGHT - 10.0, first + 30.0),
        // The interval includes a slot centre at its start, but not at its end.
        (&["--start", "23:59:50.125", "--end", "23:59:50.625"], MIDNIGHT - 9.875, MIDNIGHT - 9.375),
        (&["--start", "+10m"], f64::MAX, f64::MAX),
        (&["--start", "00:00:10", "--end", "00:00:10"], f64::MAX, f64::MAX),
    ] {
        let wanted: Vec<_> = whole.iter().filter(|line| (from..to).contains(&time(line))).cloned().collect();
        assert!(wanted.len() < whole.len() && (from == f64::MAX || !wanted.is_empty()), "{args:?}");
        assert_eq!(part(args), wanted, "{args:?}");
    }
}

/// Reports received after the end still count, as long as a requested slot waits for them.
#[test]
fn a_part_of_the_flight_waits_as_long_as_the_latency() {
    let flight = demo();
    let scratch = Scratch::new();
    let site = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap();
    let site = site
        .replace("latency_s = 6.25", "slot_s = 1.0\nlatency_s = 72.0")
        .replace("window_s = 25.0", "window_s = 110.0");
    let site = scratch.file("site.toml", site.as_bytes());
    // The transponders' first reports arrive 70 s late.
    let start = Time::from_nanos((MIDNIGHT as i64 - 30) * SECOND);
    let mut held_up: Vec<_> = datagrams(&flight.capture())
        .into_iter()
        .map(|datagram| {
            let received = datagram.received.unwrap();
            let is_early_fix = datagram.payload[0] == 129 && received.seconds_since(start) < 6.0;
            let delay_s = if is_early_fix { 70 } else { 0 };
            (received + SignedDuration::from_secs(delay_s), datagram.payload)
        })
        .collect();
    held_up.sort();
    let capture =
        scratch.file("late.pcap", pcap(held_up.iter().map(|(at, octets)| (*at, octets.as_slice()))));
    let csv = |args: &[&str]| {
        let mut command = utm_fusion("replay");
        command.arg(&capture).arg("--config").arg(&site);
        let ran = ran(command.args(["-o", "-", "--output-format", "csv"]).args(args));
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        csv_lines(ran.stdout)
    };
    let wanted: Vec<_> = csv(&[]).into_iter().filter(|line| time(line) < MIDNIGHT - 24.0).collect();
    assert!(!wanted.is_empty());
    assert_eq!(csv(&["--end", "23:59:36"]), wanted);
}

/// Edition 1.2 of CAT129 allows one record per block. Further records are read anyway, and the summary says so.
#[test]
fn several_records_in_a_cat129_block_are_read_and_noted() {
    let flight = demo();
    let scratch = Scratch::new();
    let blocks_of: Vec<_> = datagrams(&flight.capture())
        .into_iter()
        .filter(|datagram| datagram.payload[0] == 129)
        .take(3)
        .collect();
    let records: Vec<u8> = blocks_of.iter().flat_map(|datagram| datagram.payload[3..].to_vec()).collect();
    let mut block = vec![129];
    block.extend((records.len() as u16 + 3).to_be_bytes());
    block.extend(records);
    let received = blocks_of[2].received.unwrap();
    let capture = scratch.file("several.pcap", pcap([(received, block.as_slice())]));
    let ran = ran(&mut flight.replay(&[&capture]));
    assert!(ran.text().contains("noted      1 CAT129 blocks with more than one record"), "{}", ran.text());
    assert!(ran.text().contains("squitter (transponder): 3 reports"), "{}", ran.text());
}

/// Twenty seconds of a radar with a target code and a probability in percent in I048/SP (`04 01 14 46`: code 20, 70 %).
/// Items: 010, 140, 020, 040, 161, 200, 110, SP.
fn classified() -> Vec<u8> {
    let plot = |count: u32| {
        let (time, range) =
            ((0x3e_8000 + 32 * count).to_be_bytes(), (0x0114 + count as u16 / 4).to_be_bytes());
        let mut block = vec![48, 0, 29, 0xf1, 0x15, 0x09, 0x04, 25, 200];
        block.extend(&time[1..]);
        block.push(0x40);
        block.extend(range);
        block.extend([0x20, 0, 0, 7, 0, 0x6a, 0x20, 0, 0, 0x14, 4, 1, 0x14, 0x46]);
        block
    };
    (0..80).flat_map(plot).collect()
}

#[test]
fn drone_is_shown_where_classification_reads_its_probability() {
    let scratch = Scratch::new();
    let radar = scratch.file("radar.ast", classified());
    let shown = |classification: &str| {
        let site = format!(
            "[site]\nname = \"sp\"\nsac = 25\nsic = 1\n[[sensors]]\nkind = \"radar\"\nid = \"north\"\nsac = 25\nsic = 200\n\
             latitude_deg = 52.5\nlongitude_deg = -0.58\nheight_amsl_m = 100.0\nclassification = {classification}\n\
             accuracy = {{ range_m = 5.0, azimuth_deg = 0.3, height_m = 10.0 }}\n"
        );
        let (site, out) = (scratch.file("site.toml", site), scratch.path("out.csv"));
        let mut command = utm_fusion("replay");
        let ran = ran(command.arg(&radar).arg("--config").arg(site).arg("-o").arg(&out));
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        // Lines after the header.
        fs::read(&out).unwrap().iter().filter(|&&octet| octet == b'\n').count() > 1
    };
    let cases = [
        ("{ source = \"special-purpose\", octet = 2 }", false),
        ("{ source = \"special-purpose\", octet = 2, scale = 0.01 }", true),
        ("{ source = \"special-purpose\", octet = 2, scale = -0.01, offset = 1.0 }", false),
        ("{ source = \"special-purpose-category\", octet = 1, drones = [20] }", true),
        (
            "{ source = \"special-purpose-category\", octet = 1, drones = [20], probability_octet = 2, scale = 0.01 }",
            true,
        ),
        ("{ source = \"special-purpose-category\", octet = 1, drones = [19, 21] }", false),
    ];
    for (classification, expected) in cases {
        assert_eq!(shown(classification), expected, "{classification}");
    }
}
