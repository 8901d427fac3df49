//! What a route is: a path, who may ask, and what answers.

use std::borrow::Cow;
use std::fmt;
use std::future::{Future, ready};
use std::pin::Pin;

use axum::http::StatusCode;
use axum::response::Response;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;

use super::ask::{Answer, Ask, GEO_JSON, JSON, json};
use super::problem::Problem;
use super::tokens::Scope;

/// A media type, and the schema of what it holds.
pub type Typed = (&'static str, fn(&mut SchemaGenerator) -> Schema);

/// A path and what is done there.
#[derive(Debug)]
pub struct Route {
    /// With `{id}` where a part is free.
    pub path: &'static str,
    /// `GET` (then also `HEAD`) or `POST`.
    pub post: bool,
    /// One line for the document.
    pub summary: &'static str,
    /// The type of what is in its body; `None`: no body is read.
    pub body: Option<fn(&mut SchemaGenerator) -> Schema>,
    /// What the body is, where one is read.
    pub body_type: &'static str,
    /// Other media types that the body may have, each with the type of what it holds.
    pub other_bodies: Vec<Typed>,
    /// The only parameters that a query may have; `None`: the query is ignored.
    pub parameters: Option<&'static [Parameter]>,
    /// What a token needs; `None`: open to everybody.
    pub scope: Option<Scope>,
    /// Statuses beside 200, 400, 401, 403, 405 and, where it is limited, 429.
    pub problems: &'static [u16],
    /// Whether requests count against `http.requests_per_s`; probes do not.
    pub limited: bool,
    /// Where the answer is made.
    pub(super) lane: Lane,
    /// What answers.
    pub(super) reply: Reply,
}

impl Route {
    /// One that is read, without parameters.
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

    /// One that does something.
    pub(super) fn post(path: &'static str, summary: &'static str, scope: Scope, reply: Reply) -> Self {
        Self { post: true, scope: Some(scope), lane: Lane::Direct, ..Self::get(path, summary, reply) }
    }

    /// With these parameters.
    pub(super) fn with(self, parameters: &'static [Parameter]) -> Self {
        Self { parameters: Some(parameters), ..self }
    }

    /// With this as JSON in its body.
    pub(super) fn reads<T: JsonSchema>(self) -> Self {
        Self { body: Some(SchemaGenerator::subschema_for::<T>), ..self }
    }

    /// With octets of this type in its body.
    pub(super) fn reads_octets(self, body_type: &'static str) -> Self {
        Self { body: Some(SchemaGenerator::subschema_for::<Binary>), body_type, ..self }
    }

    /// With a `T` in its body as well, as JSON.
    pub(super) fn or_reads<T: JsonSchema>(mut self) -> Self {
        self.other_bodies.push((JSON, SchemaGenerator::subschema_for::<T>));
        self
    }

    /// Which ignores its query.
    pub(super) fn any_query(self) -> Self {
        Self { parameters: None, ..self }
    }

    /// With these statuses.
    pub(super) fn or(self, problems: &'static [u16]) -> Self {
        Self { problems, ..self }
    }

    /// Open to everybody (`None`), or to tokens with this scope.
    pub(super) fn needs(self, scope: Option<Scope>) -> Self {
        Self { scope, ..self }
    }

    /// Which opens a stream.
    pub(super) fn streams(self) -> Self {
        Self { lane: Lane::Direct, ..self }
    }

    /// Sets the cost of an expensive answer, in requests; 0: this request is cheap.
    pub(super) fn weighs(self, weight: fn(&Ask) -> u32) -> Self {
        Self { lane: Lane::Weighed(weight), ..self }
    }

    /// For everybody, as often as they like.
    pub(super) fn probe(self) -> Self {
        Self { scope: None, limited: false, lane: Lane::Direct, ..self }
    }
}

/// Where an answer is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Lane {
    /// By the task of the connection: it takes no time, or waits for something else.
    Direct,
    /// On a thread that makes answers.
    Quick,
    /// On the threads for what takes long, where the weight is not 0.
    Weighed(fn(&Ask) -> u32),
}

