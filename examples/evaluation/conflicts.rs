//! Scores of conflict predictions: flights replayed in this process.

use std::ops::RangeInclusive;

use utm_fusion::areas::Masks;
use utm_fusion::conflicts::ConflictWatch;
use utm_fusion::evaluate::{
    ConflictFlight, ConflictPrediction, ConflictScore, OutputPoint, Scoring, score_conflicts,
};
use utm_fusion::picture::PictureMaker;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Scenario, simulate};

use crate::flights::{self, EvaluationFailure};
use crate::integrity::{configured, labels};
use crate::parallel;

/// Scenarios for conflicts; the first has the straight legs.
pub const SCENARIOS: [&str; 3] = [LEGS, "crossing", "dense"];
pub const LEGS: &str = "legs";
/// Minimum number of predictions in a bin for its reliability to count.
const STATED: u64 = 50;

/// Flies each scenario with each seed, and adds up the scores.
pub fn measure(
    seeds: &RangeInclusive<u64>,
    threads: usize,
) -> Result<Vec<(&'static str, ConflictScore)>, EvaluationFailure> {
    let of_scenario = |name: &'static str| {
        let scenario = flights::scenario(name)?;
        let seeds: Vec<u64> = seeds.clone().collect();
        let scores = parallel::each(&seeds, threads, |_, seed| of_flight(&scenario, *seed));
        let mut all = ConflictScore::default();
        for score in scores {
            all = all.and(&score?);
        }
        Ok((name, all))
    };
    SCENARIOS.into_iter().map(of_scenario).collect()
}

fn of_flight(scenario: &Scenario, seed: u64) -> Result<ConflictScore, EvaluationFailure> {
    let simulation = simulate(scenario, seed, None)?;
    let mut config = configured(&simulation.config);
    config.conflicts.enabled = true;
    let mut pipeline = Pipeline::new(&config, Masks::default());
    let maker = PictureMaker::new(&config, pipeline.normaliser());
    let mut watch = ConflictWatch::new(&config);
    let volume = &config.conflicts.rules().volumes[0];
    let (mut foreseen, mut points) = (Vec::new(), Vec::new());
    let mut note = |pipeline: &mut Pipeline| {
        for mut emission in pipeline.emissions() {
            let now = emission.now.take().map(|now| maker.now(now));
            let approach = now.and_then(|now| watch.look(&now, &maker));
            foreseen.extend(
                approach.iter().flat_map(|approach| &approach.conflicts).map(ConflictPrediction::from),
            );
            let picture = maker.picture(emission);
            let tracks = picture.within(config.output.max_accuracy_m);
            points.extend(tracks.map(|track| OutputPoint::of_track(track, &maker)));
        }
    };
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        note(&mut pipeline);
    }
    pipeline.finish();
    note(&mut pipeline);
    Ok(score_conflicts(&ConflictFlight {
        truth: &simulation.truth(),
        labels: &labels(&simulation),
        output: &points,
        foreseen: &foreseen,
        volume: (volume.horizontal_m, volume.vertical_m),
        settings: &Scoring::of(&config),
    }))
}

/// A line for each figure of each scenario.
pub fn table(measured: &[(&'static str, ConflictScore)]) -> String {
    let mut text = String::new();
    for (name, score) in measured {
        let percent =
            |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        text += &format!(
            "{name:<9} {} violations, warned {}, foreseeable {}, ratio {}; {} warnings, false {} /h of {:.1} h; off {}; \
             t_cpa {} s, t_entry {} s, within 2 sigma {} of {}; {} changes\n",
            score.violations,
            percent(score.warned_share()),
            percent(score.foreseeable_share()),
            number(score.warned_share().zip(score.foreseeable_share()).map(|(warned, could)| warned / could)),
            score.warnings,
            number(score.false_per_h()),
            score.drone_h,
            number(score.unreliability(STATED)),
            number(score.t_cpa_rms_s()),
            number(score.t_entry_rms_s()),
            percent(score.within_share()),
            score.judged,
            number(score.changes_each()),
        );
        for bin in score.bins.iter().filter(|bin| bin.stated > 0) {
            let stated = bin.stated as f64;
            text += &format!(
                "          stated {:.2}, happened {:.2}, {} times\n",
                bin.sum / stated,
                bin.happened as f64 / stated,
                bin.stated
            );
        }
    }
    text
}
