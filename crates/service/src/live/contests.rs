//! Rejected senders under a sensor's SAC/SIC, in its status. Sans-IO.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::health::{SensorState, SensorStatus};
use fusion::Identity;
use input::pipeline::{Contest, ContestReason};

/// Maximum number of transponders named in a reason; the others are counted.
const NAMED: usize = 3;

/// A rejected sender under a sensor's SAC/SIC.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contested {
    /// The accepted sender; with port 0 the host that the sensor's `source` names.
    pub counts: SocketAddr,
    /// The rejected sender.
    pub refused: SocketAddr,
    /// Reason for the rejection.
    pub reason: ContestReason,
    /// Transponders that both senders report; empty if they send data of a radar.
    pub transponders: Vec<Identity>,
}

impl Contested {
    /// Text for the sensor's status.
    fn reason(&self) -> String {
        let Self { counts, refused, reason, transponders } = self;
        if *reason == ContestReason::ForeignSource {
            return format!(
                "{refused} sends under its SAC/SIC and is refused: it is not the source of an input, as {} is",
                counts.ip()
            );
        }
        let serials: Vec<String> =
            transponders.iter().take(NAMED).map(|one| one.name().escape_ascii().to_string()).collect();
        let of = match transponders.len() {
            0 => String::new(),
            1 => format!(" of transponder {}", serials[0]),
            count @ 2..=NAMED => format!(" of {count} transponders ({})", serials.join(", ")),
            count => format!(" of {count} transponders ({}, ...)", serials.join(", ")),
        };
        format!(
            "two senders with its SAC/SIC say different things{of}: {counts} was heard first and counts, \
             {refused} is refused while it speaks (name both as source if they are lines of one sensor)"
        )
    }
}

/// Adds the rejected senders to their sensors, which are degraded meanwhile.
pub(super) fn note_contests(sensors: &mut [SensorStatus], contests: &[Contest]) {
    let mut by_senders: BTreeMap<_, Vec<Identity>> = BTreeMap::new();
    for contest in contests {
        let Contest { sensor, counts, refused, reason, identity, .. } = *contest;
        by_senders.entry((sensor, counts, refused, reason)).or_default().extend(identity);
    }
    for ((sensor, counts, refused, reason), transponders) in by_senders {
        let Some(status) = sensors.get_mut(usize::from(sensor.0)) else { continue };
        let contested = Contested { counts, refused, reason, transponders };
        status.state = status.state.max(SensorState::Degraded);
        status.reasons.push(contested.reason());
        status.contested.push(contested);
    }
}
