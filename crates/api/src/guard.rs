//! Checks of every request (limits, CORS, token, parameter names), and headers of every response.

use std::net::{IpAddr, Ipv4Addr};
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes, to_bytes};
use axum::extract::rejection::RawPathParamsRejection;
use axum::extract::{RawPathParams, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodFilter, on};
use futures_util::FutureExt;

use super::auth;
use super::client::{PeerAddress, Subscriber, client};
use super::problem::Problem;
use super::query::Query;
use super::rate::BucketOwner;
use super::render::{ChunkedBody, bug};
use super::request::{ApiRequest, ApiResult};
use super::route::{Lane, Route};
use super::routes::ROUTES;
use super::state::ApiState;
use super::tokens::Credential;
use super::{gzip, hosts, page};

/// Maximum length of a request body, in octets.
const BODY: u64 = 64 * 1024;
/// Timeout for receiving a body.
const BODY_WITHIN: Duration = Duration::from_secs(5);
/// Maximum length of the path with its parameters, in octets.
const URI: usize = 8 * 1024;

/// Address of the client, as found by [`client`].
#[derive(Clone, Copy, Debug)]
struct Client(IpAddr);

/// Router of all routes, with their state.
pub fn router(state: ApiState) -> Router {
    let mut router = Router::new();
    for route in ROUTES.iter() {
        let method = if route.post { MethodFilter::POST } else { MethodFilter::GET };
        let handler = move |State(state): State<ApiState>, id, request: Request| async move {
            let compute = match prepare(route, state, id, &request) {
                Ok(api_request) => compute(route, api_request, request).await,
                Err(problem) => Err(problem),
            };
            compute.unwrap_or_else(IntoResponse::into_response)
        };
        router = router.route(route.path, on(method, handler));
    }
    router
        .merge(page::files())
        .fallback(async || Problem::not_found("nothing is here; /openapi.json lists what there is"))
        .method_not_allowed_fallback(async || {
            Problem::new(
                StatusCode::METHOD_NOT_ALLOWED,
                "this path does not take this method; Allow says which",
            )
        })
        .layer(from_fn_with_state(state.clone(), guard))
        .with_state(state)
}

/// Reads the body if the route has one, waits for a turn if the answer is expensive, and computes the answer.
async fn compute(route: &'static Route, mut api_request: ApiRequest, request: Request) -> ApiResult {
    let is_gzip = takes_gzip(&request);
    if route.body.is_some() {
        let read = tokio::time::timeout(BODY_WITHIN, to_bytes(request.into_body(), BODY as usize)).await;
        let body = read.map_err(|_| Problem::new(StatusCode::REQUEST_TIMEOUT, "the body did not come"))?;
        // A client that closed its connection does not receive this answer.
        api_request.body = body.map_err(|_| too_large())?;
    }
    let weight = match route.lane {
        Lane::Direct => return (route.reply.answer)(api_request).await,
        Lane::Quick => 0,
        Lane::Weighed(weight) => weight(&api_request),
    };
    let (state, client) = (api_request.state.clone(), api_request.client);
    if weight == 0 {
        return state.renderer.quick(move || written(route, api_request, is_gzip)).await?;
    }
    // One request was charged already.
    if let Some(client) = client.filter(|_| weight > 1) {
        state.charge(BucketOwner::Address(Subscriber::at(client)), weight - 1)?;
    }
    if let Some(token) = api_request.credential.0.filter(|_| weight > 1) {
        state.charge(BucketOwner::Token(token), weight - 1)?;
    }
    let client = Subscriber::at(client.unwrap_or(Ipv4Addr::UNSPECIFIED.into()));
    let (response, in_flight) =
        state.renderer.in_time(client, move || written(route, api_request, is_gzip)).await?;
    let (parts, body) = response?.into_parts();
    let octets = to_bytes(body, usize::MAX).await.map_err(|error| bug(&error))?;
    Ok(Response::from_parts(parts, Body::new(ChunkedBody::new(octets, in_flight))))
}

/// Computes the answer, compressed if wanted. Runs outside the threads that read or write sockets.
fn written(route: &Route, api_request: ApiRequest, is_gzip: bool) -> ApiResult {
    let late = || bug(&"an answer was not ready");
    let response = (route.reply.answer)(api_request).now_or_never().ok_or_else(late)??;
    gzip::answer(response, is_gzip).now_or_never().ok_or_else(late)
}

fn takes_gzip(request: &Request) -> bool {
    gzip::is_accepted(request.headers()) && request.method() != Method::HEAD
}

