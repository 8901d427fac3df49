//! Description of a route: path, access, and handler.

use std::borrow::Cow;
use std::fmt;
use std::future::ready;

use axum::http::StatusCode;
use axum::response::Response;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;

use super::problem::Problem;
use super::request::{AnswerFuture, ApiRequest, ApiResult, GEO_JSON, JSON, json};
use super::tokens::Scope;

/// A media type, with the schema of its content.
pub type MediaType = (&'static str, fn(&mut SchemaGenerator) -> Schema);

/// A route of the API.
#[derive(Debug)]
pub struct Route {
    /// Path, with `{id}` for a free part.
    pub path: &'static str,
    /// Whether the method is `POST`; otherwise `GET` and `HEAD`.
    pub post: bool,
    /// One-line summary for the documents.
    pub summary: &'static str,
    /// Type of the request body; `None` if no body is read.
    pub body: Option<fn(&mut SchemaGenerator) -> Schema>,
    /// Media type of the request body.
    pub body_type: &'static str,
    /// Further media types of the request body, with their schemas.
    pub other_bodies: Vec<MediaType>,
    /// The allowed query parameters; `None` means that the query is ignored.
    pub parameters: Option<&'static [QueryParameter]>,
    /// Scope that a token needs; `None` for a public route.
    pub scope: Option<Scope>,
    /// Error statuses besides 200, 400, 401, 403, 405 and, with a limit, 429.
    pub problems: &'static [u16],
    /// Whether requests count against `http.requests_per_s`. Probes do not.
    pub limited: bool,
    /// Threads on which the answer is made.
    pub(super) lane: Lane,
    /// Handler.
    pub(super) reply: Reply,
}

impl Route {
    /// A `GET` route without parameters.
    pub(super) fn get(path: &'static str, summary: &'static str, reply: Reply) -> Self {
        let scope = Some(Scope::Read);
        let (parameters, problems) = (Some(&[][..]), &[]);
        let (body, body_type) = (None, JSON);
        Self {
            path,
            post: false,
            summary,
            body,
            body_type,
            other_bodies: Vec::new(),
            parameters,
            scope,
            problems,
            limited: true,
            lane: Lane::Quick,
            reply,
        }
    }

    /// A `POST` route.
    pub(super) fn post(path: &'static str, summary: &'static str, scope: Scope, reply: Reply) -> Self {
        Self { post: true, scope: Some(scope), lane: Lane::Direct, ..Self::get(path, summary, reply) }
    }

    /// Sets the query parameters.
    pub(super) fn with(self, parameters: &'static [QueryParameter]) -> Self {
        Self { parameters: Some(parameters), ..self }
    }

    /// Sets a JSON request body of type `T`.
    pub(super) fn reads<T: JsonSchema>(self) -> Self {
        Self { body: Some(SchemaGenerator::subschema_for::<T>), ..self }
    }

    /// Sets a binary request body.
    pub(super) fn reads_octets(self, body_type: &'static str) -> Self {
        Self { body: Some(SchemaGenerator::subschema_for::<Binary>), body_type, ..self }
    }

    /// Adds `T` as JSON to the possible request bodies.
    pub(super) fn or_reads<T: JsonSchema>(mut self) -> Self {
        self.other_bodies.push((JSON, SchemaGenerator::subschema_for::<T>));
        self
    }

    /// Ignores the query.
    pub(super) fn any_query(self) -> Self {
        Self { parameters: None, ..self }
    }

    /// Sets the error statuses.
    pub(super) fn or(self, problems: &'static [u16]) -> Self {
        Self { problems, ..self }
    }

    /// Sets the scope that a token needs; `None` makes the route public.
    pub(super) fn needs(self, scope: Option<Scope>) -> Self {
        Self { scope, ..self }
    }

    /// Marks a route that opens a stream.
    pub(super) fn streams(self) -> Self {
        Self { lane: Lane::Direct, ..self }
    }

    /// Sets the cost of an expensive answer, in requests; 0 means that this request is cheap.
    pub(super) fn weighs(self, weight: fn(&ApiRequest) -> u32) -> Self {
        Self { lane: Lane::Weighed(weight), ..self }
    }

    /// Makes the route public and without a limit.
    pub(super) fn probe(self) -> Self {
        Self { scope: None, limited: false, lane: Lane::Direct, ..self }
    }
}

/// Threads on which an answer is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Lane {
    /// The task of the connection, for answers that take no time or wait for another component.
    Direct,
    /// A thread for quick answers.
    Quick,
    /// The threads for expensive answers, if the weight is not 0.
    Weighed(fn(&ApiRequest) -> u32),
}

