//! The pipeline's state as octets, and back: who loads it and goes on publishes what the one that wrote it would have.
//!
//! What was counted is no part of it: a process counts what it did itself.

use std::mem;

use fusion::{CheckpointError, Engine, Time};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::duplicates::Duplicates;
use super::senders::Senders;
use super::settings::settings;
use super::{Pipeline, RemoteId, Selection, Shedding};
use crate::areas::Masks;
use crate::config::Config;
use crate::normalise::Barometer;

/// Number of the layout below; that of the engine is its own.
const LAYOUT: u16 = 6;

/// Why a pipeline does not go on where another one was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotRestored {
    /// The octets are none, of another version, or not whole.
    #[error("not a state that this version has written")]
    Unreadable,
    /// Sensors or site are configured otherwise.
    #[error("the site or its sensors are configured otherwise now")]
    Site,
    /// What the engine says of its part.
    #[error(transparent)]
    Engine(#[from] CheckpointError),
}

/// What a checkpoint begins with; the engine's is behind it.
#[derive(Serialize, Deserialize)]
struct Written<State> {
    layout: u16,
    /// Hash of the site and the sensors, as the configuration has them.
    site: [u8; 32],
    state: State,
}

/// What the pipeline knows besides the engine.
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
    /// The state as octets.
    #[must_use]
    pub fn checkpoint(&self, config: &Config) -> Vec<u8> {
        let mut octets = Vec::new();
        self.checkpoint_into(config, &mut octets);
        octets
    }

    /// The same, written behind what stands in a buffer.
    pub fn checkpoint_into(&self, config: &Config, octets: &mut Vec<u8>) {
        let Self { duplicates, senders, barometer, remote_id, selection, shedding, engine, .. } = self;
        let (now, clock_behind) = (self.now, self.clock_behind);
        let state =
            State { duplicates, senders, barometer, remote_id, selection, shedding, now, clock_behind };
        let written = Written { layout: LAYOUT, site: site(config), state };
        *octets = postcard::to_extend(&written, mem::take(octets)).expect("every state can be written down");
        engine.checkpoint_into(octets);
    }

    /// The pipeline that wrote a checkpoint.
    ///
    /// # Errors
    /// It is none, of another version, damaged, or of a site with other sensors or settings.
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

/// Whose state it is.
fn site(config: &Config) -> [u8; 32] {
    Sha256::digest(format!("{:?}", (&config.site, &config.sensors))).into()
}
