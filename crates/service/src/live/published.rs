//! Data that is published: each slot's picture, and the status once a second.

use std::sync::{Arc, PoisonError, RwLock};

use serde::{Deserialize, Serialize};

use super::alerts::{Alert, AlertChange, ServiceFault};
use super::health::{SensorStatus, UnconfiguredSource};
use super::state_troubles::state_troubles;
use crate::state::StateHealth;
use fusion::time::Time;
use input::pipeline::Tally;
use picture::conflicts::{ConflictWatch, Outlook};
use picture::{Picture, PictureMaker};
use site::config::PictureKind;

/// A slot's picture as published.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedPicture {
    /// Number of the slot in this run of the service, from 1.
    pub seq: u64,
    /// Time at which the slot was due.
    pub due: Time,
    /// Time of publication.
    pub published_at: Time,
    /// The picture.
    pub picture: Picture,
    /// Predicted positions at the time of publication, if that picture is made.
    pub now: PresentPicture,
}

impl PublishedPicture {
    /// Whether `watch` evaluates conflicts in this slot.
    pub fn is_due(&self, watch: &ConflictWatch, maker: &PictureMaker) -> bool {
        let slot = match watch.on() {
            PictureKind::Lagged => Some(self.picture.slot),
            PictureKind::Now => self.now.get().map(|now| now.slot),
        };
        slot.is_some_and(|slot| maker.begins_second(slot))
    }

    /// Conflicts that `watch` finds; `None` between two evaluations, and if there is no such picture.
    pub fn conflicts(&self, watch: &mut ConflictWatch, maker: &PictureMaker) -> Option<Outlook> {
        match watch.on() {
            PictureKind::Lagged => watch.look(&self.picture, maker),
            PictureKind::Now => watch.look(&*self.now.get()?, maker),
        }
    }
}

/// The present picture, which is dropped before the others: old predictions of the present are useless.
#[derive(Debug, Default)]
pub struct PresentPicture(RwLock<Option<Arc<Picture>>>);

impl PresentPicture {
    /// The picture, unless it was dropped.
    pub fn get(&self) -> Option<Arc<Picture>> {
        self.0.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Drops the picture.
    pub fn forget(&self) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl From<Option<Picture>> for PresentPicture {
    fn from(picture: Option<Picture>) -> Self {
        Self(RwLock::new(picture.map(Arc::new)))
    }
}

/// A clone is dropped independently.
impl Clone for PresentPicture {
    fn clone(&self) -> Self {
        Self(RwLock::new(self.get()))
    }
}

impl PartialEq for PresentPicture {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

/// Status of the service; published once a second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Time of the status.
    pub at: Time,
    /// Status of the sensors, in the order of the configuration.
    pub sensors: Vec<SensorStatus>,
    /// Sources that are received but not configured.
    pub unknown: Vec<UnconfiguredSource>,
    /// Counts since the start.
    pub tally: Tally,
    /// Number of transponder numbers in use.
    pub numbers_used: usize,
    /// Lateness of the slots of the last minutes, in seconds: median, 95th and 99th percentile.
    pub lateness_s: Option<[f64; 3]>,
    /// Datagrams that could not be sent since the start.
    pub failed_sends: u64,
    /// Faults of the service itself, as known to the engine; [`Condition`](super::Condition) adds those unknown to it.
    pub troubles: Vec<ServiceFault>,
}

/// Keeps past pictures.
pub trait Archive: Send {
    /// Stores a picture; never waits.
    fn note(&mut self, picture: &Picture, maker: &PictureMaker);

    /// Present fault of the archive.
    fn trouble(&self) -> Option<ServiceFault>;
}

/// Notifies people who are not at the map of alerts.
pub trait Messenger: Send {
    /// Takes a change of an alert; never waits.
    fn note(&mut self, change: AlertChange, alert: &Alert);

    /// Present faults of the messenger.
    fn troubles(&self) -> Vec<ServiceFault>;
}

/// Sends the picture to other networks.
pub trait Outgoing: Send {
    /// Present faults of the outputs.
    fn troubles(&self) -> Vec<ServiceFault>;
}

/// Components that the observer passes its data to.
#[derive(Default)]
pub struct Followers {
    /// Receives the pictures.
    pub archive: Option<Box<dyn Archive>>,
    /// Receives the alerts.
    pub messenger: Option<Box<dyn Messenger>>,
    /// Reads the pictures itself; only its faults are requested here.
    pub outgoing: Option<Box<dyn Outgoing>>,
    /// Health of the state files, if state is kept.
    pub state: Option<StateHealth>,
}

impl Followers {
    /// Present faults of all followers.
    pub(super) fn troubles(&self, at: Time) -> Vec<ServiceFault> {
        let messenger = self.messenger.iter().flat_map(|messenger| messenger.troubles());
        let outgoing = self.outgoing.iter().flat_map(|outgoing| outgoing.troubles());
        let state = self.state.iter().flat_map(|health| state_troubles(health, at));
        let archive = self.archive.iter().filter_map(|archive| archive.trouble());
        archive.chain(messenger).chain(outgoing).chain(state).collect()
    }
}
