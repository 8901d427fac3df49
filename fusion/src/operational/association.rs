//! The pass that decides which radar track is which target.
//!
//! It runs when all radars' tracks have been compared, radar by radar: first the tracks that have begun, one to one at the
//! least cost, then the tracks that begin in the seconds ahead. What is published is seconds old, so those are known; their
//! plots tell where a target is that no sensor sees now, or that another radar alone sees: between two times at which ranges
//! cross the bias of the radar that is left is known best.
//!
//! Where no transponder tells, a track is compared with what other radars see, too ([`mutual`]): two targets that turn out to
//! be one become the older of them.
//!
//! The order counts. A target that a track of this radar has just been found to be is seen again, so no track ahead may
//! claim it; and what one radar has found, begun or ahead, is no longer missing to the next radar.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::correlation::Decided;
use super::cycle::{Cycle, LATEST};
use super::doubt::Doubt;
use super::ids::{TargetId, TrackletId};
use super::likelihood::PairLikelihood;
use super::mutual;
use super::reacquisition::{self, Measured, Unseen};
use super::settings::{Radar, periods};
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

/// Which target each of these tracklets is from now on, in the order in which that takes effect.
type Assignment = Vec<Assigned>;

/// Which target a tracklet is from now on, and how doubtful that is where it was found by its place.
#[derive(Clone, Copy, Debug)]
struct Assigned {
    tracklet: TrackletId,
    target: Option<TargetId>,
    doubt: Option<Doubt>,
}

/// In this order.
const STEPS: [fn(&RadarTracks) -> Assignment; 2] =
    [|tracks| tracks.assign_begun(), |tracks| tracks.assign_ahead()];

/// Decides which radar track is which target.
pub(super) fn associate(
    tracklets: &mut Tracklets,
    targets: &mut Targets,
    measured: &Measured,
    decided: &Decided,
    cycle: &Cycle,
) {
    let silent = &Silent::all(targets, cycle);
    for (sensor, radar) in cycle.settings.radars() {
        for assign in STEPS {
            let tracks = RadarTracks { sensor, radar, tracklets, targets, measured, silent, decided, cycle };
            for Assigned { tracklet, target, doubt } in assign(&tracks) {
                if tracklets.get(tracklet).is_some_and(|known| known.target() != target) {
                    targets.disbelieve(tracklets, tracklet, cycle);
                    target.into_iter().for_each(|target| targets.find(target, doubt));
                }
                match target {
                    Some(target) => targets.follow_together(tracklets, tracklet, target),
                    None => targets.follow(tracklets, tracklet, None),
                }
            }
        }
    }
}

/// One radar's tracks, and the targets that they could be.
struct RadarTracks<'a> {
    sensor: SensorIndex,
    radar: &'a Radar,
    tracklets: &'a Tracklets,
    targets: &'a Targets,
    measured: &'a Measured,
    silent: &'a [Silent],
    decided: &'a Decided,
    cycle: &'a Cycle<'a>,
}

/// A target that no transponder tells of in this slot. Where it must be is worked out once, and only where that is asked.
struct Silent {
    target: TargetId,
    expected: OnceLock<Option<StateEstimate>>,
}

impl Silent {
    /// All of them, by target.
    fn all(targets: &Targets, cycle: &Cycle) -> Vec<Self> {
        let silent = targets.iter().filter(|target| target.on_curve(cycle.centre, cycle.settings).is_none());
        silent.map(|target| Self { target: target.id(), expected: OnceLock::new() }).collect()
    }
}

/// A target that a radar track could be.
struct Score {
    target: TargetId,
    llr: f64,
    by: Evidence,
}

/// What a score rests on.
#[derive(Clone, Copy, Debug)]
enum Evidence {
    /// The target's transponder.
    Transponder,
    /// Its tracks of other radars.
    OtherRadars,
    /// Where it must be, since no sensor sees it.
    Place,
}

impl Evidence {
    /// A track becomes a target from this LLR on.
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

    /// The tracks that have begun, and have a plot now or had one lately.
    fn assign_begun(&self) -> Assignment {
        let cycle = self.cycle;
        let lasts_for = periods(TRACK_LASTS_PERIODS, self.radar.period_s).max(cycle.end - cycle.begin);
        let lasts = |tracklet: &&Tracklet| {
            tracklet.first() < cycle.end && cycle.centre - tracklet.last() <= lasts_for
        };
        let unseen = self.unseen();
        let lasting: Vec<&Tracklet> = self.tracklets().filter(lasts).collect();
        let threads = cycle.settings.threads;
        let scores = shared::map(threads, &lasting, |tracklet| self.scores(tracklet, &unseen));
        let mut problem = Problem::default();
        for (tracklet, scores) in lasting.into_iter().zip(scores) {
            let candidate = |score: Score| {
                let (least, bonus) = match tracklet.target() == Some(score.target) {
                    true => (DISSOCIATE_LLR, HYSTERESIS_LLR),
                    false => (score.by.least(), 0.0),
                };
                let is_free = self.decided.leaves(tracklet, score.target);
                (is_free && score.llr > least).then_some((score.target, DISSOCIATE_LLR - bonus - score.llr))
            };
            let finds = scores.iter().filter(|score| matches!(score.by, Evidence::Place));
            problem.doubt(self.doubts(tracklet, finds.map(|score| (score.target, score.llr)).collect()));
            problem.add(tracklet.id, scores.into_iter().filter_map(candidate));
        }
        let assigned = problem.solve().into_iter();
        assigned
            .map(|assigned| match self.decided.target(assigned.tracklet) {
                Some(target) => Assigned { target: Some(target), doubt: None, ..assigned },
                None => assigned,
            })
            .collect()
    }