/// What answers, with the type of its body: neither can be given without the other.
pub(super) struct Reply {
    /// Where all is well.
    pub(super) status: StatusCode,
    pub(super) content_type: &'static str,
    /// Other media types that the body may have, each with the type of what it holds.
    pub(super) others: Vec<Typed>,
    /// Of the body.
    pub(super) schema: fn(&mut SchemaGenerator) -> Schema,
    pub(super) answer: Answering,
}

type Answering = Box<dyn Fn(Ask) -> Later<Response> + Send + Sync>;

/// An answer that may have to be waited for.
pub(super) type Later<T> = Pin<Box<dyn Future<Output = Result<T, Problem>> + Send>>;

impl Reply {
    fn of<T: JsonSchema>(content_type: &'static str, answer: Answering) -> Self {
        let schema = SchemaGenerator::subschema_for::<T>;
        Self { status: StatusCode::OK, content_type, others: Vec::new(), schema, answer }
    }

    /// Or a `T` of this media type.
    pub(super) fn or<T: JsonSchema>(mut self, content_type: &'static str) -> Self {
        self.others.push((content_type, SchemaGenerator::subschema_for::<T>));
        self
    }

    /// A value as JSON.
    pub(super) fn json<T: Serialize + JsonSchema + 'static>(handler: fn(&Ask) -> Result<T, Problem>) -> Self {
        Self::octets::<T>(JSON, move |ask| json(JSON, &handler(ask)?))
    }

    /// A value as GeoJSON.
    pub(super) fn geo<T: Serialize + JsonSchema + 'static>(handler: fn(&Ask) -> Result<T, Problem>) -> Self {
        Self::octets::<T>(GEO_JSON, move |ask| json(GEO_JSON, &handler(ask)?))
    }

    /// A value as JSON, which has to be waited for.
    pub(super) fn later<T: Serialize + JsonSchema + 'static>(handler: fn(Ask) -> Later<T>) -> Self {
        let answer = move |ask| -> Later<Response> {
            let value = handler(ask);
            Box::pin(async move { json(JSON, &value.await?) })
        };
        Self::of::<T>(JSON, Box::new(answer))
    }

    /// A change of protocols; what is spoken then is a `T`.
    pub(super) fn upgrade<T: JsonSchema>(handler: fn(&Ask) -> Answer) -> Self {
        Self { status: StatusCode::SWITCHING_PROTOCOLS, ..Self::octets::<T>(JSON, handler) }
    }

    /// Octets that are a `T` already: text, or JSON that was written before.
    pub(super) fn octets<T: JsonSchema>(
        content_type: &'static str,
        handler: impl Fn(&Ask) -> Answer + Send + Sync + 'static,
    ) -> Self {
        let answer = move |ask: Ask| -> Later<Response> { Box::pin(ready(handler(&ask))) };
        Self::of::<T>(content_type, Box::new(answer))
    }
}

impl fmt::Debug for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.content_type)
    }
}

/// The values of a text.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// All of them.
    pub names: fn() -> Vec<&'static str>,
    /// Whether several may be given, separated by commas.
    pub is_list: bool,
}

/// Octets that are no text.
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

/// A parameter of a query.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// `string`, `number`, `integer`, or `time` (RFC 3339).
    pub kind: &'static str,
    /// Least and greatest value of a number.
    pub range: Option<(f64, f64)>,
    /// The only values that a text may have.
    pub values: Option<Values>,
    /// Whether it has to be given.
    pub required: bool,
    /// What it does.
    pub description: &'static str,
}

impl Parameter {
    pub(super) const fn new(name: &'static str, kind: &'static str, description: &'static str) -> Self {
        Self { name, kind, range: None, values: None, required: false, description }
    }

    pub(super) const fn within(self, least: f64, greatest: f64) -> Self {
        Self { range: Some((least, greatest)), ..self }
    }

    /// One of these values.
    pub(super) const fn one_of(self, names: fn() -> Vec<&'static str>) -> Self {
        Self { values: Some(Values { names, is_list: false }), ..self }
    }

    /// Some of these values, separated by commas.
    pub(super) const fn some_of(self, names: fn() -> Vec<&'static str>) -> Self {
        Self { values: Some(Values { names, is_list: true }), ..self }
    }

    pub(super) const fn needed(self) -> Self {
        Self { required: true, ..self }
    }
}
