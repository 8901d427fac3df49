//! Position errors, or differences from transponders.

use std::collections::BTreeSet;

use super::bins::{HEIGHT_STEPS_M, RANGE_STEPS_M, bin, label, step};
use super::bootstrap::{BlockSums, Estimator, add};
use super::detection::{HEIGHT_BINS, RANGE_BINS};
use super::scene::AssessmentScene;
use super::subject::{AssessedSubject, SubjectKind};
use super::types::{AssessmentFigure, FigureTable};
use crate::evaluate::{LocalOffset, ScoredPoint, statistics};

/// A point's error, and where its aircraft was.
struct PositionError<'a> {
    point: &'a ScoredPoint<'a>,
    drone: usize,
    error: LocalOffset,
    range_m: f64,
    height_m: Option<f64>,
}

/// Errors of a subject's points.
pub(super) fn errors(scene: &AssessmentScene<'_>, subject: &AssessedSubject<'_>) -> FigureTable {
    let error = |point| position_error(point, subject);
    let errors: Vec<PositionError<'_>> = subject.scored.iter().filter_map(error).collect();
    let key = |name: &str| subject.figure_key(&format!("accuracy.{name}"));
    let mut figures = Vec::new();
    let mut estimated =
        |name: &str, label: &str, estimator, of: &dyn Fn(&PositionError<'_>) -> Option<f64>| {
            let mut sums = BlockSums::new();
            for error in &errors {
                if let Some(value) = of(error) {
                    add(&mut sums, scene.block(error.drone, error.point.point.time), value, 1.0);
                }
            }
            if !sums.is_empty() {
                let name = (key(name), label);
                figures.push(AssessmentFigure::estimated(name, ("m", 1), estimator, &sums, scene.seed));
            }
        };
    let horizontal = |error: &PositionError<'_>| error.error.horizontal_m();
    let vertical = |error: &PositionError<'_>| error.error.vertical_m();
    estimated("horizontal.mean", "horizontal, mean", Estimator::Mean, &|error| Some(horizontal(error)));
    estimated("horizontal.rms", "horizontal, RMS", Estimator::Root, &|error| Some(horizontal(error).powi(2)));
    estimated("vertical.mean", "vertical, mean", Estimator::Mean, &vertical);
    estimated("vertical.rms", "vertical, RMS", Estimator::Root, &|error| Some(vertical(error)?.powi(2)));
    let step_m = step(errors.iter().map(|error| error.range_m), &RANGE_STEPS_M, RANGE_BINS);
    for index in errors.iter().map(|error| bin(error.range_m, step_m)).collect::<BTreeSet<i64>>() {
        let label = label(index, step_m);
        let name = format!("horizontal.rms.range.{label}");
        estimated(&name, &format!("horizontal, RMS, range {label} m"), Estimator::Root, &|error| {
            (bin(error.range_m, step_m) == index).then(|| horizontal(error).powi(2))
        });
    }
    let heights = || errors.iter().filter_map(|error| error.height_m);
    let step_m = step(heights(), &HEIGHT_STEPS_M, HEIGHT_BINS);
    for index in heights().map(|height_m| bin(height_m, step_m)).collect::<BTreeSet<i64>>() {
        let label = label(index, step_m);
        let name = format!("horizontal.rms.height.{label}");
        estimated(&name, &format!("horizontal, RMS, height {label} m AMSL"), Estimator::Root, &|error| {
            (bin(error.height_m?, step_m) == index).then(|| horizontal(error).powi(2))
        });
    }
    for class in scene.class_names() {
        let name = format!("horizontal.rms.class.{class}");
        estimated(&name, &format!("horizontal, RMS, class {class}"), Estimator::Root, &|error| {
            (scene.class(error.drone) == Some(class)).then(|| horizontal(error).powi(2))
        });
    }
    let of_all = statistics(errors.iter().map(horizontal));
    for (name, label, value) in [
        ("horizontal.p50", "horizontal, median", of_all.map(|of_all| of_all.p50_m)),
        ("horizontal.p95", "horizontal, 95 %", of_all.map(|of_all| of_all.p95_m)),
    ] {
        figures
            .push(AssessmentFigure::plain(key(name), label, "m", 1, value).with_count(errors.len() as u64));
    }
    if scene.is_truth() && subject.kind == SubjectKind::Picture {
        for (name, label, is_equipped) in
            [("transponder", "with a transponder", true), ("no-transponder", "without a transponder", false)]
        {
            let of_group = errors.iter().filter(|error| scene.equipped[error.drone] == is_equipped);
            let mut sums = BlockSums::new();
            for error in of_group {
                let block = scene.block(error.drone, error.point.point.time);
                add(&mut sums, block, horizontal(error).powi(2), 1.0);
            }
            if !sums.is_empty() {
                let name =
                    (key(&format!("horizontal.rms.class.{name}")), format!("horizontal, RMS, {label}"));
                let name = (name.0, name.1.as_str());
                figures.push(AssessmentFigure::estimated(name, ("m", 1), Estimator::Root, &sums, scene.seed));
            }
        }
    }
    FigureTable { title: subject.title.clone(), figures }
}

fn position_error<'a>(
    point: &'a ScoredPoint<'a>,
    subject: &AssessedSubject<'_>,
) -> Option<PositionError<'a>> {
    let truth = point.truth?;
    Some(PositionError {
        point,
        drone: point.drone?,
        error: point.error?,
        range_m: truth.offset_from(&subject.origin).horizontal_m(),
        height_m: truth.altitude_amsl_m,
    })
}
