//! Alignment of the sensors: bearing, range, height and clock.

use super::bootstrap::{BlockSums, Estimator, add};
use super::recording::biases;
use super::scene::AssessmentScene;
use super::subject::{AssessedSubject, SubjectKind};
use super::types::{AssessmentFigure, FigureTable};
use crate::evaluate::PolarPlace;
use fusion::registration::Misalignment;

/// Speed above which an aircraft shows the clock of a sensor, m/s.
const MOVES_M_S: f64 = 2.0;
/// Normal deviate of a 95 % interval.
const DEVIATE: f64 = 1.96;

/// Mean offsets of a sensor's reports from the reference.
pub(super) fn offsets(scene: &AssessmentScene<'_>, subject: &AssessedSubject<'_>) -> FigureTable {
    let [mut bearing, mut range, mut height, mut clock] = std::array::from_fn(|_| BlockSums::new());
    for scored in &subject.scored {
        let (Some(drone), Some(truth), Some(error)) = (scored.drone, scored.truth, scored.error) else {
            continue;
        };
        let block = scene.block(drone, scored.point.time);
        if subject.kind == SubjectKind::Radar {
            let [seen, real] = [scored.point.place, truth]
                .map(|place| PolarPlace::from(&place.offset_from(&subject.origin)));
            let turned_deg = (seen.azimuth_deg - real.azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
            add(&mut bearing, block, turned_deg, 1.0);
            add(&mut range, block, seen.range_m - real.range_m, 1.0);
        }
        if let Some(up_m) = error.up_m {
            add(&mut height, block, up_m, 1.0);
        }
        if let Some([east, north]) = scene.velocity(drone, scored.point.time)
            && east.hypot(north) > MOVES_M_S
        {
            let along = error.east_m * east + error.north_m * north;
            add(&mut clock, block, -along, east * east + north * north);
        }
    }
    let mut figures = Vec::new();
    for (name, label, unit, digits, sums) in [
        ("bearing", "bearing, measured less true", "°", 3, &bearing),
        ("range", "ground range, measured less true", "m", 1, &range),
        ("height", "height, measured less true", "m", 1, &height),
        ("clock", "time stamps: late by", "s", 3, &clock),
    ] {
        if !sums.is_empty() {
            let key = (subject.figure_key(&format!("alignment.{name}")), label);
            let figure = AssessmentFigure::estimated(key, (unit, digits), Estimator::Mean, sums, scene.seed);
            // The weights of the clock are squares of speeds.
            figures.push(AssessmentFigure { count: figure.count.filter(|_| name != "clock"), ..figure });
        }
    }
    FigureTable { title: subject.title.clone(), figures }
}

/// Estimates of the engine's registration at the end of the recording. Unobservable values are left out.
pub(super) fn registration(subject: &AssessedSubject<'_>, estimate: &Misalignment) -> FigureTable {
    let observable = biases(estimate).into_iter().filter(|(_, _, bias)| bias.observable);
    let figures = observable.map(|(name, unit, bias)| {
        let key = subject.figure_key(&format!("registration.{}", name.replace(' ', "-")));
        let name = format!("registration of the engine: {name}");
        let half = DEVIATE * bias.deviation;
        AssessmentFigure {
            interval: Some([bias.value - half, bias.value + half]),
            ..AssessmentFigure::plain(key, &name, unit, 3, Some(bias.value))
        }
    });
    FigureTable { title: subject.title.clone(), figures: figures.collect() }
}
