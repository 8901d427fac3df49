//! Metrics of one stream, per group of drones.

use super::metrics::ghosts::{self, Ghost};
use super::metrics::scene::{InputSlots, StreamScene};
use super::metrics::{association, false_tracks, gospa, identity, nees, statistics::statistics, update};
use super::scored_point::{MotionState, ScoredPoint, ScoringReference};
use super::types::{ScoredStream, Scoring, StreamMetrics, TrueDrone};

/// Kind of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StreamKind {
    /// Output of a tracker.
    Output,
    /// One of its inputs alone.
    Alone,
}

/// Common inputs for the scores of all groups of a stream.
struct ScoreInputs<'a> {
    scene: StreamScene<'a>,
    reference: ScoringReference<'a>,
    kind: StreamKind,
    ghosts: Vec<Ghost>,
}

/// Scores the counted points of a stream.
pub(super) fn scored(
    scored_point: &[ScoredPoint<'_>],
    drones: &[TrueDrone],
    reference: ScoringReference<'_>,
    inputs: Option<&InputSlots>,
    settings: &Scoring,
    kind: StreamKind,
) -> ScoredStream {
    let scene = StreamScene::new(scored_point, drones.len(), reference.counted, inputs);
    let ghosts = match kind {
        StreamKind::Output => ghosts::find(&scene, reference),
        StreamKind::Alone => Vec::new(),
    };
    let of = ScoreInputs { scene, reference, kind, ghosts };
    let where_equipped = |wanted: bool| -> Vec<usize> {
        let is_wanted = |index: &usize| drones[*index].equipped == Some(wanted);
        (0..drones.len()).filter(is_wanted).collect()
    };
    let everyone: Vec<usize> = (0..drones.len()).collect();
    ScoredStream {
        all: of.whole(&everyone),
        equipped: of.score(&where_equipped(true)),
        unequipped: of.score(&where_equipped(false)),
        drones: everyone.iter().map(|&drone| of.score(&[drone])).collect(),
        samples: scored_point.iter().map(|scored_point| scored_point.sample(settings)).collect(),
    }
}

impl ScoreInputs<'_> {
    /// Score of all drones together, including points of no drone.
    fn whole(&self, everyone: &[usize]) -> StreamMetrics {
        let Self { scene, reference, .. } = self;
        let all_points = || scene.points(everyone).chain(scene.without_drone.iter().copied());
        let (gospa_m, gospa_parts) = gospa::mean(scene, reference.truth, reference.grid).unzip();
        StreamMetrics {
            precision: self.has_pairs().then(|| association::precision(all_points())).flatten(),
            false_track_s: false_tracks::seconds_a_minute(scene, reference.grid.slot_s()),
            gospa_m,
            gospa_parts,
            ..self.score(everyone)
        }
    }

    /// Whether points may combine a radar track and a transponder, and labels determine whether they are one drone.
    fn has_pairs(&self) -> bool {
        self.kind == StreamKind::Output && self.reference.labels.is_some()
    }

    /// Score of a group of drones.
    fn score(&self, group: &[usize]) -> StreamMetrics {
        let Self { scene, reference, kind, ghosts } = self;
        let (pairs, is_output) = (self.has_pairs(), *kind == StreamKind::Output);
        let all_errors = || scene.points(group).filter_map(|scored_point| scored_point.error);
        let where_covered = |wanted: bool| {
            let is_covered = |scored_point: &ScoredPoint<'_>| {
                scene.inputs?.is_covered(scored_point.drone?, scored_point.slot)
            };
            scene.points(group).filter(move |scored_point| is_covered(scored_point) == Some(wanted))
        };
        let where_seen = |is_wanted: fn(usize) -> bool| {
            let radars = |scored_point: &ScoredPoint<'_>| {
                let radars = &scene.inputs?.radars[scored_point.drone?];
                Some(radars.get(&scored_point.slot).copied().unwrap_or(0))
            };
            scene.points(group).filter(move |scored_point| radars(scored_point).is_some_and(is_wanted))
        };
        let in_state = |state| {
            let points = scene.points(group).filter(move |scored_point| scored_point.state == Some(state));
            nees::mean(points)
        };
        let ghosts_s = || {
            let run_minutes = scene.counted.run_minutes();
            ghosts::seconds_a_minute(ghosts, group, reference.grid.slot_s(), run_minutes)
        };
        let distances = |points: &mut dyn Iterator<Item = &ScoredPoint<'_>>| {
            statistics(points.filter_map(|scored_point| scored_point.error).map(|error| error.distance_m()))
        };
        StreamMetrics {
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
            nees_straight: in_state(MotionState::Straight),
            nees_turning: in_state(MotionState::Turning),
            nees_walked_off: in_state(MotionState::WalkedOff),
            precision: pairs.then(|| association::precision(scene.points(group))).flatten(),
            recall: pairs.then(|| association::recall(scene, group)).flatten(),
            id_changes: identity::changes_a_minute(scene, group),
            two_numbers_percent: is_output.then(|| identity::two_numbers_percent(scene, group)).flatten(),
            ghosts_s: is_output.then(ghosts_s).flatten(),
            ..StreamMetrics::default()
        }
    }
}
