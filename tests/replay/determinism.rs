//! The same flight gives the same bytes, however it is read.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::ops::Range;
use std::path::{Path, PathBuf};

use fusion::time::SECOND;
use utm_fusion::capture::Reception;
use utm_fusion::normalise::nearest_day;

use super::common::{
    EXTENSIONS, Flight, SLOT_NS, Scratch, bundled, contents, datagrams, demo, fly, pcap, ran,
};

#[test]
fn two_runs_give_the_same_bytes_in_every_format() {
    for flight in bundled() {
        for extension in EXTENSIONS {
            let run = || flight.output(&[&flight.capture()], extension);
            let first = run();
            assert!(!first.is_empty());
            assert!(first == run(), "{}: {extension}", flight.name);
        }
    }
}

#[test]
fn format_option_gives_the_output_of_the_extension() {
    let flight = demo();
    for (extension, format) in
        EXTENSIONS.into_iter().zip(["asterix", "pcap", "ndjson", "geojson", "csv", "parquet", "mcap"])
    {
        let ran = ran(flight.replay(&[&flight.capture()]).args(["-o", "-", "--output-format", format]));
        assert!(ran.stdout == flight.output(&[&flight.capture()], extension), "{format}");
    }
}

#[test]
fn speed_changes_no_byte() {
    let flight = demo();
    for extension in EXTENSIONS {
        let scratch = Scratch::new();
        let file = scratch.path(format!("out.{extension}"));
        // 75 s in 0.2 s.
        let paced =
            ran(flight.replay(&[&flight.capture()]).args(["--speed", "400", "--stats"]).arg("-o").arg(&file));
        assert_eq!(paced.code, 0, "{}", paced.stderr);
        assert!(fs::read(&file).unwrap() == flight.output(&[&flight.capture()], extension), "{extension}");
        let took = paced.text().lines().find_map(|line| line.strip_prefix("took")).unwrap();
        let seconds: f64 = took.trim().trim_end_matches(" s").parse().unwrap();
        assert!(seconds > 73.0 / 400.0, "it kept to the pace: {took}");
    }
}

#[test]
fn standard_input_gives_what_the_file_gives() {
    let flight = demo();
    for extension in EXTENSIONS {
        let scratch = Scratch::new();
        let file = scratch.path(format!("out.{extension}"));
        #[expect(clippy::disallowed_methods, reason = "the standard input of the program")]
        let input = File::open(flight.capture()).unwrap();
        let ran = ran(flight.replay(&[Path::new("-")]).arg("-o").arg(&file).stdin(input));
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        assert!(fs::read(&file).unwrap() == flight.output(&[&flight.capture()], extension), "{extension}");
    }
}

/// Splits a capture: one file for the datagrams to the radar's port, one for the rest. The UDP header lies just before
/// the payload.
fn split_by_port(flight: &Flight, scratch: &Scratch) -> [PathBuf; 2] {
    let file = fs::read(flight.capture()).unwrap();
    let whole = datagrams(&flight.capture());
    let radar_port = flight.config().sensors[0].inputs[0].port;
    let of_radar = |origin: u64| {
        let at = origin as usize - 6;
        u16::from_be_bytes([file[at], file[at + 1]]) == radar_port
    };
    [(true, "radar.pcap"), (false, "transponder.pcap")].map(|(radar, name)| {
        let part = whole.iter().filter(|datagram| of_radar(datagram.origin) == radar);
        let part: Vec<_> =
            part.map(|datagram| (datagram.received.unwrap(), datagram.payload.as_slice())).collect();
        assert!(part.len() > 50);
        scratch.file(name, pcap(part))
    })
}

/// At equal reception times, files are read in the order of the command line, which may differ from the order in the
/// single file. The output does not depend on the order of radar and transponder datagrams within one slot interval.
#[test]
fn a_capture_in_two_files_gives_what_it_gives_in_one() {
    for flight in bundled() {
        let scratch = Scratch::new();
        let [radar, transponder] = split_by_port(&flight, &scratch);
        for extension in EXTENSIONS {
            let whole = flight.output(&[&flight.capture()], extension);
            assert!(flight.output(&[&radar, &transponder], extension) == whole, "{}", flight.name);
            assert!(flight.output(&[&transponder, &radar], extension) == whole, "{}", flight.name);
        }
    }
}

