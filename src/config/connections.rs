//! `connections` of a sensor: what is no ASTERIX over UDP, translated at the door.

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;

use asterix::DataSource;

use super::sensors::{Sensor, SensorKind};
use crate::gateways::mavlink;
use tables::kinds::{any_text, beside, is_plain, tables, text, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, absent, depends, need};
use tables::{names, written_by_name};

section! {
    /// A receiver or gateway whose data are translated before they are recorded and handled.
    #[derive(Eq)]
    Connection {
        /// What it speaks.
        format: ConnectionFormat = need(
            "format = \"beast\" or \"avr\" (kind = \"adsb\"), \"asterix\" (\"adsb\", \"radar\" or \"transponder\"), \"mqtt\" or \"http\" (kind = \"remote-id\") or \"mavlink\" (kind = \"transponder\", \"adsb\" or \"remote-id\")",
        ), tables::kinds::named();
        /// `"beast"`, `"avr"`, `"asterix"`: address and port of the receiver, such as `127.0.0.1:30005`. `"mqtt"`: the broker,
        /// `mqtt://host:1883`, or with TLS `mqtts://host:8883`. `"mavlink"`: own address and UDP port to listen on, which
        /// sensors of different kinds may share. `"http"` has none: gateways post to the service's own API.
        address: String = depends("none with `\"http\"`, else it is needed", String::new()), any_text();
        /// Topics that are subscribed to, with `"mqtt"`; `+` and `#` stand for any name and any names.
        topic: String = depends("`remote-id/#`", "remote-id/#".to_owned()), text("a filter of topics, up to 200 octets", |text| text.len() <= 200);
        /// Who the service is to the broker.
        username: Option<String> = absent("nobody"), any_text();
        /// File of the password.
        password_file: Option<PathBuf> = absent("none"), beside();
        /// Environment variable that holds the password instead.
        password_env: Option<String> = absent("none"), any_text();
        /// Certificates that the broker's is issued by, PEM; with `mqtts://`.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// Identifies this client at the broker; two of the same id end each other's connection.
        client_id: Option<String> = absent("`utm-fusion-` with SAC, SIC and id of the sensor"),
            text("a client id is made of letters, digits, _ and -", is_plain);
        /// The drones that a `"mavlink"` connection of a transponder carries.
        systems: Vec<MavlinkSystem> = depends("none", Vec::new()), tables();
    } by hand {}
}

names! {
    /// What a receiver or gateway speaks.
    #[derive(Copy, Eq)]
    ConnectionFormat, "format" {
        /// Frames of a 1090 MHz receiver (readsb, dump1090), binary, over TCP.
        Beast = "beast",
        /// The same as text.
        Avr = "avr",
        /// ASTERIX data blocks over TCP, as readsb sends CAT021.
        Asterix = "asterix",
        /// Lines of Remote ID from a broker of MQTT 5.
        Mqtt = "mqtt",
        /// Lines of Remote ID that gateways post to `/api/v1/remote-id` of this service (docs/API.md).
        Http = "http",
        /// MAVLink over UDP: positions of own drones (`kind = "transponder"`), aircraft with ADS-B (`"adsb"`), Remote ID
        /// (`"remote-id"`).
        Mavlink = "mavlink",
    }
}

written_by_name!(ConnectionFormat);

section! {
    /// A drone that reports its position by MAVLink.
    #[derive(Eq)]
    MavlinkSystem {
        /// MAVLink's number of the system.
        system_id: u8 = need("system_id = 1, the number of the system"),
            whole("a system has a number from 1 to 255", 1..=255);
        /// Its serial number, by which the service knows it.
        serial_number: String = need("serial_number = \"…\", by which the service knows the drone"),
            text("a serial number has 1 to 20 printable characters", |text| mavlink::System::new(text).is_some());
        /// Its manufacturer, three characters.
        manufacturer: Option<String> = absent("not stated"), text("three printable characters", |text| is_code(text, 3));
        /// Its model, three characters.
        model: Option<String> = absent("not stated"), text("three printable characters", |text| is_code(text, 3));
        /// The country that it is registered in, ISO 3166-1 alpha-2.
        country: Option<String> = absent("`ZZ`, unknown"), text("two capital letters", |text| {
            is_code(text, 2) && text.bytes().all(|octet| octet.is_ascii_uppercase())
        });
    }
}

