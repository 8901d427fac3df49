//! What one engine knows of an aircraft, or of a radar track that is nobody's, for another engine that begins to see it.
//!
//! Whether a track is a drone, whose it is and where its aircraft must be follow from all of its plots, and some of it for good:
//! what was taken for a drone once is one. An engine that has seen less would say otherwise. So what is known is handed on, and
//! both say the same from then on, as long as both see the same. Names of tracks and targets are those of the one that wrote
//! ([`TrackletId`], [`TargetId`]); what refers to things that only that one knows is left out.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::Operational;
use super::correlation::Decision;
use super::cycle::EARLIEST;
use super::ids::{TargetId, TrackletId};
use super::integrity::Judge;
use super::likelihood::PairLikelihood;
use super::mutual;
use super::settings::Settings;
use super::targets::{Target, Targets};
use super::tracklets::Tracklet;
use crate::checkpoint::LAYOUT;
use crate::frames::Enu;
use crate::report::Fix;
use crate::time::Time;

/// An aircraft or a radar track, by the name under which every engine knows it that has seen it begin or was told of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Name(Named);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum Named {
    Target(TargetId),
    Track(TrackletId),
}

/// An aircraft with its radar tracks, or a radar track that is nobody's, as one engine knows it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Acquaintance {
    /// The layout of its octets is that of a checkpoint.
    layout: u16,
    /// Centre of the slot up to which it is settled.
    until: Time,
    octets: Vec<u8>,
}

/// What was not met yet counts for so long, seconds: what it was about flies on.
const AWAITED_S: f64 = 5.0;

/// What others know and the engine has still to come to.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Awaited(Vec<Acquaintance>);

/// The octets: what is written down,
#[derive(Debug, Serialize)]
struct Written<'a> {
    target: Option<&'a Target>,
    tracklets: Vec<&'a Tracklet>,
    pairs: Vec<(TrackletId, &'a PairLikelihood)>,
    judge: Option<&'a Judge>,
    decisions: Vec<Decision>,
}

/// and what is read.
#[derive(Debug, Deserialize)]
struct Read {
    target: Option<Target>,
    tracklets: Vec<Tracklet>,
    /// How likely other radar tracks are this aircraft.
    pairs: Vec<(TrackletId, PairLikelihood)>,
    judge: Option<Judge>,
    /// What operators have decided of the radar tracks.
    decisions: Vec<Decision>,
}

impl Operational {
    /// All aircraft and radar tracks, and where each was in the slot that was decided last.
    pub(crate) fn names(&self) -> Vec<(Name, Enu)> {
        let Some(time) = self.decided else { return Vec::new() };
        let targets = self
            .targets
            .iter()
            .filter_map(|target| Some((Name(Named::Target(target.id())), target.estimate(time)?.position)));
        let tracks = self.tracklets.iter().filter(|tracklet| tracklet.target().is_none());
        let tracks = tracks
            .filter_map(|tracklet| Some((Name(Named::Track(tracklet.id)), tracklet.nearest(time)?.position)));
        targets.chain(tracks).collect()
    }

    /// Who is published under this number.
    pub(crate) fn numbered(&self, number: u32) -> Option<Name> {
        let mut targets = self.targets.iter();
        let target = targets.find(|target| target.number().is_some_and(|own| own.number == number))?;
        Some(Name(Named::Target(target.id())))
    }

    /// What is known of somebody, and of the radar tracks that could be this aircraft and are nobody's, where those are `around`.
    pub(crate) fn acquaintance(
        &self,
        Name(name): Name,
        around: impl Fn(Enu) -> bool,
    ) -> Option<Acquaintance> {
        let Self { targets, tracklets, correlations, integrities, .. } = self;
        let until = self.decided?;
        let (target, tracklets, pairs) = match name {
            Named::Target(id) => {
                let target = targets.get(id)?;
                let could_be = |other: &Tracklet| {
                    let is_near = |own: &Tracklet| other.mutual_with(own.id).is_some();
                    other.target().is_none()
                        && (other.pair(id).is_some() || target.followed(tracklets).any(is_near))
                };
                let is_around =
                    |other: &Tracklet| other.nearest(until).is_some_and(|plot| around(plot.position));
                let own = |tracklet: &&Tracklet| {
                    tracklet.target() == Some(id) || (could_be(tracklet) && is_around(tracklet))
                };
                let (own, others): (Vec<_>, Vec<_>) = tracklets.iter().partition(own);
                let pairs = others.into_iter().filter_map(|other| Some((other.id, other.pair(id)?)));
                (Some(target), own, pairs.collect())
            }
            Named::Track(id) => (None, vec![tracklets.get(id)?], Vec::new()),
        };
        let judge = target.and_then(Target::identity).and_then(|identity| integrities.judge(identity));
        let decisions = tracklets.iter().flat_map(|tracklet| correlations.of(tracklet.id)).collect();
        let octets = postcard::to_stdvec(&Written { target, tracklets, pairs, judge, decisions })
            .expect("every state can be written down");
        Some(Acquaintance { layout: LAYOUT, until, octets })
    }

