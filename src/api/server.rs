//! The socket: connections are counted, and those that say nothing are closed.

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::Extension;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::Semaphore;
use tracing::{debug, warn};

use super::ApiState;
use super::guard::router;

/// Octets sent and not acknowledged for so long, or a reader that takes none, end the connection.
const STUCK: Duration = Duration::from_secs(60);
/// After a failed `accept`: usually there are no file descriptors left, and some will come back.
const ACCEPT_AGAIN: Duration = Duration::from_millis(50);
/// Open connections are waited for so long when the service closes.
const FAREWELL: Duration = Duration::from_secs(2);

/// Connections that may wait to be accepted: after a restart all readers come back at once.
const BACKLOG: u32 = 4096;

/// Who is at the other end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peer(pub(super) IpAddr);

/// Listens for connections.
///
/// # Errors
/// The address is taken, or is not one of this machine.
pub fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // A restart does not wait for the connections of before.
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

/// Serves the API until [`ApiState::close`]; then open connections are brought to their end.
pub async fn serve(listener: TcpListener, state: ApiState) {
    let most = state.options().connections;
    let places = Arc::new(Semaphore::new(most));
    let app = router(state.clone());
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = state.closed() => break,
        };
        match accepted {
            Ok((stream, address)) => {
                // Beyond the cap there is no answer: one would cost what the cap saves.
                let Ok(place) = places.clone().try_acquire_owned() else { continue };
                let app = app.clone().layer(Extension(Peer(address.ip().to_canonical())));
                let state = state.clone();
                tokio::spawn(async move {
                    if let Err(error) = connection(stream, app, &state).await {
                        debug!("{address}: {error}");
                    }
                    drop(place);
                });
            }
            Err(error) => {
                warn!("a connection could not be accepted: {error}");
                tokio::time::sleep(ACCEPT_AGAIN).await;
            }
        }
    }
    drop(listener);
    let all = u32::try_from(most).unwrap_or(u32::MAX);
    // Who has not gone by then is cut off with the process.
    let _ = tokio::time::timeout(FAREWELL, places.acquire_many(all)).await;
}

async fn connection(stream: TcpStream, app: axum::Router, state: &ApiState) -> io::Result<()> {
    stream.set_nodelay(true)?;
    #[cfg(target_os = "linux")]
    socket2::SockRef::from(&stream).set_tcp_user_timeout(Some(STUCK))?;
    let service = TowerToHyperService::new(app);
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(state.options().header_timeout)
        .max_buf_size(64 * 1024)
        .serve_connection(TokioIo::new(stream), service);
    tokio::pin!(connection);
    let ended = tokio::select! {
        ended = &mut connection => ended,
        () = state.closed() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    ended.map_err(io::Error::other)
}
