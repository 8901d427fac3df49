//! Tables of `decode`, compared cell by cell with its JSON lines.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use super::lossless::{CAT034, CAT048, CAT065, CAT129};
use super::parquet_file::rows;
use super::{Temporary, octets};

type Row = BTreeMap<String, Value>;

/// Times of day: the only JSON numbers whose key has no unit.
const TIMES: [&str; 12] = [
    "I015_145", "I021_071", "I021_073", "I021_075", "I021_077", "I023_070", "I034_030", "I048_140",
    "I062_070", "I063_030", "I065_030", "I129_070",
];

/// Members without a column: bits and octets without a meaning.
const LOSSLESS: [&str; 3] = ["more", "primary", "undescribed"];

fn decode(arguments: &[&str], input: &Path) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_utm-fusion"));
    let output = command.arg("decode").arg(input).args(arguments).output().unwrap();
    let text = |octets| String::from_utf8(octets).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// A directory that is deleted at the end of the test.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("utm-fusion-decode-{}-{name}", std::process::id())))
    }

    fn path(&self) -> &str {
        self.0.to_str().unwrap()
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The cells of an item or a part of it.
fn flatten(row: &mut Row, name: &str, value: &Value) {
    match value {
        Value::Null => {}
        Value::Object(members) if members.len() == 1 && members.contains_key("hex") => {
            row.insert(name.to_owned(), json!(value.to_string()));
        }
        Value::Object(members) => {
            for (key, value) in members {
                if !key.starts_with("spare") && !LOSSLESS.contains(&key.as_str()) {
                    flatten(row, &format!("{name}_{key}"), value);
                }
            }
        }
        Value::Array(_) => {
            row.insert(name.to_owned(), json!(value.to_string()));
        }
        Value::String(_) if name.ends_with("_SP") || name.ends_with("_RE") => {
            row.insert(format!("{name}_hex"), value.clone());
        }
        _ => {
            let is_time = TIMES.contains(&name);
            row.insert(format!("{name}{}", if is_time { "_s" } else { "" }), value.clone());
        }
    }
}

/// The expected rows of each table for these lines.
fn expected(lines: &str) -> BTreeMap<String, Vec<Row>> {
    let mut tables = BTreeMap::<String, Vec<Row>>::new();
    for line in lines.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        let mut row = Row::new();
        for member in ["offset", "block", "input", "hex"] {
            flatten(&mut row, member, &line[member]);
        }
        let table = if let Some(items) = line.get("items") {
            if let Some(time) = line["time"].as_str() {
                let time: jiff::Timestamp = time.parse().unwrap();
                row.insert("time".to_owned(), json!(time.as_millisecond()));
            }
            flatten(&mut row, "sac", &line["sac"]);
            flatten(&mut row, "sic", &line["sic"]);
            for (item, value) in items.as_object().unwrap() {
                flatten(&mut row, &format!("I{:03}_{item}", line["cat"].as_u64().unwrap()), value);
            }
            format!("cat{:03}", line["cat"].as_u64().unwrap())
        } else {
            flatten(&mut row, "category", &line["cat"]);
            let error = &line["error"];
            flatten(&mut row, "item", &error["item"]);
            if error["kind"] != "skipped" {
                flatten(&mut row, "detail", &error["detail"]);
            }
            let other = if line.get("trailer").is_some() { "trailer" } else { "block" };
            row.insert("kind".to_owned(), json!(error["kind"].as_str().unwrap_or(other)));
            "unread".to_owned()
        };
        tables.entry(table).or_default().push(row);
    }
    tables
}

fn is_same(one: Option<&Value>, other: Option<&Value>) -> bool {
    let number = |value: Option<&Value>| value.and_then(Value::as_f64);
    one == other || number(one).is_some_and(|one| number(other) == Some(one))
}

