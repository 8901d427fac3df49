//! What fuzzing found worth keeping (`fuzz/corpus/json`), read again as the fuzz target reads it.

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
        // Seen only when the test fails, in its last line.
        println!("{}", path.display());
        json::exercise(&octets);
        count += 1;
    }
    assert!(count > 0, "{} is empty", folder.display());
}
