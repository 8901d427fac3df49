//! The command `info`: hand-made captures, options, and recordings.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod misread;
mod options;
mod recordings;
mod screen;
#[path = "../shared/mod.rs"]
mod shared;
mod times;
mod totals;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use utm_fusion::commands::{Outcome, info};

/// The octets of these hexadecimal digits; blanks are ignored.
fn octets(hex: &str) -> Vec<u8> {
    let digits: Vec<u32> =
        hex.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_digit(16).unwrap()).collect();
    digits.chunks_exact(2).map(|pair| (pair[0] << 4 | pair[1]) as u8).collect()
}

/// A block with these records.
fn block(category: u8, records: &[String]) -> Vec<u8> {
    let contents = octets(&records.concat());
    let length = u16::try_from(contents.len() + 3).unwrap().to_be_bytes();
    [&[category, length[0], length[1]], contents.as_slice()].concat()
}

/// A CAT048 record of SAC 25: I048/010, 140, 161.
fn plot(sic: u8, time_s: f64, track: u16) -> String {
    format!("c110 19{sic:02x} {:06x} {track:04x}", (time_s * 128.0) as u32)
}

/// A CAT129 record of SAC 0, SIC 0: I129/010, 040, 070.
fn fix(time_s: f64, serial: u8) -> String {
    format!("8a 0000 4452 4f4e 4500 0000 0000 00{serial:02x} {:06x}", (time_s * 128.0) as u32)
}

/// A pcap of Ethernet frames with one UDP datagram each, from 10.0.0.1 to the given port on 239.192.48.1. Times are in seconds
/// since the epoch.
fn pcap(datagrams: &[(f64, u16, Vec<u8>)]) -> Vec<u8> {
    let mut file = octets("d4c3b2a1 02000400 00000000 00000000 ffff0000 01000000");
    for (second, port, payload) in datagrams {
        let length = payload.len() as u16;
        file.extend((*second as u32).to_le_bytes());
        file.extend(((second.fract() * 1e6).round() as u32).to_le_bytes());
        file.extend((u32::from(length) + 42).to_le_bytes().repeat(2));
        file.extend(octets("01005e010101 020000000001 0800 4500"));
        file.extend((length + 28).to_be_bytes());
        file.extend(octets("0000 4000 40 11 0000 0a000001 efc03001 1f70"));
        file.extend(port.to_be_bytes());
        file.extend((length + 8).to_be_bytes());
        file.extend([0; 2]);
        file.extend_from_slice(payload);
    }
    file
}

/// A frame of a pcap without IP.
fn arp() -> Vec<u8> {
    octets("00000000 00000000 10000000 10000000 ffffffffffff 020000000001 0806 0001")
}

/// Output of `info` for these files, and its outcome.
fn info(paths: &[&Path], json: bool, strict: bool) -> (String, Outcome) {
    let inputs = paths.iter().map(|path| path.to_path_buf()).collect();
    let mut out = Vec::new();
    let outcome = info::run(&info::Args { inputs, json, strict, ..Default::default() }, &mut out).unwrap();
    (String::from_utf8(out).unwrap(), outcome)
}

/// Output of `info --json` for a file with these octets.
fn json(name: &str, octets: &[u8]) -> Value {
    let file = Temporary::new(name, octets);
    serde_json::from_str(&info(&[&file.0], true, false).0).unwrap()
}

/// A file or folder that is deleted at the end of the test.
struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str, contents: &[u8]) -> Self {
        let path = std::env::temp_dir().join(format!("utm-fusion-info-{}-{name}", std::process::id()));
        fs::write(&path, contents).unwrap();
        Self(path)
    }

    fn folder(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("utm-fusion-info-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = if self.0.is_dir() { fs::remove_dir_all(&self.0) } else { fs::remove_file(&self.0) };
    }
}
