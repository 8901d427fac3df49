//! What an operator has decided: that a radar track and a transponder are one aircraft, or that they are not.
//!
//! A decision is about a radar track for as long as the radar keeps it: a number that comes again is another track, of which
//! nothing was decided. The transponder is meant by who it is, so that it may fall silent and come back.
//!
//! Over a restart it holds where the radar's number is heard again within its break, as if there had been no restart.

use std::collections::{BTreeMap, BTreeSet};

use super::settings::Settings;
use super::tracklet::{TargetId, Tracklet, TrackletId};
use super::{Moment, Operational, break_ns};
use crate::point::{Competitor, Rival};
use crate::report::{Identity, RadarTrackKey};
use crate::slots::Slot;
use crate::time::Time;

/// No more competitors of a kind are told.
const COMPETITORS: usize = 3;

/// What is said of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// They are one aircraft.
    Correlated,
    /// They are not.
    Decorrelated,
    /// Whatever was said before no longer counts.
    Automatic,
}

impl Verdict {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Correlated, Self::Decorrelated, Self::Automatic];

    /// Its name on every interface.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Correlated => "correlated",
            Self::Decorrelated => "decorrelated",
            Self::Automatic => "automatic",
        }
    }

    /// The one of that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|verdict| verdict.name() == name)
    }
}

/// An operator's word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Correlation {
    /// The radar track as it is now.
    pub radar: RadarTrackKey,
    /// The transponder.
    pub transponder: Identity,
    /// What is said of them.
    pub verdict: Verdict,
}

/// A decision that is in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeldCorrelation {
    /// What was decided; never [`Verdict::Automatic`].
    pub correlation: Correlation,
    /// The first slot that was put out by it.
    pub since: Slot,
}

/// A decision that is kept for the time after a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SavedCorrelation {
    /// What was decided, and since when it held.
    pub held: HeldCorrelation,
    /// The last plot of its radar track.
    pub heard: Time,
}

/// What has become of a decision of before a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResumedCorrelation {
    /// The radar track is heard again: it holds as before.
    Holds(HeldCorrelation),
    /// The radar's number was not heard again within its break: another aircraft may have it now.
    Ended(HeldCorrelation),
}

/// Why something cannot be decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotCorrelated {
    /// There is nothing to decide on in this profile.
    #[error("the reference profile decides by itself; manual correlation needs the operational profile")]
    Reference,
    /// The radar has no such track in the slot that was put out last.
    #[error("the radar has no such track now")]
    NoRadarTrack,
    /// Nothing has been heard of the transponder.
    #[error("no such transponder has been heard lately")]
    NoTransponder,
}

/// What is in force, by radar track and transponder: the verdict, and since when.
#[derive(Debug, Default)]
pub(super) struct Manual(BTreeMap<(TrackletId, Identity), (Verdict, Slot)>);

impl Manual {
    pub(super) fn verdict(&self, tracklet: TrackletId, transponder: Identity) -> Verdict {
        self.0.get(&(tracklet, transponder)).map_or(Verdict::Automatic, |held| held.0)
    }
}

/// What is in force, as the assignment needs it.
#[derive(Debug, Default)]
pub(super) struct Decided {
    correlated: BTreeMap<TrackletId, TargetId>,
    /// The radars that they are of: one radar's word binds no other's tracks.
    bound: BTreeSet<(u16, TargetId)>,
    apart: BTreeSet<(TrackletId, TargetId)>,
}

impl Decided {
    /// The target that a radar track is, whatever speaks against it.
    pub(super) fn target(&self, id: TrackletId) -> Option<TargetId> {
        self.correlated.get(&id).copied()
    }

    /// Whether it is left to the evidence that this radar track is that target.
    pub(super) fn leaves(&self, tracklet: &Tracklet, target: TargetId) -> bool {
        !self.correlated.contains_key(&tracklet.id)
            && !self.bound.contains(&(tracklet.key.sensor.0, target))
            && !self.are_apart(tracklet.id, target)
    }

    /// Whether they are known not to be one.
    pub(super) fn are_apart(&self, id: TrackletId, target: TargetId) -> bool {
        self.apart.contains(&(id, target))
    }
}

