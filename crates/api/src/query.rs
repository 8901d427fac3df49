//! Query parameters of a request. Each error names the parameter and its rule.

use std::str::FromStr;

use jiff::Timestamp;

use super::problem::Problem;
use fusion::time::Time;

/// Query parameters, each at most once.
#[derive(Debug, Default)]
pub struct Query(Vec<(String, String)>);

impl Query {
    /// Parses the text after the `?`.
    ///
    /// # Errors
    /// 400 for a repeated parameter.
    pub fn parse(text: &str) -> Result<Self, Problem> {
        let mut query = Self::default();
        for (name, value) in form_urlencoded::parse(text.as_bytes()) {
            if query.text(&name).is_some() {
                let rule = "a parameter is given once; values of a list are separated by commas";
                return Err(Problem::parameter(&name, rule));
            }
            query.0.push((name.into_owned(), value.into_owned()));
        }
        Ok(query)
    }

    /// Names of the parameters, as given.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Text of a parameter, if given.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// Value of a parameter that must be `valid`; `rule` describes valid values.
    pub fn value<T: FromStr>(
        &self,
        name: &str,
        rule: &str,
        valid: impl Fn(&T) -> bool,
    ) -> Result<Option<T>, Problem> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let value = text.parse().ok().filter(valid);
        value.map(Some).ok_or_else(|| Problem::parameter(name, rule))
    }

    /// List of exactly `N` finite numbers.
    pub fn numbers<const N: usize>(&self, name: &str, rule: &str) -> Result<Option<[f64; N]>, Problem> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let read = |part: &str| part.trim().parse().ok().filter(|number: &f64| number.is_finite());
        let numbers: Option<Vec<f64>> = text.split(',').map(read).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.map(Some).ok_or_else(|| Problem::parameter(name, rule))
    }

    /// Time (RFC 3339).
    pub fn time(&self, name: &str) -> Result<Option<Time>, Problem> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let stamp = text.parse::<Timestamp>().ok();
        let time = stamp.and_then(|stamp| i64::try_from(stamp.as_nanosecond()).ok()).map(Time::from_nanos);
        time.map(Some)
            .ok_or_else(|| Problem::parameter(name, "a time is RFC 3339, such as 2026-03-14T09:00:00Z"))
    }

    /// Comma-separated list of values that `read` accepts; `rule` describes them.
    pub fn list<T>(
        &self,
        name: &str,
        read: impl Fn(&str) -> Option<T>,
        rule: impl Fn() -> String,
    ) -> Result<Option<Vec<T>>, Problem> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let values: Option<Vec<T>> = text.split(',').map(|part| read(part.trim())).collect();
        values.map(Some).ok_or_else(|| Problem::parameter(name, rule()))
    }
}
