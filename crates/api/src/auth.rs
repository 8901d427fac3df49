//! Authorisation of a request by its token or ticket.

use axum::http::{StatusCode, header};
use schemars::JsonSchema;
use serde::Serialize;

use super::problem::Problem;
use super::rate::BucketOwner;
use super::request::ApiRequest;
use super::route::Route;
use super::tokens::{Credential, Scope, TICKET, hash};

/// Authorises a request for a route.
pub fn check(request: &ApiRequest, route: &Route) -> Result<Credential, Problem> {
    let access = request.state.access();
    let (Some(tokens), Some(scope)) = (&access.tokens, route.scope) else { return Ok(Credential(None)) };
    if scope == Scope::Stream
        && !route.post
        && let Some(ticket) = request.query.text("ticket")
    {
        let credential =
            request.state.tickets.redeem(ticket).filter(|&credential| access.may_stream(credential));
        let detail = "this ticket has been used, is too old, or never was one";
        return credential.ok_or_else(|| Problem::new(StatusCode::UNAUTHORIZED, detail));
    }
    let bearer = request.header(header::AUTHORIZATION).and_then(|value| value.split_once(' '));
    let token = bearer.filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer"));
    let Some(token) = token.map(|(_, token)| hash(token.trim())) else {
        let detail = "a bearer token is needed: Authorization: Bearer …";
        return Err(Problem::new(StatusCode::UNAUTHORIZED, detail));
    };
    let Some(scopes) = tokens.scopes(&token) else {
        return Err(Problem::new(StatusCode::UNAUTHORIZED, "this bearer token is not known"));
    };
    request.state.limit(BucketOwner::Token(token))?;
    if !scopes.contains(&scope) {
        let detail = format!("this token lacks the scope {}", scope.name());
        return Err(Problem::new(StatusCode::FORBIDDEN, detail));
    }
    Ok(Credential(Some(token)))
}

/// A ticket for one stream.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Ticket")]
pub struct StreamTicket {
    /// Value of the parameter `ticket` of `/api/v1/stream`.
    ticket: String,
    expires_in_s: u64,
}

/// `POST /api/v1/stream-tickets`.
pub fn issue_ticket(request: &ApiRequest) -> Result<StreamTicket, Problem> {
    Ok(StreamTicket {
        ticket: request.state.tickets.issue(request.credential)?,
        expires_in_s: TICKET.as_secs(),
    })
}
