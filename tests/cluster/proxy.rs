//! A way to a server that can stall: what a client sees of a network that is cut, without an end of its connections.

use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::{JoinHandle, JoinSet};

/// Octets that it holds at most in each direction of a connection; what is beyond them waits at the sender.
const HELD: usize = 64 * 1024;
/// Connections at once; further ones wait.
const CONNECTIONS: usize = 64;

/// Takes connections on a port of loopback and passes them on, both ways, unless stalled.
pub struct Proxy {
    address: SocketAddr,
    open: watch::Sender<bool>,
    task: JoinHandle<()>,
}

impl Proxy {
    /// In front of that address.
    pub async fn start(server: SocketAddr) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
        let address = listener.local_addr().unwrap();
        let (open, is_open) = watch::channel(true);
        let task = tokio::spawn(accept(listener, server, is_open));
        Self { address, open, task }
    }

    /// Where clients connect.
    pub fn url(&self) -> String {
        format!("nats://{}", self.address)
    }

    /// Nothing passes from now on, in either direction; connections stay, and new ones are taken and hear nothing.
    pub fn stall(&self) {
        self.open.send_replace(false);
    }

    /// What was held passes, and all else again.
    pub fn go_on(&self) {
        self.open.send_replace(true);
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn accept(listener: TcpListener, server: SocketAddr, is_open: watch::Receiver<bool>) {
    // Dropped with this task, it ends all connections.
    let mut connections = JoinSet::new();
    loop {
        while connections.len() >= CONNECTIONS {
            connections.join_next().await;
        }
        match listener.accept().await {
            Ok((client, _)) => {
                connections.spawn(connection(client, server, is_open.clone()));
            }
            // No more descriptors, or the peer has gone: neither is this listener's end.
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
    // Either side's end is the connection's: NATS knows no half of one.
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
    let mut held = vec![0; HELD];
    loop {
        let Ok(read @ 1..) = from.read(&mut held).await else { return };
        // Checked after the read: what arrives while it is stalled does not pass.
        if is_open.wait_for(|open| *open).await.is_err() || to.write_all(&held[..read]).await.is_err() {
            return;
        }
    }
}
