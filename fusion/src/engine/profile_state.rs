//! The state of the engine's profile.

use crate::operational::{Operational, OperationalSettings};
use crate::reference::Reference;
use crate::settings::{Profile, Settings};

/// State of the profile, which determines the points of a slot.
#[derive(Debug)]
pub(super) enum ProfileState {
    Reference(Reference),
    Operational(Box<Operational>, OperationalSettings),
}

impl ProfileState {
    pub(super) fn new(settings: &Settings) -> Self {
        match &settings.profile {
            Profile::Reference(rules) => Self::Reference(Reference::new(settings, rules)),
            Profile::Operational(rules) => {
                let latency = settings.grid.slot() * settings.latency_slots as i32;
                let rules = OperationalSettings::new(&settings.sensors, latency, rules);
                Self::Operational(Box::default(), rules)
            }
        }
    }
}