fn is_code(text: &str, length: usize) -> bool {
    text.len() == length && text.bytes().all(|octet| (b' '..=b'~').contains(&octet))
}

/// What to write as the address.
const ADDRESS: &str = "address = \"127.0.0.1:30005\", or of a broker \"mqtt://127.0.0.1:1883\"";

/// A blank one.
impl Default for ConnectionFormat {
    fn default() -> Self {
        Self::Beast
    }
}

/// Of MQTT, and of MQTT over TLS, as registered.
const PORTS: [u16; 2] = [1883, 8883];

/// A broker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokerAddress {
    /// Name or address.
    pub host: String,
    /// Its port.
    pub port: u16,
    /// Whether the connection is TLS.
    pub tls: bool,
}

impl Connection {
    /// The address of a connection that is no broker's. Configurations that were read have one.
    pub fn socket(&self) -> Option<SocketAddrV4> {
        self.address.parse().ok().filter(|address: &SocketAddrV4| address.port() > 0)
    }

    /// The broker of an `"mqtt"` connection. Configurations that were read have one.
    pub fn broker(&self) -> Option<BrokerAddress> {
        let (rest, tls) = match self.address.strip_prefix("mqtts://") {
            Some(rest) => (rest, true),
            None => (self.address.strip_prefix("mqtt://")?, false),
        };
        let rest = rest.strip_suffix('/').unwrap_or(rest);
        let (host, port) = match rest.rsplit_once(':') {
            // A colon of an IPv6 address is none of a port.
            Some((host, port)) if !port.ends_with(']') => (host, port.parse().ok().filter(|port| *port > 0)?),
            _ => (rest, PORTS[usize::from(tls)]),
        };
        let is_host = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric() || "-._:[]".contains(c));
        (!host.is_empty() && is_host(host)).then(|| BrokerAddress { host: host.to_owned(), port, tls })
    }

    /// The table of a `"mavlink"` connection.
    pub fn systems(&self) -> BTreeMap<u8, mavlink::System> {
        let code =
            |text: &Option<String>| text.as_ref().and_then(|text| text.as_bytes().first_chunk().copied());
        let entry = |system: &MavlinkSystem| {
            let country = system.country.as_ref().and_then(|text| text.as_bytes().first_chunk().copied());
            let known = mavlink::System {
                manufacturer: code(&system.manufacturer),
                model: code(&system.model),
                country: country.unwrap_or(mavlink::NO_COUNTRY),
                ..mavlink::System::new(&system.serial_number)?
            };
            Some((system.system_id, known))
        };
        self.systems.iter().filter_map(entry).collect()
    }
}

/// The sensors that MAVLink messages become records of: of each kind the first one with a `"mavlink"` connection that is wanted.
pub fn mavlink_sensors<'a>(
    sensors: impl Iterator<Item = &'a Sensor>,
    is_wanted: impl Fn(&Connection) -> bool,
) -> mavlink::Sensors {
    let mut found = mavlink::Sensors::default();
    for sensor in sensors {
        let is_heard = |of: &&Connection| of.format == ConnectionFormat::Mavlink && is_wanted(of);
        let Some(connection) = sensor.connections.iter().find(is_heard) else { continue };
        let source = DataSource { sac: sensor.sac, sic: sensor.sic };
        match sensor.kind {
            SensorKind::Transponder(_) => {
                found.drones.get_or_insert_with(|| (source, connection.systems()));
            }
            SensorKind::AdsB(_) => {
                found.aircraft.get_or_insert(source);
            }
            SensorKind::RemoteId(_) => {
                let id = Some(sensor.id.clone());
                found.remote_id.get_or_insert(mavlink::RemoteIdReceiver { id });
            }
            SensorKind::Radar(_) | SensorKind::Camera(_) => {}
        }
    }
    found
}

