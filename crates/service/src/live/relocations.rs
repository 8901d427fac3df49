//! Operators' decisions to move a radar to where its tracks show it: the queue to the engine, and the relocations in force.

use super::driver::Driver;
use super::requests::{RequestError, RequestQueue, RequestSender, request_queue};
use fusion::SensorIndex;
use fusion::operational::{ActiveRelocation, RadarRelocation, Relocation};
use fusion::slots::Slot;

/// An operator's request about a radar's position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RelocationRequest {
    /// The radar.
    pub radar: SensorIndex,
    /// `true`: the position that its tracks show is used; `false`: the configured one holds again.
    pub is_applied: bool,
}

/// The API's end of the queue, with the relocations in force; cheap to clone.
pub type RelocationRequests = RequestSender<RelocationRequest, Vec<ActiveRelocation>>;

/// The engine's end of the queue.
#[derive(Debug)]
pub struct RelocationRequestQueue(RequestQueue<RelocationRequest, Vec<ActiveRelocation>>);

/// Both ends of the queue.
pub(super) fn relocation_requests() -> (RelocationRequestQueue, RelocationRequests) {
    let (requests, operators) = request_queue();
    (RelocationRequestQueue(requests), operators)
}

impl RelocationRequestQueue {
    /// Carries out the waiting requests. Returns the decisions, each with the first slot that it affects.
    pub fn carry_out_all(&self, driver: &mut Driver) -> Vec<(Slot, RadarRelocation)> {
        self.0.carry_out_all(|request| {
            let decided = relocate(*request, driver)?;
            Ok((decided, driver.pipeline().engine().relocations()))
        })
    }

    /// Refuses the waiting requests: the engines run on other nodes.
    pub fn refuse_all(&self) {
        self.0.carry_out_all(|_| Err::<((), _), _>(RequestError::NotRelocatedHere));
    }

    /// Publishes the relocations in force. Returns whether they changed.
    pub fn publish_if_changed(&self, in_force: &[ActiveRelocation]) -> bool {
        self.0.publish_if_changed(|known| *known != in_force, || in_force.to_vec())
    }
}

fn relocate(
    request: RelocationRequest,
    driver: &mut Driver,
) -> Result<(Slot, RadarRelocation), RequestError> {
    let RelocationRequest { radar, is_applied } = request;
    let engine = driver.pipeline().engine();
    let present =
        engine.relocations().into_iter().find(|active| active.radar == radar).map(|active| active.to);
    let to = if is_applied {
        let found = engine.registered().find(|(sensor, _)| *sensor == radar);
        let found = found.and_then(|(_, registered)| registered.place());
        let found = found.filter(|found| found.contradicts).ok_or(RequestError::NotContradicted)?;
        let to = present.unwrap_or_default().beyond(found);
        Some(Some(to).filter(Relocation::is_plausible).ok_or(RequestError::NotContradicted)?)
    } else {
        present.ok_or(RequestError::NotRelocated)?;
        None
    };
    let decided = RadarRelocation { radar, to };
    Ok((driver.relocate(decided).ok_or(RequestError::NotContradicted)?, decided))
}
