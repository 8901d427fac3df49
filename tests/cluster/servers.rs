//! A cluster of `nats-server` processes on loopback. They can be killed, suspended and restarted by index, and end with the test.

use std::io::{BufRead, BufReader, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use std::{fs, iter, thread};

use async_nats::jetstream::stream::{Config, StorageType};
use async_nats::{Client, ConnectOptions, jetstream};
use futures_util::TryStreamExt;

/// Timeout for the servers' answers.
const PATIENCE: Duration = Duration::from_secs(30);
/// Range in which free ports are searched, below the usual ephemeral ports.
const PORTS: std::ops::Range<u16> = 26_000..32_000;

/// The server to test with: from the environment variable, from the path, or from Debian's directory. `None`, with a message, if
/// it is not installed.
pub fn binary() -> Option<PathBuf> {
    let named = std::env::var_os("UTM_FUSION_NATS_SERVER").map(PathBuf::from);
    if let Some(named) = named {
        assert!(version(&named).is_some(), "UTM_FUSION_NATS_SERVER={} does not run", named.display());
        return Some(named);
    }
    let found = ["nats-server", "/usr/sbin/nats-server"]
        .map(PathBuf::from)
        .into_iter()
        .find(|path| version(path).is_some());
    if found.is_none() {
        println!("skipped: no nats-server");
    }
    found
}

/// Major and minor version of a server, from a text such as "nats-server: v2.9.10".
pub fn version(binary: &Path) -> Option<(u32, u32)> {
    let said = Command::new(binary).arg("--version").stderr(Stdio::null()).output().ok()?;
    let said = String::from_utf8(said.stdout).ok()?;
    let mut parts = said.trim().rsplit_once('v')?.1.split('.');
    Some((parts.next()?.parse().ok()?, parts.next()?.parse().ok()?))
}

/// Processor time of a process so far, in user and system mode, in seconds.
pub fn cpu_seconds(process: u32) -> Option<f64> {
    let line = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The process name may contain anything. After its bracket follow the fields from the third on. A tick is 10 ms on Linux.
    let mut fields = line.rsplit_once(')')?.1.split_whitespace().skip(11);
    let (user, system): (f64, f64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some((user + system) / 100.0)
}

/// Data with which a server is restarted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Store {
    /// Its directory as it left it.
    Kept,
    /// An empty directory, as on a new machine.
    Empty,
}

/// A server, and a shell that kills it if the test itself is killed.
struct Process {
    server: Child,
    guard: Child,
}

impl Drop for Process {
    fn drop(&mut self) {
        // End the guard first: later another process may have the server's process id.
        let _ = self.guard.kill();
        let _ = self.guard.wait();
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

struct Server {
    /// Unique on this machine.
    name: String,
    /// Ports for clients and for other servers.
    ports: [u16; 2],
    process: Option<Process>,
}

/// Configuration and certificates of locked servers.
#[derive(Clone)]
pub struct Lock {
    /// Configuration file with TLS and permissions.
    pub configuration: PathBuf,
    /// Directory of the servers' certificates.
    pub certificates: PathBuf,
}

/// One server, or a cluster of several, each with JetStream and its own directory.
pub struct Servers {
    binary: PathBuf,
    version: (u32, u32),
    directory: PathBuf,
    servers: Vec<Server>,
    lock: Option<Lock>,
}

impl Servers {
    /// Starts `count` servers with their files in the directory, and waits until they store streams.
    pub async fn start(binary: &Path, directory: &Path, count: usize) -> Self {
        let mut started = Self::new(binary, directory, count, None);
        started.start_all(Store::Empty).await;
        started
    }

    /// Starts locked servers, and waits until they accept connections. A client without a role cannot query their streams.
    pub fn start_locked(binary: &Path, directory: &Path, count: usize, lock: Lock) -> Self {
        let mut started = Self::new(binary, directory, count, Some(lock));
        (0..count).for_each(|index| started.spawn(index, Store::Empty));
        (0..count).for_each(|index| started.answers(index));
        started
    }

    fn new(binary: &Path, directory: &Path, count: usize, lock: Option<Lock>) -> Self {
        let version = version(binary).expect("it said its version before");
        let ports = free_ports(2 * count);
        let cluster = random();
        let servers = ports
            .chunks_exact(2)
            .enumerate()
            .map(|(index, ports)| Server {
                name: format!("s{index}-{cluster:08x}"),
                ports: [ports[0], ports[1]],
                process: None,
            })
            .collect();
        Self { binary: binary.to_owned(), version, directory: directory.to_owned(), servers, lock }
    }

    /// Major and minor version.
    pub fn version(&self) -> (u32, u32) {
        self.version
    }

    /// Number of servers, running or not.
    pub fn count(&self) -> usize {
        self.servers.len()
    }

    /// URLs for clients.
    pub fn urls(&self) -> Vec<String> {
        (0..self.count()).map(|index| self.url(index)).collect()
    }

    /// URL of a server for clients.
    pub fn url(&self, index: usize) -> String {
        format!("nats://{}", self.address(index))
    }

    /// Address of a server for clients.
    pub fn address(&self, index: usize) -> SocketAddr {
        (Ipv4Addr::LOCALHOST, self.servers[index].ports[0]).into()
    }

    /// Process ids of the running servers.
    pub fn processes(&self) -> Vec<u32> {
        self.servers.iter().filter_map(|server| Some(server.process.as_ref()?.server.id())).collect()
    }

    /// Index of a server by its name, as streams state their leader.
    pub fn index_of(&self, name: &str) -> usize {
        self.servers.iter().position(|server| server.name == name).expect("a server of this cluster")
    }

    /// A client that has the addresses of all servers, and retries soon and without end.
    pub async fn client(&self) -> Client {
        options().connect(self.urls()).await.unwrap()
    }

    /// Index of the server that leads the stream; `None` if it has no leader.
    pub async fn leader(&self, streams: &jetstream::Context, stream: &str) -> Option<usize> {
        let info = streams.get_stream(stream).await.ok()?.cached_info().clone();
        match info.cluster {
            Some(cluster) => cluster.leader.map(|name| self.index_of(&name)),
            None => Some(0),
        }
    }

    /// Kills a server like `kill -9`.
    pub fn kill(&mut self, index: usize) {
        assert!(self.servers[index].process.take().is_some(), "server {index} does not run");
    }

    /// Shuts a server down in order: it hands over its leadership first.
    pub fn end(&mut self, index: usize) {
        signal("-TERM", self.process(index));
        let mut process = self.servers[index].process.take().expect("the server runs");
        let began = Instant::now();
        while process.server.try_wait().unwrap().is_none() {
            assert!(began.elapsed() < PATIENCE, "it does not end\n{}", self.log(index));
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Kills all servers at once.
    pub fn kill_all(&mut self) {
        // Send all signals before the first wait, so that no two servers elect a leader.
        for process in self.processes() {
            signal("-KILL", process);
        }
        for server in &mut self.servers {
            server.process = None;
        }
    }

    /// Suspends a server like a machine without processor time: connections stay open without answers.
    ///
    /// On a busy machine the server may still answer for a moment after the signal.
    pub fn halt(&self, index: usize) {
        let process = self.process(index);
        signal("-STOP", process);
        let began = Instant::now();
        while state(process).is_some_and(|state| state != 'T') {
            assert!(began.elapsed() < PATIENCE, "{process} does not halt");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Continues a suspended server.
    pub fn resume(&self, index: usize) {
        signal("-CONT", self.process(index));
    }

    /// Starts a server that has ended. It may need time to catch up: see [`Self::ready`].
    pub fn restart(&mut self, index: usize, store: Store) {
        self.spawn(index, store);
        self.answers(index);
    }

    /// Starts all servers that have ended, and waits until they store streams.
    pub async fn start_all(&mut self, store: Store) {
        let ended: Vec<usize> =
            (0..self.count()).filter(|&index| self.servers[index].process.is_none()).collect();
        for &index in &ended {
            self.spawn(index, store);
        }
        for &index in &ended {
            self.answers(index);
        }
        self.ready().await;
    }

    /// Waits until a stream can be created on all servers, and existing streams have a leader and current followers.
    pub async fn ready(&self) {
        let (began, streams) = (Instant::now(), jetstream::new(self.client().await));
        for attempt in 0.. {
            let tried = tokio::time::timeout(Duration::from_secs(3), self.is_ready(&streams, attempt)).await;
            if let Ok(Ok(())) = tried {
                return;
            }
            assert!(began.elapsed() < PATIENCE, "not ready within {PATIENCE:?}: {tried:?}\n{}", self.log(0));
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    }

    /// Uses a new stream for each attempt, because the result of a failed one is unknown.
    async fn is_ready(&self, streams: &jetstream::Context, attempt: u32) -> Result<(), async_nats::Error> {
        let (name, subject) = (format!("PROBE_{attempt}"), format!("probe.{attempt}"));
        let probe = Config {
            name: name.clone(),
            subjects: vec![subject.clone()],
            storage: StorageType::Memory,
            num_replicas: self.count(),
            ..Config::default()
        };
        streams.create_stream(probe).await?;
        let stored = async { streams.publish(subject, "probe".into()).await?.await }.await;
        streams.delete_stream(name).await?;
        stored?;
        let mut all = streams.streams();
        while let Some(info) = all.try_next().await? {
            let Some(cluster) = info.cluster else { continue };
            if cluster.leader.is_none() || cluster.replicas.iter().any(|peer| !peer.current || peer.offline) {
                return Err(format!("{}: {cluster:?}", info.config.name).into());
            }
        }
        Ok(())
    }

    /// Log of a server since its first start.
    pub fn log(&self, index: usize) -> String {
        fs::read_to_string(self.file(index, "log")).unwrap_or_default()
    }

    fn process(&self, index: usize) -> u32 {
        self.servers[index].process.as_ref().expect("the server runs").server.id()
    }

    fn file(&self, index: usize, end: &str) -> PathBuf {
        self.directory.join(format!("{}.{end}", self.servers[index].name))
    }

    /// Waits until the server accepts clients, and checks that no other process answers there.
    fn answers(&mut self, index: usize) {
        let (began, address) = (Instant::now(), self.address(index));
        loop {
            let name = named(address);
            let process = self.servers[index].process.as_mut().expect("the server was started");
            let ended = process.server.try_wait().unwrap();
            if name.as_ref() == Some(&self.servers[index].name) {
                return;
            }
            assert!(
                name.is_none() && ended.is_none() && began.elapsed() < PATIENCE,
                "{address}: {name:?} answers, {ended:?}\n{}",
                self.log(index)
            );
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn configuration(&self, index: usize) -> String {
        let Server { name, ports: [clients, own], .. } = &self.servers[index];
        // Acknowledged messages have to be on disk. Servers before 2.10 end on this unknown key.
        let sync = if self.version >= (2, 10) { "sync_interval: always" } else { "" };
        let store = self.file(index, "store");
        let mut text = format!(
            "server_name: {name}\nlisten: \"127.0.0.1:{clients}\"\n\
             jetstream {{ store_dir: {store:?}, max_memory_store: 2GB, max_file_store: 2GB\n{sync} }}\n"
        );
        if self.count() > 1 {
            let others: Vec<String> = self
                .servers
                .iter()
                .map(|server| format!("\"nats-route://127.0.0.1:{}\"", server.ports[1]))
                .collect();
            // Not advertised, so that a client behind a stalled proxy does not connect directly.
            text += &format!(
                "cluster {{ name: test, listen: \"127.0.0.1:{own}\", no_advertise: true, routes: [{}] }}\n",
                others.join(", ")
            );
        }
        text
    }

    /// Arguments of a locked server in addition to the common configuration.
    fn arguments(&self, index: usize) -> Vec<String> {
        let Server { name, ports: [clients, own], .. } = &self.servers[index];
        let store = self.file(index, "store").display().to_string();
        let mut arguments: Vec<String> =
            ["-n", name, "-a", "127.0.0.1", "-p", &clients.to_string(), "-sd", &store]
                .map(str::to_owned)
                .into();
        if self.count() > 1 {
            let route = |server: &Server| format!("nats://127.0.0.1:{}", server.ports[1]);
            let routes: Vec<String> = self.servers.iter().map(route).collect();
            let own = format!("nats://127.0.0.1:{own}");
            arguments.extend(["--cluster", &own, "--routes", &routes.join(",")].map(str::to_owned));
        }
        arguments
    }

    fn spawn(&mut self, index: usize, store: Store) {
        assert!(self.servers[index].process.is_none(), "server {index} runs");
        if store == Store::Empty {
            let _ = fs::remove_dir_all(self.file(index, "store"));
        }
        let mut command = Command::new(&self.binary);
        match &self.lock {
            None => {
                let configuration = self.file(index, "conf");
                fs::write(&configuration, self.configuration(index)).unwrap();
                command.arg("--config").arg(configuration);
            }
            Some(lock) => {
                command.arg("--config").arg(&lock.configuration).args(self.arguments(index));
                command.current_dir(&lock.certificates);
            }
        }
        let log = fs::File::options().create(true).append(true).open(self.file(index, "log")).unwrap();
        // Its read ends when this process ends for any reason. It is started first: no server runs without it.
        let mut guard = Command::new("sh")
            .args(["-c", "read -r server; read -r _; kill -9 \"$server\""])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let server =
            command.stdin(Stdio::null()).stdout(log.try_clone().unwrap()).stderr(log).spawn().unwrap();
        let line = format!("{}\n", server.id());
        let written = guard.stdin.as_mut().expect("it is piped").write_all(line.as_bytes());
        self.servers[index].process = Some(Process { server, guard });
        written.unwrap();
    }
}

/// Options of a client that has to notice the end of a server soon, and retries without end. Requests have more time, because a
/// stream's first leader may be elected meanwhile; tests that need less set it (`Context::set_timeout`).
pub fn options() -> ConnectOptions {
    ConnectOptions::new()
        .retry_on_initial_connect()
        .connection_timeout(Duration::from_secs(1))
        .ping_interval(Duration::from_secs(1))
        .request_timeout(Some(Duration::from_secs(5)))
        .reconnect_delay_callback(|attempts| Duration::from_millis(if attempts <= 1 { 0 } else { 100 }))
}

/// State of a process, as the letter of proc(5); `None` if it does not exist.
fn state(process: u32) -> Option<char> {
    let line = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    line.rsplit_once(") ")?.1.chars().next()
}

fn signal(signal: &str, process: u32) {
    let sent = Command::new("kill").args([signal, &process.to_string()]).status().unwrap();
    assert!(sent.success(), "kill {signal} {process}");
}

/// Name of the server that accepts clients at this address: the first line that it sends.
fn named(address: SocketAddr) -> Option<String> {
    let stream = TcpStream::connect(address).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(1))).unwrap();
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).ok()?;
    let info: serde_json::Value = serde_json::from_str(line.strip_prefix("INFO ")?).ok()?;
    Some(info["server_name"].as_str()?.to_owned())
}

fn random() -> u32 {
    getrandom::u32().unwrap()
}

/// Free ports. A process returns none twice, so that a killed server keeps its own.
fn free_ports(count: usize) -> Vec<u16> {
    static NEXT: LazyLock<AtomicU32> = LazyLock::new(|| (random() / 2).into());
    let all = PORTS.end - PORTS.start;
    let found: Vec<u16> =
        iter::repeat_with(|| PORTS.start + (NEXT.fetch_add(1, Ordering::Relaxed) % u32::from(all)) as u16)
            .take(all.into())
            .filter(|&port| TcpListener::bind((Ipv4Addr::LOCALHOST, port)).is_ok())
            .take(count)
            .collect();
    assert_eq!(found.len(), count, "no free ports");
    found
}
