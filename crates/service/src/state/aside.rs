//! Damaged files of `[state] dir` are renamed to `<name>.damaged-<time>`; the newest few of each are kept.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use fusion::time::{SECOND, Time};

/// Number of damaged files kept under each name.
const KEPT: usize = 3;

/// Renames a damaged file, or a directory in its place; returns its new path. Older ones of the same name are removed.
///
/// # Errors
/// It cannot be renamed.
pub fn set_aside(directory: &Path, name: &str, now: Time) -> io::Result<PathBuf> {
    let mut time = now;
    let aside = loop {
        let stamp: String = time.to_string().chars().filter(|c| !matches!(c, '-' | ':')).collect();
        let aside = directory.join(format!("{name}.damaged-{stamp}"));
        if fs::symlink_metadata(&aside).is_err() {
            break aside;
        }
        time = Time::from_nanos(time.nanos().saturating_add(SECOND / 1000));
    };
    fs::rename(directory.join(name), &aside)?;
    remove_oldest(directory, name);
    Ok(aside)
}

/// A file that cannot be removed stays.
fn remove_oldest(directory: &Path, name: &str) {
    let prefix = format!("{name}.damaged-");
    let Ok(entries) = fs::read_dir(directory) else { return };
    let is_one = |name: &std::ffi::OsString| name.to_str().is_some_and(|name| name.starts_with(&prefix));
    let mut names: Vec<_> =
        entries.filter_map(|entry| Some(entry.ok()?.file_name())).filter(is_one).collect();
    names.sort_unstable();
    names.truncate(names.len().saturating_sub(KEPT));
    for path in names.into_iter().map(|name| directory.join(name)) {
        let is_directory = fs::symlink_metadata(&path).is_ok_and(|metadata| metadata.is_dir());
        let _ = if is_directory { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newest_damaged_files_are_kept() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-aside-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        let mut asides = Vec::new();
        for content in 0..6_u8 {
            fs::write(directory.join("a.json"), [content]).unwrap();
            // Two with the same time, so that the names have to be made unique.
            let now = Time::from_nanos((1_795_168_800 + i64::from(content / 2)) * SECOND);
            asides.push(set_aside(&directory, "a.json", now).unwrap());
        }
        let kept: Vec<u8> = asides.iter().filter_map(|path| Some(fs::read(path).ok()?[0])).collect();
        assert_eq!(kept, [3, 4, 5]);
        fs::create_dir_all(directory.join("a.json/inner")).unwrap();
        let aside = set_aside(&directory, "a.json", Time::from_nanos(1_795_168_900 * SECOND)).unwrap();
        assert!(aside.join("inner").is_dir() && !directory.join("a.json").exists());
        fs::remove_dir_all(&directory).unwrap();
    }
}
