//! The pass that assigns radar tracks to targets.
//!
//! It runs when the tracks of all radars have been compared, radar by radar. The tracks that have begun are assigned
//! first, one to one at the least cost, then the tracks that begin in the seconds ahead. Slots are decided seconds
//! later, so these tracks are known. Their plots show where a target is that no sensor detects now, or that only
//! another radar detects: the bias of the remaining radar is best known between two times at which ranges cross.
//!
//! Without a transponder a track is also compared with the tracks of other radars ([`radar_pairs`]). Two targets that turn
//! out to be one are merged into the older one.
//!
//! The order matters. A target with a newly assigned track of this radar is detected again, so no track ahead may claim
//! it. A target found by one radar, by a present track or one ahead, is no longer missing for the next radar.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::cycle::{Cycle, LATEST};
use super::ids::{TargetId, TrackletId};
use super::likelihood::PairLikelihood;
use super::manual_association::DecidedPairs;
use super::radar_pairs;
use super::reacquisition::{self, MeasuredPositions, UndetectedTargets};
use super::reacquisition_doubt::Doubt;
use super::settings::{RadarSettings, periods};
use super::shared;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    ASSOCIATE_LLR, CLASS_LLR_MAX, DISSOCIATE_LLR, HYSTERESIS_LLR, LOOK_AHEAD_S, MUTUAL_ASSOCIATE_LLR,
    PAIR_LLR_MAX, REACQUIRE_AHEAD_LLR, REACQUIRE_LLR, TRACK_LASTS_PERIODS,
};
use crate::assignment::{Candidate, assign};
use crate::filter::StateEstimate;
use crate::report::SensorIndex;

/// New targets of tracklets, in the order in which they take effect.
type TrackAssignments = Vec<TrackAssignment>;

/// New target of a tracklet, and the doubt if it was found by its position.
#[derive(Clone, Copy, Debug)]
struct TrackAssignment {
    tracklet: TrackletId,
    target: Option<TargetId>,
    doubt: Option<Doubt>,
}

/// The steps of the pass, in order.
const STEPS: [fn(&RadarTracks) -> TrackAssignments; 2] =
    [|tracks| tracks.assign_begun(), |tracks| tracks.assign_ahead()];

/// Assigns radar tracks to targets.
pub(super) fn associate(
    tracklets: &mut Tracklets,
    targets: &mut Targets,
    measured: &MeasuredPositions,
    decided: &DecidedPairs,
    cycle: &Cycle,
) {
    let silent = &SilentTarget::all(targets, cycle);
    for (sensor, radar) in cycle.settings.radars() {
        for assign in STEPS {
            let tracks = RadarTracks { sensor, radar, tracklets, targets, measured, silent, decided, cycle };
            for TrackAssignment { tracklet, target, doubt } in assign(&tracks) {
                if tracklets.get(tracklet).is_some_and(|known| known.target() != target) {
                    targets.mark_wrong(tracklets, tracklet, cycle);
                    target.into_iter().for_each(|target| targets.record_doubt(target, doubt));
                }
                match target {
                    Some(target) => targets.follow_together(tracklets, tracklet, target),
                    None => targets.assign_track(tracklets, tracklet, None),
                }
            }
        }
    }
}

/// The tracks of one radar, and the targets to which they may belong.
struct RadarTracks<'a> {
    sensor: SensorIndex,
    radar: &'a RadarSettings,
    tracklets: &'a Tracklets,
    targets: &'a Targets,
    measured: &'a MeasuredPositions,
    silent: &'a [SilentTarget],
    decided: &'a DecidedPairs,
    cycle: &'a Cycle<'a>,
}

/// A target without a transponder position in this slot. Its expected position is computed once, when it is first
/// needed.
struct SilentTarget {
    target: TargetId,
    expected: OnceLock<Option<StateEstimate>>,
}

impl SilentTarget {
    /// All such targets, in order.
    fn all(targets: &Targets, cycle: &Cycle) -> Vec<Self> {
        let is_silent = |target: &&Target| {
            !targets.is_companion(target.id()) && !target.is_on_curve(cycle.centre, cycle.settings)
        };
        let silent = targets.iter().filter(is_silent);
        silent.map(|target| Self { target: target.id(), expected: OnceLock::new() }).collect()
    }
}

/// A candidate target of a radar track.
struct CandidateScore {
    target: TargetId,
    llr: f64,
    by: CandidateEvidence,
}