impl Operational {
    /// Takes a decision over from the slot `since` on, which is the next one or, of a flight that is replayed, was.
    pub(crate) fn correlate(
        &mut self,
        correlation: Correlation,
        since: Slot,
        settings: &Settings,
    ) -> Result<(), NotCorrelated> {
        let Correlation { radar, transponder, .. } = correlation;
        let id = self.current(radar, settings).ok_or(NotCorrelated::NoRadarTrack)?;
        if !self.by_identity.contains_key(&transponder) && !self.manual.0.contains_key(&(id, transponder)) {
            return Err(NotCorrelated::NoTransponder);
        }
        self.hold(id, correlation, since);
        Ok(())
    }

    /// Lets a decision of before a restart hold again, where its radar track was heard again within the break of its number;
    /// `None`: that is not known yet. `time` is the centre of the slot that is published next.
    pub(crate) fn resume(
        &mut self,
        kept: SavedCorrelation,
        time: Time,
        settings: &Settings,
    ) -> Option<ResumedCorrelation> {
        let SavedCorrelation { held: HeldCorrelation { correlation, since }, heard } = kept;
        let ended = Some(ResumedCorrelation::Ended(kept.held));
        let Some(radar) = settings.radar(correlation.radar.sensor) else { return ended };
        let until = Time::from_nanos(heard.nanos() + break_ns(radar));
        let tracklet = self.current(correlation.radar, settings).and_then(|id| self.tracklets.get(&id));
        match tracklet.map(|tracklet| (tracklet.id, tracklet.first())) {
            Some((id, first)) if first <= until => {
                self.hold(id, correlation, since);
                Some(ResumedCorrelation::Holds(kept.held))
            }
            None if time <= until => None,
            Some(_) | None => ended,
        }
    }

    fn hold(&mut self, id: TrackletId, correlation: Correlation, since: Slot) {
        let Correlation { radar, transponder, verdict } = correlation;
        let pair = (id, transponder);
        let held = &mut self.manual.0;
        if verdict == Verdict::Correlated {
            // A radar track is one transponder, and a transponder one track of a radar.
            let tracklets = &self.tracklets;
            let of_radar =
                |id: &TrackletId| tracklets.get(id).is_some_and(|other| other.key.sensor == radar.sensor);
            held.retain(|(other, identity), (verdict, _)| {
                let shares = *other == id || (*identity == transponder && of_radar(other));
                *verdict != Verdict::Correlated || !shares
            });
        }
        match verdict {
            Verdict::Automatic => {
                if let Some((Verdict::Correlated, _)) = held.remove(&pair) {
                    self.part_unless_compared(id, transponder);
                }
            }
            // What was said before and is said again holds since then.
            _ if held.get(&pair).is_some_and(|before| before.0 == verdict) => {}
            _ => _ = held.insert(pair, (verdict, since)),
        }
    }

    /// What is in force, each with the last plot of its radar track.
    pub(crate) fn kept(&self) -> Vec<SavedCorrelation> {
        let kept = |(&(id, transponder), &(verdict, since)): (&(TrackletId, Identity), &(Verdict, Slot))| {
            let tracklet = self.tracklets.get(&id)?;
            let correlation = Correlation { radar: tracklet.key, transponder, verdict };
            Some(SavedCorrelation { held: HeldCorrelation { correlation, since }, heard: tracklet.last() })
        };
        self.manual.0.iter().filter_map(kept).collect()
    }

    /// Without anything to compare a radar track stays what it is, which here was an operator's word alone.
    fn part_unless_compared(&mut self, id: TrackletId, transponder: Identity) {
        let Some(&target) = self.by_identity.get(&transponder) else { return };
        let Some(tracklet) = self.tracklets.get(&id) else { return };
        if tracklet.target == Some(target) && tracklet.score(target).is_none() {
            self.join(id, None);
        }
    }

    /// What is in force, by radar track.
    pub(crate) fn correlations(&self) -> Vec<HeldCorrelation> {
        self.kept().into_iter().map(|kept| kept.held).collect()
    }

