//! Flights of a real drone radar, if `UTM_FUSION_SHARED_DATA` is set: compares the `reference` profile with another
//! implementation.
//!
//! That implementation evaluates the whole span of the truth without labels, and interpolates the transponder over the
//! whole flight. Ours omits the first 10 s and the last 7.5 s, uses labels, and interpolates with the configured
//! latency. The differences are at most 0.8 percentage points of PU and 0.1 m.

use super::common::{Scratch, evaluate, number, ran, utm_fusion};
use super::shared::recordings;

/// Flight; PU and mean ePosH of the fused output; PU and mean ePosH of the transponder alone.
const FIGURES: [(&str, [f64; 4]); 6] = [
    ("1_1", [83.0, 0.17, 99.8, 0.10]),
    ("1_4", [60.0, 0.43, 99.8, 0.18]),
    ("2_1", [76.0, 0.34, 99.8, 0.16]),
    ("1_1/degraded", [74.0, 3.6, 87.0, 3.4]),
    ("1_4/degraded", [48.0, 3.5, 81.0, 3.3]),
    ("2_1/degraded", [67.0, 3.6, 91.0, 3.4]),
];

#[test]
fn the_reference_profile_on_real_flights() {
    let Some(root) = recordings() else { return };
    for (name, figures) in FIGURES {
        let dir = root.join("drone-trial").join(name);
        let flight = root.join("drone-trial").join(name.split('/').next().unwrap());
        let (capture, site) = (dir.join("capture.pcap"), dir.join("site.toml"));
        let scratch = Scratch::new();
        let out = scratch.path("out.csv");
        let replayed = ran(utm_fusion("replay").arg(&capture).arg("--config").arg(&site).arg("-o").arg(&out));
        assert_eq!(replayed.code, 0, "{}", replayed.stderr);
        let mut command = evaluate(&flight.join("truth.csv"), &out);
        command.arg("--labels").arg(flight.join("labels.csv")).arg("--json");
        let json = ran(command.arg("--capture").arg(&capture).arg("--config").arg(&site)).json();
        let told = [
            "fused.all.pu_percent",
            "fused.all.eposh.mean_m",
            "transponder.all.pu_percent",
            "transponder.all.eposh.mean_m",
        ]
        .map(|way| number(&json, way));
        println!("{name}: {told:.3?}, elsewhere {figures:?}");
        let within_m = if name.ends_with("degraded") { 0.1 } else { 0.02 };
        for (index, (told, figure)) in told.into_iter().zip(figures).enumerate() {
            let within = if index % 2 == 0 { 1.0 } else { within_m };
            assert!((told - figure).abs() <= within, "{name}: {told} is not {figure}");
        }
    }
}
