//! What fuzzing found worth keeping (`fuzz/corpus`), read again as the fuzz targets read it.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

use std::path::Path;

use asterix::{cat034, cat048, cat129};

#[path = "../../fuzz/src/records.rs"]
mod records;

fn replay(target: &str, exercise: impl Fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target);
    let mut count = 0;
    for file in folder.read_dir().unwrap() {
        let path = file.unwrap().path();
        let octets = std::fs::read(&path).unwrap();
        // Seen only when the test fails, in its last line.
        println!("{}", path.display());
        exercise(&octets);
        count += 1;
    }
    assert!(count > 0, "{} is empty", folder.display());
}

#[test]
fn cat034() {
    replay("cat034", |octets| records::measure(34, &cat034::UAP, octets));
}

#[test]
fn cat048() {
    replay("cat048", |octets| records::exercise_with::<cat048::Record>(octets, &cat048::UAP));
}

#[test]
fn cat129() {
    replay("cat129", records::exercise::<cat129::Record>);
}
