//! Operators' decisions on correlations: the queue to the engine, and the decisions in force.

use std::collections::BTreeSet;

use super::driver::Driver;
use super::requests::{RequestError, RequestQueue, RequestSender, request_queue};
use fusion::operational::{ActiveAssociation, AssociationRefusal, ManualAssociation, Verdict};
use fusion::slots::Slot;
use fusion::{Identity, RadarTrackKey};
use picture::serial_text;

/// An operator's request to decide on a correlation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CorrelationRequest {
    /// The radar track, by its present number.
    pub radar: RadarTrackKey,
    /// The transponder.
    pub transponder: TransponderName,
    /// The decision.
    pub verdict: Verdict,
}

/// A transponder as an operator names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TransponderName {
    /// Serial number, as displayed.
    pub serial: String,
    /// Registration country, as displayed; needed if several transponders have that serial number.
    pub country: Option<String>,
}

/// The API's end of the queue, with the decisions in force; cheap to clone.
pub type CorrelationRequests = RequestSender<CorrelationRequest, Vec<ActiveAssociation>>;

/// The engine's end of the queue.
#[derive(Debug)]
pub struct CorrelationRequestQueue(RequestQueue<CorrelationRequest, Vec<ActiveAssociation>>);

/// Both ends of the queue.
pub(super) fn correlation_requests() -> (CorrelationRequestQueue, CorrelationRequests) {
    let (requests, operators) = request_queue();
    (CorrelationRequestQueue(requests), operators)
}

impl CorrelationRequestQueue {
    /// Carries out the waiting requests. Returns the decisions, each with the first slot that it affects.
    pub fn carry_out_all(&self, driver: &mut Driver) -> Vec<(Slot, ManualAssociation)> {
        self.0.carry_out_all(|request| {
            Ok((correlate(request, driver)?, driver.pipeline().engine().correlations()))
        })
    }

    /// Forwards the waiting requests to engines on other nodes. A request may name the transponders in `known`, and those
    /// with a decision in `in_force`. The forwarded decisions are added to `in_force`, the decisions in force.
    pub fn forward(
        &self,
        known: &BTreeSet<Identity>,
        in_force: &mut Vec<ActiveAssociation>,
        mut forward: impl FnMut(ManualAssociation) -> Result<ActiveAssociation, RequestError>,
    ) {
        self.0.carry_out_all(|request| {
            let correlated = in_force.iter().map(|held| held.correlation.transponder);
            let transponder = request.transponder.among(known.iter().copied().chain(correlated))?;
            let transponder = transponder.ok_or(AssociationRefusal::NoTransponder)?;
            let decided =
                forward(ManualAssociation { radar: request.radar, transponder, verdict: request.verdict })?;
            let is_same = |other: &ActiveAssociation| {
                let [one, other] = [&decided.correlation, &other.correlation];
                (one.radar, one.transponder) == (other.radar, other.transponder)
            };
            in_force.retain(|other| !is_same(other));
            in_force.extend((request.verdict != Verdict::Automatic).then_some(decided));
            Ok(((), in_force.clone()))
        });
    }

    /// Publishes the decisions in force. Returns whether they changed.
    pub fn publish_if_changed(&self, in_force: &[ActiveAssociation]) -> bool {
        self.0.publish_if_changed(|known| *known != in_force, || in_force.to_vec())
    }
}

fn correlate(
    request: &CorrelationRequest,
    driver: &mut Driver,
) -> Result<(Slot, ManualAssociation), RequestError> {
    let engine = driver.pipeline().engine();
    // A transponder with a decision may have fallen silent since.
    let correlated = engine.correlations().into_iter().map(|held| held.correlation.transponder);
    let transponder = match request.transponder.among(engine.transponders().chain(correlated))? {
        Some(transponder) => transponder,
        None if engine.knows_correlations() => return Err(AssociationRefusal::NoTransponder.into()),
        None => return Err(AssociationRefusal::Reference.into()),
    };
    let correlation = ManualAssociation { radar: request.radar, transponder, verdict: request.verdict };
    Ok((driver.correlate(correlation)?, correlation))
}

impl TransponderName {
    /// The only one of the identities that matches; `None` if none does.
    pub(super) fn among(
        &self,
        identities: impl Iterator<Item = Identity>,
    ) -> Result<Option<Identity>, RequestError> {
        let mut found: Vec<Identity> = identities.filter(|identity| self.means(*identity)).collect();
        found.sort_unstable();
        found.dedup();
        match found[..] {
            [] => Ok(None),
            [identity] => Ok(Some(identity)),
            _ => Err(RequestError::Ambiguous(found.iter().map(country).collect())),
        }
    }

    fn means(&self, identity: Identity) -> bool {
        let is_serial = serial_text(identity) == self.serial;
        is_serial && self.country.as_ref().is_none_or(|wanted| *wanted == country(&identity))
    }
}

fn country(identity: &Identity) -> String {
    match identity.country() {
        [] => "none".to_owned(),
        octets => octets.escape_ascii().to_string(),
    }
}
