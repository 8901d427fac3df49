//! How alerts reach people who are not at the map: webhooks and a broker of MQTT 5.
//!
//! ```text
//! observer ──► Notices ──► Outbox (bounded, per receiver) ──► webhook's task ──► HTTP
//!              never waits                                └─► broker's task  ──► MQTT 5
//! ```
//!
//! `Outbox` decides what is sent, what is lost and how long to wait; it knows neither clock nor socket. Each
//! receiver has a task of its own: one that is slow or gone hinders nobody else.

mod batch;
mod body;
mod counts;
mod desk;
mod mirror;
mod mqtt;
mod outbox;
mod queue;
mod receivers;
mod selection;
mod signature;
mod webhook;

use std::sync::Arc;

use crate::live::{Alert, Change, Messenger, Trouble, now};
use desk::Desk;

pub use counts::{Counts, Loss};
pub use receivers::Receivers;

pub use crate::net::peers::{Deliveries, Unusable};

/// Takes the changes of alerts for all receivers; cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Notices(Arc<[Arc<Desk>]>);

impl Notices {
    /// What has become of the notices so far, with the name of each receiver.
    pub fn counts(&self) -> impl Iterator<Item = (&str, Counts)> {
        self.0.iter().map(|desk| (desk.name(), desk.counts()))
    }
}

impl Messenger for Notices {
    fn note(&mut self, change: Change, alert: &Alert) {
        if self.0.is_empty() {
            return;
        }
        let (alert, at) = (Arc::new(alert.clone()), now());
        self.0.iter().for_each(|desk| desk.note(change, &alert, at));
    }

    fn troubles(&self) -> Vec<Trouble> {
        let now = now();
        self.0.iter().filter_map(|desk| desk.trouble(now)).collect()
    }
}