    /// How doubtful it is that a track is each of these targets, by their LLRs.
    fn doubts(
        &self,
        tracklet: &Tracklet,
        finds: Vec<(TargetId, f64)>,
    ) -> Vec<((TrackletId, TargetId), Doubt)> {
        let all: Vec<f64> = finds.iter().map(|find| find.1).collect();
        let since = tracklet.first().max(self.cycle.centre);
        let doubt = |(id, llr): (TargetId, f64)| {
            let expected = self.targets.get(id)?.estimate(since)?;
            Some(((tracklet.id, id), Doubt::new(llr, &all, expected.sigma_m().powi(2), since)))
        };
        finds.into_iter().filter_map(doubt).collect()
    }

    /// The targets that a track could be.
    fn scores(&self, tracklet: &Tracklet, unseen: &Unseen) -> Vec<Score> {
        let centre = self.cycle.centre;
        let existence = tracklet.existence();
        if existence.is_vetoed() {
            return Vec::new();
        }
        let class = existence.log_odds().min(CLASS_LLR_MAX);
        // What it is taken for was perhaps never compared with it, and is only now heard again.
        let unheard = tracklet.target().filter(|&own| tracklet.pair(own).is_none());
        let unheard = unheard.map(|own| (own, PairLikelihood::default()));
        let compared = tracklet.pairs().iter().copied().chain(unheard).filter_map(|(target, pair)| {
            let pair = pair.at(centre);
            let is_own = tracklet.target() == Some(target);
            let so_far = pair.llr + class - pair.bias_penalty;
            if so_far + PAIR_LLR_MAX <= if is_own { DISSOCIATE_LLR } else { ASSOCIATE_LLR } {
                return None; // whatever the plots ahead tell
            }
            let ahead = self.ahead(tracklet, target)?;
            ahead.total().or(pair.total())?;
            let llr = pair.llr + ahead.llr + class - pair.bias_penalty.max(ahead.bias_penalty);
            Some(Score { target, llr, by: Evidence::Transponder })
        });
        let mut scores: Vec<Score> = compared.collect();
        for score in self.mutual_scores(tracklet) {
            scores.retain(|compared| compared.target != score.target);
            scores.push(score);
        }
        match tracklet.target() {
            // Nothing to compare it with: it stays what it is.
            Some(target)
                if tracklet.pair_llr(target).is_none()
                    && !scores.iter().any(|score| score.target == target) =>
            {
                scores.push(Score { target, llr: 0.0, by: Evidence::Transponder });
            }
            Some(_) => {}
            None => {
                let plot = tracklet.nearest(centre);
                for (target, llr) in plot.into_iter().flat_map(|plot| unseen.near(plot, self.radar)) {
                    scores.retain(|compared| compared.target != target);
                    // The likelihood from before it was out of sight counts as well.
                    let class = self.targets.get(target).map_or(class, |target| target.class_llr(tracklet));
                    let llr = tracklet.pair_llr(target).unwrap_or(0.0) + llr + class;
                    scores.push(Score {
                        target,
                        llr: llr + self.total_ahead(tracklet, target),
                        by: Evidence::Place,
                    });
                }
            }
        }
        scores
    }

    /// How likely a track is a target's, by its plots after the slot, back to it, and the target's transponder.
    fn ahead(&self, tracklet: &Tracklet, target: TargetId) -> Option<PairLikelihood> {
        let Cycle { centre, settings, .. } = *self.cycle;
        let mut ahead = PairLikelihood::default();
        let plots = tracklet.between(centre, LATEST).rev();
        ahead.add_plots(plots, self.targets.get(target)?.transponder()?, self.radar, settings);
        Some(ahead)
    }

    /// The sum of that; 0 where there is nothing to compare.
    fn total_ahead(&self, tracklet: &Tracklet, target: TargetId) -> f64 {
        self.ahead(tracklet, target).and_then(|ahead| ahead.total()).unwrap_or(0.0)
    }

