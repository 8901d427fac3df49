//! Tasks that deliver data to other systems, and how they end.

use std::net::IpAddr;
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout_at};

/// Maximum time for delivering waiting data when the service ends.
const LAST: Duration = Duration::from_millis(1_500);

/// Signal that the service ends.
pub(crate) type Closing = watch::Receiver<bool>;

/// Waits until the service ends.
pub async fn closed(closing: &mut Closing) {
    // A dropped sender also means that the service has ended.
    let _ = closing.wait_for(|is_closing| *is_closing).await;
}

/// A receiver cannot be used as configured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {problem}")]
pub struct UnusableReceiver {
    key: String,
    problem: String,
}

impl UnusableReceiver {
    /// Error for the receiver that `key` configures.
    pub fn new(key: String, problem: String) -> Self {
        Self { key, problem }
    }
}

/// The delivery tasks.
#[derive(Debug)]
pub struct Deliveries {
    closing: watch::Sender<bool>,
    tasks: Vec<JoinHandle<()>>,
}

impl Deliveries {
    /// Tasks that end when `closing` becomes `true`.
    pub fn new(closing: watch::Sender<bool>, tasks: Vec<JoinHandle<()>>) -> Self {
        Self { closing, tasks }
    }

    /// Delivers the waiting data within a time limit, and ends.
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

/// Whether the host is this machine.
pub fn is_local(host: &str) -> bool {
    let address = host.trim_matches(['[', ']']).parse::<IpAddr>();
    host == "localhost" || address.is_ok_and(|address| address.to_canonical().is_loopback())
}
