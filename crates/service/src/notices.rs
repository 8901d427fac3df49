//! Delivery of alerts to webhooks and to a broker of MQTT 5, for people who are not at the map.
//!
//! ```text
//! observer ──► Notices ──► Outbox (bounded, per receiver) ──► webhook's task ──► HTTP
//!              never waits                                └─► broker's task  ──► MQTT 5
//! ```
//!
//! `Outbox` decides what is sent, what is dropped and how long to wait; it uses neither clock nor socket. Each receiver has its
//! own task, so a slow or unreachable one does not affect the others.

mod batch;
mod body;
mod counts;
mod delivery;
mod mirror;
mod mqtt;
mod outbox;
mod queue;
mod receivers;
mod selection;
mod signature;
mod webhook;

use std::sync::Arc;

use crate::live::{Alert, AlertChange, Messenger, ServiceFault, now};
use delivery::NoticeQueue;

pub use counts::{NoticeCounts, NoticeLoss};
pub use receivers::NoticeReceivers;

pub use crate::net::peers::{Deliveries, UnusableReceiver};

/// Queues changes of alerts for all receivers; cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Notices(Arc<[Arc<NoticeQueue>]>);

impl Notices {
    /// Counts so far, with the name of each receiver.
    pub fn counts(&self) -> impl Iterator<Item = (&str, NoticeCounts)> {
        self.0.iter().map(|queue| (queue.name(), queue.counts()))
    }
}

impl Messenger for Notices {
    fn note(&mut self, change: AlertChange, alert: &Alert) {
        if self.0.is_empty() {
            return;
        }
        let (alert, at) = (Arc::new(alert.clone()), now());
        self.0.iter().for_each(|queue| queue.note(change, &alert, at));
    }

    fn troubles(&self) -> Vec<ServiceFault> {
        let now = now();
        self.0.iter().filter_map(|queue| queue.trouble(now)).collect()
    }
}
