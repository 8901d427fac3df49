//! Options, exit codes, and truncated files.

#![expect(clippy::disallowed_methods, reason = "files that the program wrote")]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;
use utm_fusion::commands::Outcome;

use super::{Temporary, block, fix, info, json, octets, pcap, plot};

fn whole() -> Vec<u8> {
    pcap(&[(10.0, 8048, block(48, &[plot(7, 9.0, 1)])), (11.0, 8048, block(48, &[plot(7, 10.0, 1)]))])
}

#[test]
fn strict_tells_of_what_cannot_be_read() {
    let good = Temporary::new("good", &whole());
    let bad = Temporary::new("bad", &pcap(&[(10.0, 8048, block(48, &["40 0000".to_owned()]))]));
    let mut fragment = whole();
    fragment[24 + 16 + 20] = 0x20; // more fragments
    let lost = Temporary::new("lost", &fragment);
    assert_eq!(info(&[&good.0], false, true).1, Outcome::Done);
    assert_eq!(info(&[&bad.0], false, false).1, Outcome::Done);
    assert_eq!(info(&[&bad.0, &good.0], false, true).1, Outcome::InputErrors);
    let (text, outcome) = info(&[&lost.0], false, true);
    assert_eq!(outcome, Outcome::InputErrors);
    assert!(text.contains("skipped 1 fragmented\n"), "{text}");
    assert!(text.contains("\n\n1 frame may have held records and could not be read\n"), "{text}");
}

/// Runs the program in a folder.
fn in_folder(folder: &Path, args: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_utm-fusion"));
    let output = command.args(args).current_dir(folder).stdin(Stdio::null()).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

#[test]
fn configuration_asks_for_what_no_capture_tells() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo");
    let folder = Temporary::folder("config-out");
    fs::copy(demo.join("capture.pcap"), folder.0.join("capture.pcap")).unwrap();
    let said = |args: &[&str]| in_folder(&folder.0, args);

    let (code, told) = said(&["info", "capture.pcap", "--config-out", "site.toml"]);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("site.toml: written") && told.contains("\n048 70/41"), "{told}");
    let site = fs::read_to_string(folder.0.join("site.toml")).unwrap();
    assert!(site.contains("id = \"radar-70-41\"") && site.contains("id = \"transponder-0-0\""), "{site}");

    // The configuration is incomplete: each open value is named with its line.
    let (code, told) = said(&["check", "site.toml"]);
    assert_eq!(code, Some(3), "{told}");
    let open = ["latitude_deg", "longitude_deg", "height_amsl_m"];
    for key in open {
        let line = site.lines().position(|line| line.starts_with(key)).unwrap() + 1;
        let words =
            format!("site.toml:{line}: sensors[0].{key} = \"fill in\": this is still to be filled in; ");
        assert!(told.contains(&words), "{words}\n{told}");
    }
    assert_eq!(told.lines().count(), open.len(), "nothing else is wrong: {told}");

    // Values that were filled in are not overwritten.
    let filled = ["53.0817", "10.3264", "72.0"].into_iter();
    let filled =
        filled.fold(site.clone(), |site, value| site.replacen("\"fill in\"  ", &format!("{value}  "), 1));
    fs::write(folder.0.join("site.toml"), &filled).unwrap();
    let (code, told) = said(&["info", "capture.pcap", "--config-out", "site.toml"]);
    assert!(code == Some(2) && told.contains("the file exists and is not overwritten"), "{told}");
    assert_eq!(fs::read_to_string(folder.0.join("site.toml")).unwrap(), filled);

    let (code, told) = said(&["check", "site.toml"]);
    assert_eq!(code, Some(0), "{told}");
    let (code, told) = said(&["replay", "capture.pcap", "--config", "site.toml"]);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("sensor     radar-70-41 (radar): ") && told.contains(" fused, "), "{told}");
}

