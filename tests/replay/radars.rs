//! Two radars that see drones without transponders.

use super::common::{Scratch, ran, utm_fusion};

/// Biases of the bearings of both radars, degrees.
const BIASES_DEG: [(&str, f64); 2] = [("south-west", 1.1), ("south-east", -0.8)];

/// The bearing of a radar as `replay` states it: value, deviation, and whether it is observable.
fn bearing_deg(said: &str, radar: &str) -> (f64, f64, bool) {
    let line = said.lines().find(|line| line.starts_with(&format!("registered {radar} "))).unwrap();
    let stated = line.split("bearing ").nth(1).unwrap().split('°').next().unwrap();
    let (value, deviation) = stated.split_once(" ± ").unwrap();
    (value.parse().unwrap(), deviation.parse().unwrap(), !line.contains("(bearing"))
}

#[test]
fn two_radars_align_each_other_without_transponders() {
    let scratch = Scratch::new();
    let scenario = scratch.file(
        "two.toml",
        format!(
            "name = \"two\"\nduration_s = 600\n[airspace]\neast_m = 1100\nnorth_m = 1150\nradius_m = 600\n[drones]\nmultirotors = 3\n\
             fixed_wings = 1\nequipped = 0\n[birds]\ncount = 4\n[[radars]]\nid = \"south-west\"\nsic = 200\nunseen_s = 2.0\n\
             bias_azimuth_deg = {}\n[[radars]]\nid = \"south-east\"\nsic = 201\neast_m = 2200\nnorth_m = -100\n\
             bias_azimuth_deg = {}\nunseen_s = 2.0\n",
            BIASES_DEG[0].1, BIASES_DEG[1].1
        ),
    );
    for seed in ["41", "42"] {
        let folder = scratch.path(seed);
        let simulated =
            ran(utm_fusion("simulate").arg(&scenario).args(["--seed", seed, "--out"]).arg(&folder));
        assert_eq!(simulated.code, 0, "{}", simulated.stderr);
        let said = ran(utm_fusion("replay")
            .arg(folder.join("capture.pcap"))
            .arg("--config")
            .arg(folder.join("site.toml"))
            .arg("-o")
            .arg(scratch.path("out.ndjson")));
        assert_eq!(said.code, 0, "{}", said.stderr);
        let said = String::from_utf8(said.stdout).unwrap();
        for (radar, bias_deg) in BIASES_DEG {
            let (value, deviation, observable) = bearing_deg(&said, radar);
            println!("seed {seed}, {radar}: {value:+.2} ± {deviation:.2}°, {bias_deg:+.1}° is right");
            assert!(observable && deviation < 0.5, "{said}");
            assert!((value - bias_deg).abs() < 3.5 * deviation, "{said}");
        }
        assert!(said.contains("min of aircraft that other radars see"), "{said}");
    }
}
