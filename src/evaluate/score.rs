//! The metrics of one stream, per group of drones.

use super::judged::{Judged, Reference, State};
use super::metrics::ghosts::{self, Ghost};
use super::metrics::scene::{Inputs, Scene};
use super::metrics::{association, false_tracks, gospa, identity, nees, statistics::statistics, update};
use super::types::{Drone, Score, Scored, Scoring};

/// What a stream is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// What a tracker publishes.
    Output,
    /// One of its inputs alone.
    Alone,
}

/// What the scores of all groups of a stream have in common.
struct Of<'a> {
    scene: Scene<'a>,
    reference: Reference<'a>,
    kind: Kind,
    ghosts: Vec<Ghost>,
}

/// Scores the counted points of a stream.
pub(super) fn scored(
    judged: &[Judged<'_>],
    drones: &[Drone],
    reference: Reference<'_>,
    inputs: Option<&Inputs>,
    settings: &Scoring,
    kind: Kind,
) -> Scored {
    let scene = Scene::new(judged, drones.len(), reference.counted, inputs);
    let ghosts = match kind {
        Kind::Output => ghosts::find(&scene, reference),
        Kind::Alone => Vec::new(),
    };
    let of = Of { scene, reference, kind, ghosts };
    let where_equipped = |wanted: bool| -> Vec<usize> {
        let is_wanted = |index: &usize| drones[*index].equipped == Some(wanted);
        (0..drones.len()).filter(is_wanted).collect()
    };
    let everyone: Vec<usize> = (0..drones.len()).collect();
    Scored {
        all: of.whole(&everyone),
        equipped: of.score(&where_equipped(true)),
        unequipped: of.score(&where_equipped(false)),
        drones: everyone.iter().map(|&drone| of.score(&[drone])).collect(),
        samples: judged.iter().map(|judged| judged.sample(settings)).collect(),
    }
}

impl Of<'_> {
    /// Of all drones together, including points of no drone.
    fn whole(&self, everyone: &[usize]) -> Score {
        let Self { scene, reference, .. } = self;
        let all_points = || scene.points(everyone).chain(scene.nobody.iter().copied());
        let (gospa_m, gospa_parts) = gospa::mean(scene, reference.truth, reference.grid).unzip();
        Score {
            precision: self.has_pairs().then(|| association::precision(all_points())).flatten(),
            false_track_s: false_tracks::seconds_a_minute(scene, reference.grid.slot_s()),
            gospa_m,
            gospa_parts,
            ..self.score(everyone)
        }
    }

    /// Whether points may join a radar track and a transponder, and labels tell whether they are one drone.
    fn has_pairs(&self) -> bool {
        self.kind == Kind::Output && self.reference.labels.is_some()
    }

    /// Of a group of drones.
    fn score(&self, group: &[usize]) -> Score {
        let Self { scene, reference, kind, ghosts } = self;
        let (pairs, is_output) = (self.has_pairs(), *kind == Kind::Output);
        let all_errors = || scene.points(group).filter_map(|judged| judged.error);
        let where_covered = |wanted: bool| {
            let is_covered = |judged: &Judged<'_>| scene.inputs?.is_covered(judged.drone?, judged.slot);
            scene.points(group).filter(move |judged| is_covered(judged) == Some(wanted))
        };
        let where_seen = |is_wanted: fn(usize) -> bool| {
            let radars = |judged: &Judged<'_>| {
                let radars = &scene.inputs?.radars[judged.drone?];
                Some(radars.get(&judged.slot).copied().unwrap_or(0))
            };
            scene.points(group).filter(move |judged| radars(judged).is_some_and(is_wanted))
        };
        let in_state = |state| {
            let points = scene.points(group).filter(move |judged| judged.state == Some(state));
            nees::mean(points)
        };
        let ghosts_s = || {
            let run_minutes = scene.counted.run_minutes();
            ghosts::seconds_a_minute(ghosts, group, reference.grid.slot_s(), run_minutes)
        };
        let distances = |points: &mut dyn Iterator<Item = &Judged<'_>>| {
            statistics(points.filter_map(|judged| judged.error).map(|error| error.distance_m()))
        };
        Score {
            pu_percent: update::probability_percent(scene, group),
            pu_covered_percent: update::probability_percent_where(scene, group, true),
            pu_gap_percent: update::probability_percent_where(scene, group, false),
            gap_within_50_m_percent: update::gap_near_percent(scene, group),
            epos: distances(&mut scene.points(group)),
            eposh: statistics(all_errors().map(|error| error.horizontal_m())),
            eposv: statistics(all_errors().filter_map(|error| error.vertical_m())),
            epos_covered: distances(&mut where_covered(true)),
            epos_gap: distances(&mut where_covered(false)),
            epos_one_radar: distances(&mut where_seen(|radars| radars == 1)),
            epos_radars: distances(&mut where_seen(|radars| radars > 1)),
            nees: nees::mean(scene.points(group)),
            nees_covered: nees::mean(where_covered(true)),
            nees_gap: nees::mean(where_covered(false)),
            nees_straight: in_state(State::Straight),
            nees_turning: in_state(State::Turning),
            nees_walked_off: in_state(State::WalkedOff),
            precision: pairs.then(|| association::precision(scene.points(group))).flatten(),
            recall: pairs.then(|| association::recall(scene, group)).flatten(),
            id_changes: identity::changes_a_minute(scene, group),
            two_numbers_percent: is_output.then(|| identity::two_numbers_percent(scene, group)).flatten(),
            ghosts_s: is_output.then(ghosts_s).flatten(),
            ..Score::default()
        }
    }
}
