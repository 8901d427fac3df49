//! `[cluster]`.

use std::path::PathBuf;

use super::kinds::{Kind, any_text, beside, list, named, number, text, whole};
use super::names::{names, written_by_name};
use super::reader::Section;
use super::table::{ByHand, absent, need, section};

/// A name that may stand in a subject of the log.
fn name(rule: &'static str) -> Kind<String> {
    text(rule, |name| {
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        (1..=32).contains(&name.len()) && name.chars().all(is_plain)
    })
}

section! {
    /// Several machines over NATS JetStream (docs/SCALING.md). Without this table there is one machine, and no log.
    Cluster {
        /// Servers of the log.
        servers: Vec<String> = need("servers = [ … ], such as [\"nats://127.0.0.1:4222\"]"), list(text(
            "a server is nats://host:port or tls://host:port",
            |url| url.split_once("://").is_some_and(|(scheme, host)| matches!(scheme, "nats" | "tls") && !host.is_empty()),
        ));
        /// The file with the credentials of this process.
        credentials: Option<PathBuf> = absent("none"), beside();
        /// What this process is called; no other one of the region is called so.
        node: String = need("node = …, what no other process of the region is called"),
            name("a node is called by 1 to 32 of a-z, 0-9 and -");
        /// The machine that it runs on: an owner and who stands by for it are on different ones, where there are several.
        machine: Option<String> = absent("`node`"), any_text();
        /// The region; it has streams of its own.
        region: String = need("region = …, whose streams are used"), name("a region is called by 1 to 32 of a-z, 0-9 and -");
        /// What this process does.
        roles: Vec<Role> = Role::ALL.to_vec(), list(named());
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
    }
}
