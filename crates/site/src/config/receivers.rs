//! `[[alerts.webhooks]]` and `[alerts.mqtt]`, receivers of alerts; `[[output.mqtt]]`, brokers that receive tracks.

use std::path::PathBuf;

use axum::http::Uri;
use jiff::SignedDuration;

use super::alerts::{AlertKind, Severity};
use super::network::PictureKind;
use tables::kinds::{any_text, beside, flag, is_plain, list, named, parsed, seconds, text, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, absent, depends, need};

section! {
    /// An HTTP server to which every alert is posted.
    #[derive(Eq)]
    Webhook {
        /// Name of the receiver in the log, in `/metrics` and in alerts.
        id: String = need("id = \"operations\", a name of the receiver"),
            text("an id is made of letters, digits, _ and -", is_plain);
        /// URL to which notices are posted.
        url: Uri = need("url = \"https://host/path\""), parsed("https://host/path or http://host/path", address);
        /// File that contains the secret for signing notices.
        secret_file: Option<PathBuf> = absent("none: without a secret notices are not signed"), beside();
        /// Environment variable that holds the secret, instead of a file.
        secret_env: Option<String> = absent("none"), variable();
        /// File that contains the value of the `Authorization` header.
        authorization_file: Option<PathBuf> = absent("none: the header is not sent"), beside();
        /// Certificates of the issuers of the receiver's certificate, PEM.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// Kinds of alerts that are sent.
        kinds: Option<Vec<AlertKind>> = absent("all"), list(named());
        /// Minimum severity of the alerts that are sent.
        min_severity: Severity = Severity::Warning, named();
        /// Timeout of an attempt, in seconds.
        timeout_s: SignedDuration = SignedDuration::from_secs(10),
            seconds("a timeout is between 0.1 and 60 seconds", |s| (0.1..=60.0).contains(&s));
    } by hand {}
}

section! {
    /// An MQTT 5 broker to which alerts are published.
    #[derive(Eq)]
    Mqtt {
        /// Host name or IP address of the broker.
        host: String = need("host = \"broker.example\""),
            text("a host is a name or an address, without scheme and port", is_host);
        /// Port of the broker.
        port: u16 = depends("8883 with `tls`, else 1883", PORT), whole("a port is a whole number, 1 to 65535", 1..=65_535);
        /// Whether the connection uses TLS.
        tls: bool = false, flag();
        /// Certificates of the issuers of the broker's certificate, PEM; with `tls`.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// User name at the broker.
        username: Option<String> = absent("nobody"), any_text();
        /// File that contains the password.
        password_file: Option<PathBuf> = absent("none"), beside();
        /// Environment variable that holds the password, instead of a file.
        password_env: Option<String> = absent("none"), variable();
        /// Client id at the broker. Two clients with the same id disconnect each other.
        client_id: Option<String> = absent("`utm-fusion-` with SAC and SIC of the site"),
            text("a client id is made of letters, digits, _ and -", is_plain);
        /// First levels of all topics, unique to this service.
        prefix: String = "utm-fusion".to_owned(), text(
            "a prefix is made of names with / between them, without +, # and a $ at its beginning",
            is_prefix,
        );
        /// Kinds of alerts that are published.
        kinds: Option<Vec<AlertKind>> = absent("all"), list(named());
        /// Minimum severity of the alerts that are published.
        min_severity: Severity = Severity::Warning, named();
    } by hand {}
}

section! {
    /// An MQTT 5 broker that receives the tracks (docs/OUTPUTS.md).
    #[derive(Eq)]
    MqttTracks {
        /// Name of the broker in the log, in `/metrics` and in alerts.
        id: String = need("id = \"broker\", a name of the receiver"),
            text("an id is made of letters, digits, _ and -", is_plain);
        /// Host name or IP address of the broker.
        host: String = need("host = \"broker.example\""),
            text("a host is a name or an address, without scheme and port", is_host);
        /// Port of the broker.
        port: u16 = depends("8883 with `tls`, else 1883", PORT), whole("a port is a whole number, 1 to 65535", 1..=65_535);
        /// Whether the connection uses TLS.
        tls: bool = false, flag();
        /// Certificates of the issuers of the broker's certificate, PEM; with `tls`.
        ca: Option<PathBuf> = absent("those that this machine trusts"), beside();
        /// User name at the broker.
        username: Option<String> = absent("none"), any_text();
        /// File that contains the password.
        password_file: Option<PathBuf> = absent("none"), beside();
        /// Environment variable that holds the password, instead of a file.
        password_env: Option<String> = absent("none"), variable();
        /// Client id at the broker. Two clients with the same id disconnect each other.
        client_id: Option<String> = absent("`utm-fusion-` with SAC and SIC of the site and `id`"),
            text("a client id is made of letters, digits, _ and -", is_plain);
        /// First levels of all topics, unique to this service. Tracks are published to `<prefix>/tracks/<id of the track>`.
        prefix: String = "utm-fusion".to_owned(), text(
            "a prefix is made of names with / between them, without +, # and a $ at its beginning",
            is_prefix,
        );
        /// Whether the broker retains the last message of each track for new subscribers. It expires after 10 s.
        retain: bool = false, flag();
        /// Picture to send. `now` needs `fusion.now`.
        picture: PictureKind = PictureKind::Lagged, named();
    } by hand {}
}

