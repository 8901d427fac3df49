//! Operators' decisions where the engines are elsewhere: they are written to the cells, which all carry them out from one slot on.

use std::collections::BTreeSet;

use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tracing::warn;

use crate::config::{Action, Config, Profile};
use crate::live::correlations::Correlations;
use crate::live::integrity::{Integrities, IntegrityRequests};
use crate::live::requests::Denied;
use crate::picture::Picture;
use fusion::Identity;
use fusion::integrity::{HeldWord, Word};
use fusion::operational::{Correlation, HeldCorrelation, NotCorrelated, Verdict};
use fusion::slots::Slot;

/// Slots from the newest one that is shown to the first that is published by a decision: time enough for the cells to hear of it.
const AHEAD: i64 = 12;
/// Most decisions that wait to be written.
const QUEUE: usize = 64;

/// What was decided, from which slot on.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision {
    /// On a radar track and a transponder.
    Correlate(Slot, Correlation),
    /// On a transponder.
    Say(Slot, Word),
}

/// Decisions on their way to the cells.
pub fn decisions() -> (Sender<Decision>, Receiver<Decision>) {
    channel(QUEUE)
}

/// Takes what operators decide at a picture.
#[derive(Debug)]
pub(super) struct Decider {
    /// Why nothing is decided, whoever asks: of pairs, of transponders.
    refusals: [Option<Denied>; 2],
    to: Option<Sender<Decision>>,
    /// Those that have been in the picture lately, and the newest slot of it.
    identities: BTreeSet<Identity>,
    latest: Option<Slot>,
    /// Pairs that were decided on, until a cell says that it holds the decision.
    awaited: Vec<HeldCorrelation>,
    /// What cells have said last that is in force.
    correlations: Vec<HeldCorrelation>,
    integrities: Integrities,
}

/// Most identities that are remembered; then only those of the present picture are.
const REMEMBERED: usize = 100_000;
/// Slots within which a cell says that it holds a decision, from the first that is published by it: 5 s.
const SAID: i64 = 20;

impl Decider {
    pub(super) fn new(config: &Config, to: Option<Sender<Decision>>) -> Self {
        let is_reference = config.fusion.profile == Profile::Reference;
        let judges = !is_reference && config.integrity.action != Action::Off;
        Self {
            refusals: [
                is_reference.then(|| NotCorrelated::Reference.into()),
                (!judges).then_some(Denied::NotJudged),
            ],
            to,
            identities: BTreeSet::new(),
            latest: None,
            awaited: Vec::new(),
            correlations: Vec::new(),
            integrities: Integrities::default(),
        }
    }

    pub(super) fn see(&mut self, picture: &Picture) {
        self.latest = Some(picture.slot);
        if self.identities.len() >= REMEMBERED {
            self.identities.clear();
        }
        let seen = picture.tracks.iter().filter_map(|track| track.point.source.transponder());
        self.identities.extend(seen.map(|part| part.identity));
    }

    pub(super) fn hear(&mut self, correlations: &[HeldCorrelation], integrities: &Integrities) {
        correlations.clone_into(&mut self.correlations);
        let Self { awaited, latest, .. } = self;
        awaited.retain(|awaited| {
            let is_held = correlations.iter().any(|held| held.correlation == awaited.correlation);
            let is_refused = !is_held && latest.is_some_and(|latest| latest >= awaited.since.plus(SAID));
            if is_refused {
                let Correlation { radar, transponder, verdict } = awaited.correlation;
                let (track, transponder) = (radar.number, transponder.name().escape_ascii().to_string());
                warn!(
                    track,
                    transponder,
                    verdict = verdict.name(),
                    "no cell carries out the decision: none knows the pair"
                );
            }
            !is_held && !is_refused
        });
        self.integrities.clone_from(integrities);
    }

    /// Writes what was decided; `is_heard`: somebody is there to carry it out.
    pub(super) fn decide(&mut self, correlations: &Correlations, words: &IntegrityRequests, is_heard: bool) {
        let slot = self.latest.filter(|_| is_heard).map(|latest| latest.plus(AHEAD));
        let Self {
            refusals: [no_pair, no_word],
            to,
            identities,
            correlations: held,
            integrities,
            awaited,
            ..
        } = self;
        let allowed = |refusal: &Option<Denied>| refusal.clone().map_or(Ok(()), Err);
        let send = |decision: Decision| match to.as_ref().map(|to| to.try_send(decision)) {
            Some(Ok(())) => Ok(()),
            Some(Err(TrySendError::Full(_))) => Err(Denied::Busy),
            Some(Err(TrySendError::Closed(_))) | None => Err(Denied::Unheard),
        };
        correlations.forward(identities, held, |correlation| {
            allowed(no_pair)?;
            let slot = slot.ok_or(Denied::Unheard)?;
            send(Decision::Correlate(slot, correlation))?;
            let decided = HeldCorrelation { correlation, since: slot };
            // What was decided on this pair before is replaced.
            let pair = |of: &Correlation| (of.radar, of.transponder);
            awaited.retain(|before| pair(&before.correlation) != pair(&correlation));
            awaited.extend((correlation.verdict != Verdict::Automatic).then_some(decided));
            Ok(decided)
        });
        words.forward(identities, integrities, |word| {
            allowed(no_word)?;
            let slot = slot.ok_or(Denied::Unheard)?;
            send(Decision::Say(slot, word))?;
            Ok(HeldWord { word, since: slot })
        });
    }
}

#[cfg(test)]
mod tests {
    use fusion::{RadarTrackKey, SensorIndex};

    use super::*;

    #[test]
    fn a_decision_is_awaited_until_a_cell_holds_it_or_should_have_said_so() {
        let scenario = "name = \"x\"\nduration_s = 20\n";
        let scenario = crate::simulate::Scenario::parse(scenario, "x.toml").unwrap();
        let config = crate::simulate::simulate(&scenario, 1, None).unwrap().config;
        let mut decider = Decider::new(&config, None);
        let held = |number| {
            let radar = RadarTrackKey { sensor: SensorIndex(0), number };
            let transponder = Identity::of_address(7);
            let correlation = Correlation { radar, transponder, verdict: Verdict::Correlated };
            HeldCorrelation { correlation, since: Slot(100) }
        };
        let none = Integrities::default();
        decider.awaited = vec![held(1), held(2)];
        decider.latest = Some(Slot(100));
        // One cell has it; from another slot on than was written, where the letter came late.
        decider.hear(&[HeldCorrelation { since: Slot(103), ..held(1) }], &none);
        assert_eq!(decider.awaited, [held(2)]);
        decider.latest = Some(Slot(119));
        decider.hear(&[held(1)], &none);
        assert_eq!(decider.awaited, [held(2)]);
        decider.latest = Some(Slot(120));
        decider.hear(&[held(1)], &none);
        assert_eq!(decider.awaited, []);
    }
}
