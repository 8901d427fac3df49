//! Probability of detection (of update), by range, height and class; update intervals and gaps.

use super::bins::{HEIGHT_STEPS_M, RANGE_STEPS_M, bin, step};
use super::bootstrap::{BlockSums, Estimator, add};
use super::scene::{AssessmentScene, MotionClass};
use super::subject::{AssessedSubject, DueUpdate, SubjectKind};
use super::types::{AssessmentFigure, FigureTable};
use fusion::time::SECOND;
use input::statistics::quantile;

/// Most bins of range, and of height.
pub(super) const RANGE_BINS: f64 = 10.0;
pub(super) const HEIGHT_BINS: f64 = 8.0;

/// Probability of update of a subject, in all and by group.
pub(super) fn probability(scene: &AssessmentScene<'_>, subject: &AssessedSubject<'_>) -> FigureTable {
    let range = |due: &DueUpdate| due.place.offset_from(&subject.origin).horizontal_m();
    let counts = |due: &&DueUpdate| {
        subject.covers(scene, due.drone) && subject.max_range_m.is_none_or(|limit_m| range(due) <= limit_m)
    };
    let due: Vec<&DueUpdate> = subject.updates.due.iter().filter(counts).collect();
    let mut figures = Vec::new();
    let mut figure = |key: String, name: &str, is_wanted: &dyn Fn(&DueUpdate) -> bool| {
        let mut sums = BlockSums::new();
        for due in due.iter().filter(|due| is_wanted(due)) {
            add(&mut sums, scene.block(due.drone, due.time), f64::from(u8::from(due.is_made)), 1.0);
        }
        if !sums.is_empty() {
            let key = (subject.figure_key(&format!("detection.{key}")), name);
            figures.push(AssessmentFigure::estimated(key, ("%", 1), Estimator::Percent, &sums, scene.seed));
        }
    };
    figure("all".to_owned(), "all", &|_| true);
    let step_m = step(due.iter().map(|due| range(due)), &RANGE_STEPS_M, RANGE_BINS);
    let ranges: std::collections::BTreeSet<i64> = due.iter().map(|due| bin(range(due), step_m)).collect();
    for index in ranges {
        let label = super::bins::label(index, step_m);
        figure(format!("range.{label}"), &format!("range {label} m"), &|due| {
            bin(range(due), step_m) == index
        });
    }
    let height = |due: &DueUpdate| due.place.altitude_amsl_m;
    let step_m = step(due.iter().filter_map(|due| height(due)), &HEIGHT_STEPS_M, HEIGHT_BINS);
    let heights: std::collections::BTreeSet<i64> =
        due.iter().filter_map(|due| height(due)).map(|height_m| bin(height_m, step_m)).collect();
    for index in heights {
        let label = super::bins::label(index, step_m);
        figure(format!("height.{label}"), &format!("height {label} m AMSL"), &|due| {
            height(due).is_some_and(|height_m| bin(height_m, step_m) == index)
        });
    }
    if scene.is_truth() && subject.kind != SubjectKind::Receiver {
        for (key, name, is_equipped) in
            [("transponder", "with a transponder", true), ("no-transponder", "without a transponder", false)]
        {
            figure(format!("class.{key}"), name, &|due| scene.equipped[due.drone] == is_equipped);
        }
    }
    for (key, motion) in [
        ("hovering", MotionClass::Hovering),
        ("straight", MotionClass::Straight),
        ("turning", MotionClass::Turning),
    ] {
        figure(format!("motion.{key}"), key, &|due| scene.motion(due.drone, due.time) == Some(motion));
    }
    for class in scene.class_names() {
        figure(format!("class.{class}"), &format!("class {class}"), &|due| {
            scene.class(due.drone) == Some(class)
        });
    }
    FigureTable { title: subject.title.clone(), figures }
}

/// Update intervals and gaps of a subject.
pub(super) fn intervals(scene: &AssessmentScene<'_>, subject: &AssessedSubject<'_>) -> FigureTable {
    let intervals = &subject.updates.intervals;
    let seconds = |length_ns: i64| length_ns as f64 / SECOND as f64;
    let mut lengths: Vec<f64> = intervals.iter().map(|interval| seconds(interval.length_ns)).collect();
    lengths.sort_by(f64::total_cmp);
    let mut sums = BlockSums::new();
    let mut gaps = scene.flown(3600.0, |drone| subject.covers(scene, drone));
    for interval in intervals {
        let block = scene.block(interval.drone, interval.until);
        add(&mut sums, block, seconds(interval.length_ns), 1.0);
        if interval.length_ns > subject.gap_ns() {
            add(&mut gaps, block, 1.0, 0.0);
        }
    }
    let key = |name: &str| subject.figure_key(&format!("interval.{name}"));
    let count = lengths.len() as u64;
    let plain = |name: &str, label: &str, value| {
        AssessmentFigure::plain(key(name), label, "s", 2, value).with_count(count)
    };
    let gap_name = format!("gaps above {} s, an aircraft-hour", seconds(subject.gap_ns()));
    let figures = vec![
        AssessmentFigure::estimated(
            (key("mean"), "update interval, mean"),
            ("s", 2),
            Estimator::Mean,
            &sums,
            scene.seed,
        ),
        plain("p50", "update interval, median", quantile(&lengths, 0.5)),
        plain("p95", "update interval, 95 %", quantile(&lengths, 0.95)),
        plain("longest", "longest gap", lengths.last().copied()),
        AssessmentFigure::estimated((key("gaps"), &gap_name), ("1/h", 1), Estimator::Rate, &gaps, scene.seed),
    ];
    FigureTable { title: subject.title.clone(), figures }
}
