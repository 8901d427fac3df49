//! `[[output.cot]]`, `[[output.f3623]]`, `[[output.sapient]]`: further receivers of the picture.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;

use axum::http::Uri;
use jiff::SignedDuration;

use super::network::PictureKind;
use super::receivers::address;
use tables::kinds::{Toml, any_text, beside, ipv4, is_plain, named, parsed, seconds, text, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, absent, need};
use tables::tree::quoted;

section! {
    /// A receiver of Cursor on Target events (docs/OUTPUTS.md).
    #[derive(Eq)]
    Cot {
        /// Name of the receiver in the log, in `/metrics` and in alerts.
        id: String = need("id = \"tak\", a name of the receiver"),
            text("an id is made of letters, digits, _ and -", is_plain);
        /// URL to which events are sent.
        url: CotUrl = need("url = \"tls://tak.example:8089\""),
            parsed("`udp://` with a group's or a host's address, `tcp://` or `tls://` with a name or an address; each with a port", receiver);
        /// This machine's own address on the network of the multicast group.
        interface: Option<Ipv4Addr> = absent("left to the routing table"), ipv4(
            "the interface is named by this machine's own address on it, such as \"127.0.0.1\"",
            |interface| !interface.is_multicast() && !interface.is_broadcast(),
        );
        /// Time to live of datagrams, in hops.
        ttl: Option<u8> = absent("1 for a group, 64 for an address"), whole("a time to live is 0 to 255 hops", 0..=255);
        /// Certificates of the issuers of the receiver's certificate, PEM; with `tls://`.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// Name expected in the receiver's certificate.
        server_name: Option<String> = absent("that of the url"), any_text();
        /// Client certificate of this service, PEM, for receivers that require one; together with `key`.
        certificate: Option<PathBuf> = absent("none"), beside();
        /// Private key of the client certificate, PEM, not encrypted.
        key: Option<PathBuf> = absent("none"), beside();
        /// Picture to send. `now` needs `fusion.now`.
        picture: PictureKind = PictureKind::Lagged, named();
        /// Time for which an event is valid after it was sent, in seconds. The receiver then fades the symbol of a track that has
        /// ended.
        stale_s: SignedDuration = SignedDuration::from_secs(5),
            seconds("an event counts for 2 to 3600 seconds", |s| (2.0..=3600.0).contains(&s));
    } by hand {}
}

section! {
    /// A receiver of surveillance supplementary data, ASTM F3623 (docs/OUTPUTS.md).
    #[derive(Eq)]
    F3623 {
        /// Name of the receiver in the log, in `/metrics` and in alerts.
        id: String = need("id = \"sdsp\", a name of the receiver"),
            text("an id is made of letters, digits, _ and -", is_plain);
        /// URL to which the observations of each second are posted. For Flight Blender, the path ends in the id of a session.
        url: Uri = need("url = \"https://host/flight_stream/set_air_traffic/<session>\""),
            parsed("https://host/path or http://host/path", address);
        /// File that contains a bearer token; read again for each post.
        token_file: Option<PathBuf> = absent("none: the header `Authorization` is not sent"), beside();
        /// Certificates of the issuers of the receiver's certificate, PEM.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// Picture to send. `now` needs `fusion.now`.
        picture: PictureKind = PictureKind::Lagged, named();
        /// Timeout of a post, in seconds.
        timeout_s: SignedDuration = SignedDuration::from_secs(5),
            seconds("a timeout is between 0.1 and 60 seconds", |s| (0.1..=60.0).contains(&s));
    } by hand {}
}

impl F3623 {
    /// Whether the transport is encrypted.
    pub fn is_tls(&self) -> bool {
        self.url.scheme_str() == Some("https")
    }
}

impl ByHand for F3623 {
    fn more(&mut self, section: &mut Section<'_>) {
        if self.ca.is_some() && !self.is_tls() && section.is_sound(&["url"]) {
            section
                .contradict(&["ca"], "nobody proves anything over http; write https://, or remove the key");
        }
    }
}

/// URL of a receiver of events.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CotUrl {
    /// Transport and address.
    pub carrier: Carrier,
}

/// Transport of events.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// One UDP datagram per event.
    Udp(SocketAddrV4),
    /// TCP connection: host and port.
    Tcp(String, u16),
    /// TLS connection: host and port.
    Tls(String, u16),
}

/// Placeholder of a missing URL, which is refused.
impl Default for CotUrl {
    fn default() -> Self {
        Self { carrier: Carrier::Udp(SocketAddrV4::new(Ipv4Addr::LOCALHOST, 0)) }
    }
}

impl fmt::Display for CotUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.carrier {
            Carrier::Udp(to) => write!(f, "udp://{to}"),
            Carrier::Tcp(host, port) => write!(f, "tcp://{host}:{port}"),
            Carrier::Tls(host, port) => write!(f, "tls://{host}:{port}"),
        }
    }
}