    /// The targets that a track could be by what other radars see of them.
    fn mutual_scores<'t>(&'t self, tracklet: &'t Tracklet) -> impl Iterator<Item = Score> + 't {
        // That it is a drone is no evidence that it is this one; that it is none is evidence against it.
        let class = tracklet.existence().log_odds().min(0.0);
        let own = tracklet.target();
        mutual::targets(tracklet, self.tracklets, self.targets).filter_map(move |target| {
            let id = target.id();
            let told = mutual::told(tracklet, target, self.tracklets, self.cycle)?;
            let llr = match own == Some(id) {
                true => told.around,
                false if !self.may_become(tracklet, target) => return None,
                // What their transponder has told against it still holds.
                false => told.later + tracklet.pair_llr(id).unwrap_or(0.0).min(0.0),
            };
            Some(Score { target: id, llr: llr + class, by: Evidence::OtherRadars })
        })
    }

    /// Whether a track may become part of another target than its own. The first track of a target takes the target along: of
    /// two the one stays that a transponder tells of, or that was there before.
    fn may_become(&self, tracklet: &Tracklet, other: &Target) -> bool {
        let own = tracklet.target().and_then(|own| self.targets.get(own));
        own.is_none_or(|own| {
            let first = own.followed(self.tracklets).next();
            let takes_along = first.is_none_or(|first| first.id == tracklet.id);
            let is_before = other.transponder().is_some() || other.id() < own.id();
            own.transponder().is_none() && (is_before || !takes_along)
        })
    }

    /// Targets that no sensor sees now, where they must be.
    fn unseen(&self) -> Unseen {
        Unseen::of(self.silent.iter().filter_map(|silent| {
            let target = self.targets.get(silent.target)?;
            let is_unseen = target.is_unseen(self.tracklets, self.cycle);
            let expected = || reacquisition::expected(target, self.cycle.centre);
            is_unseen.then(|| Some((target.id(), (*silent.expected.get_or_init(expected))?)))?
        }))
    }

    /// Whether a target is missing to this radar, and what other radars see of it does not speak against its being this track.
    fn is_missing(&self, target: &Target, tracklet: &Tracklet) -> bool {
        target.is_open_to(self.sensor, self.tracklets, self.cycle)
            && mutual::llr_of_target(tracklet, target, self.tracklets, self.cycle.settings)
                .is_none_or(|llr| llr > 0.0)
    }

    /// The tracks that begin in the seconds ahead, and are targets that this radar does not see now.
    fn assign_ahead(&self) -> Assignment {
        let mut problem = Problem::default();
        let mut freed = Vec::new();
        for tracklet in self.tracklets().filter(|tracklet| tracklet.begins_within(LOOK_AHEAD_S, self.cycle)) {
            if let Some(own) = tracklet.target() {
                // The target is followed by another track meanwhile.
                if self.targets.get(own).is_none_or(|own| !own.is_followed_by(tracklet.id)) {
                    freed.push(Assigned { tracklet: tracklet.id, target: None, doubt: None });
                }
                continue;
            }
            let is_missing = |&(id, _): &(TargetId, f64)| {
                self.targets.get(id).is_some_and(|target| self.is_missing(target, tracklet))
            };
            let plausible: Vec<(TargetId, f64)> =
                reacquisition::plausible(tracklet, self.radar, self.targets, self.measured, self.decided)
                    .collect();
            // One that could also be a target that is not missing is left until it has begun.
            if plausible.iter().all(is_missing) {
                let with_ahead = |(id, llr)| (id, llr + self.total_ahead(tracklet, id));
                let plausible: Vec<(TargetId, f64)> = plausible.into_iter().map(with_ahead).collect();
                problem.doubt(self.doubts(tracklet, plausible.clone()));
                let likely = plausible.into_iter().filter(|&(_, llr)| llr > REACQUIRE_AHEAD_LLR);
                problem.add(tracklet.id, likely.map(|(id, llr)| (id, DISSOCIATE_LLR - llr)));
            }
        }
        let found = problem.solve().into_iter().filter(|found| found.target.is_some());
        freed.into_iter().chain(found).collect()
    }
}

/// An assignment problem: tracks are the rows, targets the columns.
#[derive(Default)]
struct Problem {
    rows: Vec<TrackletId>,
    columns: Vec<TargetId>,
    column_of: BTreeMap<TargetId, usize>,
    candidates: Vec<Vec<Candidate>>,
    doubts: BTreeMap<(TrackletId, TargetId), Doubt>,
}

impl Problem {
    /// A track, and the targets that it could be, with their costs; that it is none costs nothing.
    fn add(&mut self, id: TrackletId, costs: impl Iterator<Item = (TargetId, f64)>) {
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
    }

    /// How doubtful some of that is.
    fn doubt(&mut self, doubts: Vec<((TrackletId, TargetId), Doubt)>) {
        self.doubts.extend(doubts);
    }

    /// The target of each track, at the least sum of costs.
    fn solve(self) -> Assignment {
        let chosen = assign(&self.candidates, self.columns.len(), 0.0);
        let assigned = |(tracklet, column): (TrackletId, Option<usize>)| {
            let target = column.map(|column| self.columns[column]);
            let doubt = target.and_then(|target| self.doubts.get(&(tracklet, target)).copied());
            Assigned { tracklet, target, doubt }
        };
        self.rows.into_iter().zip(chosen).map(assigned).collect()
    }
}
