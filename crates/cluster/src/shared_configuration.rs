//! The configuration shared by all members of a region. A member with another one would make another picture of the same reports.

use std::fmt::Write;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use site::areas::{AreaError, Areas, HeardAreas};
use site::config::{Address, Config, Sensor};
use tables::table::{Entry, Table};

/// Maximum number of differences listed.
const MAX_LISTED: usize = 5;
/// Length in octets above which values are compared by their hash.
const MAX_PLAIN_OCTETS: usize = 120;
/// Size of all values together that fits into a message of the log, in octets. Above it each value is stored as a hash.
const MAX_TOTAL_OCTETS: usize = 256 << 10;

/// The parts of the configuration that all members need to share, by key, in order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SharedConfiguration(Vec<(String, String)>);

impl SharedConfiguration {
    /// The shared parts of a configuration: site, sensors and their inputs, engine settings, masks, cells.
    ///
    /// # Errors
    /// A file of `[[areas]]` cannot be used.
    pub fn of(config: &Config, areas: &Areas) -> Result<Self, AreaError> {
        let mut parts = Vec::new();
        add(&mut parts, "site", config.site.entries());
        let ids: Vec<&str> = config.sensors.iter().map(|sensor| &*sensor.id).collect();
        parts.push(("sensors".to_owned(), ids.join(", ")));
        for sensor in &config.sensors {
            let name = format!("sensors.{}", sensor.id);
            let own =
                sensor.entries().into_iter().filter(|entry| !["inputs", "connections"].contains(&entry.key));
            add(&mut parts, &name, own);
            parts.push((format!("{name}.groups"), groups(sensor)));
        }
        // The number of threads does not change the results.
        add(&mut parts, "fusion", config.fusion.entries().into_iter().filter(|entry| entry.key != "threads"));
        add(&mut parts, "integrity", config.integrity.entries());
        let heard = HeardAreas::load(config)?;
        parts.push(("areas".to_owned(), format!("{:?} {heard:?}", areas.masks())));
        if let Some(cluster) = &config.cluster {
            parts.push(("cluster.region".to_owned(), cluster.region.clone()));
            let shared = ["grid_deg", "cells", "halo_m", "hysteresis_m"];
            add(
                &mut parts,
                "cluster",
                cluster.entries().into_iter().filter(|entry| shared.contains(&entry.key)),
            );
        }
        let octets: usize =
            parts.iter().map(|(key, value)| key.len() + value.len().min(MAX_PLAIN_OCTETS)).sum();
        let shortest = if octets > MAX_TOTAL_OCTETS { 0 } else { MAX_PLAIN_OCTETS };
        for (_, value) in parts.iter_mut().filter(|(_, value)| value.len() > shortest) {
            *value = format!("sha256 {}", input::hex::text(&Sha256::digest(&*value)[..8]));
        }
        Ok(Self(parts))
    }

    /// Hash of the configuration; never 0, which means not stated.
    pub fn hash(&self) -> u64 {
        let mut hash = Sha256::new();
        for (key, value) in &self.0 {
            hash.update(format!("{}:{key}{}:{value}", key.len(), value.len()));
        }
        let octets = *hash.finalize().first_chunk().expect("32 octets");
        u64::from_be_bytes(octets).max(1)
    }

    /// Whether a stated hash matches. A member that states none is of an earlier version and is accepted.
    pub const fn accepts(own: u64, stated: u64) -> bool {
        stated == 0 || own == 0 || stated == own
    }

    /// Serialises the configuration for the log.
    pub fn octets(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("texts can be written down")
    }

    /// Parses octets stored under a hash; `None` if their hash differs.
    pub fn parse(octets: &[u8], hash: u64) -> Option<Self> {
        serde_json::from_slice(octets).ok().filter(|kept: &Self| kept.hash() == hash)
    }