/// Compares both kinds of tables of this input with its lines; returns the number of rows.
fn check(input: &Path, name: &str) -> usize {
    let (code, lines, _) = decode(&["--hex"], input);
    let expected = expected(&lines);
    let directory = Directory::new(name);
    let tables = decode(&["--hex", "--format", "parquet", "-o", directory.path()], input);
    assert_eq!((tables.0, tables.1.as_str()), (code, ""), "{}", tables.2);
    assert_eq!(decode(&["--hex", "--format", "csv", "-o", directory.path()], input).0, code);
    assert_eq!(fs::read_dir(&directory.0).unwrap().count(), 2 * expected.len());
    for (table, expected) in &expected {
        let rows = rows(fs::read(directory.0.join(format!("{table}.parquet"))).unwrap());
        assert_eq!(rows.len(), expected.len(), "{table}");
        for (row, expected) in rows.iter().zip(expected) {
            for column in row.keys().chain(expected.keys()) {
                let (mut cell, expected) = (row.get(column).cloned(), expected.get(column));
                if column == "time" {
                    // Times in JSON lines are in milliseconds.
                    cell = cell.and_then(|cell| cell.as_i64()).map(|micros| json!(micros.div_euclid(1000)));
                }
                assert!(is_same(cell.as_ref(), expected), "{table}, {column}: {cell:?}, not {expected:?}");
            }
        }
        let mut csv = csv::Reader::from_path(directory.0.join(format!("{table}.csv"))).unwrap();
        let names = csv.headers().unwrap().clone();
        for (record, expected) in csv.records().map(Result::unwrap).zip(expected) {
            for (name, cell) in names.iter().zip(&record).filter(|(name, _)| *name != "time") {
                let expected = match expected.get(name) {
                    None => String::new(),
                    Some(Value::String(text)) => text.clone(),
                    Some(number) => number.as_f64().unwrap().to_string(),
                };
                assert_eq!(cell, expected, "{table}, {name}");
            }
        }
    }
    expected.values().map(Vec::len).sum()
}

#[test]
fn a_cell_for_every_scalar_whatever_the_bits() {
    let mut file = Vec::new();
    for (category, hex) in [(34, CAT034), (48, CAT048), (65, CAT065), (129, CAT129)] {
        let record = octets(hex);
        for bit in 0..=record.len() * 8 {
            let mut flipped = record.clone();
            if let Some(octet) = flipped.get_mut(bit / 8) {
                *octet ^= 0x80 >> (bit % 8);
            }
            let length = u16::try_from(flipped.len() + 3).unwrap().to_be_bytes();
            file.extend([&[category, length[0], length[1]], flipped.as_slice()].concat());
        }
    }
    let input = Temporary::new("flips", &file);
    let rows = check(&input.0, "flips");
    assert!(rows > 2000, "{rows}");
}

#[test]
fn the_flight_of_the_demonstration() {
    let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap");
    assert_eq!(check(&input, "demo"), 1344);
}

#[test]
fn recordings_of_every_category() {
    let Some(data) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let mut rows = 0;
    for name in ["cat048-barcelona", "cat021-barcelona", "cat062-system-track", "cat048-croatia"] {
        for entry in fs::read_dir(Path::new(&data).join(name)).unwrap() {
            let path = entry.unwrap().path();
            let is_recording =
                path.extension().is_some_and(|kind| kind == "ast" || kind == "pcap" || kind == "ff");
            if is_recording && fs::metadata(&path).unwrap().len() < 2_000_000 {
                rows += check(&path, name);
            }
        }
    }
    println!("{rows} rows");
    assert!(rows > 1000);
}

#[test]
fn one_table_to_standard_output() {
    let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap");
    let (code, text, _) = decode(&["--format", "csv", "--cat", "129", "--limit", "2"], &input);
    assert_eq!((code, text.lines().count()), (0, 3));
    assert!(text.starts_with("time,input,offset,block,sac,sic,hex,I129_010_sac,"), "{text}");
    let (_, text, _) = decode(&["--format", "csv", "--errors-only"], &input);
    assert_eq!(text.lines().count(), 3);
    assert!(
        text.starts_with("kind,input,offset,block,category,item,detail,hex\nblock_past_end,,13199,"),
        "{text}"
    );
}

#[test]
fn what_makes_no_sense() {
    let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap");
    for (arguments, problem) in [
        (&["--format", "parquet"][..], "--format parquet needs a directory: -o DIR"),
        (&["--format", "csv"], "--format csv: a table per category needs -o DIR, or --cat for one of them"),
        (&["-o", "x"], "-o is for tables: --format csv or --format parquet"),
        (&["-o", "/dev/null/x", "--format", "csv"], "/dev/null/x: cannot be written: Not a directory"),
    ] {
        let (code, out, error) = decode(arguments, &input);
        assert!(code != 0 && out.is_empty() && error.contains(problem), "{arguments:?}: {error}");
    }
    let directory = Directory::new("input");
    fs::create_dir(&directory.0).unwrap();
    let within = directory.0.join("cat048.csv");
    fs::copy(&input, &within).unwrap();
    let (code, _, error) = decode(&["--format", "csv", "-o", directory.path()], &within);
    assert_eq!(code, 2);
    assert!(fs::read(&within).unwrap() == fs::read(&input).unwrap());
    assert!(error.contains("is in that directory and might be overwritten"), "{error}");
}
