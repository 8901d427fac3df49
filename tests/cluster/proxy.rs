//! A proxy to a server that can stall, which clients experience as a network failure: connections stay open without data.

use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::{JoinHandle, JoinSet};

/// Maximum number of octets held in each direction of a connection. Further ones wait at the sender.
const MAX_HELD_OCTETS: usize = 64 * 1024;
/// Maximum number of concurrent connections; further ones wait.
const MAX_CONNECTIONS: usize = 64;

/// Accepts connections on a loopback port and forwards them in both directions unless stalled.
pub struct Proxy {
    address: SocketAddr,
    open: watch::Sender<bool>,
    task: JoinHandle<()>,
}

impl Proxy {
    /// Starts a proxy to that address.
    pub async fn start(server: SocketAddr) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
        let address = listener.local_addr().unwrap();
        let (open, is_open) = watch::channel(true);
        let task = tokio::spawn(accept(listener, server, is_open));
        Self { address, open, task }
    }

    /// URL for clients.
    pub fn url(&self) -> String {
        format!("nats://{}", self.address)
    }

    /// Stops forwarding in both directions. Connections stay open, and new ones are accepted without an answer.
    pub fn stall(&self) {
        self.open.send_replace(false);
    }

    /// Forwards the held octets, and continues.
    pub fn resume(&self) {
        self.open.send_replace(true);
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn accept(listener: TcpListener, server: SocketAddr, is_open: watch::Receiver<bool>) {
    // Dropped with this task, which ends all connections.
    let mut connections = JoinSet::new();
    loop {
        while connections.len() >= MAX_CONNECTIONS {
            connections.join_next().await;
        }
        match listener.accept().await {
            Ok((client, _)) => {
                connections.spawn(connection(client, server, is_open.clone()));
            }
            // No more descriptors, or the peer has gone: the listener continues.
            Err(_) => tokio::time::sleep(Duration::from_millis(10)).await,
        }
        while connections.try_join_next().is_some() {}
    }
}

async fn connection(mut client: TcpStream, server: SocketAddr, mut is_open: watch::Receiver<bool>) {
    if is_open.wait_for(|open| *open).await.is_err() {
        return;
    }
    let Ok(mut server) = TcpStream::connect(server).await else { return };
    let _ = (client.set_nodelay(true), server.set_nodelay(true));
    let (from_client, to_client) = client.split();
    let (from_server, to_server) = server.split();
    // If either side closes, the connection is closed: NATS does not use half-open ones.
    tokio::select! {
        () = pass(from_client, to_server, is_open.clone()) => {}
        () = pass(from_server, to_client, is_open.clone()) => {}
    }
}

async fn pass(
    mut from: impl AsyncRead + Unpin,
    mut to: impl AsyncWrite + Unpin,
    mut is_open: watch::Receiver<bool>,
) {
    let mut held = vec![0; MAX_HELD_OCTETS];
    loop {
        let Ok(read @ 1..) = from.read(&mut held).await else { return };
        // Check after the read, so that data that arrives during a stall does not pass.
        if is_open.wait_for(|open| *open).await.is_err() || to.write_all(&held[..read]).await.is_err() {
            return;
        }
    }
}
