//! A site with several processes: servers of the log, nodes, gateways and a picture. A simulated flight is sent to them by UDP.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use fusion::time::{SECOND, Time};
use jiff::SignedDuration;
use serde_json::Value;
use utm_fusion::cluster::{Cells, GatewayReport, Holder, Log, NodeReport, NodeRole};
use utm_fusion::config::{Address, Category, CellArea, Cluster, Config, Input, PictureKind, Role, Sink};
use utm_fusion::live::now;
use utm_fusion::net::send::socket;
use utm_fusion::simulate::{Scenario, simulate};
use utm_fusion::territory::CellName;

use crate::program::{Scratch, utm_fusion};
use crate::servers::Servers;
use crate::watcher::Watcher;

/// Timeout for any awaited state. Cells move one in 10 s, and more slowly on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(90);
/// Additional time allowed in all limits, in seconds: machines that run tests are slow and busy.
pub const SLACK_S: f64 = 4.0;
/// The default lease, in seconds.
pub const LEASE_S: f64 = 2.0;
/// Names of the members.
pub const NODES: [&str; 3] = ["n0", "n1", "n2"];
pub const GATEWAYS: [&str; 2] = ["g0", "g1"];
pub const PICTURE: &str = "p0";

/// Output of `chronyc -c tracking` for a clock with an error of at most 3 ms.
pub const GOOD_CLOCK: &str =
    "C0A80001,192.168.0.1,2,1795573492.6,0.0001,0.0001,0.0002,-12.1,0.0,0.1,0.0038,0.001,64.2,Normal\n";
/// Output of `chronyc -c tracking` for an unsynchronised clock.
pub const LOST_CLOCK: &str = "00000000,,0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,1.0,1.0,0.0,Not synchronised\n";

const SCENARIO: &str = "name = \"trial\"\nduration_s = 900\n[airspace]\nradius_m = 400\n\
    [drones]\npattern = \"crossing\"\nmultirotors = 4\nequipped = 3\n[birds]\ncount = 2\n";

/// Value of a test's environment variable, or the default.
pub fn variable(name: &str, otherwise: f64) -> f64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap())
}

