//! The socket: connections are counted, and those that say nothing are closed.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use socket2::SockRef;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tracing::{debug, info, warn};

use super::client::{Peer, is_trusted};
use super::door::{Place, Refused};
use super::guard::router;
use super::metrics::open_files;
use super::state::ApiState;
use super::tls::Tls;

/// Files that the service opens besides its connections: lines, outputs, recordings, history.
const OTHER_FILES: usize = 256;
/// After a failed `accept`: usually there are no file descriptors left, and some will come back.
const ACCEPT_AGAIN: Duration = Duration::from_millis(50);
/// How long open connections are waited for when the service closes.
const FAREWELL: Duration = Duration::from_secs(2);

/// Connections that may wait to be accepted: after a restart all readers come back at once.
const BACKLOG: u32 = 4096;

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
    let mut told = false;
    let app = router(state.clone());
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = state.closed() => break,
        };
        match accepted {
            Ok((stream, address)) => {
                told = false;
                let (terms, peer) = (state.terms(), address.ip().to_canonical());
                // A proxy's connections are those of all its clients.
                let cap = terms.connections.filter(|_| !is_trusted(peer, &terms.trusted_proxies));
                // A refused connection gets no answer: one would cost what the cap saves.
                let Ok(place) = state.door.enter(peer, cap) else { continue };
                let (app, state, tls) = (app.clone(), state.clone(), terms.tls.clone());
                tokio::spawn(async move {
                    let from = From { peer: Peer(peer), place: Arc::new(place) };
                    if let Err(error) = attend(stream, tls, app, from, &state).await {
                        debug!("{address}: {error}");
                    }
                });
            }
            Err(error) => {
                if !std::mem::replace(&mut told, true) {
                    warn!("a connection could not be accepted: {error}");
                }
                tokio::time::sleep(ACCEPT_AGAIN).await;
            }
        }
    }
    drop(listener);
    // Connections that are still open by then end with the process.
    let _ = tokio::time::timeout(FAREWELL, state.door.emptied()).await;
}

/// The number of connections that leaves room for the files of the service itself.
pub(super) fn affordable(connections: usize) -> usize {
    let limits =
        String::from_utf8(std::fs::read("/proc/self/limits").unwrap_or_default()).unwrap_or_default();
    let Some(files) = open_files(&limits).filter(|&files| files < connections + OTHER_FILES) else {
        return connections;
    };
    let fewer = files.saturating_sub(OTHER_FILES).max(1);
    info!(
        "{files} files may be open: at most {fewer} HTTP connections instead of {connections}; LimitNOFILE= of systemd, \
         or ulimit -n, raises it"
    );
    fewer
}

/// Where a connection comes from, and the place that it takes.
struct From {
    peer: Peer,
    place: Arc<Place>,
}

/// A connection from its first octet to its last. With TLS that begins with a handshake, for which there is as much time
/// as for a request's headers.
async fn attend(
    stream: TcpStream,
    tls: Option<Tls>,
    app: axum::Router,
    from: From,
    state: &ApiState,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    #[cfg(target_os = "linux")]
    SockRef::from(&stream).set_tcp_user_timeout(Some(state.options.stuck_timeout))?;
    let Some(tls) = tls else { return connection(stream, app, from, state).await };
    // In a box: what it takes is not taken by those without.
    Box::pin(async move {
        let handshake = tokio::time::timeout(state.options.header_timeout, tls.acceptor().accept(stream));
        let stream = handshake.await.unwrap_or_else(|late| Err(late.into()));
        let stream = stream.inspect_err(|_| state.door.refuse(Refused::Tls, from.peer.0))?;
        connection(stream, app, from, state).await
    })
    .await
}

async fn connection(
    stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    app: axum::Router,
    from: From,
    state: &ApiState,
) -> io::Result<()> {
    let app = TowerToHyperService::new(app);
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(from.peer);
        // Whoever changes the protocol has the place for as long as the connection lasts.
        request.extensions_mut().insert(from.place.clone());
        app.call(request)
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(state.options.header_timeout)
        .max_buf_size(64 * 1024)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
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
