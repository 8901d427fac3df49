//! `[cluster]`.

use std::path::PathBuf;

use tables::kinds::{Kind, any_text, beside, is_plain, list, named, number, parsed, tables, text, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, absent, need};
use tables::{names, written_by_name};

/// Kind of a name that is valid in a subject of the log.
fn plain_name(rule: &'static str) -> Kind<String> {
    text(rule, Cluster::is_name)
}

/// Kind of a server's address. User names and passwords are refused, because messages about the server would repeat them.
fn server() -> Kind<String> {
    const RULE: &str = "a server is nats://host:port or tls://host:port";
    parsed(RULE, |url: &str| match url.split_once("://") {
        Some((_, host)) if host.contains('@') => {
            Err("the address of a server holds no name, password or token, which messages \
             would repeat; name files instead: certificate = … and key = …, or credentials = …, or nkey = …")
        }
        Some(("nats" | "tls", host)) if !host.is_empty() => Ok(url.to_owned()),
        _ => Err(RULE),
    })
}

/// Kind of the path of a seed file. A seed in its place is refused, because messages about the file would repeat it.
fn seed_file() -> Kind<PathBuf> {
    Kind::new(beside().values, |item| {
        let text = item.text()?;
        let is_seed =
            text.len() == 58 && text.starts_with('S') && text.bytes().all(|c| c.is_ascii_alphanumeric());
        if is_seed {
            item.refuse_secret("this is a seed itself; write it into a file, and the file's path here");
            return None;
        }
        (beside().read)(item)
    })
}

/// Minimum of the halo beyond the hysteresis, in metres.
const HALO_LEAST_M: f64 = 310.0;

section! {
    /// High availability and scaling over several machines, by NATS JetStream (docs/SCALING.md). Without this table the service
    /// runs on one machine, without a log.
    Cluster {
        /// NATS servers of the log.
        servers: Vec<String> = need("servers = [ … ], such as [\"nats://127.0.0.1:4222\"]"), list(server());
        /// Certificates of the issuers of the servers' certificates, PEM. If given, every connection uses TLS.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// Client certificate of this process, PEM, for servers that require one; together with `key`. If given, every connection
        /// uses TLS.
        certificate: Option<PathBuf> = absent("none"), beside();
        /// Private key of the client certificate, PEM, not encrypted.
        key: Option<PathBuf> = absent("none"), beside();
        /// File with the NATS credentials of this process: JWT and seed.
        credentials: Option<PathBuf> = absent("none"), beside();
        /// File with the seed of this process's NKEY, instead of `credentials`.
        nkey: Option<PathBuf> = absent("none"), seed_file();
        /// Prefix of the subjects on which this process receives answers. Servers with access control allow each role a prefix of
        /// its own.
        inbox: Option<String> = absent("`_INBOX.` and the role; of several roles `_INBOX`"), text(
            "an inbox is words of letters, digits, _ and - with dots between them",
            |inbox| inbox.split('.').all(|word| !word.is_empty() && is_plain(word)),
        );
        /// Name of this process, unique in the region.
        node: String = need("node = …, what no other process of the region is called"),
            plain_name("a node is called by 1 to 32 of a-z, 0-9 and -");
        /// Name of the machine that the process runs on. The owner and the standby of a cell are on different machines if there
        /// are several.
        machine: Option<String> = absent("`node`"), any_text();
        /// Name of the region. Each region has its own streams.
        region: String = need("region = …, whose streams are used"), plain_name("a region is called by 1 to 32 of a-z, 0-9 and -");
        /// Roles of this process.
        roles: Vec<Role> = Role::ALL.to_vec(), list(named());
        /// Size of the square cells into which the region is divided, in degrees of latitude and longitude. The cells cover the
        /// range of every radar (`max_range_m`, else 20 km); for a site without a radar, 20 km around it. Without this key and
        /// without `cells`, the region is one cell.
        grid_deg: Option<f64> = absent("one cell, or those of `cells`"),
            number("squares are 0.01 to 0.25 degrees", |degrees| (0.01..=0.25).contains(&degrees));
        /// Polygons into which the region is divided. They must not overlap. Tracks outside of all polygons are not published.
        cells: Vec<CellArea> = Vec::new(), tables();
        /// Names of the cells that this node may own or stand by for; `*` means all.
        owns: Vec<String> = vec!["*".to_owned()], list(any_text());
        /// Names (`node`) of gateways that are reported missing while they are silent. Gateways that ran last and did not shut
        /// down in order are reported too.
        gateways: Vec<String> = Vec::new(), list(plain_name("a gateway is called by 1 to 32 of a-z, 0-9 and -"));
        /// Width of the halo, in metres: the engine of a cell also uses reports from this far outside the cell.
        halo_m: f64 = 1000.0, number("a halo is 310 to 10000 metres", |metres| (310.0..=10_000.0).contains(&metres));
        /// Hysteresis at the border of a cell, in metres: an aircraft that leaves its cell belongs to it up to this distance.
        hysteresis_m: f64 = 150.0,
            number("a hysteresis is 0 to 5000 metres", |metres| (0.0..=5000.0).contains(&metres));
        /// Number of copies of each stream on the servers. 3 copies survive the loss of one server.
        replicas: u32 = 3, whole("copies of a stream are 1 to 5", 1..=5);
        /// Time without a sign of life after which another node takes over an owner's cells, in seconds.
        lease_s: f64 = 2.0, number("a lease is 1 to 60 seconds", |seconds| (1.0..=60.0).contains(&seconds));
        /// Maximum time for which a due slot waits for the data of late gateways, in seconds.
        wait_s: f64 = 0.5, number("a slot waits 0 to 5 seconds", |seconds| (0.0..=5.0).contains(&seconds));
        /// Time between two checkpoints of a cell, in seconds.
        checkpoint_s: f64 = 30.0,
            number("a checkpoint is written every 1 to 60 seconds", |seconds| (1.0..=60.0).contains(&seconds));
    } by hand {}
}

