//! The paper's Table 1, in shape: a radar turned by two degrees, and the `reference` profile, over drones that carry a
//! transponder (`docs/EVALUATION.md` has it over more seeds).

use std::path::Path;

use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::evaluate::{InputsAlone, Labels, Score, Scoring, evaluate, output};
use utm_fusion::simulate::{Scenario, TRANSPONDER_ID, simulate};

const SEEDS: u64 = 30;

#[test]
fn fusion_turns_sixty_metres_into_ten() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/bias.toml");
    let scenario = Scenario::load(&path).unwrap();
    let mut scores: Vec<[Score; 2]> = Vec::new();
    for seed in 1..=SEEDS {
        let simulation = simulate(&scenario, seed, None).unwrap();
        let mut config = simulation.config.clone();
        config.fusion.profile = Profile::Reference;
        let config = &config;
        let receptions = || simulation.receptions().map(Ok);
        let points = output(receptions(), config, Masks::default()).unwrap();
        let alone = InputsAlone::of(receptions(), config, Masks::default()).unwrap();
        let labels = Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into());
        let told = evaluate(&simulation.truth(), Some(&labels), &points, Some(&alone), &Scoring::of(config));
        scores.push([told.fused.equipped, told.radar.unwrap().equipped]);
    }
    let mean = |stream: usize, figure: fn(&Score) -> Option<f64>| {
        scores.iter().filter_map(|of| figure(&of[stream])).sum::<f64>() / SEEDS as f64
    };
    let epos = [0, 1].map(|stream| mean(stream, |score| score.epos.map(|error| error.mean_m)));
    let pu = [0, 1].map(|stream| mean(stream, |score| score.pu_percent));
    println!(
        "ePos: fused {:.2} m, radar {:.2} m; PU: fused {:.1} %, radar {:.1} %",
        epos[0], epos[1], pu[0], pu[1]
    );
    assert!((55.0..60.0).contains(&epos[1]), "radar alone: {:.2} m", epos[1]);
    assert!(epos[0] < 12.0, "fused: {:.2} m", epos[0]);
    assert!((38.0..43.0).contains(&pu[1]), "radar alone: {:.1} %", pu[1]);
    assert!(pu[0] > pu[1] + 20.0, "fused: {:.1} %", pu[0]);
}
