//! Identification of aircraft in the picture, and classification by radars.

use std::collections::BTreeMap;

use super::bootstrap::{BlockSums, Estimator, add};
use super::scene::AssessmentScene;
use super::subject::{AssessedSubject, SubjectKind};
use super::types::{AssessmentFigure, FigureTable};

/// Probability from which a radar's target counts as a drone.
const IS_UAV: f64 = 0.5;

/// Identity of each aircraft: that of most of its reports; of equals, the first in order of letters.
pub(super) fn identities(
    scene: &AssessmentScene<'_>,
    receivers: &[&AssessedSubject<'_>],
) -> Vec<Option<String>> {
    let mut counts: Vec<BTreeMap<&str, u64>> = vec![BTreeMap::new(); scene.drones().len()];
    for point in receivers.iter().flat_map(|receiver| &receiver.scored) {
        if let (Some(drone), Some(identity)) = (point.drone, point.point.identity.as_deref()) {
            *counts[drone].entry(identity).or_default() += 1;
        }
    }
    let most = |counts: &BTreeMap<&str, u64>| {
        let most = counts.values().max()?;
        counts.iter().find(|(_, count)| *count == most).map(|(identity, _)| (*identity).to_owned())
    };
    counts.iter().map(most).collect()
}

/// Identities in the picture.
pub(super) fn identification(
    scene: &AssessmentScene<'_>,
    picture: &AssessedSubject<'_>,
    identities: &[Option<String>],
) -> FigureTable {
    let (mut named, mut wrong) = (BlockSums::new(), BlockSums::new());
    for point in &picture.scored {
        let Some(drone) = point.drone else { continue };
        let block = scene.block(drone, point.point.time);
        let stated = point.point.identity.as_deref();
        let own = identities[drone].as_deref();
        if own.is_some() {
            add(&mut named, block, f64::from(u8::from(stated.is_some())), 1.0);
        }
        if let Some(stated) = stated {
            add(&mut wrong, block, f64::from(u8::from(own != Some(stated))), 1.0);
        }
    }
    let figure = |name: &str, label: &str, sums: &BlockSums| {
        let key = (picture.figure_key(&format!("identity.{name}")), label);
        AssessmentFigure::estimated(key, ("%", 2), Estimator::Percent, sums, scene.seed)
    };
    let figures = vec![
        figure("stated", "points of aircraft with a transponder that state an identity", &named),
        figure("wrong", "stated identities that are another's", &wrong),
    ];
    FigureTable { title: picture.title.clone(), figures }
}

/// Classification by a radar that states probabilities; `None` without any.
pub(super) fn classification(
    scene: &AssessmentScene<'_>,
    subject: &AssessedSubject<'_>,
) -> Option<FigureTable> {
    if subject.kind != SubjectKind::Radar || !scene.is_truth() {
        return None;
    }
    let (mut drones, mut others) = (BlockSums::new(), BlockSums::new());
    let mut reports = subject.points.iter().zip(subject.reports);
    for scored in &subject.scored {
        // The scored points are in the order of the reports.
        let (_, report) = reports.by_ref().find(|(point, _)| std::ptr::eq(*point, scored.point))?;
        let Some(probability) = report.uav_probability else { continue };
        let is_uav = probability >= IS_UAV;
        match scored.drone {
            Some(drone) => {
                let block = scene.block(drone, scored.point.time);
                add(&mut drones, block, f64::from(u8::from(is_uav)), 1.0);
            }
            None => {
                add(&mut others, scene.block_of_run(scored.point.time), f64::from(u8::from(!is_uav)), 1.0);
            }
        }
    }
    let figure = |name: &str, label: &str, sums: &BlockSums| {
        let key = (subject.figure_key(&format!("class.{name}")), label);
        AssessmentFigure::estimated(key, ("%", 1), Estimator::Percent, sums, scene.seed)
    };
    let figures = vec![
        figure("drones", "plots of aircraft of the truth with a UAV probability of 0.5 or more", &drones),
        figure("others", "other plots with a UAV probability below 0.5", &others),
    ];
    Some(FigureTable { title: subject.title.clone(), figures })
}
