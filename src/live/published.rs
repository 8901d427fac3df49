//! What readers are given: each slot's picture, and once a second how the service is.

use std::sync::{Arc, PoisonError, RwLock};

use serde::{Deserialize, Serialize};

use super::alerts::{Alert, Change, Trouble};
use super::health::{SensorStatus, Unknown};
use super::state_troubles::state_troubles;
use crate::config::PictureKind;
use crate::conflicts::{ConflictWatch, Outlook};
use crate::picture::{Picture, PictureMaker};
use crate::pipeline::Tally;
use crate::state::StateHealth;
use fusion::time::Time;

/// A slot's picture as it was published.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedPicture {
    /// Counts the slots of this run of the service, from 1.
    pub seq: u64,
    /// When the slot was due.
    pub due: Time,
    /// When it was published.
    pub published_at: Time,
    /// The picture itself.
    pub picture: Picture,
    /// Where aircraft are predicted to be by then, where that picture is made.
    pub now: Fleeting,
}

impl PublishedPicture {
    /// Whether `watch` looks for conflicts in it.
    pub fn is_due(&self, watch: &ConflictWatch, maker: &PictureMaker) -> bool {
        let slot = match watch.on() {
            PictureKind::Lagged => Some(self.picture.slot),
            PictureKind::Now => self.now.get().map(|now| now.slot),
        };
        slot.is_some_and(|slot| maker.begins_second(slot))
    }

    /// What `watch` finds in it; `None` between two evaluations, and where there is no such picture.
    pub fn conflicts(&self, watch: &mut ConflictWatch, maker: &PictureMaker) -> Option<Outlook> {
        match watch.on() {
            PictureKind::Lagged => watch.look(&self.picture, maker),
            PictureKind::Now => watch.look(&*self.now.get()?, maker),
        }
    }
}

/// A picture that is forgotten before others are: nobody acts on where aircraft were predicted to be some seconds ago.
#[derive(Debug, Default)]
pub struct Fleeting(RwLock<Option<Arc<Picture>>>);

impl Fleeting {
    /// The picture, while it is remembered.
    pub fn get(&self) -> Option<Arc<Picture>> {
        self.0.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Forgets it.
    pub fn forget(&self) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl From<Option<Picture>> for Fleeting {
    fn from(picture: Option<Picture>) -> Self {
        Self(RwLock::new(picture.map(Arc::new)))
    }
}

/// Each is forgotten by itself.
impl Clone for Fleeting {
    fn clone(&self) -> Self {
        Self(RwLock::new(self.get()))
    }
}

impl PartialEq for Fleeting {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

/// How the service is; published once a second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// When.
    pub at: Time,
    /// In the order of the configuration.
    pub sensors: Vec<SensorStatus>,
    /// Sources that are heard and not configured.
    pub unknown: Vec<Unknown>,
    /// What happened since the start.
    pub tally: Tally,
    /// Transponder numbers in use.
    pub numbers_used: usize,
    /// Lateness of the slots of the last minutes, seconds: median, 95th and 99th percentile.
    pub lateness_s: Option<[f64; 3]>,
    /// Datagrams that could not be sent since the start.
    pub failed_sends: u64,
    /// What the engine knows to be wrong with the service itself; [`Condition`](super::Condition) adds what it cannot know.
    pub troubles: Vec<Trouble>,
}

/// Where pictures go that are to be seen again later.
pub trait Archive: Send {
    /// Takes a picture; never waits.
    fn note(&mut self, picture: &Picture, maker: &PictureMaker);

    /// What is wrong with it.
    fn trouble(&self) -> Option<Trouble>;
}

/// How people hear of alerts who are not at the map.
pub trait Messenger: Send {
    /// Takes what has become of an alert; never waits.
    fn note(&mut self, change: Change, alert: &Alert);

    /// What is wrong with it.
    fn troubles(&self) -> Vec<Trouble>;
}

/// Who else the picture goes to.
pub trait Outgoing: Send {
    /// What is wrong with them.
    fn troubles(&self) -> Vec<Trouble>;
}

/// Who is handed what the observer sees.
#[derive(Default)]
pub struct Followers {
    /// Takes the pictures.
    pub archive: Option<Box<dyn Archive>>,
    /// Takes the alerts.
    pub messenger: Option<Box<dyn Messenger>>,
    /// Takes the pictures by itself; only what is wrong with it is asked.
    pub outgoing: Option<Box<dyn Outgoing>>,
    /// Health of the files of the state, where it is kept.
    pub state: Option<StateHealth>,
}

impl Followers {
    /// What is wrong with them.
    pub(super) fn troubles(&self, at: Time) -> Vec<Trouble> {
        let messenger = self.messenger.iter().flat_map(|messenger| messenger.troubles());
        let outgoing = self.outgoing.iter().flat_map(|outgoing| outgoing.troubles());
        let state = self.state.iter().flat_map(|health| state_troubles(health, at));
        let archive = self.archive.iter().filter_map(|archive| archive.trouble());
        archive.chain(messenger).chain(outgoing).chain(state).collect()
    }
}
