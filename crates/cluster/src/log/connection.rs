//! Connection to the log's servers: certificates and credentials, and the reason if a server refuses them.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use async_nats::jetstream::Context;
use async_nats::jetstream::context::ContextBuilder;
use async_nats::{Client, ConnectOptions, Event, ServerError};
use futures_util::future::join_all;
use tokio::time::Instant;
use tracing::warn;

use super::{LogError, REQUEST_TIMEOUT};
use service::net::dial::Certificates;
use service::net::secret::secret;
use site::config::Cluster;

/// Time after which the same warning is logged again.
const WARNING_INTERVAL: Duration = Duration::from_secs(60);
/// Maximum number of different warnings logged within that time.
const MAX_WARNINGS: usize = 64;

/// Reads the certificates, keys and credentials, and checks that the client can use them.
///
/// # Errors
/// A file cannot be used. The error names the file and does not show its content.
pub fn check(cluster: &Cluster) -> Result<(), LogError> {
    options(cluster).map(drop)
}

/// Connects once to each server. Returns the reason of each failure.
pub async fn reach(cluster: &Cluster) -> Vec<(String, Result<(), String>)> {
    let tried = cluster.servers.iter().map(async |server| {
        let reached = match options(cluster) {
            Err(error) => Err(error.to_string()),
            Ok(options) => match options.ignore_discovered_servers().connect(server).await {
                Ok(_) => Ok(()),
                Err(error) => Err(explain(&error.to_string())),
            },
        };
        (server.clone(), reached)
    });
    join_all(tried).await
}

/// Connects, and retries for ever in the background. The reason of each failure is logged.
pub(super) async fn connect(cluster: &Cluster) -> Result<(Client, Context), LogError> {
    let (refused, failed) = (RecentWarnings::default(), RecentWarnings::default());
    let options = options(cluster)?
        .retry_on_initial_connect()
        .reconnect_delay_callback(|tries| Duration::from_millis(50 * tries.clamp(1, 10) as u64))
        // The client calls this before each round over all servers, with the errors of the last round. The callback selects no
        // server.
        .reconnect_to_server_callback(move |servers, _| {
            for server in servers {
                let Some(error) = &server.last_error else { continue };
                let why = explain(error);
                if failed.is_new(&format!("{server}{why}")) {
                    warn!(%server, why, "a server of the log cannot be connected to");
                }
            }
            async { None }
        })
        .event_callback(move |event| {
            if let Event::ServerError(ServerError::Other(what)) = event
                && refused.is_new(&what)
            {
                warn!(what, "the servers of the log refuse something");
            }
            async {}
        });
    let client = options.connect(&cluster.servers).await.map_err(unusable)?;
    let context =
        ContextBuilder::new().timeout(REQUEST_TIMEOUT).ack_timeout(REQUEST_TIMEOUT).build(client.clone());
    Ok((client, context))
}

/// Options of a connection. The client reads the certificates again at each connection, so they can be renewed.
fn options(cluster: &Cluster) -> Result<ConnectOptions, LogError> {
    let Cluster { ca, certificate, key, credentials, nkey, .. } = cluster;
    let proofs = Certificates {
        ca: ca.as_deref(),
        own: certificate.as_deref().zip(key.as_deref()),
        ..Certificates::default()
    };
    proofs.check().map_err(unusable)?;
    let mut options = ConnectOptions::new()
        .name(format!("utm-fusion {}", cluster.node))
        .connection_timeout(REQUEST_TIMEOUT)
        .ping_interval(REQUEST_TIMEOUT)
        .request_timeout(Some(REQUEST_TIMEOUT))
        .custom_inbox_prefix(cluster.inbox())
        .require_tls(cluster.requires_tls());
    if let Some(ca) = ca {
        options = options.add_root_certificates(ca.clone());
    }
    if let Some((certificate, key)) = certificate.clone().zip(key.clone()) {
        options = options.add_client_certificate(certificate, key);
    }
    let text = |file: &Path| secret(Some(file), None).map(Option::unwrap_or_default).map_err(unusable);
    if let Some(file) = credentials {
        let refuse = |error| unusable(format!("{}: {error}", file.display()));
        options = options.credentials(&text(file)?).map_err(refuse)?;
    }
    if let Some(file) = nkey {
        let seed = text(file)?;
        if !is_seed(&seed) {
            let what = "holds no seed of a user's NKEY, which is one line that begins with SU";
            return Err(unusable(format!("{}: {what}; nk -gen user makes one", file.display())));
        }
        options = options.nkey(seed);
    }
    Ok(options)
}

/// Whether the text is a user's seed. The client checks a seed only as a part of credentials.
fn is_seed(text: &str) -> bool {
    let part = |name: &str, text: &str| format!("-----BEGIN {name}-----\n{text}\n------END {name}------\n\n");
    let credentials = part("NATS USER JWT", "none") + &part("USER NKEY SEED", text);
    text.starts_with("SU") && ConnectOptions::new().credentials(&credentials).is_ok()
}

fn unusable(error: impl Display) -> LogError {
    LogError::Unusable(error.to_string())
}

/// Reason why a connection failed, with a hint if the client's text is too short.
fn explain(error: &str) -> String {
    const HINTS: [(&[&str], &str); 5] = [
        (
            // Two authorities with the same name differ in their signatures.
            &["UnknownIssuer", "BadSignature"],
            "the server's certificate is not issued by one of cluster.ca, or without that key by one that this machine trusts",
        ),
        (
            &["Expired", "expired", "NotValidYet", "not valid yet"],
            "the dates of the server's certificate are wrong, or this machine's clock is",
        ),
        (
            &["CertificateRequired", "BadCertificate", "UnknownCA", "CertificateUnknown", "AccessDenied"],
            "the server does not take the certificate of this process, or wants one: cluster.certificate and cluster.key",
        ),
        (
            &["authorization violation"],
            "the server knows no user of this certificate, these credentials or this nkey",
        ),
        (&["InvalidMessage", "InvalidContentType"], "the server does not speak TLS"),
    ];
    let is_of = |(parts, _): &&(&[&str], &str)| parts.iter().any(|part| error.contains(part));
    HINTS.iter().find(is_of).map_or_else(|| error.to_owned(), |(_, hint)| format!("{hint} ({error})"))
}

/// Warnings of the last minute, with their times.
#[derive(Debug, Default)]
struct RecentWarnings(Mutex<BTreeMap<String, Instant>>);

impl RecentWarnings {
    /// Whether this warning was not logged within the last minute.
    fn is_new(&self, what: &str) -> bool {
        let (mut known, now) = (self.0.lock().unwrap_or_else(PoisonError::into_inner), Instant::now());
        known.retain(|_, at| now - *at < WARNING_INTERVAL);
        let is_new = known.len() < MAX_WARNINGS && !known.contains_key(what);
        if is_new {
            known.insert(what.to_owned(), now);
        }
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warning_is_logged_once_and_at_most_64_at_a_time() {
        let complaints = RecentWarnings::default();
        assert!(complaints.is_new("0") && !complaints.is_new("0"));
        let told = (1..100).filter(|number| complaints.is_new(&number.to_string())).count();
        assert_eq!(told, MAX_WARNINGS - 1);
    }

    #[test]
    fn invalid_user_seed_is_rejected() {
        for text in ["", "SU", "UAAAAAAA", "SUAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"] {
            assert!(!is_seed(text), "{text}");
        }
    }
}
