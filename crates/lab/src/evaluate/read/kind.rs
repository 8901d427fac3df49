//! Detects the kind of a file from its beginning.

use std::fmt;

/// A kind of file that `evaluate` reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// True paths of drones.
    Truth,
    /// The drone behind each plot and transponder.
    Labels,
    /// Attacks on transponders.
    Attacks,
    /// A tracker's output.
    Output,
}

impl FileKind {
    /// Place of the file on the command line.
    pub(super) fn place(self) -> &'static str {
        match self {
            Self::Truth => "--truth takes it",
            Self::Labels => "--labels takes them",
            Self::Attacks => "--attacks takes them",
            Self::Output => "it stands without an option: utm-fusion evaluate OUTPUT --truth TRUTH",
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Truth => "a truth (where the drones really were)",
            Self::Labels => "a file of labels (which drone each plot was)",
            Self::Attacks => "a file of attacks (what was done to transponders)",
            Self::Output => "a tracker's output",
        })
    }
}

/// Number of octets that are checked to distinguish text from binary data.
const SAMPLE: usize = 512;

/// Whether a file is text; false for an empty file.
pub(super) fn is_text(octets: &[u8]) -> bool {
    let sample = &octets[..octets.len().min(SAMPLE)];
    !sample.is_empty() && !sample.iter().any(|&octet| octet < b' ' && !b"\t\r\n".contains(&octet))
}

/// Kind of a file with this beginning; `None` if it is not evident, as for binary data.
pub fn kind(octets: &[u8]) -> Option<FileKind> {
    if !is_text(octets) {
        return None;
    }
    let text = String::from_utf8_lossy(octets);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    match text.chars().next()? {
        '{' => return Some(FileKind::Output),
        '<' => return Some(FileKind::Truth),
        _ => {}
    }
    let columns: Vec<&str> =
        text.lines().next()?.split(',').map(|name| name.trim().trim_matches('"')).collect();
    let has = |names: &[&str]| names.iter().all(|name| columns.contains(name));
    if has(&["time", "lat", "lon", "source", "track_number"])
        || has(&["time", "lat", "lon", "kind", "number"])
    {
        Some(FileKind::Output)
    } else if has(&["time", "id", "lat", "lon", "alt_msl"]) {
        Some(FileKind::Truth)
    } else if has(&["time", "sensor", "number", "id"]) {
        Some(FileKind::Labels)
    } else if has(&["id", "number", "attack", "from", "until"]) {
        Some(FileKind::Attacks)
    } else {
        None
    }
}
