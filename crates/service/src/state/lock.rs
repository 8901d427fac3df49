//! Lock on `[state] dir`: two services on one directory would overwrite each other's files.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tracing::warn;

use super::aside::set_aside;
use crate::clock::now;

/// Name of the locked file, which holds the process id of the service.
const LOCK: &str = ".lock";
/// Number of attempts on a held lock, and the pause between two.
const TRIES: u32 = 10;
const PAUSE: Duration = Duration::from_millis(100);

/// A lock that is held until it is dropped, or the process ends in any way.
#[derive(Debug)]
pub struct StateLock(#[expect(dead_code, reason = "the open file is the lock")] File);

/// Another service uses the directory.
#[derive(Debug, thiserror::Error)]
#[error(
    "{} ([state] dir) is in use by {}: stop that service, or give this one a directory of its own",
    directory.display(),
    holder.map_or_else(|| "another service".to_owned(), |id| format!("another service, process {id}"))
)]
pub struct StateInUse {
    directory: PathBuf,
    holder: Option<u32>,
}

impl StateLock {
    /// Locks a directory. `None` if it cannot be locked, for example because it is not writable; this is logged, and the
    /// service runs without the lock.
    ///
    /// # Errors
    /// Another process holds the lock.
    pub fn take(directory: &Path) -> Result<Option<Self>, StateInUse> {
        let mut file = match open(directory) {
            Ok(file) => file,
            Err(error) => {
                warn!(directory = %directory.display(), %error, "state directory cannot be locked");
                return Ok(None);
            }
        };
        match locked(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                let _ = file.take(16).read_to_string(&mut text);
                return Err(StateInUse { directory: directory.to_owned(), holder: text.trim().parse().ok() });
            }
            Err(TryLockError::Error(error)) => {
                warn!(directory = %directory.display(), %error, "state directory cannot be locked");
                return Ok(None);
            }
        }
        // On a full disk the process id is not written, but the lock is held.
        let _ = file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id()));
        Ok(Some(Self(file)))
    }
}

/// Waits for a service that is just ending.
#[expect(clippy::disallowed_methods, reason = "before the service starts")]
fn locked(file: &File) -> Result<(), TryLockError> {
    for _ in 0..TRIES {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            locked => return locked,
        }
    }
    file.try_lock()
}

fn open(directory: &Path) -> io::Result<File> {
    fs::create_dir_all(directory)?;
    let path = directory.join(LOCK);
    if fs::symlink_metadata(&path).is_ok_and(|metadata| !metadata.is_file()) {
        set_aside(directory, LOCK, now())?;
    }
    fs::OpenOptions::new().create(true).read(true).write(true).truncate(false).open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_lock_names_directory_and_holder() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-lock-{}", std::process::id()));
        let lock = StateLock::take(&directory).unwrap().unwrap();
        let error = StateLock::take(&directory).unwrap_err().to_string();
        assert!(error.contains(directory.to_str().unwrap()), "{error}");
        assert!(error.contains(&format!("process {}", std::process::id())), "{error}");
        drop(lock);
        fs::write(directory.join(LOCK), b"\xff garbage").unwrap();
        let lock = StateLock::take(&directory).unwrap();
        assert!(lock.is_some());
        drop(lock);
        fs::remove_file(directory.join(LOCK)).unwrap();
        fs::create_dir(directory.join(LOCK)).unwrap();
        assert!(StateLock::take(&directory).unwrap().is_some());
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn missing_directory_stops_no_service() {
        let file = std::env::temp_dir().join(format!("utm-fusion-lock-file-{}", std::process::id()));
        fs::write(&file, "").unwrap();
        assert!(StateLock::take(&file.join("state")).unwrap().is_none());
        fs::remove_file(file).unwrap();
    }
}