/// Returns the datagrams received between two deadlines that must not be exchanged:
/// * two datagrams with different reports for the same radar track and time, or the same serial and time: the last one
///   counts;
/// * a datagram with a report about `max_future_s` (1 s) ahead of its reception: a quarter of a second decides whether
///   it is from the future.
///
/// All others may be exchanged. A copy within 2 s is dropped; if the exchange moves it beyond 2 s, it is handled again
/// without effect. A broken datagram gives the same records at any place. Silences, and therefore restarts of the
/// engine, depend on reception times only, which stay. The order of I129/020–050 does not matter, because they never
/// change in these flights.
fn pinned(interval: &[Reception]) -> BTreeSet<usize> {
    let margin = SECOND - SLOT_NS..SECOND + SLOT_NS;
    let mut pinned = BTreeSet::new();
    let mut who_says: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (index, reception) in interval.iter().enumerate() {
        let contents = contents(&reception.payload);
        let plots = contents.plots.iter().map(|plot| (format!("{:?}", plot.track_number), plot.time_of_day));
        let fixes = contents.fixes.iter().map(|fix| (format!("{:?}", fix.serial_number), fix.time_of_day));
        for (who, time) in plots.chain(fixes) {
            let received = reception.received.unwrap();
            let at = time.and_then(|time| nearest_day(time.count(), received));
            if at.is_some_and(|at| margin.contains(&(at.nanos() - received.nanos()))) {
                pinned.insert(index);
            }
            let others = who_says.entry(format!("{who} {at:?}")).or_default();
            for &other in others.iter().filter(|&&other| interval[other].payload != reception.payload) {
                pinned.extend([index, other]);
            }
            others.push(index);
        }
    }
    pinned
}

/// Index ranges of the receptions between two deadlines.
fn intervals(receptions: &[Reception]) -> Vec<Range<usize>> {
    let interval = |reception: &Reception| reception.received.unwrap().nanos().div_euclid(SLOT_NS);
    let mut start = 0;
    let runs = receptions.chunk_by(|a, b| interval(a) == interval(b));
    runs.map(|run| {
        let range = start..start + run.len();
        start = range.end;
        range
    })
    .collect()
}

/// Permutes payloads among the reception times between two deadlines; the times stay in order. Returns the number of
/// payloads that moved.
fn permute(receptions: &mut [Reception], intervals: &[Range<usize>], mut seed: u64) -> usize {
    let mut luck = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        seed >> 33
    };
    let before: Vec<_> = receptions.iter().map(|reception| reception.origin).collect();
    for range in intervals {
        let interval = &mut receptions[range.clone()];
        let pinned = pinned(interval);
        let free: Vec<_> = (0..interval.len()).filter(|index| !pinned.contains(index)).collect();
        for last in (1..free.len()).rev() {
            let (a, b) = (free[last], free[luck() as usize % (last + 1)]);
            let times = (interval[a].received, interval[b].received);
            interval.swap(a, b);
            (interval[a].received, interval[b].received) = times;
        }
    }
    receptions.iter().zip(before).filter(|(reception, before)| reception.origin != *before).count()
}

#[test]
fn the_order_between_two_deadlines_changes_nothing() {
    for flight in bundled() {
        let (config, receptions) = (flight.config(), flight.receptions());
        let intervals = intervals(&receptions);
        let as_it_was = fly(&config, &receptions);
        for seed in 0..8 {
            let mut permuted = receptions.clone();
            let moved = permute(&mut permuted, &intervals, seed);
            assert!(moved * 10 > receptions.len(), "{}: only {moved} moved", flight.name);
            let flown = fly(&config, &permuted);
            assert_eq!(flown.tally.accepted, as_it_was.tally.accepted, "{} {seed}", flight.name);
            assert!(flown.emissions == as_it_was.emissions, "{} {seed}", flight.name);

            // Check the program once as well.
            if seed == 0 {
                let scratch = Scratch::new();
                let file = permuted.iter().map(|r| (r.received.unwrap(), r.payload.as_slice()));
                let file = scratch.file("permuted.pcap", pcap(file));
                for extension in EXTENSIONS {
                    let whole = flight.output(&[&flight.capture()], extension);
                    assert!(flight.output(&[&file], extension) == whole, "{} {extension}", flight.name);
                }
            }
        }
        let pinned: usize = intervals.iter().map(|range| pinned(&receptions[range.clone()]).len()).sum();
        assert!(pinned * 20 < receptions.len(), "{}: {pinned} are left alone", flight.name);
    }
}
