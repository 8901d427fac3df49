//! Names of recordings: `input-20261120T100000.250Z.pcap`. Their alphabetical order is their order in time.

use std::path::{Path, PathBuf};

use crate::state::{CORRELATIONS, ENGINE};
use fusion::time::{SECOND, Time};

/// Suffix of a file being written.
pub(super) const PART: &str = ".part";

/// Extensions of the files beside a capture.
const BESIDE: [&str; 5] = ["site.toml", "numbers.json", "registration.json", CORRELATIONS, ENGINE];

/// Pattern of a stamp, with 0 for any digit.
const STAMP: &[u8] = b"00000000T000000.000Z";

/// Kind of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Series {
    /// Received datagrams.
    Input,
    /// Sent datagrams.
    Output,
}

impl Series {
    const fn prefix(self) -> &'static str {
        match self {
            Self::Input => "input-",
            Self::Output => "output-",
        }
    }

    /// Name of the file that began at `stamp`, without the extension.
    pub(super) fn name(self, stamp: &str) -> String {
        format!("{}{stamp}", self.prefix())
    }

    /// Whether [`Series::name`] could have made this name.
    fn is_name(self, name: &str) -> bool {
        name.strip_prefix(self.prefix()).is_some_and(|stamp| {
            stamp.len() == STAMP.len()
                && stamp
                    .bytes()
                    .zip(STAMP)
                    .all(|(octet, &of)| if of == b'0' { octet.is_ascii_digit() } else { octet == of })
        })
    }
}

/// A time as in file names: UTC, in milliseconds.
pub(super) fn stamp(time: Time) -> String {
    time.to_string().chars().filter(|c| !matches!(c, '-' | ':')).collect()
}

/// First stamp at or after `time` that no file in `directory` has yet.
pub(super) fn free_stamp(directory: &Path, time: Time) -> String {
    let mut time = time;
    loop {
        let stamp = stamp(time);
        let file = directory.join(Series::Input.name(&stamp) + ".pcap");
        let output = directory.join(Series::Output.name(&stamp) + ".pcap");
        if ![&file, &output].into_iter().any(|file| file.exists() || part(file).exists()) {
            return stamp;
        }
        time = Time::from_nanos(time.nanos().saturating_add(SECOND / 1000));
    }
}

/// Name of a file while it is written.
pub(super) fn part(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(PART);
    name.into()
}

/// Removes all files of the recording that began at `stamp`.
pub(super) fn remove(directory: &Path, stamp: &str) {
    for series in [Series::Input, Series::Output] {
        for extension in std::iter::once("pcap").chain(BESIDE) {
            let file = directory.join(format!("{}.{extension}", series.name(stamp)));
            let _ = std::fs::remove_file(part(&file));
            let _ = std::fs::remove_file(file);
        }
    }
}

/// Series, stamp and extension of a recording's file; `None` for any other file.
pub(super) fn parts(name: &str) -> Option<(Series, &str, &str)> {
    [Series::Input, Series::Output].into_iter().find_map(|series| {
        let (begin, extension) = name.split_at_checked(series.prefix().len() + STAMP.len())?;
        let extension = extension.strip_prefix('.')?;
        let is_beside = series == Series::Input && BESIDE.contains(&extension);
        let is_known = matches!(extension, "pcap" | "pcap.part") || is_beside;
        (is_known && series.is_name(begin)).then(|| (series, &begin[series.prefix().len()..], extension))
    })
}

/// Time of a stamp.
pub(super) fn time(stamp: &str) -> Option<Time> {
    let part = |from: usize, until: usize| stamp.get(from..until);
    let (date, clock) = (part(0, 8)?, part(9, 19)?);
    let text = format!(
        "{}-{}-{}T{}:{}:{}Z",
        &date[..4],
        &date[4..6],
        &date[6..],
        &clock[..2],
        &clock[2..4],
        &clock[4..]
    );
    let nanos = text.parse::<jiff::Timestamp>().ok()?.as_nanosecond();
    i64::try_from(nanos).ok().map(Time::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_own_file_names_are_recognised() {
        let time = Time::from_nanos(1_795_168_800_250_999_999);
        let name = Series::Input.name(&stamp(time));
        assert_eq!(name, "input-20261120T100000.250Z");
        assert!(Series::Input.is_name(&name));
        for other in [
            "output-20261120T100000.250Z",
            "input-20261120T100000.250",
            "input-20261120T100000.250Z2",
            "input-20261120-100000.250Z",
            "input-",
            "my input-20261120T100000.250Z",
        ] {
            assert!(!Series::Input.is_name(other), "{other}");
        }
        let stamp = "20261120T100000.250Z";
        assert_eq!(parts("output-20261120T100000.250Z.pcap"), Some((Series::Output, stamp, "pcap")));
        assert_eq!(parts("input-20261120T100000.250Z.engine"), Some((Series::Input, stamp, "engine")));
        for other in ["input-20261120T100000.250Z.pcap.gz", "input-20261120T100000.250Z", "input-é"] {
            assert_eq!(parts(other), None, "{other}");
        }
        assert_eq!(super::time(stamp), Some(Time::from_nanos(1_795_168_800_250_000_000)));
        assert_eq!(super::time("20269920T100000.250Z"), None);
    }
}
