//! What may change while the service runs: who may ask, how often, from which pages, under which names; and the areas
//! that are shown.

use std::num::NonZeroU32;

use serde::Serialize;

use super::error::StartError;
use super::ground;
use super::tls::Tls;
use super::tokens::{Pass, Scope, Tokens};
use crate::areas::Areas;
use crate::config::{Auth, Config, Network, RateLimit};
use fusion::time::Time;

/// The terms that requests are answered on.
pub struct Terms {
    /// `None`: plain HTTP.
    pub(super) tls: Option<Tls>,
    /// Whether tokens can be overheard: they travel between machines, and neither the service nor a proxy encrypts them.
    overheard: bool,
    /// `None`: everybody may ask.
    pub(super) tokens: Option<Tokens>,
    pub(super) cors: Vec<String>,
    pub(super) limit: Option<RateLimit>,
    /// Of one address; `None`: as many as there are.
    pub(super) connections: Option<NonZeroU32>,
    pub(super) hosts: Vec<String>,
    pub(super) trusted_proxies: Vec<Network>,
    /// Which of them are in force changes with the time.
    pub(super) areas: Areas,
    /// GeoJSON.
    pub(super) coverage: Vec<u8>,
}

/// As JSON.
fn octets(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("texts, numbers and lists are written to memory without failing")
}

impl Terms {
    /// Those of a configuration, whose areas have been read; tokens, certificate and key are read now.
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

    /// What works, and should be changed.
    pub fn warnings(&self, now: Time) -> Vec<String> {
        let overheard = self.overheard.then(|| {
            "http.listen: tokens travel beyond this machine without TLS, and whoever hears them can use them; set \
             http.tls, or listen on 127.0.0.1 behind a reverse proxy that encrypts"
                .to_owned()
        });
        overheard.into_iter().chain(self.tls.as_ref().and_then(|tls| tls.warning(now))).collect()
    }

    /// How many tokens are accepted; `None`: none is asked for.
    pub fn tokens(&self) -> Option<usize> {
        self.tokens.as_ref().map(Tokens::count)
    }

    /// Whether this pass may have a stream: also asked while it is open.
    pub(super) fn may_stream(&self, pass: Pass) -> bool {
        self.may(pass, Scope::Stream)
    }

    /// Whether this pass has the scope.
    pub(super) fn may(&self, pass: Pass, scope: Scope) -> bool {
        self.tokens.as_ref().is_none_or(|tokens| {
            let scopes = pass.0.and_then(|token| tokens.scopes(&token));
            scopes.is_some_and(|scopes| scopes.contains(&scope))
        })
    }

    /// The name of the token; `None` where none was asked for.
    pub(super) fn name_of(&self, pass: Pass) -> Option<&str> {
        self.tokens.as_ref()?.name(&pass.0?)
    }
}
