//! Trust in transponders: the present assessments, and the queue of operators' trust settings to the engine.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::correlations::TransponderName;
use super::driver::Driver;
use super::requests::{RequestError, RequestQueue, RequestSender, request_queue};
use fusion::Identity;
use fusion::integrity::{ActiveOverride, Assessment, Reason, Trust, TrustOverride};
use fusion::operational::AssociationRefusal;
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};

/// An operator's request to set the trust in a transponder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrustRequest {
    /// The transponder.
    pub transponder: TransponderName,
    /// The trust.
    pub trust: Trust,
}

/// Assessments of transponders; published once a second, and at once when a state changes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrustAssessments {
    /// Time of the latest slot; `None` before the first.
    pub at: Option<Time>,
    /// Transponders received in the last hour.
    pub assessments: Vec<Assessment>,
    /// Operators' trust settings in force.
    pub words: Vec<ActiveOverride>,
    /// Number of flags since the start, by reason.
    pub flags: BTreeMap<Reason, u64>,
}

/// The API's end of the queue, with the present assessments; cheap to clone.
pub type TrustRequests = RequestSender<TrustRequest, TrustAssessments>;

/// The engine's end of the queue.
#[derive(Debug)]
pub struct TrustRequestQueue(RequestQueue<TrustRequest, TrustAssessments>);

/// Both ends of the queue.
pub(super) fn trust_requests() -> (TrustRequestQueue, TrustRequests) {
    let (requests, operators) = request_queue();
    (TrustRequestQueue(requests), operators)
}

impl TrustRequestQueue {
    /// Carries out the waiting requests. Returns the trust settings, each with the first slot that it affects.
    pub fn carry_out_all(&self, driver: &mut Driver) -> Vec<(Slot, TrustOverride)> {
        let at = driver.latest();
        self.0.carry_out_all(|request| Ok((set_trust(request, driver)?, TrustAssessments::of(driver, at))))
    }

    /// Forwards the waiting requests to engines on other nodes. A request may name the transponders in `known` and in
    /// `held`.
    pub fn forward(
        &self,
        known: &BTreeSet<Identity>,
        held: &mut TrustAssessments,
        mut forward: impl FnMut(TrustOverride) -> Result<ActiveOverride, RequestError>,
    ) {
        self.0.carry_out_all(|request| {
            let judged = held.assessments.iter().map(|assessment| assessment.identity);
            let with_settings = held.words.iter().map(|held| held.word.identity);
            let identity =
                request.transponder.among(known.iter().copied().chain(judged).chain(with_settings))?;
            let identity = identity.ok_or(AssociationRefusal::NoTransponder)?;
            let said = forward(TrustOverride { identity, trust: request.trust })?;
            held.words.retain(|held| held.word.identity != identity);
            held.words.extend((request.trust != Trust::Automatic).then_some(said));
            Ok(((), held.clone()))
        });
    }

    /// Publishes the assessments of engines on other nodes.
    pub fn publish(&self, known: &TrustAssessments) {
        self.0.publish_if_changed(|before| before != known, || known.clone());
    }

    /// Publishes the assessments as of the driver's latest slot, if a second has passed or a state has changed. Returns
    /// whether they were published.
    pub fn publish_if_changed(&self, driver: &Driver) -> bool {
        let Some(at) = driver.latest() else { return false };
        self.0.publish_if_changed(
            |known| known.is_outdated(driver, at),
            || TrustAssessments::of(driver, Some(at)),
        )
    }
}

impl TrustAssessments {
    /// The trust setting in force for a transponder.
    pub fn word(&self, identity: Identity) -> Option<&ActiveOverride> {
        self.words.iter().find(|held| held.word.identity == identity)
    }

    /// Assessments as of the driver's latest slot.
    pub fn of(driver: &Driver, at: Option<Time>) -> Self {
        let engine = driver.pipeline().engine();
        Self {
            at,
            assessments: engine.assessments().cloned().collect(),
            words: engine.trust_overrides(),
            flags: driver.flags().counts().clone(),
        }
    }

    fn is_outdated(&self, driver: &Driver, at: Time) -> bool {
        // This is called far more often than there are slots.
        if self.at == Some(at) {
            return false;
        }
        let second = |time: Time| time.nanos().div_euclid(SECOND);
        let state = |one: &Assessment| (one.identity, one.integrity.state, one.is_silent, one.twin);
        let engine = driver.pipeline().engine();
        self.at.map(second) != Some(second(at))
            || self.words != engine.trust_overrides()
            || !self.assessments.iter().map(state).eq(engine.assessments().map(state))
    }
}

fn set_trust(request: &TrustRequest, driver: &mut Driver) -> Result<(Slot, TrustOverride), RequestError> {
    let engine = driver.pipeline().engine();
    // A setting may name a transponder that fell silent long ago.
    let known = engine.assessments().map(|assessment| assessment.identity);
    let known = known.chain(engine.trust_overrides().into_iter().map(|held| held.word.identity));
    let identity = request.transponder.among(known)?.ok_or(AssociationRefusal::NoTransponder)?;
    let word = TrustOverride { identity, trust: request.trust };
    Ok((driver.set_trust(word).ok_or(RequestError::NotJudged)?, word))
}
