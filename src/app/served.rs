//! A hub with its API and the observer that raises alerts.

use std::time::Duration;

use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio::task::JoinHandle;

use super::{AppError, readers_runtime};
use api::{self, ApiState};
use service::live::{AlertMonitor, Followers, Hub, observe};

/// Maximum time to wait for the last slots to reach the archive.
const SETTLE: Duration = Duration::from_secs(2);

/// Number of threads that read requests and write responses to sockets. Inputs, outputs and alerts have other threads, so the
/// number of clients and requests takes only a share of the processor from them.
const HTTP_THREADS: usize = 2;

/// Runtime of HTTP. Dropping it does not wait for its threads.
#[derive(Debug)]
struct HttpThreads(Option<Runtime>);

impl Drop for HttpThreads {
    fn drop(&mut self) {
        self.0.take().into_iter().for_each(Runtime::shutdown_background);
    }
}

/// A hub that is served over HTTP.
#[derive(Debug)]
pub struct Served {
    /// Source of pictures and events for the clients.
    pub hub: Hub,
    /// State of the API's request handlers.
    pub api: ApiState,
    /// Root URL of the API and the map.
    pub url: String,
    http: JoinHandle<()>,
    /// Threads that serve HTTP.
    _threads: HttpThreads,
    observer: JoinHandle<()>,
}

impl Served {
    /// Starts to serve. Needs a runtime.
    ///
    /// # Errors
    /// A file that the API needs cannot be used.
    pub fn start(
        listener: TcpListener,
        hub: Hub,
        options: api::Options,
        alerts: AlertMonitor,
        followers: Followers,
    ) -> Result<Self, AppError> {
        let url = format!("{}://{}/", hub.config.http.scheme(), listener.local_addr()?);
        let threads = HttpThreads(Some(readers_runtime("http", HTTP_THREADS)?));
        let observer = tokio::spawn(observe(hub.clone(), alerts, followers));
        let entered = threads.0.as_ref().map(Runtime::enter);
        let api = ApiState::start(hub.clone(), options)?;
        // Registers the listener with the runtime of HTTP.
        let listener = TcpListener::from_std(listener.into_std()?)?;
        let http = tokio::spawn(api::serve(listener, api.clone()));
        drop(entered);
        Ok(Self { hub, api, url, http, _threads: threads, observer })
    }

    /// Waits until the observer has seen the last slot of a service that has ended.
    pub async fn settle(&mut self) {
        drop(tokio::time::timeout(SETTLE, &mut self.observer).await);
    }

    /// Closes the streams after they have sent what was published.
    ///
    /// # Errors
    /// The server's task panicked.
    pub async fn close(self) -> Result<(), AppError> {
        self.api.close();
        Ok(self.http.await?)
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::{TcpStream, UdpSocket};
    use std::sync::mpsc::channel;

    use super::*;
    use fusion::time::Time;
    use input::normalise::Normaliser;
    use picture::PictureMaker;
    use service::live::AlertSettings;
    use site::areas::Masks;
    use site::config::Config;
    use std::sync::Arc;

    /// Datagrams are read and timers fire while every HTTP thread is busy.
    #[test]
    #[expect(clippy::disallowed_methods, reason = "sockets, as a sensor has them")]
    fn busy_http_threads_delay_no_input() {
        let runtime = super::super::runtime(1).unwrap();
        let site = include_str!("../../config/demo.toml");
        let config = Arc::new(Config::parse(site, "site.toml", std::iter::empty()).unwrap());
        let maker = PictureMaker::new(&config, &Normaliser::new(&config, Masks::default()));
        let (_writer, hub) = Hub::new(config, maker.into(), Time::default());
        let (served, received) = runtime.block_on(async {
            let alerts = AlertMonitor::new(AlertSettings::default(), Time::default());
            let listener = api::listen("127.0.0.1:0".parse().unwrap()).unwrap();
            let options = api::Options::default();
            let served = Served::start(listener, hub, options, alerts, Followers::default()).unwrap();
            let socket = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
            (served, socket)
        });
        let (busy, is_busy) = channel();
        let holds: Vec<_> = (0..HTTP_THREADS)
            .map(|_| {
                let (hold, held) = channel::<()>();
                let busy = busy.clone();
                served._threads.0.as_ref().unwrap().spawn(async move {
                    busy.send(()).unwrap();
                    let _ = held.recv();
                });
                hold
            })
            .collect();
        (0..HTTP_THREADS).for_each(|_| is_busy.recv().unwrap());
        let address = served.url.trim_start_matches("http://").trim_end_matches('/').to_owned();
        let mut probe = TcpStream::connect(&address).unwrap();
        write!(probe, "GET /healthz HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
        UdpSocket::bind("127.0.0.1:0").unwrap().send_to(b"plot", received.local_addr().unwrap()).unwrap();
        let read = runtime.block_on(async {
            let reading = tokio::spawn(async move {
                let mut octets = [0; 8];
                received.recv(&mut octets).await
            });
            tokio::time::timeout(Duration::from_secs(10), reading).await
        });
        assert_eq!(read.expect("a datagram is read").unwrap().unwrap(), 4);
        probe.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
        let mut answer = String::new();
        assert!(probe.read_to_string(&mut answer).is_err(), "HTTP is busy");
        drop(holds);
        probe.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        probe.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        runtime.block_on(served.close()).unwrap();
    }
}
