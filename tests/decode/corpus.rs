//! The corpus of the fuzzer (`fuzz/corpus/json`), read like by the fuzz target.

use std::path::Path;

#[path = "../../fuzz/src/json.rs"]
mod json;

#[test]
fn fuzzed_lines() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/json");
    let mut count = 0;
    for file in folder.read_dir().unwrap() {
        let path = file.unwrap().path();
        let octets = std::fs::read(&path).unwrap();
        // Shown only if the test fails: the last line names the file.
        println!("{}", path.display());
        json::exercise(&octets);
        count += 1;
    }
    assert!(count > 0, "{} is empty", folder.display());
}