    /// Lists the differences from another configuration.
    pub fn differences(&self, there: &Self) -> String {
        let of = |all: &Self, key: &str| {
            all.0.iter().find(|(of, _)| of == key).map_or("nothing".to_owned(), |(_, value)| value.clone())
        };
        let keys =
            self.0.iter().chain(there.0.iter().filter(|(key, _)| self.0.iter().all(|(own, _)| own != key)));
        let other = keys
            .map(|(key, _)| (key, of(there, key), of(self, key)))
            .filter(|(_, there, here)| there != here);
        let all: Vec<_> = other.collect();
        let mut text = String::new();
        for (index, (key, there, here)) in all.iter().take(MAX_LISTED).enumerate() {
            let before = if index > 0 { "; " } else { "" };
            _ = write!(text, "{before}{key} is {there} there, and {here} here");
        }
        if all.len() > MAX_LISTED {
            _ = write!(text, "; and {} more", all.len() - MAX_LISTED);
        }
        text
    }
}

/// Multicast groups of a sensor's inputs. Unicast addresses and interfaces differ between machines.
fn groups(sensor: &Sensor) -> String {
    let groups = sensor.inputs.iter().filter_map(|input| match input.address {
        Address::Multicast { group, .. } => Some(format!("{group}:{}", input.port)),
        Address::Unicast(_) => None,
    });
    groups.collect::<Vec<_>>().join(", ")
}

fn add(parts: &mut Vec<(String, String)>, table: &str, entries: impl IntoIterator<Item = Entry>) {
    let part = |entry: Entry| {
        (format!("{table}.{}", entry.key), entry.value.unwrap_or_else(|_| "absent".to_owned()))
    };
    parts.extend(entries.into_iter().map(part));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(more: &str) -> Config {
        let text = format!(
            "[site]\nname = \"site\"\nsac = 25\nsic = 100\n[[sensors]]\nid = \"north\"\nkind = \"radar\"\nsac = 25\nsic = 1\n\
             latitude_deg = 51.25\nlongitude_deg = 4.35\nheight_amsl_m = 10\nmax_range_m = 5000\n\
             [[sensors.inputs]]\ngroup = \"239.1.1.1\"\nport = 8048\ninterface = \"127.0.0.1\"\n{more}\
             [cluster]\nservers = [\"nats://127.0.0.1:4222\"]\nnode = \"n\"\nregion = \"r\"\n"
        );
        Config::parse(&text, "site.toml", std::iter::empty()).unwrap()
    }

    fn shared(config: &Config) -> SharedConfiguration {
        SharedConfiguration::of(config, &Areas::default()).unwrap()
    }

    #[test]
    fn differences_are_listed_with_both_values() {
        let here = config("");
        let mut there = here.clone();
        there.fusion.latency_slots = 24;
        let mut far = here.clone();
        if let site::config::SensorKind::Radar(radar) = &mut far.sensors[0].kind {
            radar.latitude_deg = 48.1;
        }
        let text = shared(&here).differences(&shared(&there));
        assert_eq!(text, "fusion.latency_s is 6.0 there, and 6.25 here");
        let text = shared(&here).differences(&shared(&far));
        assert_eq!(text, "sensors.north.latitude_deg is 48.1 there, and 51.25 here");
        assert_ne!(shared(&here).hash(), shared(&there).hash());
        let octets = shared(&there).octets();
        assert_eq!(SharedConfiguration::parse(&octets, shared(&there).hash()), Some(shared(&there)));
        assert_eq!(SharedConfiguration::parse(&octets, 7), None);
    }

    #[test]
    fn machine_specific_settings_do_not_change_the_hash() {
        let here = config("");
        let mut there = here.clone();
        there.sensors[0].inputs[0].address =
            Address::Multicast { group: [239, 1, 1, 1].into(), interface: [10, 0, 0, 7].into() };
        let cluster = there.cluster.as_mut().unwrap();
        (cluster.node, cluster.servers) = ("other".to_owned(), vec!["nats://10.0.0.1:4222".to_owned()]);
        there.http.listen = ([10, 0, 0, 7], 8080).into();
        assert_eq!(shared(&here).hash(), shared(&there).hash());
        assert!(SharedConfiguration::accepts(7, 0) && SharedConfiguration::accepts(7, 7));
        assert!(!SharedConfiguration::accepts(7, 8));
    }
}
