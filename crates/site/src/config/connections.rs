//! `connections` of a sensor: inputs other than ASTERIX over UDP, translated on reception.

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;

use asterix::cat129::WholeSerial;

use super::line_fields::{LineFields, LineMapping};
use super::sensors::Sensor;
use tables::kinds::{any_text, beside, inline, is_plain, list, tables, text, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, absent, depends, need};
use tables::{names, written_by_name};

section! {
    /// A receiver or gateway whose data are translated before they are recorded and processed.
    #[derive(Eq)]
    Connection {
        /// Protocol of the receiver or gateway.
        format: ConnectionFormat = need(
            "format = \"beast\" or \"avr\" (kind = \"adsb\"), \"asterix\" (\"adsb\", \"radar\" or \"transponder\"), \"mqtt\" or \"http\" (kind = \"remote-id\"), \"mavlink\" (kind = \"transponder\", \"adsb\" or \"remote-id\"), or \"json\" or \"csv\" (kind = \"radar\" or \"transponder\")",
        ), tables::kinds::named();
        /// Address of the receiver. `"beast"`, `"avr"`, `"asterix"`: address and port of the receiver, such as `127.0.0.1:30005`.
        /// `"mqtt"`: the broker, `mqtt://host:1883`, or with TLS `mqtts://host:8883`. `"mavlink"`: local address and UDP port to
        /// listen on, which sensors of different kinds may share. `"json"`, `"csv"`: local address and UDP port to listen on, or
        /// a broker as with `"mqtt"`.
        /// `"http"`: none, because gateways post to the API of this service.
        address: String = depends("none with `\"http\"`, else it is needed", String::new()), any_text();
        /// Topic filter of the subscription at a broker. `+` matches one level, `#` all remaining levels.
        topic: String = depends("`remote-id/#` with `\"mqtt\"`, else needed", "remote-id/#".to_owned()), text("a filter of topics, up to 200 octets", |text| text.len() <= 200);
        /// User name at the broker.
        username: Option<String> = absent("nobody"), any_text();
        /// File that contains the password.
        password_file: Option<PathBuf> = absent("none"), beside();
        /// Environment variable that holds the password, instead of a file.
        password_env: Option<String> = absent("none"), any_text();
        /// Certificates of the issuers of the broker's certificate, PEM; with `mqtts://`.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// Client id at the broker. Two clients with the same id disconnect each other.
        client_id: Option<String> = absent("`utm-fusion-` with SAC, SIC and id of the sensor"),
            text("a client id is made of letters, digits, _ and -", is_plain);
        /// Drones that a `"mavlink"` connection of a transponder carries.
        systems: Vec<MavlinkSystem> = depends("none", Vec::new()), tables();
        /// Where lines of `"json"` and `"csv"` have their values.
        fields: Option<LineFields> = absent("needed with `\"json\"` and `\"csv\"`"), inline::<LineFields>();
        /// Names of the columns of `"csv"`, in their order.
        columns: Vec<String> = depends("needed with `\"csv\"`", Vec::new()), list(text("the name of a column, without spaces", |text| {
            !text.contains(char::is_whitespace)
        }));
        /// Values of `fields.class` that are drones; every other class is none.
        drone_classes: Vec<String> = depends("none", Vec::new()), list(any_text());
    } by hand {}
}

names! {
    /// Protocol of a receiver or gateway.
    #[derive(Copy, Eq)]
    ConnectionFormat, "format" {
        /// Beast: binary frames of a 1090 MHz receiver (readsb, dump1090), over TCP.
        Beast = "beast",
        /// AVR: text frames of a 1090 MHz receiver, over TCP.
        Avr = "avr",
        /// ASTERIX data blocks over TCP, as readsb sends CAT021.
        Asterix = "asterix",
        /// Remote ID lines from an MQTT 5 broker.
        Mqtt = "mqtt",
        /// Remote ID lines that gateways post to `/api/v1/remote-id` of this service (docs/API.md).
        Http = "http",
        /// MAVLink over UDP: positions of own drones (`kind = "transponder"`), aircraft with ADS-B (`"adsb"`), or Remote ID
        /// (`"remote-id"`).
        Mavlink = "mavlink",
        /// Lines of JSON over UDP or from an MQTT 5 broker, one object for each plot of a radar or report of a transponder.
        Json = "json",
        /// Lines of values with commas between them, else like `"json"`.
        Csv = "csv",
    }
}

written_by_name!(ConnectionFormat);

