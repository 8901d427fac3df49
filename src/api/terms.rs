//! What may change while the service runs: who may ask, how often, from which pages, under which names; and the areas
//! that are shown.

use std::num::NonZeroU32;

use super::auth::Tokens;
use super::{StartError, sites};
use crate::areas::Areas;
use crate::config::{Auth, Config, Network, RateLimit};

/// The terms that requests are answered on.
pub struct Terms {
    /// `None`: everybody may ask.
    pub(super) tokens: Option<Tokens>,
    pub(super) cors: Vec<String>,
    pub(super) limit: Option<RateLimit>,
    /// Of one address; `None`: as many as there are.
    pub(super) connections: Option<NonZeroU32>,
    pub(super) hosts: Vec<String>,
    pub(super) trusted_proxies: Vec<Network>,
    /// GeoJSON.
    pub(super) areas: Vec<u8>,
    pub(super) coverage: Vec<u8>,
}

impl Terms {
    /// Those of a configuration, whose areas have been read; the tokens are read now.
    ///
    /// # Errors
    /// The file of the tokens cannot be used.
    pub fn load(config: &Config, areas: &Areas) -> Result<Self, StartError> {
        let tokens = match &config.http.auth {
            Auth::None => None,
            Auth::Tokens { tokens_file } => Some(Tokens::load(tokens_file)?),
        };
        Ok(Self {
            tokens,
            cors: config.http.cors.clone(),
            limit: config.http.limit,
            connections: config.http.connections_per_address,
            hosts: config.http.hosts.clone(),
            trusted_proxies: config.http.trusted_proxies.clone(),
            areas: sites::areas_json(areas),
            coverage: sites::coverage_json(&config.sensors, areas),
        })
    }

    /// How many tokens are accepted; `None`: none is asked for.
    pub fn tokens(&self) -> Option<usize> {
        self.tokens.as_ref().map(Tokens::count)
    }
}
