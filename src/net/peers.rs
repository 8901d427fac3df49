//! The tasks that deliver to others, and how they end.

use std::net::IpAddr;
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout_at};

/// What waits when the service ends is on its way for at most this long.
const LAST: Duration = Duration::from_millis(1_500);

/// Says that the service ends.
pub(crate) type Closing = watch::Receiver<bool>;

/// Waits until the service ends.
pub(crate) async fn closed(closing: &mut Closing) {
    // Where nobody can say so any more it has.
    let _ = closing.wait_for(|is_closing| *is_closing).await;
}

/// A receiver cannot be used as it is configured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {problem}")]
pub struct Unusable {
    key: String,
    problem: String,
}

impl Unusable {
    /// What is wrong with the receiver that `key` configures.
    pub(crate) fn new(key: String, problem: String) -> Self {
        Self { key, problem }
    }
}

/// The tasks that deliver.
#[derive(Debug)]
pub struct Deliveries {
    closing: watch::Sender<bool>,
    tasks: Vec<JoinHandle<()>>,
}

impl Deliveries {
    /// Of tasks that end when `closing` says so.
    pub(crate) fn new(closing: watch::Sender<bool>, tasks: Vec<JoinHandle<()>>) -> Self {
        Self { closing, tasks }
    }

    /// Delivers what waits, as far as that goes at once, and ends.
    pub async fn close(self) {
        self.closing.send_replace(true);
        let until = Instant::now() + LAST;
        for mut task in self.tasks {
            if timeout_at(until, &mut task).await.is_err() {
                task.abort();
            }
        }
    }
}

/// Whether that is this machine.
pub(crate) fn is_local(host: &str) -> bool {
    let address = host.trim_matches(['[', ']']).parse::<IpAddr>();
    host == "localhost" || address.is_ok_and(|address| address.to_canonical().is_loopback())
}