section! {
    /// A drone that reports its position by MAVLink.
    #[derive(Eq)]
    MavlinkSystem {
        /// MAVLink system id of the drone.
        system_id: u8 = need("system_id = 1, the number of the system"),
            whole("a system has a number from 1 to 255", 1..=255);
        /// Serial number under which the service publishes the drone.
        serial_number: String = need("serial_number = \"…\", by which the service knows the drone"),
            text("a serial number has 1 to 20 printable characters", |text| KnownSystem::new(text).is_some());
        /// Manufacturer, three characters.
        manufacturer: Option<String> = absent("not stated"), text("three printable characters", |text| is_code(text, 3));
        /// Model, three characters.
        model: Option<String> = absent("not stated"), text("three printable characters", |text| is_code(text, 3));
        /// Country of registration, ISO 3166-1 alpha-2.
        country: Option<String> = absent("`ZZ`, unknown"), text("two capital letters", |text| {
            is_code(text, 2) && text.bytes().all(|octet| octet.is_ascii_uppercase())
        });
    }
}

fn is_code(text: &str, length: usize) -> bool {
    text.len() == length && text.bytes().all(|octet| (b' '..=b'~').contains(&octet))
}

/// Example in error messages about a missing address.
const ADDRESS: &str = "address = \"127.0.0.1:30005\", or of a broker \"mqtt://127.0.0.1:1883\"";

/// Placeholder of a connection whose format is not read yet.
impl Default for ConnectionFormat {
    fn default() -> Self {
        Self::Beast
    }
}

/// Registered ports of MQTT and of MQTT over TLS.
const PORTS: [u16; 2] = [1883, 8883];

/// Address of an MQTT broker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokerAddress {
    /// Host name or IP address.
    pub host: String,
    /// Port of the broker.
    pub port: u16,
    /// Whether the connection is TLS.
    pub tls: bool,
}

impl Connection {
    /// Address of a connection whose format has a socket address. `None` for brokers; a validated configuration always has it.
    pub fn socket(&self) -> Option<SocketAddrV4> {
        self.address.parse().ok().filter(|address: &SocketAddrV4| address.port() > 0)
    }

    /// Whether the connection has lines of text whose values `fields` names.
    pub fn has_lines(&self) -> bool {
        matches!(self.format, ConnectionFormat::Json | ConnectionFormat::Csv)
    }

    /// Where the lines of a `"json"` or `"csv"` connection have their values, for a sensor of kind `radar` or `transponder`.
    ///
    /// # Errors
    /// What is missing or too much, for the operator.
    pub fn line_mapping(&self, is_radar: bool) -> Result<LineMapping, String> {
        let fields = self.fields.as_ref().ok_or("add fields = { … }, the names of the values")?;
        fields.mapping(&self.columns, &self.drone_classes, is_radar)
    }

    /// Whether it is a subscription at an MQTT broker.
    pub fn is_subscription(&self) -> bool {
        self.format == ConnectionFormat::Mqtt || (self.has_lines() && self.address.starts_with("mqtt"))
    }

    /// Whether the service listens on a UDP port, and senders need no connection.
    pub fn is_listener(&self) -> bool {
        self.format == ConnectionFormat::Mavlink || (self.has_lines() && !self.is_subscription())
    }

    /// Broker of an `"mqtt"` connection. A validated configuration always has it.
    pub fn broker(&self) -> Option<BrokerAddress> {
        let (rest, tls) = match self.address.strip_prefix("mqtts://") {
            Some(rest) => (rest, true),
            None => (self.address.strip_prefix("mqtt://")?, false),
        };
        let rest = rest.strip_suffix('/').unwrap_or(rest);
        let (host, port) = match rest.rsplit_once(':') {
            // A colon within an IPv6 address does not start a port.
            Some((host, port)) if !port.ends_with(']') => (host, port.parse().ok().filter(|port| *port > 0)?),
            _ => (rest, PORTS[usize::from(tls)]),
        };
        let is_host = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric() || "-._:[]".contains(c));
        (!host.is_empty() && is_host(host)).then(|| BrokerAddress { host: host.to_owned(), port, tls })
    }

    /// Drones of a `"mavlink"` connection, by MAVLink system id.
    pub fn systems(&self) -> BTreeMap<u8, KnownSystem> {
        let code =
            |text: &Option<String>| text.as_ref().and_then(|text| text.as_bytes().first_chunk().copied());
        let entry = |system: &MavlinkSystem| {
            let country = system.country.as_ref().and_then(|text| text.as_bytes().first_chunk().copied());
            let known = KnownSystem {
                manufacturer: code(&system.manufacturer),
                model: code(&system.model),
                country: country.unwrap_or(NO_COUNTRY),
                ..KnownSystem::new(&system.serial_number)?
            };
            Some((system.system_id, known))
        };
        self.systems.iter().filter_map(entry).collect()
    }
}

