//! A hub with its readers: the API, and the observer that raises alerts.

use std::time::Duration;

use tokio::net::TcpListener;
use tokio::task::JoinHandle;

use super::Failure;
use crate::api::{self, ApiState};
use crate::live::{Alerts, Followers, Hub, observe};

/// The last slots are on their way to the archive for at most this long.
const SETTLE: Duration = Duration::from_secs(2);

/// A hub that is served.
#[derive(Debug)]
pub struct Served {
    /// What the readers see.
    pub hub: Hub,
    /// Who answers requests.
    pub api: ApiState,
    /// The root of the API and the map.
    pub url: String,
    http: JoinHandle<()>,
    observer: JoinHandle<()>,
}

impl Served {
    /// Begins to serve; within a runtime.
    ///
    /// # Errors
    /// What the configuration of the API names cannot be used.
    pub fn start(
        listener: TcpListener,
        hub: Hub,
        options: api::Options,
        alerts: Alerts,
        followers: Followers,
    ) -> Result<Self, Failure> {
        let url = format!("{}://{}/", hub.config.http.scheme(), listener.local_addr()?);
        let api = ApiState::start(hub.clone(), options)?;
        let observer = tokio::spawn(observe(hub.clone(), alerts, followers));
        let http = tokio::spawn(api::serve(listener, api.clone()));
        Ok(Self { hub, api, url, http, observer })
    }

    /// Waits until the observer has seen the last slot of a service that has ended.
    pub async fn settle(&mut self) {
        drop(tokio::time::timeout(SETTLE, &mut self.observer).await);
    }

    /// Ends the streams when they have shown what was published.
    ///
    /// # Errors
    /// The server's task panicked.
    pub async fn close(self) -> Result<(), Failure> {
        self.api.close();
        Ok(self.http.await?)
    }
}