#[test]
fn a_configuration_is_written_of_what_is_there_only() {
    let folder = Temporary::folder("config-out-parts");
    let said = |args: &[&str]| in_folder(&folder.0, args);
    fs::write(folder.0.join("nothing.pcap"), pcap(&[(10.0, 8048, block(200, &["0102".to_owned()]))]))
        .unwrap();
    let (code, told) = said(&["info", "nothing.pcap", "--config-out", "site.toml"]);
    assert!(code == Some(1) && told.contains("not written: the input has no sensor"), "{told}");
    assert!(!folder.0.join("site.toml").exists());

    // Two lines of one radar, and a receiver, in three files: one radar with two inputs.
    let names = ["a.pcap", "b.pcap", "c.pcap"];
    let blocks = [block(48, &[plot(7, 9.0, 1)]), block(48, &[plot(7, 9.0, 1)]), block(129, &[fix(9.0, 1)])];
    for ((name, block), port) in names.into_iter().zip(blocks).zip([8048, 8049, 8129]) {
        fs::write(folder.0.join(name), pcap(&[(10.0, port, block)])).unwrap();
    }
    let (code, told) = said(&["info", "a.pcap", "b.pcap", "c.pcap", "--config-out", "all.toml"]);
    assert_eq!(code, Some(0), "{told}");
    let all = fs::read_to_string(folder.0.join("all.toml")).unwrap();
    assert_eq!(all.matches("[[sensors]]").count(), 2, "{all}");
    let locate = "utm-fusion locate a.pcap b.pcap c.pcap -o ";
    assert!(
        told.contains(&format!("`{locate}site.toml`"))
            && all.contains(&format!("#   {locate}located.toml\n")),
        "{told}{all}"
    );
    let both = "{ group = \"239.192.48.1\", port = 8048 }, { group = \"239.192.48.1\", port = 8049 }";
    assert!(all.contains(both), "{all}");

    // Without a radar in the recording all of its values are open.
    let (code, told) = said(&["info", "c.pcap", "--config-out", "c.toml"]);
    assert_eq!(code, Some(0), "{told}");
    assert!(!told.contains("locate"), "there is no radar: {told}");
    let open = fs::read_to_string(folder.0.join("c.toml")).unwrap();
    assert!(!open.contains("locate"), "{open}");
    let (code, told) = said(&["check", "c.toml"]);
    assert!(code == Some(3) && told.lines().count() == 5, "{told}");
    assert!(told.lines().all(|line| line.contains("this is still to be filled in; ")), "{told}");
}

/// The site of a recording without CAT048 and CAT129 is complete once the radar's position is filled in.
#[test]
fn config_out_lists_adsb_and_remote_id_receivers() {
    let folder = Temporary::folder("config-out-others");
    let said = |args: &[&str]| in_folder(&folder.0, args);
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/event.toml");
    let scenario = fs::read_to_string(scenario).unwrap().replace("duration_s = 300", "duration_s = 20");
    fs::write(folder.0.join("event.toml"), scenario).unwrap();
    let (code, told) = said(&["simulate", "event.toml", "--out", "event"]);
    assert_eq!(code, Some(0), "{told}");
    let (code, told) = said(&["info", "event/capture.pcap", "--config-out", "site.toml"]);
    assert_eq!(code, Some(0), "{told}");
    let site = fs::read_to_string(folder.0.join("site.toml")).unwrap();
    for kind in ["radar", "transponder", "adsb", "remote-id"] {
        assert!(site.contains(&format!("kind = \"{kind}\"\n")), "{kind}: {site}");
    }
    fs::write(folder.0.join("whole.toml"), site.replace("\"fill in\"", "50.0")).unwrap();
    let (code, told) = said(&["check", "whole.toml"]);
    assert_eq!(code, Some(0), "{told}\n{site}");
}

#[test]
fn a_damaged_file_is_told_up_to_there_and_the_next_one_is_read() {
    let mut octets = whole();
    octets.pop();
    let (cut, good) = (Temporary::new("cut", &octets), Temporary::new("next", &whole()));
    let (text, outcome) = info(&[&cut.0, &good.0], false, true);
    assert_eq!(outcome, Outcome::InputUnreadable);
    assert!(
        text.contains("\ndamage     at offset 94: the file ends in the middle of a pcap record"),
        "{text}"
    );
    assert!(text.contains("\n048 25/7           1  100 %"), "{text}");
    assert!(text.contains("\n\n") && text.contains("\n048 25/7           2  100 %"), "{text}");
    let (lines, _) = info(&[&cut.0, &good.0], true, false);
    assert_eq!(lines.lines().count(), 2);
}