impl Toml for CotUrl {
    fn toml(&self) -> Option<String> {
        Some(quoted(&self.to_string()))
    }
}

fn receiver(text: &str) -> Result<CotUrl, &'static str> {
    const RULE: &str = "expected udp://239.2.3.1:6969, tcp://host:8087 or tls://host:8089";
    let uri: Uri = text.parse().map_err(|_| RULE)?;
    let host = uri.host().filter(|host| !host.is_empty()).ok_or(RULE)?;
    let port = uri
        .port_u16()
        .filter(|&port| port > 0)
        .ok_or("the port is missing: TAK has 6969 for udp, 8087 for tcp, 8089 for tls")?;
    let is_bare = matches!(uri.path(), "" | "/") && uri.query().is_none();
    if !is_bare || uri.authority().is_some_and(|authority| authority.as_str().contains('@')) {
        return Err(RULE);
    }
    let carrier = match uri.scheme_str() {
        Some("udp") => {
            let host: Ipv4Addr =
                host.parse().map_err(|_| "over UDP the receiver is a group or a host by its IPv4 address")?;
            if host.is_unspecified() {
                return Err("nothing can be sent to 0.0.0.0; write the address of the receiver");
            }
            Carrier::Udp(SocketAddrV4::new(host, port))
        }
        Some("tcp") => Carrier::Tcp(host.to_owned(), port),
        Some("tls") => Carrier::Tls(host.to_owned(), port),
        _ => return Err(RULE),
    };
    Ok(CotUrl { carrier })
}

/// Rejects keys that do not fit the transport, and a certificate without its key.
impl ByHand for Cot {
    fn more(&mut self, section: &mut Section<'_>) {
        let group = match self.url.carrier {
            Carrier::Udp(to) => Some(to.ip().is_multicast()),
            _ => None,
        };
        if section.is_sound(&["url"]) {
            if group != Some(true) {
                section.contradict(
                    &["interface"],
                    "an interface goes with a group; remove it, the url says where",
                );
            }
            if group.is_none() {
                section.contradict(&["ttl"], "only datagrams have one here; remove it");
            }
            if !matches!(self.url.carrier, Carrier::Tls(..)) {
                section.contradict(
                    &["ca", "server_name", "certificate", "key"],
                    "nobody proves anything without TLS; write tls://, or remove the key",
                );
            }
        }
        if self.certificate.is_some() != self.key.is_some() {
            section.contradict(
                &["certificate", "key"],
                "a certificate and its key go together; name both files",
            );
        }
    }
}

section! {
    /// A SAPIENT node that receives detection reports, BSI Flex 335 v2.0 (docs/SAPIENT.md).
    #[derive(Eq)]
    Sapient {
        /// Name of the receiver in the log, in `/metrics` and in alerts.
        id: String = need("id = \"c2\", a name of the receiver"),
            text("an id is made of letters, digits, _ and -", is_plain);
        /// URL at which the node listens.
        url: TcpUrl = need("url = \"tcp://127.0.0.1:14000\""),
            parsed("`tcp://` with a name or an address, and a port", tcp);
        /// UUID of this service at that node. It must never change.
        node_id: String = need("node_id = \"…\", a UUID as uuidgen prints it"),
            text("a node is known by a UUID in lower case, such as a8654cdf-4328-47de-81fa-c495589e30c9", is_uuid);
        /// Picture to send. `now` needs `fusion.now`.
        picture: PictureKind = PictureKind::Lagged, named();
        /// Time between two status reports, in seconds.
        status_interval as "status_interval_s": SignedDuration = SignedDuration::from_secs(5),
            seconds("a status report goes out every 1 to 60 seconds", |s| (1.0..=60.0).contains(&s));
    }
}

/// Host and port of a TCP server.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TcpUrl {
    /// Host name or IP address.
    pub host: String,
    /// Port of the server.
    pub port: u16,
}

impl fmt::Display for TcpUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tcp://{}:{}", self.host, self.port)
    }
}

impl Toml for TcpUrl {
    fn toml(&self) -> Option<String> {
        Some(quoted(&self.to_string()))
    }
}

fn tcp(text: &str) -> Result<TcpUrl, &'static str> {
    const RULE: &str = "expected tcp://host:port";
    match receiver(text).map(|url| url.carrier) {
        Ok(Carrier::Tcp(host, port)) => Ok(TcpUrl { host, port }),
        _ => Err(RULE),
    }
}

/// Whether `text` is 8-4-4-4-12 hexadecimal digits.
fn is_uuid(text: &str) -> bool {
    let is_digit = |c: u8| matches!(c, b'0'..=b'9' | b'a'..=b'f');
    let lengths: Vec<usize> = text.split('-').map(str::len).collect();
    lengths == [8, 4, 4, 4, 12] && text.bytes().all(|c| c == b'-' || is_digit(c))
}