section! {
    /// A polygonal cell of a region.
    CellArea {
        /// Name of the cell, unique in the region.
        name: String = need("name = …, what no other cell is called"), plain_name("a cell is called by 1 to 32 of a-z, 0-9 and -");
        /// Corners of the polygon in order, each as longitude and latitude in degrees. The first corner is not repeated.
        polygon: Vec<Vec<f64>> = need("polygon = [[4.30, 51.20], …]"),
            list(list(number("a longitude or a latitude in degrees", |degrees| degrees.abs() <= 360.0)));
    } by hand {}
}

impl ByHand for CellArea {
    fn more(&mut self, section: &mut Section<'_>) {
        if self.polygon.iter().any(|corner| corner.len() != 2) {
            section.contradict(&["polygon"], "a corner is [longitude, latitude]");
        }
    }
}

impl CellArea {
    /// Corners of the polygon: longitude and latitude, in degrees.
    pub fn corners(&self) -> Vec<[f64; 2]> {
        self.polygon.iter().filter_map(|corner| <[f64; 2]>::try_from(&corner[..]).ok()).collect()
    }
}

names! {
    /// Role of a process in a cluster.
    #[derive(Copy, Eq)]
    Role, "role" {
        /// Receives data from the sensors and writes them to the log.
        Gateway = "gateway",
        /// Owns cells, and stands by for others.
        Node = "node",
        /// Publishes the picture: map, API and outputs.
        Picture = "picture",
    }
}
written_by_name!(Role);

impl Role {
    /// All roles.
    pub const ALL: [Self; 3] = [Self::Gateway, Self::Node, Self::Picture];
}

impl Cluster {
    /// Whether this process has the role.
    pub fn does(&self, role: Role) -> bool {
        self.roles.contains(&role)
    }

    /// Whether this process may own the cell named `cell`.
    pub fn may_own(&self, cell: &str) -> bool {
        self.owns.iter().any(|own| own == "*" || own == cell)
    }

    /// Whether connections without TLS are refused, whatever the addresses of the servers say.
    pub fn requires_tls(&self) -> bool {
        self.ca.is_some() || self.certificate.is_some()
    }

    /// Prefix of the subjects on which this process receives answers.
    pub fn inbox(&self) -> String {
        match (&self.inbox, &self.roles[..]) {
            (Some(inbox), _) => inbox.clone(),
            (None, [role]) => format!("_INBOX.{}", role.name()),
            (None, _) => "_INBOX".to_owned(),
        }
    }

    /// Whether `name` is valid for a process of a region, or for a region.
    pub fn is_name(name: &str) -> bool {
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        (1..=32).contains(&name.len()) && name.chars().all(is_plain)
    }

    /// Name of the machine that this process runs on.
    pub fn machine(&self) -> &str {
        self.machine.as_deref().unwrap_or(&self.node)
    }
}

impl ByHand for Cluster {
    fn more(&mut self, section: &mut Section<'_>) {
        for (name, is_empty) in [("servers", self.servers.is_empty()), ("roles", self.roles.is_empty())] {
            if is_empty {
                section.contradict(&[name], "at least one is needed");
            }
        }
        if self.certificate.is_some() != self.key.is_some() {
            section.contradict(
                &["certificate", "key"],
                "certificate and key belong together; give both or none",
            );
        }
        if self.credentials.is_some() && self.nkey.is_some() {
            section.contradict(&["nkey"], "credentials hold a seed, too; give one of the two");
        }
        if self.grid_deg.is_some() && !self.cells.is_empty() {
            section.contradict(&["grid_deg", "cells"], "cells are squares, or polygons");
        }
        // An aircraft that leaves a cell is handed over while both cells still see it: 60 m, plus the distance flown between a
        // slot and its publication.
        if self.halo_m < self.hysteresis_m + HALO_LEAST_M {
            section.contradict(
                &["halo_m", "hysteresis_m"],
                "a halo is larger than the hysteresis by 310 metres: 60, and 6.25 s at 40 m/s",
            );
        }
    }
}