/// Handler together with the type of its body, so that neither can be given without the other.
pub(super) struct Reply {
    /// Status of a successful answer.
    pub(super) status: StatusCode,
    pub(super) content_type: &'static str,
    /// Further media types of the body, with their schemas.
    pub(super) others: Vec<MediaType>,
    /// Schema of the body.
    pub(super) schema: fn(&mut SchemaGenerator) -> Schema,
    pub(super) answer: Handler,
}

type Handler = Box<dyn Fn(ApiRequest) -> AnswerFuture<Response> + Send + Sync>;

impl Reply {
    fn of<T: JsonSchema>(content_type: &'static str, answer: Handler) -> Self {
        let schema = SchemaGenerator::subschema_for::<T>;
        Self { status: StatusCode::OK, content_type, others: Vec::new(), schema, answer }
    }

    /// Adds `T` as another media type of the body.
    pub(super) fn or<T: JsonSchema>(mut self, content_type: &'static str) -> Self {
        self.others.push((content_type, SchemaGenerator::subschema_for::<T>));
        self
    }

    /// Value as JSON.
    pub(super) fn json<T: Serialize + JsonSchema + 'static>(
        handler: fn(&ApiRequest) -> Result<T, Problem>,
    ) -> Self {
        Self::octets::<T>(JSON, move |request| json(JSON, &handler(request)?))
    }

    /// Value as GeoJSON.
    pub(super) fn geo<T: Serialize + JsonSchema + 'static>(
        handler: fn(&ApiRequest) -> Result<T, Problem>,
    ) -> Self {
        Self::octets::<T>(GEO_JSON, move |request| json(GEO_JSON, &handler(request)?))
    }

    /// Value as JSON from an asynchronous handler.
    pub(super) fn later<T: Serialize + JsonSchema + 'static>(
        handler: fn(ApiRequest) -> AnswerFuture<T>,
    ) -> Self {
        let answer = move |request| -> AnswerFuture<Response> {
            let value = handler(request);
            Box::pin(async move { json(JSON, &value.await?) })
        };
        Self::of::<T>(JSON, Box::new(answer))
    }

    /// Change of protocols, after which messages are of type `T`.
    pub(super) fn upgrade<T: JsonSchema>(handler: fn(&ApiRequest) -> ApiResult) -> Self {
        Self { status: StatusCode::SWITCHING_PROTOCOLS, ..Self::octets::<T>(JSON, handler) }
    }

    /// Octets that already are an encoded `T`: text, or JSON.
    pub(super) fn octets<T: JsonSchema>(
        content_type: &'static str,
        handler: impl Fn(&ApiRequest) -> ApiResult + Send + Sync + 'static,
    ) -> Self {
        let answer =
            move |request: ApiRequest| -> AnswerFuture<Response> { Box::pin(ready(handler(&request))) };
        Self::of::<T>(content_type, Box::new(answer))
    }
}

impl fmt::Debug for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.content_type)
    }
}

/// Possible values of a text parameter.
#[derive(Clone, Copy, Debug)]
pub struct AllowedValues {
    /// All possible values.
    pub names: fn() -> Vec<&'static str>,
    /// Whether several values may be given, separated by commas.
    pub is_list: bool,
}

/// Binary octets.
pub(super) struct Binary;

impl JsonSchema for Binary {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Binary".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schemars::json_schema!({ "type": "string", "format": "binary" })
    }
}

/// A query parameter.
#[derive(Clone, Copy, Debug)]
pub struct QueryParameter {
    /// Name of the parameter.
    pub name: &'static str,
    /// Type: `string`, `number`, `integer`, or `time` (RFC 3339).
    pub kind: &'static str,
    /// Minimum and maximum of a number.
    pub range: Option<(f64, f64)>,
    /// The possible values of a text.
    pub values: Option<AllowedValues>,
    /// Whether the parameter is required.
    pub required: bool,
    /// Description for the documents.
    pub description: &'static str,
}

impl QueryParameter {
    pub(super) const fn new(name: &'static str, kind: &'static str, description: &'static str) -> Self {
        Self { name, kind, range: None, values: None, required: false, description }
    }

    pub(super) const fn within(self, least: f64, greatest: f64) -> Self {
        Self { range: Some((least, greatest)), ..self }
    }

    /// Restricts the value to one of these names.
    pub(super) const fn one_of(self, names: fn() -> Vec<&'static str>) -> Self {
        Self { values: Some(AllowedValues { names, is_list: false }), ..self }
    }

    /// Restricts the value to a comma-separated list of these names.
    pub(super) const fn some_of(self, names: fn() -> Vec<&'static str>) -> Self {
        Self { values: Some(AllowedValues { names, is_list: true }), ..self }
    }

    pub(super) const fn needed(self) -> Self {
        Self { required: true, ..self }
    }
}
