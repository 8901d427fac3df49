//! Files that cannot be scored: the error messages, with their places.

use std::path::PathBuf;

use super::common::{Scratch, evaluate, ran, utm_fusion};

const TRUTH: &str = "time,id,lat,lon,alt_msl\n1773478800,A,0,0,0\n1773478804,A,0,0,0\n";
const OUTPUT: &str = "time,id,source,track_number,radar_track,transponder,lat,lon,alt_msl,flags\n";
const LABELS: &str = "time,sensor,number,id,seduced\n";

fn said(truth: &str, labels: &str, output: &[u8]) -> (i32, String) {
    let scratch = Scratch::new();
    let (truth, output) = (scratch.file("truth.csv", truth), scratch.file("out.csv", output));
    let labels = scratch.file("labels.csv", labels);
    let told = ran(evaluate(&truth, &output).arg("--labels").arg(labels));
    (told.code, told.stderr)
}

#[test]
fn invalid_truth_is_reported_with_its_line() {
    for (truth, words) in [
        ("", "truth.csv: is empty"),
        ("time,id,lat,lon\n", "truth.csv:1: no column `alt_msl`; the first line must name the columns"),
        (
            "time,id,lat,lon,alt_msl\n1,A,0,0,0\n1,A,91,0,0\n",
            "truth.csv:3: lat: \"91\" is no number of degrees from -90",
        ),
        (
            "time,id,lat,lon,alt_msl\nnoon,A,0,0,0\n",
            "truth.csv:2: time: \"noon\" is no time; write seconds UTC",
        ),
        ("time,id,lat,lon,alt_msl\n1,A,0,0,high\n", "truth.csv:2: alt_msl: \"high\" is no number of metres"),
        ("time,id,lat,lon,alt_msl\n1,,0,0,0\n", "truth.csv:2: the drone has no id"),
        ("time,id,lat,lon,alt_msl\n1,A,0,0,0\n2,A,0\n", "truth.csv:3: 3 cells, and 5 columns are named"),
        ("time,id,lat,lon,alt_msl\n", "no drone is in the truth"),
        ("<kml></kml>", "truth.csv: is XML, but no GPX"),
        ("<gpx>", "truth.csv:1: this is no well-formed XML"),
        ("<gpx></gpx>", "is GPX without a track point"),
        (
            "<gpx><trk><trkseg>\n<trkpt lat='1' lon='2'/></trkseg></trk></gpx>",
            "truth.csv:2: a track point without a time",
        ),
        (
            "<gpx><trk>\n\n<trkpt lat='x' lon='2'><time>2026-03-14T09:00:00Z</time></trkpt></trk></gpx>",
            "truth.csv:3: lat: \"x\"",
        ),
    ] {
        let (code, stderr) = said(truth, LABELS, OUTPUT.as_bytes());
        assert_eq!(code, 1, "{truth:?}: {stderr}");
        assert!(stderr.contains(words), "{truth:?}: {stderr}");
    }
}

#[test]
fn invalid_labels_are_reported_with_their_line() {
    for (labels, words) in [
        ("time,sensor,id\n", "labels.csv:1: no column `number`"),
        ("time,sensor,number,id,seduced\n1,radar,x,A,0\n", "labels.csv:2: number: \"x\" is no track number"),
        (
            "time,sensor,number,id,seduced\n\n1,radar,1,A,maybe\n",
            "labels.csv:3: seduced: \"maybe\" is neither 1 nor 0",
        ),
    ] {
        let (code, stderr) = said(TRUTH, labels, OUTPUT.as_bytes());
        assert_eq!(code, 1, "{labels:?}: {stderr}");
        assert!(stderr.contains(words), "{labels:?}: {stderr}");
    }
    let (code, stderr) = said(TRUTH, "time,sensor,number,id\n1,radar,1,OTHER\n", OUTPUT.as_bytes());
    assert_eq!(code, 0, "a doubt is no error: {stderr}");
    assert!(stderr.contains("no drone of --labels is in --truth"), "{stderr}");
    assert!(stderr.contains("no slot counts: the first 10 s"), "the truth is 4 s long: {stderr}");
}

#[test]
fn invalid_output_is_reported_with_its_line() {
    let track = r#"{"time":"2026-03-14T09:00:00.125Z","source":"radar","track_number":1,"lat":0,"lng":0}"#;
    let late = format!("{track}\n{track}\n{{\"time\":1}}\n");
    let nowhere = track.replace("\"lat\":0", "\"lat\":100");
    for (output, words) in [
        (&b""[..], "out.csv: is empty"),
        (b"hello, world\n", "out.csv:1: no column `time`"),
        (b"time,lat,lon,number\n", "out.csv:1: no column `source` or `kind`"),
        (
            b"time,kind,number,lat,lon\n1,bird,1,0,0\n",
            "out.csv:2: kind: \"bird\" is none of fused, radar, transponder",
        ),
        (b"time,kind,number,lat,lon\n1,radar,-1,0,0\n", "out.csv:2: number: \"-1\" is no track number"),
        (b"time,kind,number,lat,lon,radar_track\n1,radar,1,0,0,70000\n", "out.csv:2: radar_track: \"70000\""),
        (late.as_bytes(), "out.csv:3: this is no track as `replay` writes it"),
        (nowhere.as_bytes(), "out.csv:1: latitude 100 and longitude 0 are no place"),
        (b"{\"type\":\"FeatureCollection\",\"features\":[\n{}]}", "out.csv:2: this is no track"),
        (
            b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
            "out.csv: looks like a PNG image, which cannot be scored; give what `replay -o` writes",
        ),
        (b"\x30\x00\x08\xc0\x10\x19\x01\x00", "holds no CAT129 record"),
        (
            b"\x81\x00\x06\x80\x00\x00\x81\x00\x06\x80\x00\x00",
            "the record at offset 3 has no time of day (I129/070)",
        ),
    ] {
        let (code, stderr) = said(TRUTH, LABELS, output);
        assert_eq!(code, 1, "{output:?}: {stderr}");
        assert!(stderr.contains(words), "{output:?}: {stderr}");
    }
}

