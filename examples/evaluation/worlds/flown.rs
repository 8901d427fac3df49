//! Flies a world, fuses and scores it.

use std::collections::BTreeSet;

use fusion::slots::Slot;
use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::evaluate::{
    self, ErrorSample, Evaluation, InputsAlone, Labels, ScoredStream, Scoring, evaluate, integrity, output,
};
use utm_fusion::simulate::{Scenario, simulate};

use super::figures::WorldFigures;
use crate::figures::{COVERED, GAP, ScoreFigure};
use crate::flights::EvaluationFailure;
use crate::integrity::configured;

/// A scenario and its seed. It has no attacks on transponders.
pub struct World {
    pub scenario: Scenario,
    pub seed: u64,
}

impl World {
    pub fn figures(&self) -> Result<WorldFigures, EvaluationFailure> {
        let simulation = simulate(&self.scenario, self.seed, None)?;
        let truth = simulation.truth();
        let config = configured(&simulation.config);
        let labels = Labels::of_site(simulation.labels.clone(), &config);
        let scoring = Scoring::of(&config);
        let receptions = || simulation.receptions().map(Ok);
        let alone = InputsAlone::of(receptions(), &config, Masks::default())?;
        let points = output(receptions(), &config, Masks::default())?;
        let flags = integrity(&evaluate::IntegrityFlight {
            truth: &truth,
            labels: &labels,
            reports: &alone.reports,
            attacks: &[],
            output: &points,
            alerts: None,
            settings: &scoring,
        });
        let ours = evaluate(&truth, Some(&labels), &points, Some(&alone), &scoring);
        let mut paper = config.clone();
        paper.fusion.profile = Profile::Reference;
        let paper = output(receptions(), &paper, Masks::default())?;
        let paper = evaluate(&truth, Some(&labels), &paper, None, &scoring);
        let (all, equipped) = (&ours.fused.all, &ours.fused.equipped);
        let over = |scored: Option<&ScoredStream>, figure: ScoreFigure| {
            Some(figure(equipped)? / figure(&scored?.equipped)?)
        };
        let nees = all.nees;
        Ok(WorldFigures {
            name: self.scenario.name.clone(),
            seed: self.seed,
            covered: over(ours.transponder.as_ref(), COVERED),
            vertical: vertical(&ours, &scoring),
            update: equipped.pu_percent,
            update_covered: equipped.pu_covered_percent,
            update_others: ours.fused.unequipped.pu_percent,
            gap: over(ours.radar.as_ref(), GAP),
            nees: nees.map(|nees| nees.horizontal),
            nees_height: nees.and_then(|nees| nees.vertical),
            beyond: nees.map(|nees| nees.beyond_percent),
            beyond_height: nees.and_then(|nees| nees.vertical_beyond_percent),
            flags: flags.clean.flags.len(),
            hours: flags.clean.identity_h,
            precision: all.precision,
            id_changes: all.id_changes,
            two_numbers: all.two_numbers_percent,
            false_track_s: all.false_track_s,
            gospa: all.gospa_m.zip(paper.fused.all.gospa_m).map(|(ours, paper)| ours / paper),
        })
    }
}

/// Ratio of the mean height error to the transponder's, on slots that the transponder covers.
fn vertical(evaluation: &Evaluation, scoring: &Scoring) -> Option<f64> {
    let at = |sample: &ErrorSample| Some((sample.drone?, scoring.grid.of(sample.time)));
    let transponder = &evaluation.transponder.as_ref()?.samples;
    let covered: BTreeSet<(usize, Slot)> = transponder.iter().filter_map(at).collect();
    let mean_m = |samples: &[ErrorSample]| {
        let is_covered = |sample: &&ErrorSample| at(sample).is_some_and(|at| covered.contains(&at));
        let errors: Vec<f64> =
            samples.iter().filter(is_covered).filter_map(|sample| sample.error?.vertical_m()).collect();
        (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64)
    };
    Some(mean_m(&evaluation.fused.samples)? / mean_m(transponder)?)
}
