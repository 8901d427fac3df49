//! Protection against requests from pages of other origins.
//!
//! A browser has access to its network on behalf of every page it shows. A page whose host name is made to point to this service
//! ("DNS rebinding") would count as the same origin; therefore host names have to be known. A page of another origin can send a
//! POST without reading the answer, and can read a WebSocket; therefore these need an origin of this service, a listed one, or
//! none (not a browser).

use std::net::{Ipv4Addr, Ipv6Addr};

use axum::extract::Request;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Method, StatusCode, Version, header};

use super::access::AccessSettings;
use super::client::PeerAddress;
use super::problem::Problem;

/// Content types that a form of any page can send without a preflight request. No route reads a form.
const FORMS: [&str; 3] = ["application/x-www-form-urlencoded", "multipart/form-data", "text/plain"];

/// Refuses a request for an unknown host, or one from a page that may not send it.
pub fn check(request: &Request, access: &AccessSettings) -> Result<(), Problem> {
    is_ours(request, &access.hosts)?;
    let headers = request.headers();
    if request.method() == Method::POST {
        is_of_our_page(headers, access)?;
        return is_no_form(headers);
    }
    // Browsers do not require permission to read a WebSocket of another origin, so every page could.
    if headers.contains_key(header::SEC_WEBSOCKET_KEY) { is_of_our_page(headers, access) } else { Ok(()) }
}

/// Checks that every host name in the request belongs to this service.
fn is_ours(request: &Request, hosts: &[String]) -> Result<(), Problem> {
    let malformed = |rule: &str| Err(Problem::new(StatusCode::BAD_REQUEST, rule));
    let mut lines = request.headers().get_all(header::HOST).iter();
    let host = match (lines.next(), lines.next()) {
        (_, Some(_)) => return malformed("the header Host is given once"),
        (Some(host), None) => match host.to_str().ok().and_then(|host| host.parse::<Authority>().ok()) {
            Some(host) if !host.as_str().contains('@') => Some(host),
            _ => return malformed("the header Host is a name or an address, with a port or without"),
        },
        // HTTP/1.1 over a socket requires the header.
        (None, None)
            if request.version() == Version::HTTP_11
                && request.extensions().get::<PeerAddress>().is_some() =>
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

/// Whether `host` is an address or a known name. An address cannot be redirected.
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

/// Whether the request comes from a known page or from no page. Browsers state the origin; other programs do not.
fn is_of_our_page(headers: &HeaderMap, access: &AccessSettings) -> Result<(), Problem> {
    let foreign = |page: &str| {
        let detail =
            format!("a page of {page} may not send this; http.cors lists the origins whose pages may");
        Err(Problem::new(StatusCode::FORBIDDEN, detail))
    };
    match headers.get(header::ORIGIN) {
        Some(origin) => {
            let origin = origin.to_str().unwrap_or("an unreadable origin");
            let is_listed = access.cors.iter().any(|known| known == origin);
            if !is_listed && !is_own(origin, headers, &access.hosts) {
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

/// Whether the origin is a page of this service, with the host and port of the request, or with a configured name that a reverse
/// proxy does not pass on.
fn is_own(origin: &str, headers: &HeaderMap, hosts: &[String]) -> bool {
    let Some(page) = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://")) else {
        return false;
    };
    let asked = headers.get(header::HOST).and_then(|host| host.to_str().ok());
    asked.is_some_and(|host| host.eq_ignore_ascii_case(page)) || hosts.iter().any(|known| known == page)
}
