//! Who may do what: the token or the ticket of a request.

use axum::http::{StatusCode, header};
use schemars::JsonSchema;
use serde::Serialize;

use super::ask::Ask;
use super::problem::Problem;
use super::rate::Who;
use super::route::Route;
use super::tokens::{Pass, Scope, TICKET, hash};

/// By what the request may be answered.
pub fn check(ask: &Ask, route: &Route) -> Result<Pass, Problem> {
    let terms = ask.state.terms();
    let (Some(tokens), Some(scope)) = (&terms.tokens, route.scope) else { return Ok(Pass(None)) };
    if scope == Scope::Stream
        && !route.post
        && let Some(ticket) = ask.query.text("ticket")
    {
        let pass = ask.state.tickets().redeem(ticket).filter(|&pass| terms.may_stream(pass));
        let detail = "this ticket has been used, is too old, or never was one";
        return pass.ok_or_else(|| Problem::new(StatusCode::UNAUTHORIZED, detail));
    }
    let bearer = ask.header(header::AUTHORIZATION).and_then(|value| value.split_once(' '));
    let token = bearer.filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer"));
    let Some(token) = token.map(|(_, token)| hash(token.trim())) else {
        let detail = "a bearer token is needed: Authorization: Bearer …";
        return Err(Problem::new(StatusCode::UNAUTHORIZED, detail));
    };
    let Some(scopes) = tokens.scopes(&token) else {
        return Err(Problem::new(StatusCode::UNAUTHORIZED, "this bearer token is not known"));
    };
    ask.state.limit(Who::Token(token))?;
    if !scopes.contains(&scope) {
        let detail = format!("this token lacks the scope {}", scope.name());
        return Err(Problem::new(StatusCode::FORBIDDEN, detail));
    }
    Ok(Pass(Some(token)))
}

/// A ticket for one stream.
#[derive(Serialize, JsonSchema)]
pub struct Ticket {
    /// Given to `/api/v1/stream` as its parameter `ticket`.
    ticket: String,
    expires_in_s: u64,
}

/// `POST /api/v1/stream-tickets`.
pub fn open_ticket(ask: &Ask) -> Result<Ticket, Problem> {
    Ok(Ticket { ticket: ask.state.tickets().issue(ask.pass)?, expires_in_s: TICKET.as_secs() })
}
