//! Encodes and restores the state of a pipeline. A restored pipeline publishes what the one that wrote the state would have.
//!
//! Counters are not included: a process counts what it did itself.

use std::mem;

use fusion::{CheckpointError, Engine, Time};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::duplicates::Duplicates;
use super::senders::Senders;
use super::settings::settings;
use super::{Pipeline, RemoteId, Selection, Shedding};
use crate::normalise::Barometer;
use site::areas::Masks;
use site::config::Config;

/// Version of the layout below; the engine's part has its own version.
const LAYOUT: u16 = 7;

/// Reason why a checkpoint cannot be restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotRestored {
    /// The octets are no checkpoint, of another version, or incomplete.
    #[error("not a state that this version has written")]
    Unreadable,
    /// The configuration of the site or the sensors has changed.
    #[error("the site or its sensors are configured otherwise now")]
    Site,
    /// Error in the engine's part.
    #[error(transparent)]
    Engine(#[from] CheckpointError),
}

/// The first part of a checkpoint; the engine's part follows it.
#[derive(Serialize, Deserialize)]
struct Written<State> {
    layout: u16,
    /// Hash of the configuration of the site and the sensors.
    site: [u8; 32],
    state: State,
}

/// State of the pipeline without the engine.
#[derive(Serialize, Deserialize)]
struct State<D, S, B, R, H, L> {
    duplicates: D,
    senders: S,
    barometer: B,
    remote_id: R,
    selection: H,
    shedding: L,
    now: Time,
    clock_behind: bool,
}

impl Pipeline {
    /// The state, encoded.
    #[must_use]
    pub fn checkpoint(&self, config: &Config) -> Vec<u8> {
        let mut octets = Vec::new();
        self.checkpoint_into(config, &mut octets);
        octets
    }

    /// Appends the encoded state to a buffer.
    pub fn checkpoint_into(&self, config: &Config, octets: &mut Vec<u8>) {
        let Self { duplicates, senders, barometer, remote_id, selection, shedding, engine, .. } = self;
        let (now, clock_behind) = (self.now, self.clock_behind);
        let state =
            State { duplicates, senders, barometer, remote_id, selection, shedding, now, clock_behind };
        let written = Written { layout: LAYOUT, site: site(config), state };
        *octets = postcard::to_extend(&written, mem::take(octets)).expect("every state can be written down");
        engine.checkpoint_into(octets);
    }

    /// Restores the pipeline from a checkpoint.
    ///
    /// # Errors
    /// The octets are no checkpoint, of another version or damaged, or the site had other sensors or settings.
    pub fn restored(config: &Config, masks: Masks, octets: &[u8]) -> Result<Self, NotRestored> {
        type Known =
            State<Duplicates, Senders, Barometer, Option<RemoteId>, Option<Selection>, Option<Shedding>>;
        let (layout, _) = postcard::take_from_bytes::<u16>(octets).map_err(|_| NotRestored::Unreadable)?;
        if layout != LAYOUT {
            return Err(NotRestored::Unreadable);
        }
        let (written, engine) =
            postcard::take_from_bytes::<Written<Known>>(octets).map_err(|_| NotRestored::Unreadable)?;
        if written.site != site(config) {
            return Err(NotRestored::Site);
        }
        let new = Self::new(config, masks);
        let engine = Engine::restored(settings(config, &new.normaliser), engine)?;
        let State { duplicates, senders, barometer, remote_id, selection, shedding, now, clock_behind } =
            written.state;
        let senders = new.senders.going_on(senders);
        Ok(Self {
            duplicates,
            senders,
            barometer,
            remote_id,
            selection,
            shedding,
            engine,
            now,
            clock_behind,
            ..new
        })
    }
}

/// Hash of the configuration of the site and the sensors.
fn site(config: &Config) -> [u8; 32] {
    Sha256::digest(format!("{:?}", (&config.site, &config.sensors))).into()
}