#[test]
fn a_truth_and_an_output_that_are_exchanged_are_recognised() {
    let scratch = Scratch::new();
    let truth = scratch.file("truth.csv", TRUTH);
    let labels = scratch.file("labels.csv", LABELS);
    let line = r#"{"time":"2026-03-14T09:00:00.125Z","source":"radar","track_number":1,"lat":0,"lng":0}"#;
    for (name, contents) in [
        ("out.csv", OUTPUT.as_bytes()),
        ("out.ndjson", line.as_bytes()),
        ("out.ast", b"\x81\x00\x06\x80\x00\x00"),
    ] {
        let output = scratch.file(name, contents);
        let told = ran(&mut evaluate(&output, &truth));
        let (truth, output) = (truth.display(), output.display());
        let right = format!("they are exchanged. Write: utm-fusion evaluate {output} --truth {truth}");
        assert!(told.code == 2 && told.stderr.contains(&right), "{}", told.stderr);
    }
    let output = scratch.file("out.csv", OUTPUT);
    for (given, other, words) in [
        (&output, &output, "out.csv: this is a tracker's output, not a truth"),
        (&truth, &truth, "truth.csv: this is a truth (where the drones really were), not a tracker's output"),
        (&labels, &output, "--labels takes them"),
    ] {
        let told = ran(&mut evaluate(given, other));
        assert!(told.code == 1 && told.stderr.contains(words), "{}", told.stderr);
    }
    let told = ran(evaluate(&truth, &output).arg("--labels").arg(&truth));
    assert!(told.code == 1 && told.stderr.contains("not a file of labels"), "{}", told.stderr);
}

#[test]
fn missing_file_is_reported_with_its_path() {
    let scratch = Scratch::new();
    let truth = scratch.file("truth.csv", TRUTH);
    let told = ran(&mut evaluate(&truth, &PathBuf::from("nowhere.csv")));
    assert_eq!(told.code, 1);
    assert!(told.stderr.contains("nowhere.csv: cannot be read"), "{}", told.stderr);
    let site = scratch.file("site.toml", "nonsense = 1\n");
    let mut command = evaluate(&truth, &scratch.file("out.csv", OUTPUT));
    assert_eq!(ran(command.arg("--config").arg(site)).code, 3);
}

#[test]
fn plots_are_files_that_stand_alone() {
    let scratch = Scratch::new();
    let seconds: String = (0..40).map(|second| format!("{second},A<&\"B,0,0,0\n")).collect();
    let truth =
        scratch.file("truth.csv", format!("time,id,lat,lon,alt_msl\n{}", seconds.replace("A<&\"B", "A<&B")));
    let out = scratch.file("out.csv", format!("{OUTPUT}15.125,T-7,transponder,7,,7,0.00001,0,1,\n"));
    let plots = scratch.path("plots/of/this");
    let told = ran(evaluate(&truth, &out).arg("--plot").arg(&plots));
    assert_eq!(told.code, 0, "{}", told.stderr);
    for name in [
        "error-over-time.svg",
        "error-over-range.svg",
        "error-over-azimuth.svg",
        "error-distribution.svg",
        "plan-view.svg",
        "height-over-time.svg",
    ] {
        let svg = String::from_utf8(std::fs::read(plots.join(name)).unwrap()).unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert_eq!(document.root_element().tag_name().name(), "svg", "{name}");
    }
    let page = String::from_utf8(std::fs::read(plots.join("index.html")).unwrap()).unwrap();
    assert!(page.contains("A&lt;&amp;B") && !page.contains("<script") && page.matches("<svg").count() >= 6);
    // A folder that cannot be created is reported.
    let told = ran(evaluate(&truth, &out).arg("--plot").arg(truth.join("below-a-file")));
    assert_eq!(told.code, 1);
    assert!(told.stderr.contains("--plot") && told.stderr.contains("cannot be written"), "{}", told.stderr);
}

#[test]
fn output_without_points_is_scored_as_empty() {
    let scratch = Scratch::new();
    let seconds: String = (0..40).map(|second| format!("{second},A,0,0,0\n")).collect();
    let truth = scratch.file("truth.csv", format!("time,id,lat,lon,alt_msl\n{seconds}"));
    let told = ran(evaluate(&truth, &scratch.file("out.csv", OUTPUT)).arg("--json"));
    assert!(told.stderr.contains("holds no point"), "{}", told.stderr);
    assert_eq!(told.json()["fused"]["all"]["pu_percent"], 0.0);
    assert_eq!(told.json()["fused"]["all"].get("epos"), None);
}

#[test]
fn closed_pipe_and_standard_input_are_handled() {
    let scratch = Scratch::new();
    let truth = scratch.file("truth.csv", TRUTH);
    let mut command = utm_fusion("evaluate");
    let told = ran(command.arg("--truth").arg(&truth).arg("-"));
    assert_eq!(told.code, 1);
    assert!(told.stderr.contains("standard input: is empty"), "{}", told.stderr);
}
