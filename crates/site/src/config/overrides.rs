//! Override of single keys by the environment: `UTM_FUSION__SECTION__KEY`.

use tables::error::{Faults, Place};
use tables::tree::{Node, Table, Value, parse_variable};

const PREFIX: &str = "UTM_FUSION__";

/// Inserts the variables of `env` that have the prefix into `root`. Invalid values and unknown keys are reported later by the
/// readers of the tables, which name the variable.
pub(super) fn apply(root: &mut Table, env: impl Iterator<Item = (String, String)>, faults: &Faults) {
    let mut variables: Vec<_> = env.filter(|(name, _)| name.starts_with(PREFIX)).collect();
    // The order of an environment is arbitrary; after sorting, a table comes before its keys.
    variables.sort();
    for (name, text) in variables {
        let path: Vec<String> = name[PREFIX.len()..].split("__").map(str::to_lowercase).collect();
        if let Err(message) = set(root, &path, parse_variable(&name, &text)) {
            faults.add(&Place::Variable(name), &path.join("."), None, message);
        }
    }
}

fn set(root: &mut Table, path: &[String], node: Node) -> Result<(), String> {
    if let [array @ ("sensors" | "areas"), ..] = path.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        return Err(format!("[[{array}]] is set in the file only; remove the variable and edit the file"));
    }
    let Some((key, tables)) = path.split_last().filter(|(_, tables)| !tables.is_empty()) else {
        return Err(
            "this names no key; write UTM_FUSION__SECTION__KEY, such as UTM_FUSION__FUSION__LATENCY_S".into(),
        );
    };
    let mut table = root;
    for name in tables {
        if name == "transponder_numbers" {
            // Names of variables do not preserve the case of a serial.
            return Err("serials are set together; write \
                 UTM_FUSION__FUSION__TRANSPONDER_NUMBERS={ \"DRONE-ALPHA\" = 7 }"
                .into());
        }
        let empty = || Node { place: node.place.clone(), value: Value::Table(Table::new()) };
        match &mut table.entry(name.clone()).or_insert_with(empty).value {
            Value::Table(inner) => table = inner,
            other => {
                return Err(format!("{name} is {}, which has no keys; set {name} as a whole", other.kind()));
            }
        }
    }
    table.insert(key.clone(), node);
    Ok(())
}
