//! Reader of the hub: passes each second's picture to the sinks.

use std::sync::Arc;

use tokio::sync::broadcast::error::{RecvError, TryRecvError};
use tokio::sync::watch;
use tracing::warn;

use super::delivery::SinkQueue;
use super::second::PictureSecond;
use crate::live::{Hub, PublishedPicture};
use crate::net::peers::{Closing, closed};
use site::config::PictureKind;

/// Follows the hub until the service ends and its last slot is passed on; then `seen` becomes `true`.
pub(super) async fn follow(
    hub: Hub,
    queues: Arc<[Arc<SinkQueue>]>,
    mut closing: Closing,
    seen: watch::Sender<bool>,
) {
    let mut frames = hub.pictures();
    loop {
        tokio::select! {
            frame = frames.recv() => match frame {
                Ok(frame) => hand_on(&frame, &hub, &queues),
                Err(RecvError::Lagged(slots)) => miss(slots, &hub, &queues),
                Err(RecvError::Closed) => break,
            },
            () = closed(&mut closing) => break,
        }
    }
    loop {
        match frames.try_recv() {
            Ok(frame) => hand_on(&frame, &hub, &queues),
            Err(TryRecvError::Lagged(slots)) => miss(slots, &hub, &queues),
            Err(TryRecvError::Empty | TryRecvError::Closed) => break,
        }
    }
    seen.send_replace(true);
}

fn hand_on(frame: &Arc<PublishedPicture>, hub: &Hub, queues: &[Arc<SinkQueue>]) {
    for kind in [PictureKind::Lagged, PictureKind::Now] {
        let mut those = queues.iter().filter(|queue| queue.picture == kind).peekable();
        if those.peek().is_some()
            && let Some(second) = PictureSecond::of(frame, kind, hub).map(Arc::new)
        {
            those.for_each(|queue| queue.note(second.clone()));
        }
    }
}

fn miss(slots: u64, hub: &Hub, queues: &[Arc<SinkQueue>]) {
    warn!(slots, "sinks miss slots, which were published faster than read");
    let seconds = usize::try_from(hub.maker.seconds(slots)).unwrap_or(usize::MAX);
    queues.iter().for_each(|queue| queue.missed(seconds));
}
