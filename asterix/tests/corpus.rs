//! The corpus of the fuzzer (`fuzz/corpus`), read like by the fuzz targets. It is not part of the published package, nor is this
//! file.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

// The name used by the fuzz targets.
extern crate utm_asterix as asterix;

use std::path::Path;

use asterix::cat021::Edition;
use asterix::{AnyRecord, Record, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129};

#[cfg(feature = "all")]
#[path = "../../fuzz/src/all.rs"]
mod all;
#[path = "common/any.rs"]
mod any;
#[cfg(feature = "all")]
#[allow(dead_code, reason = "its generator is used here")]
#[path = "common/damage.rs"]
mod damaging;
#[path = "../../fuzz/src/records.rs"]
mod records;

fn replay(target: &str, exercise: impl Fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target);
    let mut count = 0;
    for file in folder.read_dir().unwrap() {
        let path = file.unwrap().path();
        let octets = std::fs::read(&path).unwrap();
        // Shown only if the test fails: the last line names the file.
        println!("{}", path.display());
        exercise(&octets);
        count += 1;
    }
    assert!(count > 0, "{} is empty", folder.display());
}

/// Every block of this category in the folder with that name, decoded as any category.
fn any<R>(target: &str, edition: R::Edition)
where
    R: Record + Into<AnyRecord> + std::fmt::Debug,
{
    let count = std::cell::Cell::new(0);
    replay(target, |octets| {
        for block in blocks(octets).flatten().filter(|block| block.category == R::CATEGORY) {
            count.set(count.get() + any::compare::<R>(&block, edition, Edition::default()));
        }
    });
    assert!(count.get() > 0, "{target} has no record");
}

#[test]
fn of_whichever_category() {
    any::<cat015::Record>("cat015", ());
    any::<cat021::Record>("cat021", Edition::default());
    any::<cat034::Record>("cat034", ());
    any::<cat048::Record>("cat048", ());
    any::<cat062::Record>("cat062", ());
    any::<cat063::Record>("cat063", ());
    any::<cat065::Record>("cat065", ());
    any::<cat129::Record>("cat129", ());
}

#[test]
fn cat015() {
    replay("cat015", records::exercise_with_table::<cat015::Record>);
}

#[test]
fn cat063() {
    replay("cat063", records::exercise_with_table::<cat063::Record>);
}

#[test]
fn cat062() {
    replay("cat062", records::exercise_with_table::<cat062::Record>);
}

#[test]
fn cat021() {
    replay("cat021", records::exercise_with_table::<cat021::Record>);
}

#[test]
fn cat034() {
    replay("cat034", records::exercise_with_table::<cat034::Record>);
}

#[test]
fn cat048() {
    replay("cat048", records::exercise_with_table::<cat048::Record>);
}

#[test]
fn cat065() {
    replay("cat065", records::exercise_with_table::<cat065::Record>);
}

#[test]
fn cat129() {
    replay("cat129", records::exercise::<cat129::Record>);
}

#[cfg(feature = "all")]
#[test]
fn all() {
    replay("all", all::exercise);
    let mut random = damaging::Random(0x6675_7a7a_6675_7a7a);
    for _ in 0..100_000 {
        let octets: Vec<u8> = (0..random.below(50)).map(|_| random.octet()).collect();
        all::exercise(&octets);
    }
}
