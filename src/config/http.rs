//! `[http]`: the HTTP service.

use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::path::{self, Path, PathBuf};

use super::cidr::Network;
use super::reader::{Item, Section};

/// `[http]`: the HTTP service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Http {
    /// Address and port; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Certificate and key; `None`: plain HTTP.
    pub tls: Option<TlsFiles>,
    /// Who may use it.
    pub auth: Auth,
    /// Origins whose pages may use it from a browser, beside its own.
    pub cors: Vec<String>,
    /// How often one address, and one token, may ask; `None`: as often as it likes.
    pub limit: Option<RateLimit>,
    /// Connections that one address may have open; `None`: as many as there are.
    pub connections_per_address: Option<NonZeroU32>,
    /// Names under which it is reached, lower case, beside addresses and `localhost`.
    pub hosts: Vec<String>,
    /// Reverse proxies: whose word on the client's address is believed.
    pub trusted_proxies: Vec<Network>,
    /// What lies under the map; `None`: the page asks nobody but this service.
    pub tiles: Option<Tiles>,
}

/// That of an empty section.
impl Default for Http {
    fn default() -> Self {
        Self {
            listen: (Ipv4Addr::LOCALHOST, 8080).into(),
            tls: None,
            auth: Auth::None,
            cors: Vec::new(),
            limit: Some(RateLimit::default()),
            connections_per_address: Some(CONNECTIONS_PER_ADDRESS),
            hosts: Vec::new(),
            trusted_proxies: Vec::new(),
            tiles: None,
        }
    }
}

impl Http {
    /// `https` or `http`.
    pub fn scheme(&self) -> &'static str {
        if self.tls.is_some() { "https" } else { "http" }
    }

    /// Whether only this machine can reach it.
    pub fn is_local(&self) -> bool {
        self.listen.ip().to_canonical().is_loopback()
    }
}

/// What an address has open unless the configuration says otherwise: the map in ten tabs, over HTTP/1.1.
const CONNECTIONS_PER_ADDRESS: NonZeroU32 = NonZeroU32::new(64).unwrap();

/// How often one may ask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RateLimit {
    /// In the long run; at least 1.
    pub requests_per_s: u32,
    /// At once, by one who was silent; at least 1.
    pub burst: u32,
}

/// Far beyond what the page and dashboards that poll come to.
impl Default for RateLimit {
    fn default() -> Self {
        Self { requests_per_s: 50, burst: 200 }
    }
}

/// Map tiles of a server of the user's choice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tiles {
    /// `https://host/…` with `{z}`, `{x}`, `{y}`: Web Mercator.
    pub url: String,
    /// Whose they are; shown on the map.
    pub attribution: String,
}

impl Tiles {
    /// `https://host`: the one place beside the service that the page may load pictures from.
    pub fn origin(&self) -> &str {
        self.url.match_indices('/').nth(2).map_or(&*self.url, |(end, _)| &self.url[..end])
    }
}

/// What the service proves itself with; absolute paths (in the file they are relative to the configuration).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TlsFiles {
    /// Its certificate and those that issued it, PEM.
    pub certificate: PathBuf,
    /// Its private key, PEM.
    pub key: PathBuf,
}

/// Who may use the HTTP service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Auth {
    /// Everybody; on a loopback address only.
    None,
    /// Holders of a bearer token.
    Tokens {
        /// Their names, hashes and scopes (TOML); an absolute path (in the file it is relative to the configuration).
        tokens_file: PathBuf,
    },
}

pub(super) fn read_http(mut section: Section<'_>, config: &Path) -> Option<Http> {
    let listen_item = section.item("listen");
    let usual = Http::default();
    let listen = listen_item.as_ref().map_or(Some(usual.listen), |item| {
        let listen = item.text()?.parse().ok();
        if listen.is_none() {
            item.refuse(
                "expected an address and a port, such as \"127.0.0.1:8080\"; names are not looked up",
            );
        }
        listen
    });
    let auth = section.item("auth").map(|item| read_auth(item.section()?, config));
    let tls = section.item("tls").map(|item| read_tls(item.section()?, config));
    let cors = read_list(section.item("cors"), read_origin);
    let limit = read_limit(&mut section);
    let connections = section.item("connections_per_address").map(|item| {
        let rule = "connections of one address are a whole number, 0 (no limit) to 1000000";
        item.whole(0..=1_000_000u32, rule).map(NonZeroU32::new)
    });
    let hosts = read_list(section.item("hosts"), read_host);
    let trusted_proxies = read_list(section.item("trusted_proxies"), read_network);
    let tiles = section.item("tiles").map(|item| read_tiles(item.section()?));
    section.finish();
    let http = Http {
        listen: listen?,
        auth: auth.unwrap_or(Some(usual.auth))?,
        tls: tls.map_or(Some(None), |tls| tls.map(Some))?,
        cors: cors?,
        limit: limit?,
        connections_per_address: connections.unwrap_or(Some(usual.connections_per_address))?,
        hosts: hosts?,
        trusted_proxies: trusted_proxies?,
        tiles: tiles.map_or(Some(None), |tiles| tiles.map(Some))?,
    };
    if let (Auth::None, false, Some(item)) = (&http.auth, http.is_local(), listen_item) {
        item.refuse(
            "without authentication the service listens on a loopback address only; write 127.0.0.1, \
             or auth = { mode = \"tokens\", tokens_file = … }",
        );
    }
    Some(http)
}

