//! The metrics of one stream, per group of drones.

use super::judged::{Judged, Reference};
use super::metrics::scene::{Inputs, Scene};
use super::metrics::{association, false_tracks, gospa, identity, nees, statistics::statistics, update};
use super::types::{Drone, Score, Scored, Scoring};

/// Scores the counted points of a stream. `pairs`: whether they may join a radar track and a transponder.
pub(super) fn scored(
    judged: &[Judged<'_>],
    drones: &[Drone],
    reference: Reference<'_>,
    inputs: Option<&Inputs>,
    settings: &Scoring,
    pairs: bool,
) -> Scored {
    let scene = Scene::new(judged, drones.len(), reference.counted, inputs);
    let where_equipped = |wanted: bool| -> Vec<usize> {
        let is_wanted = |index: &usize| drones[*index].equipped == Some(wanted);
        (0..drones.len()).filter(is_wanted).collect()
    };
    let everyone: Vec<usize> = (0..drones.len()).collect();
    let pairs = pairs && reference.labels.is_some();
    Scored {
        all: whole(&scene, &everyone, reference, pairs),
        equipped: score(&scene, &where_equipped(true), pairs),
        unequipped: score(&scene, &where_equipped(false), pairs),
        drones: everyone.iter().map(|&drone| score(&scene, &[drone], pairs)).collect(),
        samples: judged.iter().map(|judged| judged.sample(settings)).collect(),
    }
}

/// Of all drones together, including points of no drone.
fn whole(scene: &Scene<'_>, everyone: &[usize], reference: Reference<'_>, pairs: bool) -> Score {
    let all_points = || scene.points(everyone).chain(scene.nobody.iter().copied());
    let (gospa_m, gospa_parts) = gospa::mean(scene, reference.truth, reference.grid).unzip();
    Score {
        precision: pairs.then(|| association::precision(all_points())).flatten(),
        false_track_s: false_tracks::seconds_a_minute(scene, reference.grid.slot_s()),
        gospa_m,
        gospa_parts,
        ..score(scene, everyone, pairs)
    }
}

/// Of a group of drones.
fn score(scene: &Scene<'_>, group: &[usize], pairs: bool) -> Score {
    let all_errors = || scene.points(group).filter_map(|judged| judged.error);
    let where_covered = |wanted: bool| {
        let is_covered = |judged: &Judged<'_>| scene.inputs?.is_covered(judged.drone?, judged.slot);
        scene.points(group).filter(move |judged| is_covered(judged) == Some(wanted))
    };
    let distances = |points: &mut dyn Iterator<Item = &Judged<'_>>| {
        statistics(points.filter_map(|judged| judged.error).map(|error| error.distance_m()))
    };
    Score {
        pu_percent: update::probability_percent(scene, group),
        pu_covered_percent: update::probability_percent_where(scene, group, true),
        pu_gap_percent: update::probability_percent_where(scene, group, false),
        epos: distances(&mut scene.points(group)),
        eposh: statistics(all_errors().map(|error| error.horizontal_m())),
        eposv: statistics(all_errors().filter_map(|error| error.vertical_m())),
        epos_covered: distances(&mut where_covered(true)),
        epos_gap: distances(&mut where_covered(false)),
        nees: nees::mean(scene.points(group)),
        nees_covered: nees::mean(where_covered(true)),
        nees_gap: nees::mean(where_covered(false)),
        precision: pairs.then(|| association::precision(scene.points(group))).flatten(),
        recall: pairs.then(|| association::recall(scene, group)).flatten(),
        id_changes: identity::changes_a_minute(scene, group),
        ..Score::default()
    }
}
