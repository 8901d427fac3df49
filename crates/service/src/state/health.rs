//! Health of the files in `[state] dir`: which cannot be written, and which were damaged and set aside.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tracing::error;

use super::aside::set_aside;
use fusion::time::Time;

/// Health of all files, shared by the threads that write them; cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct StateHealth(Arc<Mutex<BTreeMap<String, FileHealth>>>);

/// Health of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileHealth {
    /// Error of the last write; `None` if it succeeded, or there was none.
    pub failing: Option<String>,
    /// Number of times that a damaged file was set aside since the start.
    pub damaged: u64,
    /// Latest damage: the time at which it was found, and the present name of the file.
    pub aside: Option<(Time, String)>,
}

impl StateHealth {
    fn files(&self) -> MutexGuard<'_, BTreeMap<String, FileHealth>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Health by name, for each file with a reported event.
    pub fn all(&self) -> BTreeMap<String, FileHealth> {
        self.files().clone()
    }

    /// Records a failed write; returns whether the one before had succeeded.
    pub fn note_failure(&self, file: &str, error: &dyn Display) -> bool {
        self.files().entry(file.to_owned()).or_default().failing.replace(error.to_string()).is_none()
    }

    /// Records a successful write; returns whether the one before had failed.
    pub fn note_success(&self, file: &str) -> bool {
        self.files().get_mut(file).is_some_and(|file| file.failing.take().is_some())
    }

    /// Sets a damaged file of `directory` aside, logs and records it. `what` describes its contents for the log.
    pub fn set_aside(&self, directory: &Path, file: &str, what: &str, error: &dyn Display, now: Time) {
        let aside = match set_aside(directory, file, now) {
            Ok(aside) => {
                error!(contents = what, %error, aside = %aside.display(), "state file is damaged: set aside, another one is begun");
                aside.file_name().unwrap_or_default().to_string_lossy().into_owned()
            }
            Err(rename) => {
                error!(contents = what, %error, %rename, "state file is damaged and cannot be set aside");
                file.to_owned()
            }
        };
        let mut files = self.files();
        let health = files.entry(file.to_owned()).or_default();
        health.damaged += 1;
        health.aside = Some((now, aside));
    }

    /// Sets aside anything but a regular file in the place of a file, or of its `.part`: a directory could not be written,
    /// and a pipe would block.
    pub fn clear_obstacles(&self, directory: &Path, file: &str, what: &str, now: Time) {
        let is_obstacle = |path: &Path| std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file());
        if is_obstacle(&directory.join(file)) {
            self.set_aside(directory, file, what, &"it is no file", now);
        }
        let part = format!("{file}.part");
        if is_obstacle(&directory.join(&part)) && set_aside(directory, &part, now).is_ok() {
            error!(contents = what, part, "the place of a state file was taken: set aside");
        }
    }
}