/// Kind of evidence for a candidate.
#[derive(Clone, Copy, Debug)]
enum CandidateEvidence {
    /// The target's transponder.
    Transponder,
    /// The target's tracks of other radars.
    OtherRadars,
    /// The target's expected position, because no sensor detects it.
    Place,
}

impl CandidateEvidence {
    /// Minimum LLR for a new assignment.
    fn least(self) -> f64 {
        match self {
            Self::Transponder => ASSOCIATE_LLR,
            Self::OtherRadars => MUTUAL_ASSOCIATE_LLR,
            Self::Place => REACQUIRE_LLR,
        }
    }
}

impl RadarTracks<'_> {
    fn tracklets(&self) -> impl Iterator<Item = &Tracklet> {
        self.tracklets.of_radar(self.sensor)
    }

    /// Assigns the tracks that have begun, and have a present or recent plot.
    fn assign_begun(&self) -> TrackAssignments {
        let cycle = self.cycle;
        let lasts_for = periods(TRACK_LASTS_PERIODS, self.radar.period_s).max(cycle.end - cycle.begin);
        let lasts = |tracklet: &&Tracklet| {
            tracklet.first() < cycle.end && cycle.centre - tracklet.last() <= lasts_for
        };
        let unseen = self.unseen();
        let lasting: Vec<&Tracklet> = self.tracklets().filter(lasts).collect();
        let threads = cycle.settings.threads;
        let scores = shared::map(threads, &lasting, |tracklet| self.scores(tracklet, &unseen));
        let mut problem = AssignmentProblem::default();
        for (tracklet, scores) in lasting.into_iter().zip(scores) {
            let candidate = |score: CandidateScore| {
                let (least, bonus) = match tracklet.target() == Some(score.target) {
                    true => (DISSOCIATE_LLR, HYSTERESIS_LLR),
                    false => (score.by.least(), 0.0),
                };
                let is_free = self.decided.leaves(tracklet, score.target);
                (is_free && score.llr > least).then_some((score.target, DISSOCIATE_LLR - bonus - score.llr))
            };
            let finds = scores.iter().filter(|score| matches!(score.by, CandidateEvidence::Place));
            let finds = finds.map(|score| (score.target, score.llr)).collect();
            problem.add(tracklet.id, scores.into_iter().filter_map(candidate), finds);
        }
        let assigned =
            problem.solve(|tracklet, target, finds| self.doubt(tracklet, target, finds)).into_iter();
        assigned
            .map(|assigned| match self.decided.target(assigned.tracklet) {
                Some(target) => TrackAssignment { target: Some(target), doubt: None, ..assigned },
                None => assigned,
            })
            .collect()
    }

    /// Doubt that a track is this one of the targets found by their positions, each with its LLR.
    fn doubt(&self, id: TrackletId, target: TargetId, finds: &[(TargetId, f64)]) -> Option<Doubt> {
        let &(_, llr) = finds.iter().rev().find(|find| find.0 == target)?;
        let since = self.tracklets.get(id)?.first().max(self.cycle.centre);
        let expected = self.targets.get(target)?.estimate(since)?;
        let all: Vec<f64> = finds.iter().map(|find| find.1).collect();
        Some(Doubt::new(llr, &all, expected.sigma_m().powi(2), since))
    }

    /// Candidate targets of a track.
    fn scores(&self, tracklet: &Tracklet, unseen: &UndetectedTargets) -> Vec<CandidateScore> {
        let centre = self.cycle.centre;
        let existence = tracklet.existence();
        if existence.is_vetoed() {
            return Vec::new();
        }
        let class = existence.log_odds().min(CLASS_LLR_MAX);
        // The track's present target may have a transponder that is received again, and was never compared with it.
        let unheard = tracklet.target().filter(|&own| tracklet.pair(own).is_none());
        let unheard = unheard.map(|own| (own, PairLikelihood::default()));
        let leads = |pair: &(TargetId, PairLikelihood)| !self.targets.is_companion(pair.0);
        let pairs = tracklet.pairs().iter().copied().chain(unheard).filter(leads);
        let compared = pairs.filter_map(|(target, pair)| {
            let pair = pair.at(centre);
            let is_own = tracklet.target() == Some(target);
            let so_far = pair.llr + class - pair.bias_penalty;
            if so_far + PAIR_LLR_MAX <= if is_own { DISSOCIATE_LLR } else { ASSOCIATE_LLR } {
                return None; // no plots ahead can change this
            }
            let ahead = self.ahead(tracklet, target)?;
            ahead.total().or(pair.total())?;
            let llr = pair.llr + ahead.llr + class - pair.bias_penalty.max(ahead.bias_penalty);
            Some(CandidateScore { target, llr, by: CandidateEvidence::Transponder })
        });
        let mut scores: Vec<CandidateScore> = compared.collect();
        for score in self.radar_pair_scores(tracklet) {
            scores.retain(|compared| compared.target != score.target);
            scores.push(score);
        }
        match tracklet.target() {
            // The track keeps its target if there is no evidence on it.
            Some(target)
                if tracklet.pair_llr(target).is_none()
                    && !scores.iter().any(|score| score.target == target) =>
            {
                scores.push(CandidateScore { target, llr: 0.0, by: CandidateEvidence::Transponder });
            }
            Some(_) => {}
            None => {
                let plot = tracklet.nearest(centre);
                for (target, llr) in plot.into_iter().flat_map(|plot| unseen.near(plot, self.radar)) {
                    scores.retain(|compared| compared.target != target);
                    // The likelihood from before the target was lost counts as well.
                    let class = self.targets.get(target).map_or(class, |target| target.class_llr(tracklet));
                    let llr = tracklet.pair_llr(target).unwrap_or(0.0) + llr + class;
                    scores.push(CandidateScore {
                        target,
                        llr: llr + self.total_ahead(tracklet, target),
                        by: CandidateEvidence::Place,
                    });
                }
            }
        }
        scores
    }

    /// Likelihood of a track and a target's transponder from the plots after the slot, back to the slot.
    fn ahead(&self, tracklet: &Tracklet, target: TargetId) -> Option<PairLikelihood> {
        let Cycle { centre, settings, .. } = *self.cycle;
        let mut ahead = PairLikelihood::default();
        let plots = tracklet.between(centre, LATEST).rev();
        ahead.add_plots(plots, self.targets.get(target)?.transponder()?, self.radar, settings);
        Some(ahead)
    }

    /// Total LLR of [`Self::ahead`]; 0 without a comparison.
    fn total_ahead(&self, tracklet: &Tracklet, target: TargetId) -> f64 {
        self.ahead(tracklet, target).and_then(|ahead| ahead.total()).unwrap_or(0.0)
    }

    /// Candidate targets of a track from the tracks of other radars.
    fn radar_pair_scores<'t>(&'t self, tracklet: &'t Tracklet) -> impl Iterator<Item = CandidateScore> + 't {
        // Being a drone is no evidence for this target; not being a drone is evidence against it.
        let class = tracklet.existence().log_odds().min(0.0);
        let own = tracklet.target();
        radar_pairs::targets(tracklet, self.tracklets, self.targets).filter_map(move |target| {
            let id = target.id();
            let likelihood = radar_pairs::track_likelihood(tracklet, target, self.tracklets, self.cycle)?;
            let llr = match own == Some(id) {
                true => likelihood.around,
                false if !self.may_become(tracklet, target) => return None,
                // Evidence of the target's transponder against the track still counts.
                false => likelihood.later + tracklet.pair_llr(id).unwrap_or(0.0).min(0.0),
            };
            Some(CandidateScore { target: id, llr: llr + class, by: CandidateEvidence::OtherRadars })
        })
    }

    /// Whether a track may move to another target. If it is the first track of its target, the two targets merge: the
    /// one with a transponder remains, or the older one.
    fn may_become(&self, tracklet: &Tracklet, other: &Target) -> bool {
        let own = tracklet.target().and_then(|own| self.targets.get(own));
        own.is_none_or(|own| {
            let first = own.followed(self.tracklets).next();
            let takes_along = first.is_none_or(|first| first.id == tracklet.id);
            let is_before = other.transponder().is_some() || other.id() < own.id();
            own.transponder().is_none() && (is_before || !takes_along)
        })
    }

    /// Targets that no sensor detects now, at their expected positions.
    fn unseen(&self) -> UndetectedTargets {
        UndetectedTargets::of(self.silent.iter().filter_map(|silent| {
            let target = self.targets.get(silent.target)?;
            let is_unseen = target.is_unseen(self.tracklets, self.cycle);
            let expected = || reacquisition::expected(target, self.cycle.centre);
            is_unseen.then(|| Some((target.id(), (*silent.expected.get_or_init(expected))?)))?
        }))
    }

    /// Whether a target is missing for this radar, and the tracks of other radars do not contradict this track.
    fn is_missing(&self, target: &Target, tracklet: &Tracklet) -> bool {
        target.is_open_to(self.sensor, self.tracklets, self.cycle)
            && radar_pairs::llr_of_target(tracklet, target, self.tracklets, self.cycle.settings)
                .is_none_or(|llr| llr > 0.0)
    }

    /// Assigns the tracks that begin in the seconds ahead to targets that this radar does not detect now.
    fn assign_ahead(&self) -> TrackAssignments {
        let mut problem = AssignmentProblem::default();
        let mut freed = Vec::new();
        for tracklet in self.tracklets().filter(|tracklet| tracklet.begins_within(LOOK_AHEAD_S, self.cycle)) {
            if let Some(own) = tracklet.target() {
                // Another track follows the target meanwhile.
                if self.targets.get(own).is_none_or(|own| !own.is_followed_by(tracklet.id)) {
                    freed.push(TrackAssignment { tracklet: tracklet.id, target: None, doubt: None });
                }
                continue;
            }
            let is_missing = |&(id, _): &(TargetId, f64)| {
                self.targets.get(id).is_some_and(|target| self.is_missing(target, tracklet))
            };
            let mut plausible: Vec<(TargetId, f64)> = Vec::new();
            let mut all =
                reacquisition::plausible(tracklet, self.radar, self.targets, self.measured, self.decided);
            // A track that could also be a target that is not missing is left until it has begun.
            let is_left = all.any(|found| {
                plausible.push(found);
                !is_missing(&found)
            });
            if !is_left {
                plausible.iter_mut().for_each(|(id, llr)| *llr += self.total_ahead(tracklet, *id));
                let likely = plausible.iter().filter(|found| found.1 > REACQUIRE_AHEAD_LLR);
                let costs: Vec<(TargetId, f64)> =
                    likely.map(|&(id, llr)| (id, DISSOCIATE_LLR - llr)).collect();
                problem.add(tracklet.id, costs.into_iter(), plausible);
            }
        }
        let found = problem.solve(|tracklet, target, finds| self.doubt(tracklet, target, finds));
        let found = found.into_iter().filter(|found| found.target.is_some());
        freed.into_iter().chain(found).collect()
    }
}

