//! `[cluster]`.

use std::path::PathBuf;

use tables::kinds::{Kind, any_text, beside, is_plain, list, named, number, parsed, tables, text, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, absent, need};
use tables::{names, written_by_name};

/// A name that may stand in a subject of the log.
fn plain_name(rule: &'static str) -> Kind<String> {
    text(rule, Cluster::is_name)
}

/// A server's address, without a name and a password: messages about the server would repeat them.
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

/// The file of a seed. The seed itself is refused: messages about the file would repeat it.
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

/// What a halo is larger by than the hysteresis, metres.
const HALO_LEAST_M: f64 = 310.0;

section! {
    /// Several machines over NATS JetStream (docs/SCALING.md). Without this table there is one machine, and no log.
    Cluster {
        /// Servers of the log.
        servers: Vec<String> = need("servers = [ … ], such as [\"nats://127.0.0.1:4222\"]"), list(server());
        /// Certificates that those of the servers are issued by, PEM. With it every connection is TLS.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// Certificate of this process, PEM, for servers that ask for one; with `key`. With it every connection is TLS.
        certificate: Option<PathBuf> = absent("none"), beside();
        /// Its key, PEM, not encrypted.
        key: Option<PathBuf> = absent("none"), beside();
        /// The file with the credentials of this process: JWT and seed.
        credentials: Option<PathBuf> = absent("none"), beside();
        /// The file with the seed of this process's NKEY, in place of `credentials`.
        nkey: Option<PathBuf> = absent("none"), seed_file();
        /// Prefix of the subjects on which this process receives answers; locked servers allow each role its own.
        inbox: Option<String> = absent("`_INBOX.` and the role; of several roles `_INBOX`"), text(
            "an inbox is words of letters, digits, _ and - with dots between them",
            |inbox| inbox.split('.').all(|word| !word.is_empty() && is_plain(word)),
        );
        /// What this process is called; no other one of the region is called so.
        node: String = need("node = …, what no other process of the region is called"),
            plain_name("a node is called by 1 to 32 of a-z, 0-9 and -");
        /// The machine that it runs on: an owner and who stands by for it are on different ones, where there are several.
        machine: Option<String> = absent("`node`"), any_text();
        /// The region; it has streams of its own.
        region: String = need("region = …, whose streams are used"), plain_name("a region is called by 1 to 32 of a-z, 0-9 and -");
        /// What this process does.
        roles: Vec<Role> = Role::ALL.to_vec(), list(named());
        /// The region is divided into squares of so many degrees of latitude and longitude: all that a radar reaches
        /// (`max_range_m`, else 20 km), or of a site without a radar those within 20 km of it. Without this key, and without
        /// `cells`, it is one cell.
        grid_deg: Option<f64> = absent("one cell, or those of `cells`"),
            number("squares are 0.01 to 0.25 degrees", |degrees| (0.01..=0.25).contains(&degrees));
        /// The region is divided into these polygons, which do not overlap; nothing outside of them is published.
        cells: Vec<CellArea> = Vec::new(), tables();
        /// Cells that this node may own or stand by for, by name; `*` for all.
        owns: Vec<String> = vec!["*".to_owned()], list(any_text());
        /// Gateways that are missed where they say nothing, by `node`, besides those that ran last and were not ended in order.
        gateways: Vec<String> = Vec::new(), list(plain_name("a gateway is called by 1 to 32 of a-z, 0-9 and -"));
        /// A cell's engine sees what is so far around it, too, metres.
        halo_m: f64 = 1000.0, number("a halo is 310 to 10000 metres", |metres| (310.0..=10_000.0).contains(&metres));
        /// An aircraft that has left its cell stays that cell's while it is no farther away than this, metres.
        hysteresis_m: f64 = 150.0,
            number("a hysteresis is 0 to 5000 metres", |metres| (0.0..=5000.0).contains(&metres));
        /// Copies of each stream that the servers keep; 3 where no server may be missed.
        replicas: u32 = 3, whole("copies of a stream are 1 to 5", 1..=5);
        /// Time after which another node owns a cell whose owner is not heard of, seconds.
        lease_s: f64 = 3.0, number("a lease is 1 to 60 seconds", |seconds| (1.0..=60.0).contains(&seconds));
        /// Time for which a slot that is due waits for sensors whose gateways are late, seconds.
        wait_s: f64 = 0.5, number("a slot waits 0 to 5 seconds", |seconds| (0.0..=5.0).contains(&seconds));
        /// Time between two checkpoints of a cell, seconds.
        checkpoint_s: f64 = 30.0,
            number("a checkpoint is written every 1 to 60 seconds", |seconds| (1.0..=60.0).contains(&seconds));
    } by hand {}
}

section! {
    /// A cell of a region, as a polygon.
    CellArea {
        /// What it is called.
        name: String = need("name = …, what no other cell is called"), plain_name("a cell is called by 1 to 32 of a-z, 0-9 and -");
        /// Its corners in order, longitude and latitude in degrees each; the first is not repeated.
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
    /// Its corners, longitude and latitude in degrees.
    pub fn corners(&self) -> Vec<[f64; 2]> {
        self.polygon.iter().filter_map(|corner| <[f64; 2]>::try_from(&corner[..]).ok()).collect()
    }
}

names! {
    /// What a process of a cluster does.
    #[derive(Copy, Eq)]
    Role, "role" {
        /// It listens to the sensors, and writes what they send into the log.
        Gateway = "gateway",
        /// It owns cells, and stands by for others.
        Node = "node",
        /// It shows and sends the picture.
        Picture = "picture",
    }
}
written_by_name!(Role);

impl Role {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gateway, Self::Node, Self::Picture];
}

impl Cluster {
    /// Whether this process does that.
    pub fn does(&self, role: Role) -> bool {
        self.roles.contains(&role)
    }

    /// Whether this process may own a cell of this name.
    pub fn may_own(&self, cell: &str) -> bool {
        self.owns.iter().any(|own| own == "*" || own == cell)
    }

    /// Whether connections without TLS are refused, whatever the servers' addresses say.
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

    /// Whether a member of a region, or a region, may be called so.
    pub fn is_name(name: &str) -> bool {
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        (1..=32).contains(&name.len()) && name.chars().all(is_plain)
    }

    /// The machine that this process runs on.
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
        // What leaves a cell is handed over while both still see it: 60 m, and what is flown from a slot to its picture.
        if self.halo_m < self.hysteresis_m + HALO_LEAST_M {
            section.contradict(
                &["halo_m", "hysteresis_m"],
                "a halo is larger than the hysteresis by 310 metres: 60, and 6.25 s at 40 m/s",
            );
        }
    }
}