/// Waits until `look` returns a value.
pub async fn until<T>(what: &str, mut look: impl AsyncFnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = look().await {
            return found;
        }
        assert!(began.elapsed() < PATIENCE, "not within {PATIENCE:?}: {what}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

/// A process of the site, killed on drop.
#[derive(Debug)]
struct Running {
    child: Child,
    log: PathBuf,
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Parameters of a site.
pub struct Setup {
    /// Number of servers of the log. Each has a copy of every stream.
    pub servers: usize,
    pub lease_s: f64,
    pub checkpoint_s: f64,
    /// Whether the site is divided into four cells that meet at the radar.
    pub is_divided: bool,
    /// Addresses of the log for each process, if not the servers themselves.
    pub through: Vec<(&'static str, String)>,
    /// Gateway whose clock can be shifted, and the library of libfaketime.
    pub shifted: Option<(&'static str, PathBuf)>,
    /// Whether enough aircraft fly to load a node.
    pub is_crowded: bool,
    /// Directory of the roles' certificates, if the servers are locked.
    pub certificates: Option<PathBuf>,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            servers: 1,
            lease_s: LEASE_S,
            checkpoint_s: 30.0,
            is_divided: false,
            through: Vec::new(),
            shifted: None,
            is_crowded: false,
            certificates: None,
        }
    }
}

/// Sends the flight to the gateways until dropped.
struct Feed {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Feed {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        drop(self.thread.take().map(JoinHandle::join));
    }
}

/// A site. Its processes end before its servers, and its directory is removed last.
pub struct Site {
    running: Vec<(&'static str, Running)>,
    feed: Option<Feed>,
    /// The log, as read by the test.
    pub log: Log,
    pub cluster: Cluster,
    pub config: Arc<Config>,
    pub servers: Servers,
    shifted: Option<(&'static str, PathBuf)>,
    certificates: Option<PathBuf>,
    scratch: Scratch,
}

impl Site {
    /// Starts all processes and a flight, and waits until a node owns the cell and another one stands by. `None` if nats-server
    /// is not installed.
    pub async fn start(setup: Setup) -> Option<Self> {
        let (servers, scratch) = crate::cluster(setup.servers).await?;
        Some(Self::over(servers, scratch, setup).await)
    }

    /// Starts the site with existing servers.
    pub async fn over(servers: Servers, scratch: Scratch, setup: Setup) -> Self {
        let start = Time::from_nanos((now().nanos() / SECOND + 2) * SECOND);
        // In a divided site the aircraft fly over the radar, where the cells meet.
        let corner = "east_m = 0\nnorth_m = 0\nradius_m = 400";
        let mut scenario = SCENARIO.to_owned();
        if setup.is_divided {
            scenario = scenario.replace("radius_m = 400", corner);
        }
        if setup.is_crowded {
            scenario = scenario.replace("radius_m = 400", "radius_m = 4500");
            scenario = scenario.replace("multirotors = 4\nequipped = 3", "multirotors = 120\nequipped = 60");
            scenario = scenario.replace("count = 2", "count = 150");
        }
        let simulation =
            simulate(&Scenario::parse(&scenario, "trial.toml").unwrap(), 1, Some(start)).unwrap();
        let cluster = Cluster {
            servers: servers.urls(),
            ca: None,
            certificate: None,
            key: None,
            credentials: None,
            nkey: None,
            inbox: None,
            node: "watcher".to_owned(),
            machine: None,
            region: "trial".to_owned(),
            roles: Role::ALL.to_vec(),
            grid_deg: None,
            cells: if setup.is_divided { quarters(&simulation.config) } else { Vec::new() },
            owns: vec!["*".to_owned()],
            gateways: Vec::new(),
            halo_m: 1000.0,
            // Small, so that aircraft on circles of 400 m often change their cells.
            hysteresis_m: 40.0,
            replicas: setup.servers as u32,
            lease_s: setup.lease_s,
            wait_s: 0.5,
            checkpoint_s: setup.checkpoint_s,
        };
        let mut config = on_own_ports(simulation.config.clone());
        config.cluster = Some(cluster.clone());
        // Only a node may create the streams.
        let log = Log::open(&proven(&cluster, setup.certificates.as_deref(), "node")).await.unwrap();
        let mut site = Self {
            running: Vec::new(),
            feed: None,
            log,
            cluster,
            config: Arc::new(config),
            servers,
            shifted: setup.shifted,
            certificates: setup.certificates,
            scratch,
        };
        site.scratch.script("chronyc", "#!/bin/sh\ncat \"$TRIAL_CLOCK\"\n");
        let roles = NODES.map(|name| (name, Role::Node)).into_iter();
        let roles = roles.chain(GATEWAYS.map(|name| (name, Role::Gateway))).chain([(PICTURE, Role::Picture)]);
        for (name, role) in roles {
            let through = setup.through.iter().find(|(of, _)| *of == name).map(|(_, url)| url.clone());
            site.configure(name, vec![role], through);
            site.clock(name, GOOD_CLOCK);
            site.shift(name, SignedDuration::ZERO);
            site.run(name);
        }
        let datagrams: Vec<(Time, Vec<u8>)> =
            simulation.datagrams.into_iter().map(|datagram| (datagram.received, datagram.payload)).collect();
        site.fly(datagrams, |_| SignedDuration::ZERO);
        site.pair().await;
        site
    }

    /// Starts a process that is gateway and node of a separate region on the same lines. Returns its log.
    pub async fn beside(&mut self, name: &'static str) -> Log {
        let cluster = Cluster { region: name.to_owned(), ..self.cluster.clone() };
        let before = std::mem::replace(&mut self.cluster, cluster);
        self.configure(name, vec![Role::Gateway, Role::Node], None);
        self.clock(name, GOOD_CLOCK);
        self.run(name);
        let log = Log::open(&self.cluster).await.unwrap();
        self.cluster = before;
        log
    }

    /// Starts another node with this configuration, which has to end by itself. Returns its exit code.
    pub async fn node_with(&mut self, name: &'static str, cluster: Cluster) -> Option<i32> {
        let before = std::mem::replace(&mut self.cluster, cluster);
        self.configure(name, vec![Role::Node], None);
        self.clock(name, GOOD_CLOCK);
        self.cluster = before;
        self.run(name);
        let began = Instant::now();
        loop {
            let process = &mut self.running.last_mut().expect("it was started").1.child;
            if let Some(status) = process.try_wait().unwrap() {
                self.running.pop();
                return status.code();
            }
            assert!(began.elapsed() < PATIENCE, "{name} goes on\n{}", self.log_text(name));
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }

    /// Sets the output of `chronyc -c tracking` for a process.
    pub fn clock(&self, name: &str, said: &str) {
        self.replaced(&format!("{name}.clock"), said);
    }

    /// Sets the error of a process's clock, within a second, if that clock can be shifted.
    pub fn shift(&self, name: &str, by: SignedDuration) {
        self.replaced(&format!("{name}.shift"), &format!("{:+.6}\n", by.as_secs_f64()));
    }

    /// Replaces a file atomically.
    fn replaced(&self, name: &str, contents: &str) {
        let new = self.scratch.file(&format!("{name}.new"), contents);
        fs::rename(new, self.scratch.path(name)).unwrap();
    }

    fn configure(&self, name: &str, roles: Vec<Role>, through: Option<String>) {
        let mut config = Config::clone(&self.config);
        let cluster = proven(&self.cluster, self.certificates.as_deref(), roles[0].name());
        let mut cluster = Cluster { node: name.to_owned(), roles, inbox: None, ..cluster };
        cluster.servers = through.map_or(cluster.servers, |url| vec![url]);
        config.cluster = Some(cluster);
        config.state.dir = self.scratch.path(format!("{name}.state"));
        self.scratch.file(&format!("{name}.toml"), config.to_string());
    }

    /// Configuration file of a process.
    pub fn file(&self, name: &str) -> PathBuf {
        self.scratch.path(format!("{name}.toml"))
    }

    /// Starts a process, which may have run before.
    pub fn run(&mut self, name: &'static str) {
        assert!(self.running.iter().all(|(of, _)| *of != name), "{name} runs");
        let log = self.scratch.path(format!("{name}.log"));
        let stderr = File::options().create(true).append(true).open(&log).unwrap();
        let mut command = utm_fusion("run");
        let path = std::env::var_os("PATH").unwrap_or_default();
        let own = std::iter::once(self.scratch.path("")).chain(std::env::split_paths(&path));
        command.env("PATH", std::env::join_paths(own).unwrap());
        command.env("TRIAL_CLOCK", self.scratch.path(format!("{name}.clock")));
        if let Some((_, library)) = self.shifted.as_ref().filter(|(of, _)| *of == name) {
            command.env("LD_PRELOAD", library).env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
            command.env("FAKETIME_TIMESTAMP_FILE", self.scratch.path(format!("{name}.shift")));
            command.env("FAKETIME_CACHE_DURATION", "1");
        }
        let child = command.arg("--config").arg(self.file(name)).stdout(Stdio::null()).stderr(stderr).spawn();
        self.running.push((name, Running { child: child.unwrap(), log }));
    }

    /// Sends the datagrams at their times, plus the delay of their category.
    fn fly(&mut self, datagrams: Vec<(Time, Vec<u8>)>, late: impl Fn(u8) -> SignedDuration) {
        let mut sent: Vec<_> =
            datagrams.into_iter().map(|(at, payload)| (at + late(payload[0]), payload)).collect();
        sent.sort_by_key(|(at, _)| *at);
        let to = self.config.sensors.iter().map(|sensor| match sensor.inputs[0].address {
            Address::Multicast { group, .. } => (group, sensor.inputs[0].port),
            Address::Unicast(address) => (address, sensor.inputs[0].port),
        });
        let to: Vec<_> = to.collect();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let thread = std::thread::spawn(move || {
            let socket = socket(Some(Ipv4Addr::LOCALHOST), 1).unwrap();
            for (at, payload) in sent {
                if let Ok(early) = Duration::try_from(at - now()) {
                    std::thread::sleep(early);
                }
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                socket.send_to(&payload, to[usize::from(payload[0] == 129)]).unwrap();
            }
        });
        self.feed = Some(Feed { stop, thread: Some(thread) });
    }

    /// Starts the flight again, with one sensor's datagrams delayed.
    pub fn fly_late(&mut self, category: u8, late: SignedDuration) {
        self.feed = None;
        let start = Time::from_nanos((now().nanos() / SECOND + 2) * SECOND);
        let simulation = simulate(&Scenario::parse(SCENARIO, "trial.toml").unwrap(), 1, Some(start)).unwrap();
        let datagrams =
            simulation.datagrams.into_iter().map(|datagram| (datagram.received, datagram.payload)).collect();
        self.fly(datagrams, |of| if of == category { late } else { SignedDuration::ZERO });
    }

    /// Kills a process like `kill -9`.
    pub fn kill(&mut self, name: &str) {
        let at = self.running.iter().position(|(of, _)| *of == name).expect("it runs");
        drop(self.running.remove(at));
    }

    /// Sends `-STOP` or `-CONT` to a process.
    pub fn signal(&self, name: &str, signal: &str) {
        let running = self.process(name);
        let sent = Command::new("kill").args([signal, &running.child.id().to_string()]).status().unwrap();
        assert!(sent.success(), "kill {signal} {name}");
    }

    /// Share of a core that a process uses during `meanwhile`.
    pub async fn share(&self, name: &str, lasts: Duration, meanwhile: impl AsyncFnOnce(Duration)) -> f64 {
        let (before, began) = (self.processor_s(name), Instant::now());
        meanwhile(lasts).await;
        (self.processor_s(name) - before) / began.elapsed().as_secs_f64()
    }

    /// Limits a process to a share of a core for the time `lasts`. It is suspended most of the time, and continues about every
    /// `turn_s` seconds until it has used its share.
    pub async fn starve(&self, name: &str, share: f64, lasts: Duration, turn_s: f64) {
        let (before, began) = (self.processor_s(name), Instant::now());
        // Processor time that it may still use, in seconds; negative if it was suspended too late.
        let left_s = || share * began.elapsed().as_secs_f64() - (self.processor_s(name) - before);
        while began.elapsed() < lasts {
            self.signal(name, "-STOP");
            let halted = Instant::now();
            // Limit the suspension, so that no lease expires because the last turn was too long.
            while left_s() < share * turn_s && halted.elapsed().as_secs_f64() < 2.0 * turn_s {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
            self.signal(name, "-CONT");
            // The process may need less than its share.
            while left_s() > 0.0 && began.elapsed() < lasts {
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
        }
    }

    /// Processor time used by a process, in steps of 10 ms.
    fn processor_s(&self, name: &str) -> f64 {
        let id = self.process(name).child.id();
        // Ticks in user and system mode, after the name in parentheses (proc_pid_stat(5)).
        let stat = fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
        let fields = stat.rsplit_once(')').unwrap().1.split_whitespace().skip(11).take(2);
        fields.map(|field| field.parse::<u64>().unwrap()).sum::<u64>() as f64 * 0.01
    }

    fn process(&self, name: &str) -> &Running {
        &self.running.iter().find(|(of, _)| *of == name).expect("it runs").1
    }

    /// Log of a process since its first start.
    pub fn log_text(&self, name: &str) -> String {
        fs::read_to_string(self.scratch.path(format!("{name}.log"))).unwrap_or_default()
    }

    /// Owner of the first cell.
    pub async fn owner(&self) -> Option<Holder> {
        self.owner_of(&Cells::of(&self.config).unwrap().names()[0]).await
    }

    /// Owner of a cell.
    pub async fn owner_of(&self, cell: &CellName) -> Option<Holder> {
        self.log.holder(&format!("{cell}.owner")).await.ok().flatten().map(|held| held.by)
    }

    /// Report of a node.
    pub async fn report(&self, node: &str) -> Option<NodeReport> {
        let said = self.log.entry(&format!("node.{node}")).await.ok().flatten()?;
        postcard::from_bytes(&said).ok()
    }

    /// Owner and standby of the first cell, once both have its state. Waits for those of all cells.
    pub async fn pair(&self) -> [&'static str; 2] {
        let mut first = None;
        for cell in Cells::of(&self.config).unwrap().names() {
            let pair = self.pair_of(cell).await;
            first = first.or(Some(pair));
        }
        first.unwrap()
    }

    /// Owner and standby of a cell, once both have its state.
    pub async fn pair_of(&self, cell: &CellName) -> [&'static str; 2] {
        let owner =
            async || self.log.holder(&format!("{cell}.owner")).await.ok().flatten().map(|held| held.by);
        until("an owner, and one who stands by", async || {
            let owner = owner().await?;
            let mut pair = [None; 2];
            for node in NODES {
                let Some(report) = self.report(node).await else { continue };
                let counts = report.counts(cell.as_str());
                match counts.part {
                    NodeRole::Owner if report.holder == owner && counts.published > 0 => pair[0] = Some(node),
                    NodeRole::Standby if counts.behind < 4 => pair[1] = Some(node),
                    _ => {}
                }
            }
            Some([pair[0]?, pair[1]?])
        })
        .await
    }

    /// Waits for another owner of the first cell.
    pub async fn owner_other_than(&self, before: &Holder) -> Holder {
        until("another owner", async || self.owner().await.filter(|owner| owner != before)).await
    }

    /// Watches the outputs of the first cell.
    pub async fn watch(&self) -> Watcher {
        self.watch_cell(&Cells::of(&self.config).unwrap().names()[0]).await
    }

    /// Watches the outputs of a cell.
    pub async fn watch_cell(&self, cell: &CellName) -> Watcher {
        Watcher::start(&self.log, &self.cluster, &self.config, cell).await
    }

    /// Report of a gateway.
    pub async fn gateway(&self, gateway: &str) -> Option<GatewayReport> {
        let said = self.log.entry(&format!("gateway.{gateway}")).await.ok().flatten()?;
        postcard::from_bytes(&said).ok()
    }

    /// Runs `utm-fusion cluster` with these arguments.
    pub async fn command(&self, arguments: &[&str]) -> Output {
        let mut command = utm_fusion("cluster");
        command.args(arguments).arg("--config").arg(self.file(NODES[0]));
        tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap()
    }

    /// Answer of the picture: status and JSON.
    pub async fn ask(&self, path: &str) -> Option<(u16, Value)> {
        self.request(&format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")).await
    }

    /// Answer of the picture to an operator's decision.
    pub async fn decide(&self, path: &str, body: &Value) -> Option<(u16, Value)> {
        let body = body.to_string();
        self.request(&format!(
            "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n{body}",
            body.len()
        ))
        .await
    }

    /// Address at which the picture serves the map.
    pub fn address(&self) -> Option<String> {
        let log = fs::read_to_string(&self.process(PICTURE).log).ok()?;
        Some(log.rsplit_once("url=\"http://")?.1.split('/').next()?.to_owned())
    }

    async fn request(&self, request: &str) -> Option<(u16, Value)> {
        let address = self.address()?;
        let request = request.to_owned();
        let answer = tokio::task::spawn_blocking(move || {
            let mut socket = TcpStream::connect(address).ok()?;
            socket.write_all(request.as_bytes()).ok()?;
            let mut answer = String::new();
            socket.read_to_string(&mut answer).ok()?;
            Some(answer)
        });
        let answer = answer.await.unwrap()?;
        let (head, body) = answer.split_once("\r\n\r\n")?;
        Some((head.split(' ').nth(1)?.parse().ok()?, serde_json::from_str(body).ok()?))
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        if std::thread::panicking() {
            for (name, _) in &self.running {
                let said = self.log_text(name);
                let lines: Vec<&str> = said.lines().collect();
                println!("--- {name}\n{}", lines[lines.len().saturating_sub(25)..].join("\n"));
            }
        }
    }
}

/// Adds the certificate of a role, if the servers are locked.
pub fn proven(cluster: &Cluster, certificates: Option<&Path>, role: &str) -> Cluster {
    let Some(own) = certificates.map(|certificates| certificates.join(role)) else { return cluster.clone() };
    Cluster {
        ca: Some(own.join("ca.pem")),
        certificate: Some(own.join("certificate.pem")),
        key: Some(own.join("key.pem")),
        inbox: Some(format!("_INBOX.{role}")),
        ..cluster.clone()
    }
}

/// Four cells that meet at the origin of the site's frame.
fn quarters(config: &Config) -> Vec<CellArea> {
    let (latitude, longitude, _) = config.origin();
    let quarter = |name: &str, [east, north]: [f64; 2]| {
        let (far_east, far_north) = (longitude + 0.1 * east, latitude + 0.1 * north);
        let (west, east) = (longitude.min(far_east), longitude.max(far_east));
        let (south, north) = (latitude.min(far_north), latitude.max(far_north));
        let polygon =
            [[west, south], [east, south], [east, north], [west, north]].map(|corner| corner.to_vec());
        CellArea { name: name.to_owned(), polygon: polygon.to_vec() }
    };
    vec![
        quarter("ne", [1.0, 1.0]),
        quarter("nw", [-1.0, 1.0]),
        quarter("se", [1.0, -1.0]),
        quarter("sw", [-1.0, -1.0]),
    ]
}

/// Keeps the site local: multicast groups of this process, ports of this site.
fn on_own_ports(mut config: Config) -> Config {
    static SITES: AtomicU16 = AtomicU16::new(0);
    let port = 18_000 + 20 * SITES.fetch_add(1, Ordering::Relaxed);
    let group = |last| Ipv4Addr::new(239, 192, 100 + (std::process::id() % 150) as u8, last);
    let address = |last| Address::Multicast { group: group(last), interface: Ipv4Addr::LOCALHOST };
    for (index, sensor) in (1..).zip(config.sensors.iter_mut()) {
        let (address, port) = (address(index), port + u16::from(index));
        sensor.inputs = vec![Input { address, port, source: None, trailer_octets: None }];
    }
    config.output.asterix = vec![Sink {
        address: address(99),
        port,
        ttl: 1,
        picture: PictureKind::Lagged,
        category: Category::Cat129,
    }];
    config.http.listen = ([127, 0, 0, 1], 0).into();
    config
}
