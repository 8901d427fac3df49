//! The command `locate`: simulated sites, the demonstration's recording, and the drone trial's radar.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "the program writes files, and the test reads them")]

#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use program::{Scratch, utm_fusion};

/// A flight over an unknown site: eight drones, six of them with a transponder, and birds.
const FLIGHT: &str = "name = \"unknown\"\nduration_s = 180\n[drones]\nmultirotors = 6\nfixed_wings = 2\nequipped = 6\n\
    [birds]\ncount = 6\n[[radars]]\neast_m = 300\nnorth_m = 2300\nbias_azimuth_deg = 137\n";

fn located(inputs: &[&Path], more: &[&str]) -> Output {
    utm_fusion("locate").args(inputs).args(more).output().unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// A key of the first radar in a site file.
fn key(site: &str, name: &str) -> f64 {
    let line = site.lines().find(|line| line.starts_with(&format!("{name} = "))).unwrap();
    line.split(['=', '#']).nth(1).unwrap().trim().parse().unwrap()
}

/// Metres between the places of two site files.
fn apart_m(site: &str, other: &str) -> f64 {
    let difference = |name: &str| key(site, name) - key(other, name);
    let east = difference("longitude_deg") * 111_320.0 * key(site, "latitude_deg").to_radians().cos();
    (difference("latitude_deg") * 111_250.0).hypot(east)
}

fn flown(scratch: &Scratch) -> PathBuf {
    let scenario = scratch.file("unknown.toml", FLIGHT);
    let out = scratch.path("flight");
    let simulated = utm_fusion("simulate").arg(scenario).arg("--out").arg(&out).output().unwrap();
    assert!(simulated.status.success(), "{}", text(&simulated));
    out
}

#[test]
fn unknown_site_is_located_and_its_file_is_valid() {
    let scratch = Scratch::new();
    let flight = flown(&scratch);
    // Without CAT034, in which the radar states its position.
    let inputs = [flight.join("radar.ast"), flight.join("transponder.ast")];
    let (site, plot) = (scratch.path("site.toml"), scratch.path("plot.svg"));
    let more = ["-o", site.to_str().unwrap(), "--plot", plot.to_str().unwrap()];
    let output = located(&[&inputs[0], &inputs[1]], &more);
    assert!(output.status.success(), "{}", text(&output));
    let (found, truth) =
        (fs::read_to_string(&site).unwrap(), fs::read_to_string(flight.join("site.toml")).unwrap());
    assert!(apart_m(&found, &truth) < 60.0, "{found}");
    assert!((key(&found, "bearing_correction_deg") + 137.0).abs() < 2.0, "{found}");
    let checked = utm_fusion("check").arg(&site).output().unwrap();
    assert!(checked.status.success(), "{}", text(&checked));
    let figure = fs::read_to_string(&plot).unwrap();
    assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>"));
    let again = located(&[&inputs[0], &inputs[1]], &more[..2]);
    assert_eq!(again.status.code(), Some(2), "an existing file is not overwritten: {}", text(&again));
}

#[test]
fn radar_of_the_demonstration_is_located() {
    let scratch = Scratch::new();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo");
    let site = scratch.path("site.toml");
    let output = located(&[&demo.join("capture.pcap")], &["-o", site.to_str().unwrap()]);
    assert!(output.status.success(), "{}", text(&output));
    let (found, truth) =
        (fs::read_to_string(&site).unwrap(), fs::read_to_string(demo.join("site.toml")).unwrap());
    assert!(apart_m(&found, &truth) < 25.0, "{found}");
    assert!((key(&found, "bearing_correction_deg") - 0.8).abs() < 1.2, "{found}");
}

#[test]
fn recording_without_transponders_is_refused() {
    let scratch = Scratch::new();
    let output = located(&[&flown(&scratch).join("radar.ast")], &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("no transponder reports a position"), "{}", text(&output));
}

#[test]
fn trial_radar_is_located_from_its_own_flights() {
    let Some(root) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        return println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    };
    for flight in ["1_1", "1_4"] {
        let scratch = Scratch::new();
        let folder = Path::new(&root).join("drone-trial").join(flight);
        let site = scratch.path("site.toml");
        let output = located(&[&folder.join("capture.pcap")], &["-o", site.to_str().unwrap()]);
        assert!(output.status.success(), "{}", text(&output));
        let found = fs::read_to_string(&site).unwrap();
        let stated = fs::read_to_string(folder.join("site.toml")).unwrap();
        assert!(apart_m(&found, &stated) < 25.0, "{flight}: {found}");
    }
}
