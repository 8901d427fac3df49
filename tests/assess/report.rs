//! The report as a page and as JSON: bytes, provenance, comparisons, and hostile input.

use std::fs;

use serde_json::Value;

use crate::program::{Scratch, utm_fusion};
use crate::{Flight, SCENARIO, assess, demo, figure, figures, simulated, simulated_as};

/// Writes the report of a flight and returns page and JSON.
fn written(scratch: &Scratch, flight: &Flight, with_truth: bool, more: &[&str]) -> (String, String) {
    let page = scratch.path("report.html");
    let output = assess(flight, with_truth, &[&["-o", page.to_str().unwrap()], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty());
    (fs::read_to_string(&page).unwrap(), fs::read_to_string(scratch.path("report.json")).unwrap())
}

#[test]
fn report_is_the_same_octet_by_octet() {
    let scratch = Scratch::new();
    let first = written(&scratch, &demo(), true, &[]);
    assert_eq!(first, written(&scratch, &demo(), true, &[]));
    let example = fs::read_to_string("docs/examples/assess-demo.html").unwrap();
    assert!(first.0 == example, "docs/examples/assess-demo.html: run scripts/assess-examples");
    for foreign in ["<script", "http://", "https://", "src="] {
        let found = first.0.replace("http://www.w3.org/2000/svg", "").contains(foreign);
        assert!(!found, "the page holds {foreign}");
    }
}

#[test]
fn report_states_its_files_by_hash() {
    let scratch = Scratch::new();
    let (page, json) = written(&scratch, &demo(), true, &[]);
    let report: Value = serde_json::from_str(&json).unwrap();
    let files = report["provenance"]["files"].as_array().unwrap();
    let roles: Vec<&str> = files.iter().map(|file| file["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["recording", "configuration", "truth"]);
    for (file, path) in files.iter().zip([demo().capture, demo().site, demo().truth]) {
        let hash = {
            use sha2::Digest;
            let digest = sha2::Sha256::digest(fs::read(path).unwrap());
            digest.iter().map(|octet| format!("{octet:02x}")).collect::<String>()
        };
        assert_eq!(file["sha256"], hash);
        assert!(page.contains(&hash));
    }
}

#[test]
fn figures_agree_with_evaluate() {
    let scratch = Scratch::new();
    let flight = simulated(&scratch, "1002");
    let report = figures(&flight, true, &[]);
    let picture = scratch.path("picture.ndjson");
    let replay = utm_fusion("replay")
        .arg(&flight.capture)
        .arg("--config")
        .arg(&flight.site)
        .arg("-o")
        .arg(&picture)
        .output();
    assert!(replay.unwrap().status.success());
    let scored = utm_fusion("evaluate")
        .arg(&picture)
        .arg("--truth")
        .arg(&flight.truth)
        .arg("--json")
        .output()
        .unwrap();
    let scored: Value = serde_json::from_slice(&scored.stdout).unwrap();
    let all = &scored["fused"]["all"];
    for (key, expected, tolerance) in [
        ("picture.detection.all", &all["pu_percent"], 0.051),
        ("picture.accuracy.horizontal.mean", &all["eposh"]["mean_m"], 0.051),
        ("picture.accuracy.horizontal.p95", &all["eposh"]["p95_m"], 0.051),
        ("picture.tracking.changes", &all["id_changes"], 0.000_51),
        ("picture.tracking.false-time", &all["false_track_s"], 0.0051),
    ] {
        let (value, expected) = (figure(&report, key)["value"].as_f64().unwrap(), expected.as_f64().unwrap());
        assert!((value - expected).abs() < tolerance, "{key}: {value}, and evaluate has {expected}");
    }
    let rms = figure(&report, "picture.accuracy.horizontal.rms");
    let [low, value, high] = ["low", "value", "high"].map(|name| rms[name].as_f64().unwrap());
    assert!(low < value && value < high, "{rms}");
}

#[test]
fn recording_does_not_differ_from_itself() {
    let scratch = Scratch::new();
    let flight = simulated(&scratch, "1003");
    let capture = flight.capture.to_str().unwrap();
    let truth = flight.truth.to_str().unwrap();
    let report = figures(&flight, true, &["--against", capture, "--against-truth", truth]);
    let compared = report["comparison"].as_array().unwrap();
    assert!(compared.len() > 50, "{}", compared.len());
    for figure in compared {
        let verdict = figure["verdict"].as_str().unwrap();
        assert!(["not-distinguishable", "no-interval"].contains(&verdict), "{figure}");
        assert_eq!(figure["difference"], 0.0, "{figure}");
    }
}

#[test]
fn misaligned_radar_differs_significantly() {
    let scratch = Scratch::new();
    // Far apart, so that a turned plot is still nearest to its own aircraft.
    let spread =
        SCENARIO.replace("pattern = \"crossing\"\n", "").replace("radius_m = 500", "radius_m = 1500");
    let flight = simulated_as(&scratch, &spread, "1004");
    let site = fs::read_to_string(&flight.site).unwrap();
    let turned = site.replace("bearing_correction_deg = 0.0", "bearing_correction_deg = 3.0");
    assert_ne!(site, turned);
    let turned = scratch.file("turned.toml", turned);
    let [capture, truth, turned] =
        [&flight.capture, &flight.truth, &turned].map(|path| path.to_str().unwrap());
    let more = ["--against", capture, "--against-truth", truth, "--against-config", turned];
    let report = figures(&flight, true, &more);
    let compared = report["comparison"].as_array().unwrap();
    let bearing =
        compared.iter().find(|figure| figure["key"] == "sensor.gamekeeper.alignment.bearing").unwrap();
    assert_eq!(bearing["verdict"], "higher", "{bearing}");
    // Plots more than 150 m away belong to no aircraft, so the mean is below 3 degrees.
    assert!((1.5..3.5).contains(&bearing["difference"].as_f64().unwrap()), "{bearing}");
}

#[test]
fn report_without_a_truth_states_what_it_cannot_say() {
    let scratch = Scratch::new();
    let (page, json) = written(&scratch, &demo(), false, &[]);
    let report: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["reference"], "transponders");
    assert!(!json.contains("tracking.false") && !json.contains("class.others"), "not known without a truth");
    assert!(
        page.contains("What this recording cannot say")
            && page.contains("internal consistency, not accuracy")
    );
    assert!(page.contains("Detection of aircraft without a transponder"));
}

#[test]
fn names_in_the_site_file_are_escaped() {
    let scratch = Scratch::new();
    let site = fs::read_to_string("config/demo.toml").unwrap();
    let name = site.lines().find(|line| line.starts_with("name = ")).unwrap();
    let hostile = site.replace(name, "name = \"<script>alert('1')</script>&\"");
    let flight = Flight { site: scratch.file("site.toml", hostile), ..demo() };
    let output = assess(&flight, true, &["-o", scratch.path("report.html").to_str().unwrap()]);
    if output.status.success() {
        let page = fs::read_to_string(scratch.path("report.html")).unwrap();
        assert!(!page.contains("<script>") && page.contains("&lt;script&gt;"));
    } else {
        assert_eq!(output.status.code(), Some(3), "such a name may be refused");
    }
}

#[test]
fn damaged_recording_is_assessed_up_to_the_damage() {
    let scratch = Scratch::new();
    let octets = fs::read("testdata/demo/capture.pcap").unwrap();
    let flight = Flight { capture: scratch.file("cut.pcap", &octets[..octets.len() / 2 + 3]), ..demo() };
    let output = assess(&flight, true, &[]);
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["cannot_say"][0]["what"], "The rest of a recording");
}

#[test]
fn usage_errors_name_the_remedy() {
    let scratch = Scratch::new();
    let said = |more: &[&str]| {
        let output = utm_fusion("assess").args(more).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let alone = scratch.file("alone.pcap", fs::read("testdata/demo/capture.pcap").unwrap());
    let alone = alone.to_str().unwrap();
    let (capture, site) = ("testdata/demo/capture.pcap", "config/demo.toml");
    let truth = "testdata/demo/truth.csv";
    for (arguments, code, text) in [
        (&[alone][..], 2, "no site.toml beside the recording"),
        (&["-", "--config", site], 2, "standard input cannot be"),
        (&[capture, "--config", site, "-o", "figures.json"], 2, "name a page"),
        (&[capture, "--config", site, "--truth", truth, "--against", capture], 2, "belong together"),
        (&[capture, "--config", "config/fusion-none.toml"], 1, "cannot be read"),
        (&[truth, "--config", site], 1, "truth.csv"),
    ] {
        let (found, message) = said(arguments);
        assert_eq!(found, Some(code), "{arguments:?}: {message}");
        assert!(message.contains(text), "{arguments:?}: {message}");
    }
}
