//! Values of the API from fixed sets: schemas take each set from the type that has the values.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::common::Site;

/// Texts written by the program that are not from a closed set, by type and field.
const FREE: [(&str, &str); 9] = [
    ("ConflictList", "reason"),        // human-readable text
    ("CellState", "left_out"),         // human-readable text
    ("ProblemJson", "title"),          // reason phrases of HTTP
    ("ReadsbReceiver", "version"),     // version of the program
    ("ServiceInfo", "version"),        // version of the program
    ("FaultCount", "reason"),          // names of counters, extended by releases
    ("RefusedCount", "reason"),        // names of counters
    ("SensorStatusJson", "refused"),   // names of counters
    ("InputCounters", "untranslated"), // names of counters
];

fn files(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Types with a schema: name, and lines of code.
fn described(code: &str) -> Vec<(String, Vec<&str>)> {
    let lines: Vec<&str> = code.lines().collect();
    let derives = |line: &&str| line.trim_start().starts_with("#[derive(") && line.contains("JsonSchema");
    let begins = (0..lines.len()).filter(|&index| derives(&lines[index]));
    let whole = |begin: usize| {
        let head = lines[begin..]
            .iter()
            .position(|line| line.contains("struct ") || line.contains("enum "))
            .unwrap();
        let mut words = lines[begin + head].split(|c: char| !c.is_alphanumeric() && c != '_');
        let name = words.by_ref().skip_while(|word| !matches!(*word, "struct" | "enum")).nth(1).unwrap();
        let rest = &lines[begin + head..];
        let end = rest.iter().position(|line| line.ends_with(';') || *line == "}").unwrap_or(rest.len());
        (name.to_owned(), lines[begin..=begin + head + end.min(rest.len() - 1)].to_vec())
    };
    begins.map(whole).collect()
}

/// Faults of a type with a schema.
fn complaints(name: &str, lines: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    let mut attributes = String::new();
    for line in lines.iter().map(|line| line.trim()) {
        if line.starts_with("///") {
            continue;
        }
        if line.starts_with("#[") || (!attributes.is_empty() && !attributes.ends_with(")]")) {
            attributes.push_str(line);
            continue;
        }
        let has_set = ["\"enum\"", "\"const\""].into_iter().find_map(|key| attributes.split_once(key));
        if has_set.is_some_and(|(_, rest)| rest.contains('"')) {
            found.push(format!("{name}: a set written by hand: {attributes}"));
        }
        let field = line.trim_start_matches("pub ").split(':').next().unwrap_or_default();
        let is_free = FREE.contains(&(name, field));
        if line.contains("&'static str") && has_set.is_none() && !is_free {
            found.push(format!("{name}: `{line}` has no set of values"));
        }
        attributes.clear();
    }
    found
}

#[test]
fn schemas_take_closed_sets_from_types() {
    let mut paths = Vec::new();
    files(Path::new("crates"), &mut paths);
    let codes: Vec<String> = paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    let all: Vec<_> = codes.iter().flat_map(|code| described(code)).collect();
    assert!(all.len() > 80, "only {} types with a schema are found", all.len());
    let found: Vec<String> = all.iter().flat_map(|(name, lines)| complaints(name, lines)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn sets_written_by_hand_are_found() {
    let code = "#[derive(Serialize, JsonSchema)]\nstruct A {\n    #[schemars(extend(\"enum\" = [\"x\"]))]\n    a: u8,\n    /// b\n    b: Option<&'static str>,\n}\n";
    let [(name, lines)] = &described(code)[..] else { panic!() };
    assert_eq!(name, "A");
    assert_eq!(complaints(name, lines).len(), 2, "{:?}", complaints(name, lines));
}

/// A parameter with a fixed set of values lists them, and its description names each.
#[tokio::test]
async fn parameters_list_their_values() {
    let document = Site::plain().get("/openapi.json").await.json();
    let paths = document["paths"].as_object().unwrap();
    let operations = paths.values().flat_map(|path| path.as_object().unwrap().values());
    let parameters: Vec<&Value> =
        operations.flat_map(|operation| operation["parameters"].as_array().unwrap()).collect();
    let with = |name: &str| {
        let found = parameters.iter().find(|parameter| parameter["name"] == name);
        found.unwrap_or_else(|| panic!("no parameter {name}"))
    };
    for (name, values) in [
        ("source", "fused|radar|transponder|camera"),
        ("class", "drone|crewed|vehicle|other|unknown"),
        ("integrity", "unverified|verified|suspect|failed|none"),
        ("include", "competitors"),
    ] {
        let parameter = with(name);
        assert_eq!(parameter["schema"]["pattern"], format!("^({values})(,({values}))*$"), "{name}");
        let description = parameter["description"].as_str().unwrap();
        values.split('|').for_each(|value| assert!(description.contains(value), "{name}: {value}"));
    }
    for name in ["at", "level", "format", "verdict"] {
        let parameter = with(name);
        let description = parameter["description"].as_str().unwrap();
        let values = parameter["schema"]["enum"].as_array().unwrap_or_else(|| panic!("{name}: no enum"));
        for value in values {
            assert!(description.contains(value.as_str().unwrap()), "{name}: {value}");
        }
    }
    assert!(with("kind")["schema"]["pattern"].as_str().unwrap().contains("|emergency"));
}