    /// The transponders that something can be decided of.
    pub(crate) fn transponders(&self) -> impl Iterator<Item = Identity> {
        self.by_identity.keys().copied()
    }

    /// The radar track that has this number in the slot that was put out last; where none has, one that is about to.
    fn current(&self, radar: RadarTrackKey, settings: &Settings) -> Option<TrackletId> {
        let time = self.settled?;
        let tracklets = self.by_key.get(&radar)?.iter().filter_map(|id| self.tracklets.get(id));
        let lasting = tracklets.filter(|tracklet| !has_ended(tracklet, time, settings));
        lasting
            .max_by_key(|tracklet| match tracklet.first() <= time {
                true => (true, tracklet.last().nanos()),
                false => (false, -tracklet.first().nanos()),
            })
            .map(|tracklet| tracklet.id)
    }

    /// Correlations end with the radar track that they are about.
    pub(super) fn end_correlations(&mut self, time: Time, settings: &Settings) {
        let Self { manual, tracklets, .. } = self;
        manual.0.retain(|(id, _), _| {
            tracklets.get(id).is_some_and(|tracklet| !has_ended(tracklet, time, settings))
        });
    }

    /// What is in force now.
    pub(super) fn correlated(&self) -> Decided {
        let mut correlated = Decided::default();
        for (&(id, identity), &(verdict, _)) in &self.manual.0 {
            let Some(&target) = self.by_identity.get(&identity) else { continue };
            let Some(tracklet) = self.tracklets.get(&id) else { continue };
            if verdict == Verdict::Correlated {
                correlated.correlated.insert(id, target);
                correlated.bound.insert((tracklet.key.sensor.0, target));
            } else {
                correlated.apart.insert((id, target));
            }
        }
        correlated
    }

    /// Who else came near, by target: the transponders that its radar track could be and the radar tracks that its transponder
    /// could be, the likeliest first, at most three of each.
    pub(super) fn competitors(&self, moment: &Moment) -> BTreeMap<TargetId, Vec<Competitor>> {
        let mut all: BTreeMap<TargetId, Vec<Competitor>> = BTreeMap::new();
        let is_now = |tracklet: &&Tracklet| tracklet.first() < moment.end && tracklet.last() >= moment.begin;
        for tracklet in self.tracklets.values().filter(is_now) {
            let followed =
                |id: &TargetId| self.targets.get(id).is_some_and(|own| own.tracklet == Some(tracklet.id));
            let own = tracklet.target.filter(followed);
            for &(id, evidence) in &tracklet.pairs {
                let Some(score) = evidence.doubt() else { continue };
                let transponder = self.targets.get(&id).and_then(|target| target.transponder.as_ref());
                let Some(transponder) = transponder.filter(|_| own != Some(id)) else { continue };
                let identity = transponder.identity;
                let decorrelated = self.manual.verdict(tracklet.id, identity) == Verdict::Decorrelated;
                let competitor = |who| Competitor { who, score, decorrelated };
                all.entry(id).or_default().push(competitor(Rival::Radar(tracklet.key)));
                if let Some(own) = own {
                    let number = transponder.numbered.map(|numbered| numbered.number);
                    let rival = Rival::Transponder { sensor: transponder.sensor, number, identity };
                    all.entry(own).or_default().push(competitor(rival));
                }
            }
        }
        for competitors in all.values_mut() {
            // Stable: equal ones stand in the order in which they began.
            competitors.sort_by(|a, b| b.score.total_cmp(&a.score));
            let (mut radars, mut transponders) = (0, 0);
            competitors.retain(|competitor| {
                let count = match competitor.who {
                    Rival::Radar(_) => &mut radars,
                    Rival::Transponder { .. } => &mut transponders,
                };
                *count += 1;
                *count <= COMPETITORS
            });
        }
        all
    }
}

/// Whether a plot with its number would now be one of another track.
fn has_ended(tracklet: &Tracklet, time: Time, settings: &Settings) -> bool {
    settings
        .radar(tracklet.key.sensor)
        .is_none_or(|radar| time.nanos() - tracklet.last().nanos() > break_ns(radar))
}

#[cfg(test)]
mod tests;
