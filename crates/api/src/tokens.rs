//! Bearer tokens, of which only the SHA-256 is stored, and tickets for browsers.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use axum::http::StatusCode;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;
use tokio::time::Instant;

use super::error::StartError;
use super::problem::Problem;

/// Validity of a ticket.
pub const TICKET: Duration = Duration::from_secs(30);
/// Maximum number of unused tickets.
const TICKETS: usize = 4_096;

/// Permission of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scope {
    /// Read data.
    Read,
    /// Open streams.
    Stream,
    /// Control a replay, and make decisions: which radar track belongs to which transponder, and what to do about an alert.
    Control,
    /// Post data of a receiver.
    Input,
}

impl Scope {
    /// Name in the file of tokens.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Stream => "stream",
            Self::Control => "control",
            Self::Input => "input",
        }
    }
}

/// SHA-256 of a token or a ticket.
pub type Hash = [u8; 32];

/// The accepted tokens.
pub struct Tokens(Vec<Token>);

struct Token {
    /// Name in the file.
    name: String,
    hash: Hash,
    scopes: Vec<Scope>,
}

/// Token of a request; `None` if none was required.
#[derive(Clone, Copy, Debug, Default)]
pub struct Credential(pub Option<Hash>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenEntry {
    sha256: String,
    scopes: Vec<Scope>,
}

impl Tokens {
    /// Reads the file: `name = { sha256 = "…", scopes = ["read", "stream"] }`, one line per token.
    pub fn load(file: &Path) -> Result<Self, StartError> {
        let refuse = |problem: String| StartError::Tokens { file: file.to_owned(), problem };
        #[expect(clippy::disallowed_methods, reason = "the one place that reads tokens")]
        let text = std::fs::read_to_string(file)
            .map_err(|error| refuse(format!("the tokens cannot be read: {error}")))?;
        Self::parse(&text).map_err(refuse)
    }

    fn parse(text: &str) -> Result<Self, String> {
        // The text of the TOML error would show the line, and with it a hash.
        let entries: BTreeMap<String, TokenEntry> = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| text[..span.start].lines().count().max(1));
            format!("line {line}: {}; write name = {{ sha256 = \"…\", scopes = [\"read\", \"stream\", \"control\"] }}", error.message())
        })?;
        if entries.is_empty() {
            return Err("holds no token: nobody could use the service".to_owned());
        }
        let token = |(name, entry): (String, TokenEntry)| {
            let hash =
                input::hex::octets(&entry.sha256).and_then(|hash| hash.try_into().ok()).ok_or_else(|| {
                    format!("{name}: sha256 is not 64 hexadecimal digits, as sha256sum prints them")
                })?;
            Ok(Token { name, hash, scopes: entry.scopes })
        };
        entries.into_iter().map(token).collect::<Result<_, String>>().map(Self)
    }

    /// Number of tokens.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Scopes of a token; `None` if it is unknown. All hashes are compared, each in constant time.
    pub fn scopes(&self, token: &Hash) -> Option<&[Scope]> {
        self.find(token).map(|token| &token.scopes[..])
    }

    /// Name of a token in the file.
    pub fn name(&self, token: &Hash) -> Option<&str> {
        self.find(token).map(|token| token.name.as_str())
    }

    fn find(&self, token: &Hash) -> Option<&Token> {
        self.0
            .iter()
            .fold(None, |found, known| if known.hash.ct_eq(token).into() { Some(known) } else { found })
    }
}

/// Hash of a token or a ticket.
pub fn hash(secret: &str) -> Hash {
    Sha256::digest(secret.as_bytes()).into()
}

/// Issued and unused tickets, oldest first. Only their hashes are stored.
#[derive(Debug, Default)]
pub struct Tickets(Mutex<VecDeque<IssuedTicket>>);

#[derive(Debug)]
struct IssuedTicket {
    issued: Instant,
    hash: Hash,
    /// Token for which the ticket was issued. The ticket gives the same access.
    credential: Credential,
}

impl Tickets {
    /// Issues a ticket for the holder of this pass.
    ///
    /// # Errors
    /// No random numbers are available, or too many tickets are unused.
    pub fn issue(&self, credential: Credential) -> Result<String, Problem> {
        let mut octets = [0; 24];
        getrandom::fill(&mut octets)
            .map_err(|error| Problem::unavailable(format!("there is no randomness: {error}"), Vec::new()))?;
        let ticket = input::hex::text(&octets);
        let mut tickets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        forget(&mut tickets);
        if tickets.len() >= TICKETS {
            return Err(Problem::new(StatusCode::TOO_MANY_REQUESTS, "too many tickets wait to be used")
                .retry_after_s(TICKET.as_secs() as u32));
        }
        tickets.push_back(IssuedTicket { issued: Instant::now(), hash: hash(&ticket), credential });
        Ok(ticket)
    }

    /// Uses a ticket once; `None` if it is invalid.
    pub fn redeem(&self, ticket: &str) -> Option<Credential> {
        let hash = hash(ticket);
        let mut tickets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        forget(&mut tickets);
        let place = tickets.iter().position(|ticket| ticket.hash.ct_eq(&hash).into())?;
        tickets.remove(place).map(|ticket| ticket.credential)
    }
}

fn forget(tickets: &mut VecDeque<IssuedTicket>) {
    while tickets.front().is_some_and(|ticket| ticket.issued.elapsed() > TICKET) {
        tickets.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn token_file_errors_give_the_reason_without_the_hash() {
        let hash = "2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b"; // SHA-256 of "secret"
        let tokens =
            Tokens::parse(&format!("desk = {{ sha256 = \"{hash}\", scopes = [\"read\"] }}")).unwrap();
        assert_eq!(tokens.scopes(&super::hash("secret")), Some(&[Scope::Read][..]));
        assert_eq!(tokens.scopes(&super::hash("Secret")), None);
        for (text, part) in [
            (String::new(), "no token"),
            ("desk = 1".to_owned(), "line 1"),
            (format!("desk = {{ sha256 = \"{hash}\", scopes = [\"all\"] }}"), "line 1"),
            ("desk = { sha256 = \"12\", scopes = [] }".to_owned(), "desk: sha256"),
            (format!("desk = {{ sha256 = \"{}é\", scopes = [] }}", &hash[..62]), "desk: sha256"),
        ] {
            let Err(problem) = Tokens::parse(&text) else { panic!("{text} is accepted") };
            assert!(problem.contains(part) && !problem.contains(&hash[..20]), "{text}: {problem}");
        }
    }
}
