//! The HTTP server: connections are counted, and idle ones are closed.

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

use super::client::{PeerAddress, is_trusted};
use super::connection_limit::{ConnectionRefusal, CountedConnection};
use super::guard::router;
use super::metrics::open_files;
use super::state::ApiState;
use super::tls::Tls;

/// Number of files that the service opens besides connections: inputs, outputs, recordings, history.
const OTHER_FILES: usize = 256;
/// Pause after a failed `accept`, usually because no file descriptors are left.
const ACCEPT_AGAIN: Duration = Duration::from_millis(50);
/// Maximum time to wait for open connections when the service closes.
const FAREWELL: Duration = Duration::from_secs(2);

/// Number of connections that may wait to be accepted: after a restart all clients reconnect at once.
const BACKLOG: u32 = 4096;

/// Listens for connections.
///
/// # Errors
/// The address is in use, or does not belong to this machine.
pub fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // A restart need not wait for connections of the previous process.
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

/// Serves the API until [`ApiState::close`], then waits for open connections.
pub async fn serve(listener: TcpListener, state: ApiState) {
    let mut logged = false;
    let app = router(state.clone());
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = state.closed() => break,
        };
        match accepted {
            Ok((stream, address)) => {
                logged = false;
                let (access, peer) = (state.access(), address.ip().to_canonical());
                // Connections of a proxy belong to all of its clients.
                let cap = access.connections.filter(|_| !is_trusted(peer, &access.trusted_proxies));
                // A refused connection gets no answer, which would cost what the limit saves.
                let Ok(connection) = state.connection_limit.admit(peer, cap) else { continue };
                let (app, state, tls) = (app.clone(), state.clone(), access.tls.clone());
                tokio::spawn(async move {
                    let peer = ConnectionPeer { peer: PeerAddress(peer), connection: Arc::new(connection) };
                    if let Err(error) = serve_connection(stream, tls, app, peer, &state).await {
                        debug!("{address}: {error}");
                    }
                });
            }
            Err(error) => {
                if !std::mem::replace(&mut logged, true) {
                    warn!("a connection could not be accepted: {error}");
                }
                tokio::time::sleep(ACCEPT_AGAIN).await;
            }
        }
    }
    drop(listener);
    // Connections still open then end with the process.
    let _ = tokio::time::timeout(FAREWELL, state.connection_limit.all_closed()).await;
}

/// Number of connections that leaves enough files for the service itself.
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

/// Peer of a connection, and its entry in the connection limit.
struct ConnectionPeer {
    peer: PeerAddress,
    connection: Arc<CountedConnection>,
}

/// Serves a connection from start to end. A TLS handshake has the same timeout as the headers of a request.
async fn serve_connection(
    stream: TcpStream,
    tls: Option<Tls>,
    app: axum::Router,
    peer: ConnectionPeer,
    state: &ApiState,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    #[cfg(target_os = "linux")]
    SockRef::from(&stream).set_tcp_user_timeout(Some(state.options.stuck_timeout))?;
    let Some(tls) = tls else { return connection(stream, app, peer, state).await };
    // Boxed, so that connections without TLS do not need its memory.
    Box::pin(async move {
        let handshake = tokio::time::timeout(state.options.header_timeout, tls.acceptor().accept(stream));
        let stream = handshake.await.unwrap_or_else(|late| Err(late.into()));
        let stream =
            stream.inspect_err(|_| state.connection_limit.refuse(ConnectionRefusal::Tls, peer.peer.0))?;
        connection(stream, app, peer, state).await
    })
    .await
}

async fn connection(
    stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    app: axum::Router,
    peer: ConnectionPeer,
    state: &ApiState,
) -> io::Result<()> {
    let app = TowerToHyperService::new(app);
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(peer.peer);
        // After a change of protocols the connection is counted until it ends.
        request.extensions_mut().insert(peer.connection.clone());
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