impl Sensor {
    /// Complains of `"mavlink"` connections with a table of drones, or without one, where the kind of sensor has none or one.
    pub(super) fn check_systems(&self, section: &mut Section<'_>) {
        let is_own = self.kind.is_transponder();
        let is_mavlink = |of: &&Connection| of.format == ConnectionFormat::Mavlink;
        if self.connections.iter().filter(is_mavlink).any(|of| of.systems.is_empty() == is_own) {
            let message = if is_own {
                "no drone would be known; add systems = [{ system_id = 1, serial_number = \"…\" }]"
            } else {
                "only a sensor of kind \"transponder\" has drones of its own; remove systems"
            };
            section.contradict(&["connections"], message);
        }
    }

    /// Whether gateways post to it over HTTP.
    pub fn is_posted(&self) -> bool {
        self.connections.iter().any(|connection| connection.format == ConnectionFormat::Http)
    }
}

impl ConnectionFormat {
    /// The kinds of sensors that have such connections.
    pub(super) const fn kinds(self) -> &'static [&'static str] {
        match self {
            Self::Beast | Self::Avr => &["adsb"],
            Self::Asterix => &["adsb", "radar", "transponder"],
            Self::Mqtt | Self::Http => &["remote-id"],
            Self::Mavlink => &["transponder", "adsb", "remote-id"],
        }
    }
}

/// An address that fits to the format, and no keys of another format.
impl ByHand for Connection {
    /// Without the keys of other formats.
    fn arrange(&self, entries: &mut Vec<Entry>) {
        let is_broker = self.format == ConnectionFormat::Mqtt;
        let others = ["username", "password_file", "password_env", "ca", "client_id"];
        entries.retain(|entry| match entry.key {
            "address" => self.format != ConnectionFormat::Http,
            "topic" => is_broker,
            "systems" => !self.systems.is_empty(),
            key => is_broker || !others.contains(&key),
        });
    }

    fn more(&mut self, section: &mut Section<'_>) {
        if !section.is_sound(&["format", "address"]) {
            return;
        }
        let is_broker = self.format == ConnectionFormat::Mqtt;
        if self.format == ConnectionFormat::Http {
            section.contradict(
                &["address"],
                "gateways post to this service, where http.listen says; remove this key",
            );
        } else if section.need("address", ADDRESS).is_none() {
            return;
        } else if is_broker && self.broker().is_none() {
            section.contradict(&["address"], "a broker is mqtt://host:port, or with TLS mqtts://host:port; user and password have keys of their own");
        } else if !is_broker && self.socket().is_none() {
            section.contradict(&["address"], "expected an IPv4 address and a port, such as 127.0.0.1:30005");
        } else if self.format != ConnectionFormat::Mavlink
            && self.socket().is_some_and(|socket| *socket.ip() == Ipv4Addr::UNSPECIFIED)
        {
            section.contradict(
                &["address"],
                "nothing can be connected to at 0.0.0.0; write the address of the receiver",
            );
        }
        if !is_broker {
            for key in ["topic", "username", "password_file", "password_env", "ca", "client_id"] {
                if section.written(key).is_some() {
                    section.contradict(
                        &[key],
                        "only a connection with format = \"mqtt\" has this key; remove it",
                    );
                }
            }
        } else {
            if self.password_file.is_some() && self.password_env.is_some() {
                section
                    .contradict(&["password_env"], "there is a file of it too; remove one of the two keys");
            }
            if self.username.is_none() {
                section.contradict(
                    &["password_file", "password_env"],
                    "a password belongs to a username; add it, or remove the key",
                );
            }
            if self.ca.is_some() && self.broker().is_some_and(|broker| !broker.tls) {
                section.contradict(
                    &["ca"],
                    "nobody proves anything without TLS; write mqtts://, or remove the key",
                );
            }
        }
        let has_systems = !self.systems.is_empty();
        if has_systems && self.format != ConnectionFormat::Mavlink {
            let message = "only a connection with format = \"mavlink\" has this key; remove it";
            section.contradict(&["systems"], message);
        }
        let mut ids: Vec<u8> = self.systems.iter().map(|system| system.system_id).collect();
        ids.sort_unstable();
        ids.dedup();
        if ids.len() < self.systems.len() {
            section.contradict(&["systems"], "two drones have the same system_id; give each its own");
        }
    }
}
