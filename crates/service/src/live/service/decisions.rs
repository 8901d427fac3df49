//! Operators' decisions if the engines run on other nodes. They are written to all cells, which apply them from the same
//! slot on.

use std::collections::BTreeSet;

use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tracing::warn;

use crate::live::correlations::CorrelationRequestQueue;
use crate::live::integrity::{TrustAssessments, TrustRequestQueue};
use crate::live::requests::RequestError;
use fusion::Identity;
use fusion::integrity::{ActiveOverride, TrustOverride};
use fusion::operational::{ActiveAssociation, AssociationRefusal, ManualAssociation, Verdict};
use fusion::slots::Slot;
use picture::Picture;
use site::config::{Action, Config, Profile};

/// Number of slots from the newest one shown to the first that a decision affects: time for the cells to receive it.
const AHEAD: i64 = 12;
/// Maximum number of decisions waiting to be written.
const QUEUE: usize = 64;

/// A decision, with the first slot that it affects.
#[derive(Clone, Debug, PartialEq)]
pub enum OperatorDecision {
    /// Decision on a radar track and a transponder.
    Correlate(Slot, ManualAssociation),
    /// Trust setting for a transponder.
    SetTrust(Slot, TrustOverride),
}

/// Queue of decisions to the cells.
pub fn decisions() -> (Sender<OperatorDecision>, Receiver<OperatorDecision>) {
    channel(QUEUE)
}

/// Takes operators' decisions at a viewer.
#[derive(Debug)]
pub(super) struct DecisionForwarder {
    /// Reasons for refusing all requests: for correlations, and for trust settings.
    refusals: [Option<RequestError>; 2],
    to: Option<Sender<OperatorDecision>>,
    /// Transponders seen in the picture lately, and its newest slot.
    identities: BTreeSet<Identity>,
    latest: Option<Slot>,
    /// Decisions on correlations that no cell has confirmed yet.
    unconfirmed: Vec<ActiveAssociation>,
    /// Decisions in force, as last reported by the cells.
    correlations: Vec<ActiveAssociation>,
    integrities: TrustAssessments,
}

/// Maximum number of transponders kept; then only those of the present picture are.
const IDENTITIES_MAX: usize = 100_000;
/// Number of slots, from the first one affected, within which a cell confirms a decision: 5 s.
const CONFIRMATION_SLOTS: i64 = 20;

impl DecisionForwarder {
    pub(super) fn new(config: &Config, to: Option<Sender<OperatorDecision>>) -> Self {
        let is_reference = config.fusion.profile == Profile::Reference;
        let judges = !is_reference && config.integrity.action != Action::Off;
        Self {
            refusals: [
                is_reference.then(|| AssociationRefusal::Reference.into()),
                (!judges).then_some(RequestError::NotJudged),
            ],
            to,
            identities: BTreeSet::new(),
            latest: None,
            unconfirmed: Vec::new(),
            correlations: Vec::new(),
            integrities: TrustAssessments::default(),
        }
    }

    pub(super) fn note_picture(&mut self, picture: &Picture) {
        self.latest = Some(picture.slot);
        if self.identities.len() >= IDENTITIES_MAX {
            self.identities.clear();
        }
        let seen = picture.tracks.iter().filter_map(|track| track.point.source.transponder());
        self.identities.extend(seen.map(|part| part.identity));
    }

    pub(super) fn note_cell_status(
        &mut self,
        correlations: &[ActiveAssociation],
        integrities: &TrustAssessments,
    ) {
        correlations.clone_into(&mut self.correlations);
        let Self { unconfirmed, latest, .. } = self;
        unconfirmed.retain(|unconfirmed| {
            let is_held = correlations.iter().any(|held| held.correlation == unconfirmed.correlation);
            let is_refused =
                !is_held && latest.is_some_and(|latest| latest >= unconfirmed.since.plus(CONFIRMATION_SLOTS));
            if is_refused {
                let ManualAssociation { radar, transponder, verdict } = unconfirmed.correlation;
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

    /// Forwards the waiting requests to the cells; `is_heard`: a cell is received that can carry them out.
    pub(super) fn forward(
        &mut self,
        correlations: &CorrelationRequestQueue,
        words: &TrustRequestQueue,
        is_heard: bool,
    ) {
        let slot = self.latest.filter(|_| is_heard).map(|latest| latest.plus(AHEAD));
        let Self {
            refusals: [no_pair, no_word],
            to,
            identities,
            correlations: held,
            integrities,
            unconfirmed,
            ..
        } = self;
        let allowed = |refusal: &Option<RequestError>| refusal.clone().map_or(Ok(()), Err);
        let send = |decision: OperatorDecision| match to.as_ref().map(|to| to.try_send(decision)) {
            Some(Ok(())) => Ok(()),
            Some(Err(TrySendError::Full(_))) => Err(RequestError::Busy),
            Some(Err(TrySendError::Closed(_))) | None => Err(RequestError::Unheard),
        };
        correlations.forward(identities, held, |correlation| {
            allowed(no_pair)?;
            let slot = slot.ok_or(RequestError::Unheard)?;
            send(OperatorDecision::Correlate(slot, correlation))?;
            let decided = ActiveAssociation { correlation, since: slot };
            // Replaces an earlier decision on the same pair.
            let pair = |of: &ManualAssociation| (of.radar, of.transponder);
            unconfirmed.retain(|before| pair(&before.correlation) != pair(&correlation));
            unconfirmed.extend((correlation.verdict != Verdict::Automatic).then_some(decided));
            Ok(decided)
        });
        words.forward(identities, integrities, |word| {
            allowed(no_word)?;
            let slot = slot.ok_or(RequestError::Unheard)?;
            send(OperatorDecision::SetTrust(slot, word))?;
            Ok(ActiveOverride { word, since: slot })
        });
    }
}

#[cfg(test)]
mod tests {
    use fusion::{RadarTrackKey, SensorIndex};

    use super::*;

    #[test]
    fn decision_is_unconfirmed_until_a_cell_holds_it_or_5_s() {
        let scenario = "name = \"x\"\nduration_s = 20\n";
        let scenario = lab::simulate::Scenario::parse(scenario, "x.toml").unwrap();
        let config = lab::simulate::simulate(&scenario, 1, None).unwrap().config;
        let mut forwarder = DecisionForwarder::new(&config, None);
        let held = |number| {
            let radar = RadarTrackKey { sensor: SensorIndex(0), number };
            let transponder = Identity::of_address(7);
            let correlation = ManualAssociation { radar, transponder, verdict: Verdict::Correlated };
            ActiveAssociation { correlation, since: Slot(100) }
        };
        let none = TrustAssessments::default();
        forwarder.unconfirmed = vec![held(1), held(2)];
        forwarder.latest = Some(Slot(100));
        // One cell confirms it, from a later slot than was written because the message came late.
        forwarder.note_cell_status(&[ActiveAssociation { since: Slot(103), ..held(1) }], &none);
        assert_eq!(forwarder.unconfirmed, [held(2)]);
        forwarder.latest = Some(Slot(119));
        forwarder.note_cell_status(&[held(1)], &none);
        assert_eq!(forwarder.unconfirmed, [held(2)]);
        forwarder.latest = Some(Slot(120));
        forwarder.note_cell_status(&[held(1)], &none);
        assert_eq!(forwarder.unconfirmed, []);
    }
}
