//! Exit codes, and messages on standard output and standard error.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

use asterix::{blocks, cat048};

use super::common::{EXTENSIONS, Scratch, bundled, csv_lines, datagrams, demo, pcap, ran, utm_fusion};

#[test]
fn an_input_is_never_overwritten() {
    let flight = demo();
    let scratch = Scratch::new();
    let octets = fs::read(flight.capture()).unwrap();
    let capture = scratch.file("capture.pcap", &octets);
    let ran = ran(flight.replay(&[&capture]).arg("-o").arg(&capture));
    assert_eq!(ran.code, 2, "{}", ran.stderr);
    assert!(ran.stderr.contains("is also an input: it would be overwritten"), "{}", ran.stderr);
    assert_eq!(fs::read(&capture).unwrap(), octets);
}

#[test]
fn wrong_usage_exits_with_code_2() {
    let flight = demo();
    let (site, capture) = (flight.site(), flight.capture());
    let (site, capture) = (site.to_str().unwrap(), capture.to_str().unwrap());
    let scratch = Scratch::new();
    let unknown = scratch.path("out.txt");
    let unknown = unknown.to_str().unwrap();
    let write_one = format!("tip: `utm-fusion info {capture} --config-out site.toml` writes");
    let name_it = format!("tip: a configuration is named with --config: --config {site}");
    for (args, message) in [
        (&["replay"][..], "<INPUT>"),
        (&["replay", capture], "--config <FILE>"),
        (&["replay", "--config", site], "<INPUT>"),
        (&["replay", capture], write_one.as_str()),
        (&["replay", "-o", site, capture], name_it.as_str()),
        (&["run"], "utm-fusion run <FILE>"),
        (
            &["replay", site, "--config", capture],
            "is a configuration and no capture: utm-fusion replay CAPTURE --config",
        ),
        (&["check"], "utm-fusion check <FILE>"),
        (&["check", site, "--config", site], "cannot be used with"),
        (&["demo", "--http", "localhost"], "such as 127.0.0.1:8080, or only the port: 8080"),
        (&["demo", "--http", "http://localhost:8080/"], "such as 127.0.0.1:8080, or only the port: 8080"),
        (&["fly"], "unrecognized subcommand 'fly'"),
        (&[], "Usage: utm-fusion"),
        (&["replay", capture, "--config", site, "--loud"], "unexpected argument '--loud'"),
        (
            &["replay", capture, "--config", site, "-o", "-", "--output-format", "xml"],
            "asterix, pcap, cat062, cat062-pcap, ndjson, geojson, csv, parquet, mcap",
        ),
        (
            &["replay", capture, "--config", site, "-o", unknown],
            "the extension is none of .ast .pcap .ndjson .geojson .csv .parquet .mcap; name one with --output-format",
        ),
        (&["replay", capture, "--config", site, "-o", "-"], "name one with --output-format"),
        (
            &["replay", capture, "--config", site, "--output-format", "csv"],
            "--output-format needs -o FILE, or -o - for standard output",
        ),
        (
            &["replay", capture, "--config", site, "--profile", "nonsense"],
            "--profile nonsense: there is no such profile; use \"operational\" or \"reference\"",
        ),
        (&["replay", capture, "--config", site, "--start", "noon"], "write it as 2026-11-20T10:00:00Z"),
        (&["replay", capture, "--config", site, "--speed", "0"], "write `max`, or how many times faster"),
        (&["replay", capture, "--config", site, "--date", "2026-02-30"], "--date <YYYY-MM-DD>"),
        (
            &["replay", capture, "--config", site, "--start", "+60s", "--end", "+30s"],
            "--end is not after --start",
        ),
        (&["replay", capture, "--config", site, "--end", "+5"], "write a duration with its unit"),
        (&["record", "--config", site, "--dir", unknown, "--duration=-5s"], "at least 0 and at most a year"),
        (&["replay", capture, "--config", site, "--loop"], "--loop needs --udp, --to-inputs or --serve"),
        (
            &["replay", capture, "--config", site, "--loop", "--udp", "-o", unknown],
            "--loop and -o exclude each other",
        ),
        (&["replay", "-", "--config", site, "--loop", "--udp"], "standard input cannot be; name a file"),
        (&["replay", "-", "--config", site, "--serve"], "standard input cannot be; name a file"),
        (&["replay", capture, "--config", site, "--udp", "--serve"], "cannot be used with '--serve'"),
    ] {
        let ran = ran(Command::new(env!("CARGO_BIN_EXE_utm-fusion")).args(args).stdin(Stdio::null()));
        assert_eq!(ran.code, 2, "{args:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(message), "{args:?}: {}", ran.stderr);
        assert!(ran.stdout.is_empty(), "{args:?}");
    }
    assert!(!Path::new(unknown).exists());
}

/// A new user may copy the file alone to another place, and give it with or without the option's name.
#[test]
fn the_example_is_valid_wherever_it_is_copied_to() {
    let scratch = Scratch::new();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/example.toml");
    let copy = scratch.file("site.toml", fs::read(example).unwrap());
    for args in [vec![copy.as_os_str()], vec!["--config".as_ref(), copy.as_os_str()]] {
        let ran = ran(utm_fusion("check").args(args));
        assert_eq!((ran.code, ran.stderr.as_str()), (0, ""));
        assert!(ran.text().contains("site.toml: valid."), "{}", ran.text());
    }
}

#[test]
fn configuration_of_other_sensors_fails_and_names_both() {
    let flight = demo();
    let scratch = Scratch::new();
    let half = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap().replace("sic = 41", "sic = 42");
    let site = half.replace("sac = 0\nsic = 0", "sac = 7\nsic = 8");
    let site = scratch.file("other.toml", site);
    let replay = |arguments: &[&str]| {
        ran(utm_fusion("replay").arg(flight.capture()).arg("--config").arg(&site).args(arguments))
    };
    for arguments in [&[][..], &["-o", "-", "--output-format", "csv"]] {
        let ran = replay(arguments);
        assert_eq!(ran.code, 1, "{}", ran.stderr);
        let told = ran.stderr.lines().last().unwrap();
        for words in [
            "none of the 1,321 records is from a sensor of ",
            "the input has CAT048 70/41, CAT034 70/41, CAT129 0/0, ",
            "other.toml has CAT048 70/42, CAT129 7/8. ",
            &format!("utm-fusion info {} --config-out FILE", flight.capture().display()),
        ] {
            assert!(told.contains(words), "{words}\n{told}");
        }
    }
    // A configuration that covers only a part of the flight is valid.
    fs::write(&site, half).unwrap();
    assert_eq!(replay(&[]).code, 0);
}

/// No line of the help is longer than the terminal width.
#[test]
fn help_keeps_to_the_width_of_the_terminal() {
    let commands =
        ["", "demo", "run", "replay", "decode", "encode", "info", "simulate", "evaluate", "check", "record"];
    for columns in [80, 100] {
        for command in commands {
            let mut help = Command::new(env!("CARGO_BIN_EXE_utm-fusion"));
            help.args(Some(command).filter(|name| !name.is_empty())).arg("--help");
            let ran = ran(help.env("COLUMNS", columns.to_string()).stdin(Stdio::null()));
            assert_eq!(ran.code, 0);
            let longest = ran.text().lines().max_by_key(|line| line.chars().count()).unwrap();
            assert!(longest.chars().count() <= columns, "{command}, {columns} columns: {longest}");
            assert!(longest.chars().count() > columns * 3 / 5, "{command}, {columns} columns: {longest}");
        }
    }
}

#[test]
fn missing_output_is_refused() {
    let flight = demo();
    let ran = ran(flight.replay(&[&flight.capture()]).arg("--udp").env("UTM_FUSION__OUTPUT__ASTERIX", "[]"));
    assert_eq!(ran.code, 2, "{}", ran.stderr);
    assert!(ran.stderr.contains("--udp: the configuration names no output.asterix"), "{}", ran.stderr);
}

#[test]
fn unwritable_output_exits_with_code_1() {
    let flight = demo();
    let scratch = Scratch::new();
    let file = scratch.path("no such directory/out.csv");
    let ran = ran(flight.replay(&[&flight.capture()]).arg("-o").arg(&file));
    let told = format!("utm-fusion: {}: cannot be written: ", file.display());
    assert!(ran.stderr.starts_with(&told), "{}", ran.stderr);
    assert_eq!(ran.code, 1);
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_is_reported_with_the_file() {
    let flight = demo();
    let ran = ran(flight.replay(&[&flight.capture()]).args(["-o", "/dev/full", "--output-format", "csv"]));
    assert!(ran.stderr.contains("utm-fusion: /dev/full: cannot be written: "), "{}", ran.stderr);
    assert_eq!(ran.code, 1);
}

/// Number of the first line that contains `what`, from 1.
fn line_of(text: &str, what: &str) -> usize {
    text.lines().position(|line| line.contains(what)).unwrap() + 1
}

#[test]
fn invalid_configuration_exits_with_code_3() {
    let flight = demo();
    let scratch = Scratch::new();
    let site = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap();
    for (from, to, key, message) in [
        ("latitude_deg = 53.0817", "latitude_deg = 152", "sensors[0].latitude_deg = 152", "-90 and 90"),
        ("max_range_m = 5000.0", "max_rang_m = 5000.0", "sensors[0].max_rang_m", "did you mean max_range_m?"),
        ("window_s = 25.0", "window_s = 25.1", "fusion.window_s = 25.1", "whole number of slots"),
        (
            "id = \"squitter\"",
            "id = \"halfmoon\" # too",
            "sensors[1].id = \"halfmoon\"",
            "another sensor has this id",
        ),
        ("sic = 41", "sic 41", "", "this is not TOML"),
    ] {
        let wrong = site.replace(from, to);
        assert_ne!(wrong, site);
        let place = format!(":{}: {key}", line_of(&wrong, to));
        let file = scratch.file("wrong.toml", wrong.as_bytes());
        let place = file.display().to_string() + &place;
        for command in [&mut utm_fusion("check"), utm_fusion("replay").arg(flight.capture())] {
            let ran = ran(command.arg("--config").arg(&file));
            assert_eq!(ran.code, 3, "{to}: {}", ran.stderr);
            let told = ran.stderr.lines().find(|line| line.contains(&place));
            assert!(told.is_some_and(|line| line.contains(message)), "{place}: {message}\n{}", ran.stderr);
            assert!(ran.stdout.is_empty());
        }
    }
}

/// An open bracket makes all following lines invalid.
#[test]
fn single_syntax_error_is_reported_once() {
    let flight = demo();
    let scratch = Scratch::new();
    let site = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap();
    let line = line_of(&site, "sic = 41");
    let file = scratch.file("open.toml", site.replace("sic = 41", "sic = [41").as_bytes());
    let ran = ran(utm_fusion("check").arg("--config").arg(&file));
    assert_eq!(ran.code, 3);
    let at = |line| format!("utm-fusion: {}:{line}: this is not TOML: ", file.display());
    assert!([line, line + 1].map(at).iter().any(|place| ran.stderr.starts_with(place)), "{}", ran.stderr);
    assert!(ran.stderr.lines().count() <= 3, "{}", ran.stderr);
}

/// One of the two sensors would never receive anything.
#[test]
fn two_sensors_with_one_key_are_refused() {
    let scratch = Scratch::new();
    let flight = demo();
    let site = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap();
    let radar = &site[site.find("[[sensors]]").unwrap()..site.rfind("[[sensors]]").unwrap()];
    let twice = site.clone() + "\n" + &radar.replace("halfmoon", "fullmoon");
    let own = site.replacen("sac = 70\nsic = 1\n", "sac = 70\nsic = 41\n", 1);
    for (name, text, key) in [("twice.toml", twice, "sensors[2]"), ("own.toml", own, "sensors[0]")] {
        let file = scratch.file(name, text.as_bytes());
        let ran = ran(utm_fusion("check").arg("--config").arg(&file));
        assert_eq!(ran.code, 3, "{}", ran.stderr);
        assert!(ran.stderr.contains(&format!("{name}:")) && ran.stderr.contains(key), "{}", ran.stderr);
    }
}

#[test]
fn invalid_override_is_reported_with_its_variable() {
    let flight = demo();
    for command in [&mut utm_fusion("check"), utm_fusion("replay").arg(flight.capture())] {
        let command = command.arg("--config").arg(flight.site());
        let ran = ran(command.env("UTM_FUSION__FUSION__RATIO_MIN", "2"));
        assert_eq!(ran.code, 3);
        let told = "utm-fusion: environment variable UTM_FUSION__FUSION__RATIO_MIN: fusion.ratio_min = 2: ";
        assert!(ran.stderr.starts_with(told), "{}", ran.stderr);
    }
}

#[test]
fn check_prints_what_is_in_force_and_it_is_valid_again() {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    let sites = bundled().into_iter().map(|flight| flight.site());
    let scratch = Scratch::new();
    for site in sites.chain([config.join("example.toml"), config.join("deenethorpe.toml")]) {
        let check = |file: &Path| {
            let ran = ran(utm_fusion("check").arg("--config").arg(file));
            assert_eq!((ran.code, ran.stderr.as_str()), (0, ""), "{}", file.display());
            String::from_utf8(ran.stdout).unwrap()
        };
        let shown = check(&site);
        for default in ["max_gap_s = 25.0", "weight_radar = 1.0", "geoid undulation: ", "serial = \"uas\""] {
            assert!(shown.contains(default), "{default} is not in\n{shown}");
        }
        let again = check(&scratch.file("again.toml", shown.as_bytes()));
        // All lines except the one that names the file.
        assert_eq!(again.split_once('\n').unwrap().1, shown.split_once('\n').unwrap().1);
    }
    // Settings from the environment are included.
    let file = config.join("deenethorpe.toml");
    let ran = ran(utm_fusion("check").arg("--config").arg(file).env("UTM_FUSION__FUSION__MIN_SAMPLES", "7"));
    assert!(ran.text().contains("\nmin_samples = 7\n"), "{}", ran.text());
}

#[test]
fn a_reader_that_has_read_enough_is_no_failure() {
    // More than a pipe can hold.
    let flight = bundled().remove(2);
    assert!(flight.output(&[&flight.capture()], "csv").len() > 1 << 18);
    let mut command = flight.replay(&[&flight.capture()]);
    command.args(["-o", "-", "--output-format", "csv"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut first = [0; 10];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    assert_eq!(&first, b"time,id,so");
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(!stderr.contains("utm-fusion:") && !stderr.contains("ERROR"), "{stderr}");
}

#[test]
fn standard_output_is_data_and_standard_error_plain_text() {
    let flight = demo();
    for (extension, format) in
        EXTENSIONS.into_iter().zip(["asterix", "pcap", "ndjson", "geojson", "csv", "parquet", "mcap"])
    {
        for more in [&[][..], &["--stats"]] {
            let mut command = flight.replay(&[&flight.capture()]);
            let ran = ran(command.args(["-o", "-", "--output-format", format]).args(more));
            assert_eq!(ran.code, 0);
            assert!(ran.stdout == flight.output(&[&flight.capture()], extension), "{format}");
            // No progress bar, no colours, and the summary only if requested.
            assert!(!ran.stderr.contains(['\r', '\x1b']), "{:?}", ran.stderr);
            assert_eq!(ran.stderr.contains("received   379 datagrams"), !more.is_empty());
        }
    }
    let ran = ran(&mut flight.replay(&[&flight.capture()]));
    assert!(ran.text().starts_with("received   379 datagrams"), "{}", ran.text());
    assert!(!ran.text().contains("took"), "the same input gives the same summary");
}

/// `… octet=5439 category=48 item="040" …`: category, item and octet.
fn place(warning: &str) -> (u8, Option<&str>, usize) {
    let field = |name: &str| warning.split(' ').find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
    let octet = field("octet").unwrap().parse().unwrap();
    (field("category").unwrap().parse().unwrap(), field("item").map(|item| item.trim_matches('"')), octet)
}

#[test]
fn a_warning_names_the_octet_of_the_file() {
    for flight in bundled() {
        let file = fs::read(flight.capture()).unwrap();
        let payloads = datagrams(&flight.capture());
        let ran = ran(&mut flight.replay(&[&flight.capture()]));
        let mut seen = 0;
        for warning in ran.stderr.lines().filter(|line| line.contains("unreadable ASTERIX")) {
            assert!(warning.contains(&format!("capture=\"{}\"", flight.capture().display())), "{warning}");
            let (category, item, octet) = place(warning);
            let datagram = payloads.iter().rfind(|datagram| datagram.origin as usize <= octet).unwrap();
            let end = datagram.origin as usize + datagram.payload.len();
            assert!(warning.contains(&format!("received={}}}: ", datagram.received.unwrap())), "{warning}");
            assert!(octet < end, "{warning}: behind the datagram that holds it");
            let length = || usize::from(u16::from_be_bytes([file[octet + 1], file[octet + 2]]));
            let in_a_block = || {
                let blocks = blocks(&datagram.payload).map_while(Result::ok);
                let at = octet - datagram.origin as usize;
                blocks.into_iter().any(|block| {
                    block.category == category
                        && (block.offset + 3..block.offset + block.octets.len()).contains(&at)
                })
            };
            let holds = match (item, warning.split_once("detail=").unwrap().1) {
                (None, "the block's LEN is below 3, the size of its own header") => {
                    file[octet] == category && length() < 3
                }
                (None, "the block runs past the end of the datagram") => {
                    file[octet] == category && octet + length() > end
                }
                (None, "the FSPEC runs past the end of its block") => in_a_block() && file[octet] & 1 == 1,
                (Some(_), _) => in_a_block(),
                _ => false,
            };
            assert!(holds, "{warning}");
            seen += 1;
        }
        // The demonstration has two; of the many warnings of the hostile feed, the first twenty are logged
        // individually.
        let wanted = match flight.name.as_str() {
            "demo" => 2,
            "conformance/hostile" => 20,
            _ => 0,
        };
        assert_eq!(seen, wanted, "{}", ran.stderr);
    }
}

/// A bad record in the middle of a datagram: records before it and blocks after it are not affected.
#[test]
fn a_bad_record_costs_no_neighbour() {
    let flight = demo();
    let scratch = Scratch::new();
    let mut datagrams = datagrams(&flight.capture());
    let is_crowded = |payload: &[u8]| {
        blocks(payload).count() == 1
            && blocks(payload)
                .flatten()
                .all(|b| b.category == 48 && b.records::<cat048::Record>().count() > 3)
    };
    let index = datagrams.iter().rposition(|datagram| is_crowded(&datagram.payload)).unwrap();
    let payload = &datagrams[index].payload;
    let block = blocks(payload).next().unwrap().unwrap();
    let second = block.records::<cat048::Record>().nth(1).unwrap().unwrap().offset;
    // The first record, and one that announces I048/040 but is truncated after one octet; then the others.
    let framed = |parts: &[&[u8]]| {
        let octets = parts.concat();
        [&[48], &(octets.len() as u16 + 3).to_be_bytes()[..], &octets].concat()
    };
    datagrams[index].payload =
        [framed(&[&payload[3..second], &[0x10, 0x77]]), framed(&[&payload[second..]])].concat();

    let file = pcap(datagrams.iter().map(|d| (d.received.unwrap(), d.payload.as_slice())));
    let broken = scratch.file("broken.pcap", &file);
    let out = scratch.path("out.csv");
    let ran = ran(flight.replay(&[&broken]).arg("-o").arg(&out));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(csv_lines(fs::read(&out).unwrap()) == flight.csv());

    let warning = ran.stderr.lines().find(|line| line.contains("item=\"040\"")).unwrap();
    let (category, item, octet) = place(warning);
    assert_eq!((category, item), (48, Some("040")));
    assert_eq!(file[octet - 1..=octet + 1], [0x10, 0x77, 48], "after its FSPEC, before the next block");
    assert!(warning.ends_with("detail=the item runs past the end of its block"), "{warning}");
    assert!(ran.text().contains("dropped    1 unreadable in category 48: item_past_end"), "{}", ran.text());
    assert!(ran.text().contains("(radar): 1175 plots"), "{}", ran.text());
}

#[test]
fn decode_of_an_absent_category_is_reported() {
    let capture = demo().capture();
    let absent = ran(utm_fusion("decode").arg(&capture).args(["--cat", "62"]));
    assert!(absent.stderr.contains("no record of category 62"), "{}", absent.stderr);
    let present = ran(utm_fusion("decode").arg(&capture).args(["--cat", "48", "--limit", "1"]));
    assert!(!present.stderr.contains("no record"), "{}", present.stderr);
}

#[test]
fn check_of_a_scenario_names_it_a_scenario() {
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/crossing.toml");
    let checked = ran(utm_fusion("check").arg(&scenario));
    assert_eq!(checked.code, 3, "{}", checked.stderr);
    assert!(checked.stderr.contains("this is a scenario, and no site"), "{}", checked.stderr);
    assert_eq!(checked.stderr.trim_end().lines().count(), 1, "{}", checked.stderr);
}

/// The error names the line of the file; the JSON reader counts within the line.
#[test]
fn encode_names_the_line_of_the_file_alone() {
    let scratch = Scratch::new();
    let lines = scratch.file("lines.ndjson", b"\n{\"cat\":48,\n");
    let encoded = ran(utm_fusion("encode").arg(&lines).arg("-o").arg(scratch.path("out.ast")));
    assert!(encoded.stderr.contains("line 2: "), "{}", encoded.stderr);
    assert!(!encoded.stderr.contains("line 1"), "{}", encoded.stderr);
}

#[test]
fn run_takes_its_file_as_check_does() {
    let scratch = Scratch::new();
    let site = scratch.file("site.toml", b"[site]\n");
    for command in ["run", "check"] {
        let refused = ran(utm_fusion(command).arg(&site));
        assert_eq!(refused.code, 3, "{command}: {}", refused.stderr);
        assert!(refused.stderr.contains("sensors: this key is missing"), "{command}: {}", refused.stderr);
    }
}
