//! `[http]`.

use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::path::PathBuf;

use super::cidr::Network;
use tables::kinds::{Kind, Toml, any_text, beside, inline, limit, list, named, parsed, text, whole};
use tables::names;
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, Row, absent, depends, need};

section! {
    /// The HTTP service.
    #[derive(Eq)]
    Http {
        /// Address and port to listen on; port 0 takes a free one. Without authentication, only a loopback address is accepted.
        listen: SocketAddr = SocketAddr::from((Ipv4Addr::LOCALHOST, 8080)), parsed(
            "an address and a port, such as \"127.0.0.1:8080\"",
            |text| text.parse().map_err(|_| {
                "expected an address and a port, such as \"127.0.0.1:8080\"; names are not looked up"
            }),
        );
        /// Authentication. SIGHUP never disables it on an address that other machines can reach.
        auth: Auth = Auth::None, authentication(), reloaded;
        /// Certificate and key for TLS. SIGHUP changes the files or reads them again; enabling or disabling TLS needs a restart.
        tls: Option<TlsFiles> = absent("none, plain HTTP"), inline::<TlsFiles>(), reloaded;
        /// Further origins (CORS) whose pages may use the service from a browser.
        cors: Vec<String> = Vec::new(), list(text(
            "an origin is https://host or http://host, in lower case, with :port where it is no usual one",
            is_origin,
        )), reloaded;
        /// Host names under which clients reach the service, in addition to IP addresses and `localhost`.
        hosts: Vec<String> = Vec::new(), list(text(
            "a host is a name in lower case, such as \"fusion.example\", without scheme and port; addresses and localhost are \
             accepted anyway",
            is_host,
        )), reloaded;
        /// Reverse proxies whose `X-Forwarded-For` header is trusted.
        trusted_proxies: Vec<Network> = Vec::new(), list(parsed(
            "an address such as \"127.0.0.1\" or a network such as \"10.0.0.0/8\"",
            str::parse::<Network>,
        )), reloaded;
        /// Maximum number of open connections per client address. The default is enough for the map in ten tabs over HTTP/1.1.
        connections_per_address: Option<NonZeroU32> = NonZeroU32::new(64), limit(
            "connections of one address are a whole number, 0 (no limit) to 1000000",
        ), reloaded;
        /// Long-term limit of requests per second, per client address and per token.
        requests_per_s: Option<NonZeroU32> = NonZeroU32::new(REQUESTS_PER_S), limit(
            "requests a second of one address are a whole number, 0 (no limit) to 1000000",
        ), reloaded;
        /// Number of requests that a client may send at once after a pause.
        requests_burst: u32 = depends("four times `requests_per_s`", BURST_S * REQUESTS_PER_S),
            whole("requests at once are a whole number, 1 to 1000000", 1..=1_000_000), reloaded;
        /// Raster map tiles (Web Mercator) from a server of the operator's choice.
        tiles: Option<Tiles> = absent("none, the page asks nobody but this service"), inline::<Tiles>();
    } by hand {}
}

/// Default rate limit, far above what the map page and polling dashboards need.
const REQUESTS_PER_S: u32 = 50;
/// Time, in seconds, whose requests at the default rate make up the default burst.
const BURST_S: u32 = 4;

/// Limit of the rate of requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RateLimit {
    /// Long-term number of requests per second; at least 1.
    pub requests_per_s: u32,
    /// Number of requests at once after a pause; at least 1.
    pub burst: u32,
}

impl Http {
    /// URL scheme of the service: `https` or `http`.
    pub fn scheme(&self) -> &'static str {
        if self.tls.is_some() { "https" } else { "http" }
    }

    /// Whether only this machine can reach the service.
    pub fn is_local(&self) -> bool {
        self.listen.ip().to_canonical().is_loopback()
    }

    /// Rate limit per client address and per token; `None` means no limit.
    pub fn limit(&self) -> Option<RateLimit> {
        let burst = self.requests_burst;
        self.requests_per_s.map(|per_s| RateLimit { requests_per_s: per_s.get(), burst })
    }
}

