//! The corpus of the fuzzer (`fuzz/corpus/captures`), read like by the fuzz target.

use std::path::Path;

#[path = "../../fuzz/src/captures.rs"]
mod captures;

#[test]
fn fuzzed_captures() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/captures");
    let mut count = 0;
    for file in folder.read_dir().unwrap() {
        let path = file.unwrap().path();
        let octets = std::fs::read(&path).unwrap();
        // Shown only if the test fails: the last line names the file.
        println!("{}", path.display());
        captures::exercise(&octets);
        count += 1;
    }
    assert!(count > 0, "{} is empty", folder.display());
}
