//! Senders that are refused under a sensor's SAC/SIC, in its status. Sans-IO.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::health::{SensorState, SensorStatus};
use crate::pipeline::{Contest, ContestReason};
use fusion::Identity;

/// Most transponders that are named; the others are counted.
const NAMED: usize = 3;

/// A sender that is refused under a sensor's SAC/SIC.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contested {
    /// The sender that counts; with port 0 the host that the sensor's `source` names.
    pub counts: SocketAddr,
    /// The sender that is refused.
    pub refused: SocketAddr,
    /// Why it is refused.
    pub reason: ContestReason,
    /// The transponders that both report; empty where they speak for a radar.
    pub transponders: Vec<Identity>,
}

impl Contested {
    /// The reason in the sensor's status.
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

/// Adds the refused senders of each sensor, which is degraded while they last.
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