/// An assignment problem: tracks are the rows, targets the columns.
#[derive(Default)]
struct AssignmentProblem {
    rows: Vec<TrackletId>,
    columns: Vec<TargetId>,
    column_of: BTreeMap<TargetId, usize>,
    candidates: Vec<Vec<Candidate>>,
    /// Targets of each track that were found by their positions, each with its LLR.
    finds: Vec<Vec<(TargetId, f64)>>,
}

impl AssignmentProblem {
    /// Adds a track and its candidate targets with their costs; no target costs nothing. `finds`: targets found by their
    /// positions, each with its LLR.
    fn add(
        &mut self,
        id: TrackletId,
        costs: impl Iterator<Item = (TargetId, f64)>,
        finds: Vec<(TargetId, f64)>,
    ) {
        let Self { columns, column_of, .. } = self;
        let mut column = |target: TargetId| {
            *column_of.entry(target).or_insert_with(|| {
                columns.push(target);
                columns.len() - 1
            })
        };
        self.rows.push(id);
        self.candidates
            .push(costs.map(|(target, cost)| Candidate { column: column(target), cost }).collect());
        self.finds.push(finds);
    }

    /// The target of each track, at the least total cost. `doubt` is called for the chosen pairs.
    fn solve(
        self,
        doubt: impl Fn(TrackletId, TargetId, &[(TargetId, f64)]) -> Option<Doubt>,
    ) -> TrackAssignments {
        let chosen = assign(&self.candidates, self.columns.len(), 0.0);
        let rows = self.rows.into_iter().zip(&self.finds).zip(chosen);
        rows.map(|((tracklet, finds), column)| {
            let target = column.map(|column| self.columns[column]);
            let doubt = target.and_then(|target| doubt(tracklet, target, finds));
            TrackAssignment { tracklet, target, doubt }
        })
        .collect()
    }
}
