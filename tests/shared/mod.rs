//! Folders of captures, for tests of several commands.

use std::fs;
use std::path::{Path, PathBuf};

/// The folder of real recordings, which are not part of the project; `None`, with a message, if none is given.
pub fn recordings() -> Option<PathBuf> {
    let folder = std::env::var_os("UTM_FUSION_SHARED_DATA");
    if folder.is_none() {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    }
    folder.map(PathBuf::from)
}

/// Folders of other inputs, which have their own tests: radio frames (Wi-Fi, Bluetooth), and field cases.
const OTHERS: [&str; 2] = ["remote-id-radio", "field-cases"];

/// The captures of UDP datagrams and of ASTERIX in a folder and its subfolders.
pub fn captures(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if OTHERS.iter().any(|name| path.ends_with(name)) {
            continue;
        }
        let is_capture =
            |end: &std::ffi::OsStr| ["pcap", "ast", "raw", "bin"].iter().any(|known| end == *known);
        if path.is_dir() {
            found.extend(captures(&path));
        } else if path.extension().is_some_and(is_capture) {
            found.push(path);
        }
    }
    found
}
