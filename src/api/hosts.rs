//! Under which names the service is asked, and which pages may steer it.
//!
//! A browser lends its place in the network to whatever page it shows. A page whose name is made to point here ("DNS
//! rebinding") would read as one of our own: so a name has to be known. And a page of another origin can send a POST
//! without reading the answer, and read a WebSocket: so these have to come from a page of ours, a listed one, or no page at all.

use std::net::{Ipv4Addr, Ipv6Addr};

use axum::extract::Request;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Method, StatusCode, Version, header};

use super::client::Peer;
use super::problem::Problem;
use super::terms::Terms;

/// What a form of any page can send without asking first; no route reads a form.
const FORMS: [&str; 3] = ["application/x-www-form-urlencoded", "multipart/form-data", "text/plain"];

/// A problem where the request is for another host, or comes from a page that may not send it.
pub fn check(request: &Request, terms: &Terms) -> Result<(), Problem> {
    is_ours(request, &terms.hosts)?;
    let headers = request.headers();
    if request.method() == Method::POST {
        is_of_our_page(headers, terms)?;
        return is_no_form(headers);
    }
    // A WebSocket is not asked for leave to read: any page could.
    if headers.contains_key(header::SEC_WEBSOCKET_KEY) { is_of_our_page(headers, terms) } else { Ok(()) }
}

/// Every name that the request gives its host is one of ours.
fn is_ours(request: &Request, hosts: &[String]) -> Result<(), Problem> {
    let malformed = |rule: &str| Err(Problem::new(StatusCode::BAD_REQUEST, rule));
    let mut lines = request.headers().get_all(header::HOST).iter();
    let host = match (lines.next(), lines.next()) {
        (_, Some(_)) => return malformed("the header Host is given once"),
        (Some(host), None) => match host.to_str().ok().and_then(|host| host.parse::<Authority>().ok()) {
            Some(host) if !host.as_str().contains('@') => Some(host),
            _ => return malformed("the header Host is a name or an address, with a port or without"),
        },
        // What came over no socket has no name to be asked under.
        (None, None)
            if request.version() == Version::HTTP_11 && request.extensions().get::<Peer>().is_some() =>
        {
            return malformed("HTTP/1.1 needs the header Host");
        }
        (None, None) => None,
    };
    let named = host.iter().chain(request.uri().authority()).find(|host| !is_known(host.host(), hosts));
    named.map_or(Ok(()), |host| {
        let detail = format!(
            "this service does not answer to the name {}; where the name is right, add it to http.hosts",
            host.host()
        );
        Err(Problem::new(StatusCode::MISDIRECTED_REQUEST, detail))
    })
}

/// Whether it is a name of ours. An address cannot be made to point anywhere else.
fn is_known(host: &str, hosts: &[String]) -> bool {
    let is_address = host.parse::<Ipv4Addr>().is_ok()
        || host
            .strip_prefix('[')
            .and_then(|host| host.strip_suffix(']'))
            .is_some_and(|host| host.parse::<Ipv6Addr>().is_ok());
    let name = host.strip_suffix('.').unwrap_or(host);
    is_address
        || name.eq_ignore_ascii_case("localhost")
        || hosts.iter().any(|known| name.eq_ignore_ascii_case(known))
}

/// Browsers say which page a request comes from; programs do not.
fn is_of_our_page(headers: &HeaderMap, terms: &Terms) -> Result<(), Problem> {
    let foreign = |page: &str| {
        let detail =
            format!("a page of {page} may not send this; http.cors lists the origins whose pages may");
        Err(Problem::new(StatusCode::FORBIDDEN, detail))
    };
    match headers.get(header::ORIGIN) {
        Some(origin) => {
            let origin = origin.to_str().unwrap_or("an unreadable origin");
            let is_listed = terms.cors.iter().any(|known| known == origin);
            if !is_listed && !is_own(origin, headers, &terms.hosts) {
                return foreign(origin);
            }
        }
        None if headers.get("sec-fetch-site").is_some_and(|site| site == "cross-site") => {
            return foreign("another site");
        }
        None => {}
    }
    Ok(())
}

fn is_no_form(headers: &HeaderMap) -> Result<(), Problem> {
    let kind = headers.get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or("");
    let kind = kind.split(';').next().unwrap_or("").trim();
    if FORMS.iter().any(|form| form.eq_ignore_ascii_case(kind)) {
        let detail = format!(
            "no form is read here, and {kind} is one; parameters stand behind the ?, and a body of JSON needs the header \
             Content-Type: application/json"
        );
        return Err(Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail));
    }
    Ok(())
}

/// Whether the page is one that this service serves: under the name and port that is asked, or under a name of its own
/// that a reverse proxy has and does not pass on.
fn is_own(origin: &str, headers: &HeaderMap, hosts: &[String]) -> bool {
    let Some(page) = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://")) else {
        return false;
    };
    let asked = headers.get(header::HOST).and_then(|host| host.to_str().ok());
    asked.is_some_and(|host| host.eq_ignore_ascii_case(page)) || hosts.iter().any(|known| known == page)
}