impl ByHand for MqttTracks {
    fn more(&mut self, section: &mut Section<'_>) {
        if section.written("port").is_none() {
            self.port = if self.tls { TLS_PORT } else { PORT };
        }
        let has_both = self.password_file.is_some() && self.password_env.is_some();
        broker_keys(section, self.tls, self.ca.is_some(), self.username.is_some(), has_both);
    }
}

/// Rejects keys of a broker that contradict each other.
fn broker_keys(section: &Section<'_>, tls: bool, has_ca: bool, has_username: bool, has_both_passwords: bool) {
    one_place(section, has_both_passwords, &["password_env"]);
    if has_ca && !tls {
        section.contradict(&["ca"], "nobody proves anything without tls = true; add it, or remove the key");
    }
    if !has_username {
        let message = "a password belongs to a username; add it, or remove the key";
        section.contradict(&["password_file", "password_env"], message);
    }
}

/// Registered port of MQTT.
const PORT: u16 = 1883;
/// Registered port of MQTT over TLS.
const TLS_PORT: u16 = 8883;

impl Webhook {
    /// Whether the transport is encrypted.
    pub fn is_tls(&self) -> bool {
        self.url.scheme_str() == Some("https")
    }
}

/// Rejects a secret from two places, an empty list of kinds, and `ca` without TLS.
impl ByHand for Webhook {
    fn more(&mut self, section: &mut Section<'_>) {
        one_place(section, self.secret_file.is_some() && self.secret_env.is_some(), &["secret_env"]);
        some_kinds(section, self.kinds.as_deref());
        if self.ca.is_some() && !self.is_tls() && section.is_sound(&["url"]) {
            section
                .contradict(&["ca"], "nobody proves anything over http; write https://, or remove the key");
        }
    }
}

/// Sets the default port, and rejects an empty list of kinds and keys that contradict each other.
impl ByHand for Mqtt {
    fn more(&mut self, section: &mut Section<'_>) {
        if section.written("port").is_none() {
            self.port = if self.tls { TLS_PORT } else { PORT };
        }
        some_kinds(section, self.kinds.as_deref());
        let has_both = self.password_file.is_some() && self.password_env.is_some();
        broker_keys(section, self.tls, self.ca.is_some(), self.username.is_some(), has_both);
    }
}

fn one_place(section: &Section<'_>, has_both: bool, names: &[&str]) {
    if has_both {
        section.contradict(names, "there is a file of it too; remove one of the two keys");
    }
}

fn some_kinds(section: &Section<'_>, kinds: Option<&[AlertKind]>) {
    if kinds.is_some_and(<[_]>::is_empty) {
        section
            .contradict(&["kinds"], "nothing would ever be sent; name some kinds, or remove the key for all");
    }
}

fn variable() -> tables::kinds::Kind<String> {
    text("the name of a variable is made of letters, digits and _", |name| {
        name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    })
}

pub(super) fn address(text: &str) -> Result<Uri, &'static str> {
    const RULE: &str = "expected https://host/path or http://host/path";
    let uri: Uri = text.parse().map_err(|_| RULE)?;
    let host = uri.host().filter(|host| !host.is_empty()).ok_or(RULE)?;
    if !matches!(uri.scheme_str(), Some("http" | "https")) {
        return Err(RULE);
    }
    // The URL contains a user name and a password.
    if uri.authority().is_some_and(|authority| authority.as_str().contains('@')) || host.contains('@') {
        return Err(
            "no password belongs into this file; authorization_file or token_file names one that holds it",
        );
    }
    Ok(uri)
}

fn is_host(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_alphanumeric() || "-._:".contains(c))
}

fn is_prefix(text: &str) -> bool {
    let is_name = |name: &str| !name.is_empty() && !name.chars().any(|c| "+#".contains(c) || c.is_control());
    !text.starts_with('$') && text.len() <= 200 && text.split('/').all(is_name)
}
