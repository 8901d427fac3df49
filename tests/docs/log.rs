//! The log's fields in the sources: the JSON format puts them beside members of its own, so no name may occur twice.

use std::fs;
use std::path::{Path, PathBuf};

/// Members of the JSON format in the object of an event, and in that of a span.
const OF_EVENTS: &[&str] = &["timestamp", "level", "message", "target", "span", "spans"];
const OF_SPANS: &[&str] = &["name"];
const EVENTS: &[&str] = &["error!(", "warn!(", "info!(", "debug!(", "trace!(", "event!("];
const SPANS: &[&str] =
    &["error_span!(", "warn_span!(", "info_span!(", "debug_span!(", "trace_span!(", "span!("];

/// Arguments of a macro, of which the opening parenthesis has been read.
fn arguments(text: &str) -> Vec<String> {
    let (mut found, mut depth, mut chars) = (vec![String::new()], 0_u32, text.chars());
    while let Some(char) = chars.next() {
        let last = found.last_mut().unwrap();
        match char {
            '"' => {
                last.push('"');
                while let Some(char) = chars.next() {
                    match char {
                        '\\' => _ = chars.next(),
                        '"' => break,
                        _ => {}
                    }
                }
                continue;
            }
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' if depth == 0 => break,
            ')' | ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                found.push(String::new());
                continue;
            }
            _ => {}
        }
        last.push(char);
    }
    found
}

/// Names of the fields of an event or a span. Arguments of a message follow its text, and are no fields.
fn fields(arguments: &[String], is_span: bool) -> Vec<String> {
    let is_field = |argument: &&String| is_span || !argument.trim().starts_with('"');
    let fields = arguments.iter().skip(usize::from(is_span)).take_while(is_field);
    let name = |argument: &String| {
        let name = argument.split('=').next().unwrap().trim().trim_start_matches(['%', '?']);
        let is_name = |char: char| char.is_alphanumeric() || char == '_' || char == '.';
        // A shorthand has the name of the variable.
        (!name.is_empty() && name.chars().all(is_name)).then(|| name.to_owned())
    };
    fields.filter_map(name).collect()
}

/// Names in a source that occur twice in an object of the JSON format, and the number of events and spans.
fn collisions(source: &str) -> (Vec<String>, usize) {
    let (mut twice, mut count) = (Vec::new(), 0);
    for (macros, members, is_span) in [(EVENTS, OF_EVENTS, false), (SPANS, OF_SPANS, true)] {
        for start in macros {
            for (at, _) in source.match_indices(start) {
                if source[..at].ends_with(|char: char| char.is_alphanumeric() || char == '_') {
                    continue;
                }
                count += 1;
                let mut names = fields(&arguments(&source[at + start.len()..]), is_span);
                names.extend(members.iter().map(|&member| member.to_owned()));
                names.sort();
                twice.extend(names.windows(2).filter(|two| two[0] == two[1]).map(|two| two[0].clone()));
            }
        }
    }
    (twice, count)
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn field_named_as_a_json_member_is_found() {
    for (source, found) in [
        ("error_span!(\"input\", name = line.name())", &["name"][..]),
        ("error_span!(\"input\", line = line.name(), level)", &[]),
        ("info!(%level, site = of(a, \"(\"), \"at {}\", message)", &["level"]),
        ("warn!(sensor, text = f(target), sensor = 5, \"twice\")", &["sensor"]),
        ("some_info!(level, \"another macro\")", &[]),
    ] {
        assert_eq!(collisions(source).0, found, "{source}");
    }
}

#[test]
fn log_fields_differ_from_members_of_the_json_format() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["src", "crates", "fusion/src", "asterix/src", "remote-id/src"] {
        sources(&root.join(folder), &mut files);
    }
    let mut macros = 0;
    for file in files {
        let (twice, count) = collisions(&fs::read_to_string(&file).unwrap());
        assert!(twice.is_empty(), "{}: {twice:?}", file.display());
        macros += count;
    }
    assert!(macros > 150, "{macros} events and spans");
}