/// `requests_per_s` and `requests_burst`.
fn read_limit(section: &mut Section<'_>) -> Option<Option<RateLimit>> {
    const RULE: &str = "requests a second of one address are a whole number, 0 (no limit) to 1000000";
    let usual = RateLimit::default();
    let requests_per_s = section
        .item("requests_per_s")
        .map_or(Some(usual.requests_per_s), |i| i.whole(0..=1_000_000u32, RULE));
    if requests_per_s == Some(0) {
        if let Some(item) = section.stray("requests_burst") {
            item.refuse("with requests_per_s = 0 there is no limit; remove this key or set a rate");
        }
        return Some(None);
    }
    let rule = "requests at once are a whole number, 1 to 1000000";
    let burst = section.item("requests_burst").map(|item| item.whole(1..=1_000_000u32, rule));
    let requests_per_s = requests_per_s?;
    // As the defaults are to each other: four seconds' worth.
    let burst = burst.unwrap_or(Some(requests_per_s.saturating_mul(usual.burst / usual.requests_per_s)))?;
    Some(Some(RateLimit { requests_per_s, burst }))
}

fn read_auth(mut section: Section<'_>, config: &Path) -> Option<Auth> {
    let mode = section.need("mode", "mode = \"none\" or mode = \"tokens\"");
    let mode = mode.and_then(|item| item.word(&[("none", false), ("tokens", true)]));
    let auth = match mode {
        Some(true) => section
            .need("tokens_file", "tokens_file = …, the file of the tokens' hashes and scopes")
            .and_then(|item| Some(Auth::Tokens { tokens_file: beside(config, &item)? })),
        Some(false) => {
            if let Some(item) = section.stray("tokens_file") {
                item.refuse(
                    "without mode = \"tokens\" nobody reads this file; remove the key or change the mode",
                );
            }
            Some(Auth::None)
        }
        None => {
            section.abandon();
            None
        }
    };
    section.finish();
    auth
}

fn read_tls(mut section: Section<'_>, config: &Path) -> Option<TlsFiles> {
    let certificate =
        section.need("certificate", "certificate = …, the file of the certificate and its issuers");
    let certificate = certificate.and_then(|item| beside(config, &item));
    let key = section.need("key", "key = …, the file of the certificate's private key");
    let key = key.and_then(|item| beside(config, &item));
    section.finish();
    Some(TlsFiles { certificate: certificate?, key: key? })
}

/// A path that is relative to the configuration.
fn beside(config: &Path, item: &Item<'_>) -> Option<PathBuf> {
    let written = config.parent().unwrap_or(Path::new("")).join(item.text()?);
    Some(path::absolute(&written).unwrap_or(written))
}

fn read_tiles(mut section: Section<'_>) -> Option<Tiles> {
    let url = section.need("url", "url = \"https://host/{z}/{x}/{y}.png\"").and_then(|item| {
        let tiles = Tiles { url: item.text()?.to_owned(), attribution: String::new() };
        let whole = ["/{z}", "{x}", "{y}"].iter().all(|part| tiles.url.contains(part));
        if !whole || !is_origin(tiles.origin()) {
            item.refuse("tiles are at https://host/… or http://host/…, with {z}, {x} and {y} in the path");
        }
        Some(tiles.url)
    });
    let attribution = section.item("attribution").map(|item| Some(item.text()?.to_owned()));
    section.finish();
    Some(Tiles { url: url?, attribution: attribution.unwrap_or(Some(String::new()))? })
}

/// Whether it is `scheme://host[:port]`, as a browser writes it.
fn is_origin(text: &str) -> bool {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://"));
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-.:[]".contains(c);
    host.is_some_and(|host| !host.is_empty() && host.chars().all(plain))
}

fn read_origin(item: &Item<'_>) -> Option<String> {
    let text = item.text()?;
    if !is_origin(text) {
        item.refuse(
            "an origin is https://host or http://host, in lower case, with :port where it is no usual one",
        );
    }
    Some(text.to_owned())
}

/// Each entry as `read` reads it; an absent list is empty.
fn read_list<T>(list: Option<Item<'_>>, read: impl Fn(&Item<'_>) -> Option<T>) -> Option<Vec<T>> {
    let Some(list) = list else { return Some(Vec::new()) };
    // Every entry is read, also after a failure, before the failure shows.
    let read: Vec<_> = list.list()?.iter().map(read).collect();
    read.into_iter().collect()
}

fn read_host(item: &Item<'_>) -> Option<String> {
    let text = item.text()?;
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-._".contains(c);
    let is_name = text.chars().all(plain) && text.parse::<Ipv4Addr>().is_err();
    if !is_name {
        item.refuse(
            "a host is a name in lower case, such as \"fusion.example\", without scheme and port; \
             addresses and localhost are accepted anyway",
        );
    }
    is_name.then(|| text.to_owned())
}

fn read_network(item: &Item<'_>) -> Option<Network> {
    item.text()?.parse().map_err(|error| item.refuse(error)).ok()
}
