//! The paper's Table 1 with the `reference` profile, over drones with a transponder (`docs/EVALUATION.md` has more
//! seeds). The improvement is checked with a radar misaligned by two degrees, and the values in the scenario `paper`.

use std::ops::RangeInclusive;
use std::path::Path;

use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::evaluate::{InputsAlone, Labels, Scoring, StreamMetrics, evaluate, output};
use utm_fusion::simulate::{Scenario, TRANSPONDER_ID, simulate};

/// Means of a figure over flights, for the fused output and for the radar alone.
struct Means(Vec<[StreamMetrics; 2]>);

impl Means {
    /// Flies a shipped scenario with `reference`, and with `threshold_m` if given.
    fn of(name: &str, seeds: RangeInclusive<u64>, threshold_m: Option<&[(f64, f64)]>) -> Self {
        let file = format!("config/scenarios/{name}.toml");
        let scenario = Scenario::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
        let scores = seeds.map(|seed| {
            let simulation = simulate(&scenario, seed, None).unwrap();
            let mut config = simulation.config.clone();
            config.fusion.profile = Profile::Reference;
            if let Some(threshold_m) = threshold_m {
                config.fusion.threshold_m = threshold_m.to_vec();
            }
            let receptions = || simulation.receptions().map(Ok);
            let points = output(receptions(), &config, Masks::default()).unwrap();
            let alone = InputsAlone::of(receptions(), &config, Masks::default()).unwrap();
            let receivers = [TRANSPONDER_ID.to_owned()].into();
            let labels = Labels::with_receivers(simulation.labels.clone(), &receivers);
            let (truth, scoring) = (simulation.truth(), Scoring::of(&config));
            let told = evaluate(&truth, Some(&labels), &points, Some(&alone), &scoring);
            [told.fused.equipped, told.radar.unwrap().equipped]
        });
        Self(scores.collect())
    }

    fn mean(&self, figure: fn(&StreamMetrics) -> Option<f64>) -> [f64; 2] {
        [0, 1].map(|stream| {
            self.0.iter().filter_map(|of| figure(&of[stream])).sum::<f64>() / self.0.len() as f64
        })
    }

    /// Position error, metres, and probability of update, percent.
    fn both(&self) -> ([f64; 2], [f64; 2]) {
        let epos = self.mean(|score| score.epos.map(|error| error.mean_m));
        let pu = self.mean(|score| score.pu_percent);
        println!(
            "ePos: fused {:.2} m, radar {:.2} m; PU: fused {:.1} %, radar {:.1} %",
            epos[0], epos[1], pu[0], pu[1]
        );
        (epos, pu)
    }
}

#[test]
fn fusion_turns_sixty_metres_into_ten() {
    let (epos, pu) = Means::of("bias", 1..=30, None).both();
    assert!((55.0..60.0).contains(&epos[1]), "radar alone: {:.2} m", epos[1]);
    assert!(epos[0] < 12.0, "fused: {:.2} m", epos[0]);
    assert!((38.0..43.0).contains(&pu[1]), "radar alone: {:.1} %", pu[1]);
    assert!(pu[0] > pu[1] + 20.0, "fused: {:.1} %", pu[0]);
}

#[test]
fn paper_scenario_has_both_figures_together() {
    let (epos, pu) = Means::of("paper", 1101..=1110, Some(&[(0.0, 300.0)])).both();
    assert!((55.0..67.0).contains(&epos[1]), "radar alone: {:.2} m", epos[1]);
    assert!((4.5..6.5).contains(&epos[0]), "fused: {:.2} m", epos[0]);
    assert!((40.0..44.0).contains(&pu[1]), "radar alone: {:.1} %", pu[1]);
    assert!((46.5..51.0).contains(&pu[0]), "fused: {:.1} %", pu[0]);
}