    /// Goes on with what another engine knows, as soon as this one has come to the same slot.
    pub(crate) fn await_acquaintance(&mut self, acquaintance: Acquaintance) {
        self.awaited.0.push(acquaintance);
    }

    /// Takes over what others know, up to the slot that was decided last.
    pub(super) fn meet_awaited(&mut self, settings: &Settings) {
        let Some(decided) = self.decided else { return };
        let awaited = std::mem::take(&mut self.awaited.0);
        let (due, later): (Vec<_>, Vec<_>) = awaited.into_iter().partition(|known| known.until <= decided);
        self.awaited.0 = later;
        for Acquaintance { layout, until, octets } in due {
            let is_fresh = layout == LAYOUT && decided.seconds_since(until) <= AWAITED_S;
            // Another version writes otherwise; then the engine goes on with what it sees itself.
            let read: Option<Read> = is_fresh.then(|| postcard::from_bytes(&octets).ok()).flatten();
            // What was known here all the time would go back to what it was then.
            if let Some(read) = read.filter(|read| until == decided || !self.is_known(read)) {
                self.meet(read, (until, decided), settings);
            }
        }
    }

    /// Whether it has its name here, too: it was seen to begin, or met before.
    fn is_known(&self, read: &Read) -> bool {
        match &read.target {
            Some(target) => self.targets.get(target.id()).is_some(),
            None => read.tracklets.iter().all(|tracklet| self.tracklets.get(tracklet.id).is_some()),
        }
    }

    /// Puts what is known in the place of what was known here, and brings it from the slot up to which it is settled to the one
    /// that was decided last.
    fn meet(&mut self, read: Read, (until, decided): (Time, Time), settings: &Settings) {
        let Read { target, mut tracklets, pairs, judge, decisions } = read;
        let id = target.as_ref().map(Target::id);
        let identity = target.as_ref().and_then(Target::identity);
        // Who it was here, and the numbers under which that was published.
        let before = identity.and_then(|identity| self.targets.of_identity(identity));
        let mut numbers = Vec::new();
        let mut fixes: Vec<Fix> = Vec::new();
        for before in BTreeSet::from_iter(before.into_iter().chain(id)) {
            if let Some(known) = self.targets.take(before) {
                fixes.extend(known.transponder().into_iter().flat_map(|own| own.after(EARLIEST)));
                numbers.extend(known.number());
                let own = self.tracklets.iter_mut().filter(|tracklet| tracklet.target() == Some(before));
                own.for_each(|tracklet| _ = tracklet.replace_target(None));
            }
        }
        for tracklet in &mut tracklets {
            let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
            for known in self.tracklets.take_same(tracklet, radar) {
                numbers.extend(known.target().and_then(|left| self.targets.leave(left, known.id)));
                self.correlations.rename(known.id, tracklet.id);
                tracklet.absorb(known);
            }
        }
        self.correlations.take_over(decisions);
        let own: Vec<TrackletId> = tracklets.iter().map(|tracklet| tracklet.id).collect();
        tracklets.into_iter().for_each(|tracklet| self.tracklets.put(tracklet));
        if let Some(mut target) = target {
            if let Some(identity) = identity {
                fixes.extend(self.admission.admit(identity));
            }
            target.go_on(fixes, numbers.first().copied());
            numbers = numbers.split_off(numbers.len().min(1));
            self.targets.put(target);
        }
        numbers.into_iter().for_each(|number| self.targets.release(number));
        if let (Some(identity), Some(judge)) = (identity, judge) {
            self.integrities.take_over(identity, judge, &self.tracklets);
        }
        self.catch_up(&own, id, pairs, (until, decided), settings);
    }

    /// Compares what was met with everything else as it would have been.
    fn catch_up(
        &mut self,
        own: &[TrackletId],
        target: Option<TargetId>,
        pairs: Vec<(TrackletId, PairLikelihood)>,
        since: (Time, Time),
        settings: &Settings,
    ) {
        let Self { tracklets, targets, .. } = self;
        for (other, pair) in pairs {
            if let Some((other, target)) = tracklets.get_mut(other).zip(target) {
                other.set_known_pair(target, pair);
                compare(other, &[target], targets, since, settings);
            }
        }
        for &id in own {
            let Some(tracklet) = tracklets.get_mut(id) else { continue };
            let compared: Vec<TargetId> = tracklet.pairs().iter().map(|pair| pair.0).collect();
            compare(tracklet, &compared, targets, since, settings);
            mutual::catch_up(tracklets, id, own, since, settings);
        }
    }
}

/// Takes the plots of a while into a track's likelihoods with these targets.
fn compare(
    tracklet: &mut Tracklet,
    compared: &[TargetId],
    targets: &Targets,
    since: (Time, Time),
    settings: &Settings,
) {
    let Some(radar) = settings.radar(tracklet.key.sensor) else { return };
    for &id in compared {
        if let Some(transponder) = targets.get(id).and_then(Target::transponder) {
            tracklet.compare(id, transponder, since, radar, settings);
        }
    }
}