/// A drone whose MAVLink system id is known, as its positions are published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KnownSystem {
    /// Serial number. I129/040 holds its last 12 characters; a longer one is also in SP.
    pub serial_number: WholeSerial,
    /// I129/020.
    pub manufacturer: Option<[u8; 3]>,
    /// I129/030.
    pub model: Option<[u8; 3]>,
    /// I129/050.
    pub country: [u8; 2],
}

/// Country of a drone without one: the ISO 3166-1 user-assigned code commonly used for "unknown".
pub const NO_COUNTRY: [u8; 2] = *b"ZZ";

impl KnownSystem {
    /// A system with this serial number; `None` if it is blank, longer than 20 octets or not printable ASCII.
    pub fn new(serial_number: &str) -> Option<Self> {
        let is_sound = serial_number.bytes().all(|octet| (b' '..=b'~').contains(&octet));
        if serial_number.trim().is_empty() || !is_sound {
            return None;
        }
        let serial_number = WholeSerial::new(serial_number.as_bytes())?;
        Some(Self { serial_number, manufacturer: None, model: None, country: NO_COUNTRY })
    }
}

impl Sensor {
    /// Reports `"mavlink"` connections whose table of drones is missing, or present for a kind of sensor that has none.
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

    /// Reports connections with lines whose fields do not make a report of this sensor.
    pub(super) fn check_lines(&self, section: &mut Section<'_>) {
        for connection in self.connections.iter().filter(|of| of.has_lines()) {
            if let Err(message) = connection.line_mapping(self.kind.is_radar()) {
                section.contradict(&["connections"], message);
            }
        }
    }

    /// Whether gateways post to this connection over HTTP.
    pub fn is_posted(&self) -> bool {
        self.connections.iter().any(|connection| connection.format == ConnectionFormat::Http)
    }
}

impl ConnectionFormat {
    /// Kinds of sensors that may have connections of this format.
    pub(super) const fn kinds(self) -> &'static [&'static str] {
        match self {
            Self::Beast | Self::Avr => &["adsb"],
            Self::Asterix => &["adsb", "radar", "transponder"],
            Self::Mqtt | Self::Http => &["remote-id"],
            Self::Mavlink => &["transponder", "adsb", "remote-id"],
            Self::Json | Self::Csv => &["radar", "transponder"],
        }
    }
}

/// Rejects an address that does not fit the format, and keys of other formats.
impl ByHand for Connection {
    /// Leaves out the keys of other formats.
    fn arrange(&self, entries: &mut Vec<Entry>) {
        let is_broker = self.is_subscription();
        let others = ["username", "password_file", "password_env", "ca", "client_id"];
        entries.retain(|entry| match entry.key {
            "address" => self.format != ConnectionFormat::Http,
            "topic" => is_broker,
            "systems" => !self.systems.is_empty(),
            "fields" => self.fields.is_some(),
            "columns" => !self.columns.is_empty(),
            "drone_classes" => !self.drone_classes.is_empty(),
            key => is_broker || !others.contains(&key),
        });
    }

    fn more(&mut self, section: &mut Section<'_>) {
        if !section.is_sound(&["format", "address"]) {
            return;
        }
        let is_broker = self.is_subscription();
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
            let broker = if self.has_lines() { ", or a broker, mqtt://host:port" } else { "" };
            section.contradict(
                &["address"],
                format!("expected an IPv4 address and a port, such as 127.0.0.1:30005{broker}"),
            );
        } else if !self.is_listener()
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
                        "only a connection to a broker, mqtt://host:port, has this key; remove it",
                    );
                }
            }
        } else {
            if self.has_lines() {
                section.need("topic", "topic = \"radar/hill\", where the sensor publishes its lines");
            }
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
        let is_csv = self.format == ConnectionFormat::Csv;
        if is_csv
            && section.need("columns", "columns = [\"time\", …], the names of the values of a line").is_none()
        {
            return;
        }
        for (key, belongs) in
            [("fields", self.has_lines()), ("columns", is_csv), ("drone_classes", self.has_lines())]
        {
            if !belongs && section.written(key).is_some() {
                let formats = if key == "columns" { "\"csv\"" } else { "\"json\" or \"csv\"" };
                let message = format!("only a connection with format = {formats} has this key; remove it");
                section.contradict(&[key], message);
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
