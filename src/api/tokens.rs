//! Bearer tokens, of which only the SHA-256 is kept, and tickets for browsers.

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

/// How long a ticket is valid.
pub const TICKET: Duration = Duration::from_secs(30);
/// Tickets that wait to be used.
const TICKETS: usize = 4_096;

/// What a token allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scope {
    /// To read.
    Read,
    /// To open streams.
    Stream,
    /// To steer a replay, and to decide: which radar track is which transponder, what to do about an alert.
    Control,
    /// To post what a receiver has heard.
    Input,
}

impl Scope {
    /// Its name in the file of tokens.
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

/// The tokens that are accepted.
pub struct Tokens(Vec<Token>);

struct Token {
    /// Its name in the file.
    name: String,
    hash: Hash,
    scopes: Vec<Scope>,
}

/// The token of a request; `None`: none was asked for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pass(pub Option<Hash>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    sha256: String,
    scopes: Vec<Scope>,
}

impl Tokens {
    /// Reads the file: `name = { sha256 = "…", scopes = ["read", "stream"] }`, a line per token.
    pub fn load(file: &Path) -> Result<Self, StartError> {
        let refuse = |problem: String| StartError::Tokens { file: file.to_owned(), problem };
        #[expect(clippy::disallowed_methods, reason = "the one place that reads tokens")]
        let text = std::fs::read_to_string(file)
            .map_err(|error| refuse(format!("the tokens cannot be read: {error}")))?;
        Self::parse(&text).map_err(refuse)
    }

    fn parse(text: &str) -> Result<Self, String> {
        // The error's own text would show the line, and with it a hash.
        let entries: BTreeMap<String, Entry> = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| text[..span.start].lines().count().max(1));
            format!("line {line}: {}; write name = {{ sha256 = \"…\", scopes = [\"read\", \"stream\", \"control\"] }}", error.message())
        })?;
        if entries.is_empty() {
            return Err("holds no token: nobody could use the service".to_owned());
        }
        let token = |(name, entry): (String, Entry)| {
            let hash =
                crate::hex::octets(&entry.sha256).and_then(|hash| hash.try_into().ok()).ok_or_else(|| {
                    format!("{name}: sha256 is not 64 hexadecimal digits, as sha256sum prints them")
                })?;
            Ok(Token { name, hash, scopes: entry.scopes })
        };
        entries.into_iter().map(token).collect::<Result<_, String>>().map(Self)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// What a token allows; `None`: it is not known. All hashes are compared, each in constant time.
    pub fn scopes(&self, token: &Hash) -> Option<&[Scope]> {
        self.find(token).map(|token| &token.scopes[..])
    }

    /// The name of a token in the file.
    pub fn name(&self, token: &Hash) -> Option<&str> {
        self.find(token).map(|token| token.name.as_str())
    }

    fn find(&self, token: &Hash) -> Option<&Token> {
        self.0
            .iter()
            .fold(None, |found, known| if known.hash.ct_eq(token).into() { Some(known) } else { found })
    }
}

/// The hash of a token or a ticket.
pub fn hash(secret: &str) -> Hash {
    Sha256::digest(secret.as_bytes()).into()
}

/// Tickets that were given out and not yet used, oldest first. Only their hashes are kept, as of tokens.
#[derive(Debug, Default)]
pub struct Tickets(Mutex<VecDeque<Ticket>>);

#[derive(Debug)]
struct Ticket {
    issued: Instant,
    hash: Hash,
    /// The token that it was issued to: it opens no more than that.
    pass: Pass,
}

impl Tickets {
    /// A new ticket for the holder of this pass.
    ///
    /// # Errors
    /// There is no randomness, or too many tickets wait to be used.
    pub fn issue(&self, pass: Pass) -> Result<String, Problem> {
        let mut octets = [0; 24];
        getrandom::fill(&mut octets)
            .map_err(|error| Problem::unavailable(format!("there is no randomness: {error}"), Vec::new()))?;
        let ticket = crate::hex::text(&octets);
        let mut tickets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        forget(&mut tickets);
        if tickets.len() >= TICKETS {
            return Err(Problem::new(StatusCode::TOO_MANY_REQUESTS, "too many tickets wait to be used")
                .retry_after_s(TICKET.as_secs() as u32));
        }
        tickets.push_back(Ticket { issued: Instant::now(), hash: hash(&ticket), pass });
        Ok(ticket)
    }

    /// Uses a ticket up; `None` where it is not good.
    pub fn redeem(&self, ticket: &str) -> Option<Pass> {
        let hash = hash(ticket);
        let mut tickets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        forget(&mut tickets);
        let place = tickets.iter().position(|ticket| ticket.hash.ct_eq(&hash).into())?;
        tickets.remove(place).map(|ticket| ticket.pass)
    }
}

fn forget(tickets: &mut VecDeque<Ticket>) {
    while tickets.front().is_some_and(|ticket| ticket.issued.elapsed() > TICKET) {
        tickets.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_tokens_is_read_or_refused_with_the_reason_and_without_the_hash() {
        let hash = "2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b"; // of "secret"
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