/// Checks a request, and prepares it for the handlers.
fn prepare(
    route: &Route,
    state: ApiState,
    id: Result<RawPathParams, RawPathParamsRejection>,
    request: &Request,
) -> Result<ApiRequest, Problem> {
    let id = id.map_err(|_| Problem::parameter("id", "an id is UTF-8, percent-encoded"))?;
    let id = id.iter().next().map_or_else(String::new, |(_, id)| id.to_owned());
    let query = request.uri().query().unwrap_or("");
    let query = match route.parameters {
        Some(_) => Query::parse(query)?,
        None => Query::default(),
    };
    let client = request.extensions().get::<Client>().map(|client| client.0);
    let headers = request.headers().clone();
    let (credential, body) = (Credential::default(), Bytes::new());
    let upgrade = request.extensions().get().filter(|_| request.method() == Method::GET).cloned();
    let connection = request.extensions().get().cloned();
    let mut api_request =
        ApiRequest { state, query, id, headers, client, credential, body, upgrade, connection };
    api_request.credential = auth::check(&api_request, route)?;
    let known = route.parameters.unwrap_or(&[]);
    if let Some(name) = api_request.query.names().find(|name| known.iter().all(|known| known.name != *name)) {
        let names: Vec<_> = known.iter().map(|known| known.name).collect();
        let rule = match names[..] {
            [] => "this path takes no parameters".to_owned(),
            _ => format!("there is no such parameter; there are {}", names.join(", ")),
        };
        return Err(Problem::parameter(name, rule));
    }
    Ok(api_request)
}

async fn guard(State(state): State<ApiState>, mut request: Request, next: Next) -> Response {
    let access = state.access();
    if let Some(&PeerAddress(peer)) = request.extensions().get() {
        let client = client(peer, request.headers(), &access.trusted_proxies);
        request.extensions_mut().insert(Client(client));
    }
    let origin = request.headers().get(header::ORIGIN).filter(|origin| {
        let known = |known: &String| known.as_bytes() == origin.as_bytes();
        access.cors.iter().any(known)
    });
    let origin = origin.cloned();
    let takes_gzip = takes_gzip(&request);
    let preflight = request.method() == Method::OPTIONS
        && request.headers().contains_key(header::ACCESS_CONTROL_REQUEST_METHOD);
    let allowed = too_often(&state, &request)
        .and_then(|()| hosts::check(&request, &access))
        .and_then(|()| too_much(&request));
    let mut response = if let Err(problem) = allowed {
        problem.into_response()
    } else if preflight && origin.is_some() {
        let mut response = Response::new(Body::empty());
        *response.status_mut() = StatusCode::NO_CONTENT;
        let headers = response.headers_mut();
        headers.insert(header::ACCESS_CONTROL_ALLOW_METHODS, HeaderValue::from_static("GET, HEAD, POST"));
        headers.insert(
            header::ACCESS_CONTROL_ALLOW_HEADERS,
            HeaderValue::from_static("authorization, content-type, if-none-match, last-event-id"),
        );
        headers.insert(header::ACCESS_CONTROL_MAX_AGE, HeaderValue::from_static("600"));
        response
    } else {
        next.run(request).await
    };
    if !access.cors.is_empty() {
        response.headers_mut().append(header::VARY, HeaderValue::from_static("origin"));
    }
    if let Some(origin) = origin {
        let headers = response.headers_mut();
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, origin);
        headers.insert(header::ACCESS_CONTROL_EXPOSE_HEADERS, HeaderValue::from_static("etag, retry-after"));
    }
    response = gzip::answer(response, takes_gzip).await;
    secure(response.headers_mut(), state.policy());
    state.count_answer(response.status().as_u16());
    response
}

fn too_often(state: &ApiState, request: &Request) -> Result<(), Problem> {
    let path = request.uri().path();
    let is_free = page::is_file(path) || ROUTES.iter().any(|route| !route.limited && route.path == path);
    match request.extensions().get() {
        Some(&Client(client)) if !is_free => state.limit(BucketOwner::Address(Subscriber::at(client))),
        _ => Ok(()),
    }
}

fn too_much(request: &Request) -> Result<(), Problem> {
    if request.uri().path_and_query().is_some_and(|text| text.as_str().len() > URI) {
        return Err(Problem::new(StatusCode::URI_TOO_LONG, format!("a path has at most {URI} octets")));
    }
    let length = request.headers().get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok());
    if length.is_none_or(|length| length.parse::<u64>().is_ok_and(|octets| octets <= BODY)) {
        return Ok(());
    }
    Err(too_large())
}

fn too_large() -> Problem {
    Problem::new(StatusCode::PAYLOAD_TOO_LARGE, format!("a body has at most {BODY} octets"))
}

/// Security headers: no content sniffing, no framing.
fn secure(headers: &mut HeaderMap, policy: HeaderValue) {
    headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    let fixed = [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
}
