//! Names of recordings: `input-20261120T100000.250Z.pcap`, so that their order is that of time.

use std::io;
use std::path::{Path, PathBuf};

use crate::state::{CORRELATIONS, ENGINE};
use fusion::time::{SECOND, Time};

/// What a file has behind its name while it is written.
pub(super) const PART: &str = ".part";

/// What may stand beside a file.
const BESIDE: [&str; 5] = ["site.toml", "numbers.json", "registration.json", CORRELATIONS, ENGINE];

/// What is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Series {
    /// What was received.
    Input,
    /// What was sent.
    Output,
}

impl Series {
    const fn prefix(self) -> &'static str {
        match self {
            Self::Input => "input-",
            Self::Output => "output-",
        }
    }

    /// The name of its file that began at `stamp`, without the extension.
    pub(super) fn name(self, stamp: &str) -> String {
        format!("{}{stamp}", self.prefix())
    }

    /// Whether that is what [`Series::name`] makes.
    fn is_name(self, name: &str) -> bool {
        const PATTERN: &[u8] = b"00000000T000000.000Z";
        name.strip_prefix(self.prefix()).is_some_and(|stamp| {
            stamp.len() == PATTERN.len()
                && stamp
                    .bytes()
                    .zip(PATTERN)
                    .all(|(octet, &of)| if of == b'0' { octet.is_ascii_digit() } else { octet == of })
        })
    }
}

/// A time as it stands in names: UTC, to the millisecond.
pub(super) fn stamp(time: Time) -> String {
    time.to_string().chars().filter(|c| !matches!(c, '-' | ':')).collect()
}

/// A stamp at or after `time` that no file in `directory` has yet.
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

/// The file while it is written.
pub(super) fn part(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(PART);
    name.into()
}

/// Names (without extension) of the files of a series that end in `extension`, oldest first.
fn names(directory: &Path, series: Series, extension: &str) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        let name = entry?.file_name();
        let name = name.to_str().and_then(|name| name.strip_suffix(extension));
        names.extend(name.filter(|name| series.is_name(name)).map(str::to_owned));
    }
    names.sort_unstable();
    Ok(names)
}

/// Removes what there is of the files that began at `stamp`.
pub(super) fn remove(directory: &Path, stamp: &str) {
    for series in [Series::Input, Series::Output] {
        for extension in std::iter::once("pcap").chain(BESIDE) {
            let file = directory.join(format!("{}.{extension}", series.name(stamp)));
            let _ = std::fs::remove_file(part(&file));
            let _ = std::fs::remove_file(file);
        }
    }
}

/// Gives the files that an interrupted recorder left their names; how many there were.
pub(super) fn complete_leftovers(directory: &Path) -> io::Result<usize> {
    let mut count = 0;
    for series in [Series::Input, Series::Output] {
        for name in names(directory, series, ".pcap.part")? {
            let file = directory.join(name + ".pcap");
            std::fs::rename(part(&file), &file)?;
            count += 1;
        }
    }
    Ok(count)
}

/// Removes the oldest files of both series until `keep` of each are left, the one being written counted, with what stands
/// beside them. Other files are left alone.
pub(super) fn remove_oldest(directory: &Path, keep: usize) -> io::Result<()> {
    for series in [Series::Input, Series::Output] {
        let mut all = names(directory, series, ".pcap")?;
        let written = names(directory, series, ".pcap.part")?.len();
        let keep = keep.saturating_sub(written);
        all.truncate(all.len().saturating_sub(keep));
        for name in all {
            std::fs::remove_file(directory.join(format!("{name}.pcap")))?;
            for beside in BESIDE {
                match std::fs::remove_file(directory.join(format!("{name}.{beside}"))) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                    _ => {}
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_own_names_are_names() {
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
    }
}