impl ByHand for Http {
    fn more(&mut self, section: &mut Section<'_>) {
        if self.requests_per_s.is_none() {
            if let Some(item) = section.written("requests_burst") {
                item.refuse("with requests_per_s = 0 there is no limit; remove this key or set a rate");
            }
        } else if section.written("requests_burst").is_none() {
            self.requests_burst =
                self.limit().map_or(0, |limit| limit.requests_per_s.saturating_mul(BURST_S));
        }
        if self.auth == Auth::None && !self.is_local() && section.is_sound(&["auth"]) {
            section.contradict(
                &["listen"],
                "without authentication the service listens on a loopback address only; write 127.0.0.1, \
                 or auth = { mode = \"tokens\", tokens_file = … }",
            );
        }
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        entries.retain(|entry| entry.key != "requests_burst" || self.requests_per_s.is_some());
    }
}

section! {
    /// Raster map tiles from a server of the operator's choice.
    #[derive(Eq)]
    Tiles {
        /// URL of a tile, with `{z}`, `{x}` and `{y}`.
        url: String = need("url = \"https://host/{z}/{x}/{y}.png\""), text(
            "tiles are at https://host/… or http://host/…, with {z}, {x} and {y} in the path",
            |url| ["/{z}", "{x}", "{y}"].iter().all(|part| url.contains(part)) && is_origin(origin_of(url)),
        );
        /// Copyright notice of the tiles, shown on the map.
        attribution: String = String::new(), any_text();
    }
}

impl Tiles {
    /// Origin `https://host` of the tiles: the only one, besides the service, from which the page may load images.
    pub fn origin(&self) -> &str {
        origin_of(&self.url)
    }
}

section! {
    /// Certificate and key of the service. Paths are absolute after the configuration is read.
    #[derive(Eq)]
    TlsFiles {
        /// Certificate of the service followed by its issuers, PEM.
        certificate: PathBuf = need("certificate = …, the file of the certificate and its issuers"), beside();
        /// Private key of the service, PEM.
        key: PathBuf = need("key = …, the file of the certificate's private key"), beside();
    }
}

names! {
    /// Authentication of the HTTP service.
    #[derive(Eq)]
    Auth, "mode" {
        /// No authentication; on a loopback address only.
        None = "none",
        /// Clients authenticate with a bearer token.
        Tokens {
            /// File of token names, hashes and scopes (TOML), relative to the configuration file.
            tokens_file: PathBuf
        } = "tokens",
    }
}

fn authentication() -> Kind<Auth> {
    Kind::new("a table of the keys below", |item| {
        let mut section = item.section()?;
        let mode = section.need("mode", "mode = \"none\" or mode = \"tokens\"");
        let mut auth = mode.and_then(|item| (named().read)(&item))?;
        if let Auth::Tokens { tokens_file } = &mut auth {
            let item =
                section.need("tokens_file", "tokens_file = …, the file of the tokens' hashes and scopes");
            *tokens_file = item.and_then(|item| (beside().read)(&item)).unwrap_or_default();
        } else if let Some(item) = section.stray("tokens_file") {
            item.refuse(
                "without mode = \"tokens\" nobody reads this file; remove the key or change the mode",
            );
        }
        section.finish();
        Some(auth)
    })
}

impl Toml for Auth {
    fn toml(&self) -> Option<String> {
        let file = match self {
            Self::None => String::new(),
            Self::Tokens { tokens_file } => format!(", tokens_file = {}", tokens_file.toml()?),
        };
        Some(format!("{{ mode = \"{}\"{file} }}", self.name()))
    }

    fn keys() -> Vec<Row> {
        let about = "File of the bearer tokens: `name = { sha256 = \"64 hexadecimal digits\", scopes = [\"read\", \"stream\"] }`; \
                     with `mode = \"tokens\"`.";
        vec![
            Row::by_hand("mode", None, &named::<Self>().values, "Who may use the service."),
            Row::by_hand("tokens_file", None, &beside().values, about),
        ]
    }
}

/// Origin `https://host` of a URL.
fn origin_of(url: &str) -> &str {
    url.match_indices('/').nth(2).map_or(url, |(end, _)| &url[..end])
}

/// Whether `text` is `scheme://host[:port]`, as browsers write it.
fn is_origin(text: &str) -> bool {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://"));
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-.:[]".contains(c);
    host.is_some_and(|host| !host.is_empty() && host.chars().all(plain))
}

/// Whether `text` is a host name, not an IP address.
fn is_host(text: &str) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-._".contains(c);
    text.chars().all(plain) && text.parse::<Ipv4Addr>().is_err()
}
