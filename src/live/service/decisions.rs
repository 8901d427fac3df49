//! Operators' decisions where the engines are elsewhere: they are written to the cells, which all carry them out from one slot on.

use std::collections::BTreeSet;

use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::mpsc::{Receiver, Sender, channel};

use crate::config::{Action, Config, Profile};
use crate::live::correlations::Correlations;
use crate::live::integrity::{Integrities, IntegrityRequests};
use crate::live::requests::Denied;
use crate::picture::Picture;
use fusion::Identity;
use fusion::integrity::{HeldWord, Word};
use fusion::operational::{Correlation, HeldCorrelation, NotCorrelated};
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
    /// Those that have been in the picture since the service began, at most as many as there are numbers; and the newest slot.
    identities: BTreeSet<Identity>,
    latest: Option<Slot>,
    /// What cells have said last that is in force.
    correlations: Vec<HeldCorrelation>,
    integrities: Integrities,
}

/// Identities that are remembered.
const REMEMBERED: usize = 100_000;

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
        self.integrities.clone_from(integrities);
    }

    /// Writes what was decided; `is_heard`: somebody is there to carry it out.
    pub(super) fn decide(&mut self, correlations: &Correlations, words: &IntegrityRequests, is_heard: bool) {
        let slot = self.latest.filter(|_| is_heard).map(|latest| latest.plus(AHEAD));
        let Self { refusals: [no_pair, no_word], to, identities, correlations: held, integrities, .. } = self;
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
            Ok(HeldCorrelation { correlation, since: slot })
        });
        words.forward(identities, integrities, |word| {
            allowed(no_word)?;
            let slot = slot.ok_or(Denied::Unheard)?;
            send(Decision::Say(slot, word))?;
            Ok(HeldWord { word, since: slot })
        });
    }
}
