//! Differences between two configurations, key by key.

use std::collections::BTreeSet;
use std::fmt::{self, Display, Formatter};

use toml::{Table, Value};

use super::Config;

/// A key whose value differs. Values are TOML; `None` where a configuration lacks the key.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigChange {
    /// Path of the key. Entries of a list that have an id are named by it: `sensors.north.latitude_deg`.
    pub key: String,
    /// Value in the first configuration.
    pub old: Option<Value>,
    /// Value in the second configuration.
    pub new: Option<Value>,
}

/// Writes `site.name = "north", was "south"`; long values are left out.
impl Display for ConfigChange {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { key, old, new } = self;
        match (old, new, old.as_ref().and_then(short), new.as_ref().and_then(short)) {
            (.., Some(old), Some(new)) => write!(f, "{key} = {new}, was {old}"),
            (None, Some(_), _, Some(new)) => write!(f, "{key} = {new}, was not there"),
            (None, ..) => write!(f, "{key}, was not there"),
            (Some(_), None, Some(old), _) => write!(f, "{key} is gone, was {old}"),
            (Some(_), None, ..) => write!(f, "{key} is gone"),
            _ => write!(f, "{key} is another"),
        }
    }
}

fn short(value: &Value) -> Option<String> {
    const LONGEST: usize = 120;
    let shown = (!value.is_table()).then(|| value.to_string())?;
    (shown.len() <= LONGEST && !shown.contains('\n')).then_some(shown)
}

/// Changes from `old` to `new`, in the order of the keys. Both configurations are compared as TOML with all defaults filled in,
/// so every key is covered.
pub fn changes(old: &Config, new: &Config) -> Vec<ConfigChange> {
    let tree = |config: &Config| {
        Value::Table(config.to_string().parse::<Table>().expect("what is shown reads back"))
    };
    let mut changes = Vec::new();
    compare("", Some(tree(old)), Some(tree(new)), &mut changes);
    changes
}

fn compare(key: &str, old: Option<Value>, new: Option<Value>, changes: &mut Vec<ConfigChange>) {
    if old == new {
        return;
    }
    match (old, new) {
        (Some(Value::Table(old)), Some(Value::Table(new))) => compare_tables(key, old, new, changes),
        (Some(Value::Array(old)), Some(Value::Array(new))) => match (by_id(&old), by_id(&new)) {
            (Some(before), Some(after)) if common(&old, &after).eq(common(&new, &before)) => {
                compare_tables(key, before, after, changes);
            }
            // The ids are in another order or missing: the list is compared as a whole.
            _ => changes.push(ConfigChange {
                key: key.to_owned(),
                old: Some(Value::Array(old)),
                new: Some(Value::Array(new)),
            }),
        },
        (old, new) => changes.push(ConfigChange { key: key.to_owned(), old, new }),
    }
}

fn compare_tables(path: &str, mut old: Table, mut new: Table, changes: &mut Vec<ConfigChange>) {
    let keys: BTreeSet<String> = old.keys().chain(new.keys()).cloned().collect();
    for key in keys {
        let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        compare(&inner, old.remove(&key), new.remove(&key), changes);
    }
}

/// Entries of a list by id; `None` if an entry has no id.
fn by_id(list: &[Value]) -> Option<Table> {
    let entry = |value: &Value| Some((value.get("id")?.as_str()?.to_owned(), value.clone()));
    list.iter().map(entry).collect()
}

/// Ids of `list` that `other` contains too, in the order of `list`.
fn common<'a>(list: &'a [Value], other: &'a Table) -> impl Iterator<Item = &'a str> {
    let id = |entry: &'a Value| entry.get("id")?.as_str();
    list.iter().filter_map(id).filter(|id| other.contains_key(*id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Auth;

    #[test]
    fn each_key_is_named_and_a_sensor_by_its_id() {
        let text = include_str!("../../../../config/example.toml");
        let config = Config::parse(text, "config/example.toml", std::iter::empty()).unwrap();
        let told = |change: &dyn Fn(&mut Config)| {
            let mut other = config.clone();
            change(&mut other);
            changes(&config, &other).iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(told(&|_| {}), [""; 0]);
        let few = told(&|config| {
            config.sensors[1].period_s = Some(1.0);
            config.site.name = "other".to_owned();
            config.site.geoid_undulation_m = None;
            config.output.record = None;
            config.http.auth = Auth::Tokens { tokens_file: "/etc/tokens".into() };
        });
        assert_eq!(
            few,
            [
                "http.auth.mode = \"tokens\", was \"none\"",
                "http.auth.tokens_file = \"/etc/tokens\", was not there",
                "output.record is gone",
                "sensors.ground-station.period_s = 1.0, was 2.0",
                "site.geoid_undulation_m is gone, was 46.9",
                "site.name = \"other\", was \"example\"",
            ]
        );
        assert_eq!(told(&|config| drop(config.sensors.remove(1))), ["sensors.ground-station is gone"]);
        let renamed = told(&|config| config.sensors[1].id = "ground".to_owned());
        assert_eq!(renamed, ["sensors.ground, was not there", "sensors.ground-station is gone"]);
        // The order matters, because the first radar is the origin.
        assert_eq!(told(&|config| config.sensors.reverse()), ["sensors is another"]);
    }
}
