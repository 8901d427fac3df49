//! Settings of the API that may change while the service runs: access, limits, origins, host names, and the areas shown.

use std::num::NonZeroU32;

use serde::Serialize;

use super::error::StartError;
use super::ground;
use super::tls::Tls;
use super::tokens::{Credential, Scope, Tokens};
use fusion::time::Time;
use site::areas::Areas;
use site::config::{Auth, Config, Network, RateLimit};

/// Access settings, and areas.
pub struct AccessSettings {
    /// TLS; `None` for plain HTTP.
    pub(super) tls: Option<Tls>,
    /// Whether tokens can be intercepted: they pass between machines without encryption by the service or a proxy.
    overheard: bool,
    /// Accepted tokens; `None` if none is required.
    pub(super) tokens: Option<Tokens>,
    pub(super) cors: Vec<String>,
    pub(super) limit: Option<RateLimit>,
    /// Maximum number of connections per client address; `None` means no limit.
    pub(super) connections: Option<NonZeroU32>,
    pub(super) hosts: Vec<String>,
    pub(super) trusted_proxies: Vec<Network>,
    /// Areas; which of them are in force changes with time.
    pub(super) areas: Areas,
    /// Coverage as GeoJSON.
    pub(super) coverage: Vec<u8>,
}

/// Value as JSON.
fn octets(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("texts, numbers and lists are written to memory without failing")
}

impl AccessSettings {
    /// Access settings of a configuration whose areas have been read. Reads tokens, certificate and key.
    ///
    /// # Errors
    /// The file of the tokens, of the certificate or of the key cannot be used.
    pub fn load(config: &Config, areas: &Areas) -> Result<Self, StartError> {
        let tokens = match &config.http.auth {
            Auth::None => None,
            Auth::Tokens { tokens_file } => Some(Tokens::load(tokens_file)?),
        };
        let http = &config.http;
        Ok(Self {
            tls: http.tls.as_ref().map(Tls::load).transpose()?,
            overheard: tokens.is_some()
                && !http.is_local()
                && http.tls.is_none()
                && http.trusted_proxies.is_empty(),
            tokens,
            cors: config.http.cors.clone(),
            limit: config.http.limit(),
            connections: config.http.connections_per_address,
            hosts: config.http.hosts.clone(),
            trusted_proxies: config.http.trusted_proxies.clone(),
            areas: areas.clone(),
            coverage: octets(&ground::coverage(&config.sensors, areas)),
        })
    }

    /// Warnings about settings that work but should be changed.
    pub fn warnings(&self, now: Time) -> Vec<String> {
        let overheard = self.overheard.then(|| {
            "http.listen: tokens travel beyond this machine without TLS, and whoever hears them can use them; set \
             http.tls, or listen on 127.0.0.1 behind a reverse proxy that encrypts"
                .to_owned()
        });
        overheard.into_iter().chain(self.tls.as_ref().and_then(|tls| tls.warning(now))).collect()
    }

    /// Number of accepted tokens; `None` if none is required.
    pub fn tokens(&self) -> Option<usize> {
        self.tokens.as_ref().map(Tokens::count)
    }

    /// Whether this pass may have a stream; checked again while the stream is open.
    pub(super) fn may_stream(&self, credential: Credential) -> bool {
        self.may(credential, Scope::Stream)
    }

    /// Whether this pass has the scope.
    pub(super) fn may(&self, credential: Credential, scope: Scope) -> bool {
        self.tokens.as_ref().is_none_or(|tokens| {
            let scopes = credential.0.and_then(|token| tokens.scopes(&token));
            scopes.is_some_and(|scopes| scopes.contains(&scope))
        })
    }

    /// Name of the token; `None` if none was required.
    pub(super) fn token_name(&self, credential: Credential) -> Option<&str> {
        self.tokens.as_ref()?.name(&credential.0?)
    }
}
