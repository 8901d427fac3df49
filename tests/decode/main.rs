//! The commands `decode` and `encode`: hand-made records, options, and the recordings of the project.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

// The name used by the tests of the codec, some of which are included here.
extern crate asterix as utm_asterix;

mod all;
mod corpus;
mod editions;
mod encoding;
mod lines;
mod lossless;
mod options;
#[path = "../shared/parquet.rs"]
mod parquet_file;
mod recordings;
#[path = "../shared/mod.rs"]
mod shared;
mod tables;
mod trailers;

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// The octets of these hexadecimal digits; blanks are ignored.
fn octets(hex: &str) -> Vec<u8> {
    let digits: Vec<u32> =
        hex.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_digit(16).unwrap()).collect();
    digits.chunks_exact(2).map(|pair| (pair[0] << 4 | pair[1]) as u8).collect()
}

/// A block with these records.
fn block(category: u8, records: &[&str]) -> Vec<u8> {
    let contents = octets(&records.concat());
    let length = u16::try_from(contents.len() + 3).unwrap().to_be_bytes();
    [&[category, length[0], length[1]], contents.as_slice()].concat()
}

/// A pcap of Ethernet frames with one UDP datagram each, and the offsets of the datagrams in it.
fn pcap(datagrams: &[(u32, &[u8])]) -> (Vec<u8>, Vec<usize>) {
    let mut file = octets("d4c3b2a1 02000400 00000000 00000000 ffff0000 01000000");
    let mut offsets = Vec::new();
    for (seconds, payload) in datagrams {
        let length = payload.len() as u16;
        file.extend(seconds.to_le_bytes());
        file.extend([0; 4]);
        file.extend((u32::from(length) + 42).to_le_bytes().repeat(2));
        file.extend(octets("01005e010101 020000000001 0800"));
        file.extend(octets("4500"));
        file.extend((length + 28).to_be_bytes());
        file.extend(octets("0000 4000 40 11 0000 0a000001 efc03001"));
        file.extend(octets("1f70 1f70"));
        file.extend((length + 8).to_be_bytes());
        file.extend([0; 2]);
        offsets.push(file.len());
        file.extend_from_slice(payload);
    }
    (file, offsets)
}

/// A file that is deleted at the end of the test.
struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str, contents: &[u8]) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("utm-fusion-decode-{}-{number}-{name}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::write(&path, contents).unwrap();
        Self(path)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}