#[test]
fn unknown_categories_are_counted_and_named_if_known() {
    let file = [block(48, &[plot(7, 9.0, 1)]), block(205, &["01".to_owned()]), block(200, &[])].concat();
    let info = json("unknown", &file);
    let categories: Vec<_> = info["categories"].as_array().unwrap().iter().map(Value::to_string).collect();
    assert_eq!(
        categories,
        [
            r#"{"category":48,"name":"monoradar target reports","blocks":1,"octets":12,"records":1}"#,
            r#"{"category":200,"name":null,"blocks":1,"octets":3,"records":null}"#,
            r#"{"category":205,"name":"radio direction finder reports","blocks":1,"octets":4,"records":0}"#,
        ]
    );
}

#[test]
fn service_messages_are_told_by_source_and_item() {
    // CAT034: 010, 000, 030. CAT065, whose FRN 8 to 12 are not defined: 010, 000, 030 and SP.
    let file = [
        block(34, &["e0 1907 01 000480".to_owned()]),
        block(65, &["d1 02 1908 01 000500 02aa".to_owned(), "d0 1908 01 000580".to_owned()]),
    ];
    let info = json("service", &file.concat());
    let sources: Vec<_> = info["sources"].as_array().unwrap().iter().collect();
    assert_eq!(
        (&sources[0]["category"], &sources[0]["sic"], &sources[0]["records"]),
        (&34.into(), &7.into(), &1.into())
    );
    assert_eq!(
        (&sources[1]["category"], &sources[1]["sic"], &sources[1]["records"]),
        (&65.into(), &8.into(), &2.into())
    );
    assert_eq!(sources[0]["items"].to_string(), r#"{"010":1,"000":1,"030":1}"#);
    assert_eq!(sources[1]["items"].to_string(), r#"{"010":2,"000":2,"030":2,"SP":1}"#);
}

#[test]
fn a_final_recording_has_messages_and_no_frames() {
    let data = block(48, &[plot(7, 9.0, 1)]);
    let length = (data.len() + 12) as u16;
    let file = [&length.to_be_bytes()[..], &[0, 0, 0, 0, 0x03, 0x84], &data, &[0xa5; 4]].concat();
    let file = Temporary::new("final", &file);
    let (told, _) = info(&[&file.0], false, false);
    assert!(told.contains("format     FINAL recording, 24 octets\n"), "{told}");
    assert!(told.contains("content    1 recorded message with 12 octets\n"), "{told}");
}

#[test]
fn a_raw_file_with_rubbish_behind_its_blocks() {
    let info = json("rubbish", &[block(48, &[plot(7, 9.0, 1)]), octets("30 ffff 00")].concat());
    assert_eq!(info["errors"][0]["kind"], "block_past_end");
    assert_eq!((&info["errors"][0]["first_offset"], &info["octets"]), (&12.into(), &16.into()));
}

#[test]
fn exit_codes() {
    let info = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_utm-fusion")).arg("info").args(arguments).output().unwrap();
        (output.status.code(), output.stdout.is_empty())
    };
    let mut octets = whole();
    let good = Temporary::new("code-good", &octets);
    octets.pop();
    let cut = Temporary::new("code-cut", &octets);
    let bad = Temporary::new("code-bad", &pcap(&[(10.0, 8048, block(48, &["40 0000".to_owned()]))]));
    let [good, cut, bad] = [&good, &cut, &bad].map(|file| file.0.to_str().unwrap());
    assert_eq!(info(&[good, "--strict"]), (Some(0), false));
    assert_eq!(info(&[cut, "--strict"]), (Some(1), false));
    assert_eq!(info(&[bad, "--strict"]), (Some(4), false));
    assert_eq!(info(&[good, "/nonexistent.ast"]), (Some(1), true));
    assert_eq!(info(&[]), (Some(2), true));
}
